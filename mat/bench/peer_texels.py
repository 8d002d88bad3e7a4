"""Materials of texels as scikit-learn finds them from the same seeds."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.ndimage import uniform_filter

from skyshine.mat.bench.equal_error import EqualError, Measured
from skyshine.materials.library import MaterialLibrary
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.features.colour import to_coordinates
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.quality.held_out import folds

_TREES = (3, 10)  # forests that are tried have so many


def texels(job: TextureJob, folder: Path, library: MaterialLibrary, database: Path, seconds: float) -> list[EqualError]:
    """Texels of a texture classified from its seeds, by this project and by scikit-learn, judged at seeds that are held
    out; empty where no seeds can be.

    Times include the classifiers that are trained without the seeds that they are judged by.

    Parameters
    ----------
    job : TextureJob
    folder : Path
        Folder to which its paths are relative.
    library : MaterialLibrary
    database : Path
        Texture database of the job.
    seconds : float
        Processor seconds that it took.
    """
    from sklearn.discriminant_analysis import QuadraticDiscriminantAnalysis
    from sklearn.ensemble import RandomForestClassifier

    if job.way != "seeds":
        return []
    with open_tmm(database) as built:
        confusion = built.array("quality/confusion")  # the first column has what became unknown
    texture, _, _, seeds = load_texture(job, folder, library)
    if seeds is None or not confusion.sum():
        return []
    wrong = 1 - float(np.trace(confusion[:, 1:]) / confusion.sum())
    ours = [Measured("as the job says", seconds / (texture.height * texture.width), wrong)]
    part = folds(job, seeds)
    learners = {"quadratic discriminant": QuadraticDiscriminantAnalysis(reg_param=0.01)} | {
        f"forest of {count} trees": RandomForestClassifier(count, min_samples_leaf=5, random_state=0)
        for count in _TREES
    }
    theirs = [
        _measured(name, learner, texture, seeds, part, job.classifier.radius) for name, learner in learners.items()
    ]
    judged = f"share of wrong texels among {np.count_nonzero(part >= 0):,} held-out seeds"
    return [EqualError.of("a texel's material", "scikit-learn", "1", ours, theirs, judged)]


def _measured(
    name: str, learner: Any, texture: TextureFile, seeds: SeedTexels, part: npt.NDArray[Any], radius: int
) -> Measured:
    """Seconds of a texel and share of wrong ones of a learner of colours, averaged over the box of the job."""
    begin = time.process_time()
    pixels, _ = texture.window(slice(0, texture.height), slice(0, texture.width))
    colours = to_coordinates(pixels.reshape(-1, pixels.shape[-1]), texture.encoding)
    features = uniform_filter(colours.reshape(*pixels.shape[:2], -1), (2 * radius + 1, 2 * radius + 1, 1))
    at_seeds = features[seeds.rows, seeds.columns]
    found: npt.NDArray[Any] = np.full(part.size, -1)
    for number in np.unique(part[part >= 0]):
        learner.fit(at_seeds[part != number], seeds.material[part != number])
        found[part == number] = learner.predict(at_seeds[part == number])
    learner.fit(at_seeds, seeds.material)
    learner.predict(features.reshape(len(colours), -1))
    seconds = time.process_time() - begin
    tested = part >= 0
    return Measured(name, seconds / len(colours), float(np.mean(found[tested] != seeds.material[tested])))
