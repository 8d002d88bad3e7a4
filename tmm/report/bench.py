"""Error against run time of the classifiers, on labelled textures, with classifiers of scikit-learn in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.documents import StrictModel, load_model
from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.classify.mapper import Mapper
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.features.colour import DistinctColours, to_lab
from skyshine.tmm.images.labels import Labels
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.model import Classifier, LabelImage, TextureJob, TmmJob
from skyshine.tmm.mapping.texture_map import BAND, STRIP, seed_mappers
from skyshine.tmm.quality.counts import Quality, Tally

FAST = "fast, radius {}"
OURS = {FAST.format(radius): Classifier(speed="fast", radius=radius) for radius in (0, 4, 8, 12)}
GRAPH, WITH_MODEL = "graph", "graph and model"
PEERS = ("scikit-learn QDA", "scikit-learn random forest")
# So many trees that more change little.
FOREST = {"n_estimators": 50, "min_samples_leaf": 5, "random_state": 0, "n_jobs": 1}


class Truth(StrictModel):
    """Label images by the names of textures."""

    truth: dict[str, LabelImage] = Field(min_length=1, description="Label image and palette of each texture.")


@dataclass
class Row:
    """What one setting took and reached over all textures.

    Attributes
    ----------
    training, classifying : float
        Processor seconds.
    texels : int
    """

    name: str
    tally: Tally
    training: float = 0.0
    classifying: float = 0.0
    texels: int = 0

    @property
    def quality(self) -> Quality:
        """What was reached so far."""
        return self.tally.quality()

    @property
    def rate(self) -> float:
        """Texels classified in a processor second."""
        return self.texels / max(self.classifying, 1e-9)


Classify = Callable[[slice, slice], tuple[npt.NDArray[Any], npt.NDArray[Any]]]


def bench(
    job: TmmJob, folder: Path, truth: Path, library: MaterialLibrary
) -> Iterator[tuple[TextureJob, int, list[Row]]]:
    """Train every classifier on the seeds of each texture and classify it; seeds do not count in the result.

    Parameters
    ----------
    job : TmmJob
        Of textures with seeds; a `model` that one names joins its seeds in one of the rows.
    folder : Path
        To which the job's paths are relative.
    truth : Path
        YAML file with the key `truth`: texture names with `image`, relative to this file, and `palette`.

    Yields
    ------
    job : TextureJob
        The texture just done.
    colours : int
        Its number of distinct colours.
    rows : list of Row
        Over the textures up to this one.

    Raises
    ------
    InputError
        A file cannot be read, or a texture has no seeds or no truth.
    """
    labels = load_model(truth, Truth, context={"materials": library.names}).truth
    names = tuple(sorted({name for entry in labels.values() for name in entry.palette.values()}))
    rows = [Row(name, Tally(len(names))) for name in (*OURS, GRAPH, WITH_MODEL, *PEERS)]
    for entry in job.textures:
        if entry.seeds is None or entry.name not in labels:
            missing = "seeds" if entry.seeds is None else "truth"
            raise InputError(
                f"'{entry.name}' has no {missing}; textures with truth: {nearest(entry.name, labels)}", file=truth
            )
        texture, colours, _, seeds = load_texture(entry, folder, library)
        if seeds is None:
            raise ValueError(f"'{entry.name}' has no seeds")
        known = Labels(labels[entry.name], truth.parent, names).fits(texture.height, texture.width)
        for row in rows:
            started = time.process_time()
            classify, materials = _trained(row.name, entry, folder, texture, colours, seeds, library)
            row.training += time.process_time() - started
            _run(
                row,
                classify,
                np.array([*(names.index(n) if n in names else -1 for n in materials), -1]),
                texture,
                known,
                seeds,
            )
        yield entry, colours.number, rows


def _trained(
    name: str,
    job: TextureJob,
    folder: Path,
    texture: TextureFile,
    colours: DistinctColours,
    seeds: SeedTexels,
    library: MaterialLibrary,
) -> tuple[Classify, tuple[str, ...]]:
    """A classifier of windows, which gives material and confidence, and the names of its materials."""
    if name in (*OURS, GRAPH, WITH_MODEL):
        settings = OURS.get(name, Classifier()).model_copy(update={"prior": job.classifier.prior})
        general = read_model(model_path(job.model, folder)) if name == WITH_MODEL and job.model is not None else None
        entry = job.model_copy(update={"classifier": settings})
        return _windows(seed_mappers(entry, texture, colours, seeds, general, library)(None))
    from sklearn.discriminant_analysis import QuadraticDiscriminantAnalysis
    from sklearn.ensemble import RandomForestClassifier

    learner = QuadraticDiscriminantAnalysis(reg_param=0.01) if name == PEERS[0] else RandomForestClassifier(**FOREST)
    learner.fit(to_lab(seeds.colours[:, :3], texture.encoding), seeds.material)

    def peer(rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        pixels, valid = texture.window(rows, columns)
        posterior = learner.predict_proba(to_lab(pixels.reshape(-1, pixels.shape[2])[:, :3], texture.encoding))
        material = learner.classes_[posterior.argmax(axis=1)].reshape(valid.shape)
        return np.where(valid, material, -1), posterior.max(axis=1).reshape(valid.shape)

    return peer, seeds.names


def _windows(mapper: Mapper) -> tuple[Classify, tuple[str, ...]]:
    def classify(rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        classified = mapper.window(rows.start, rows.stop, columns.start, columns.stop)
        return classified.material, classified.confidence

    return classify, mapper.names


def _run(
    row: Row, classify: Classify, index: npt.NDArray[Any], texture: TextureFile, known: Labels, seeds: SeedTexels
) -> None:
    for top in range(0, texture.height, BAND):
        rows = slice(top, min(top + BAND, texture.height))
        truth = known.rows(rows.start, rows.stop).copy()
        mine = (seeds.rows >= rows.start) & (seeds.rows < rows.stop)
        truth[seeds.rows[mine] - top, seeds.columns[mine]] = -1
        for left in range(0, texture.width, STRIP):
            columns = slice(left, min(left + STRIP, texture.width))
            started = time.process_time()
            material, confidence = classify(rows, columns)
            row.classifying += time.process_time() - started
            scored = truth[:, columns] != -1
            row.tally.add(truth[:, columns][scored], index[material[scored]], confidence[scored])
    row.texels += texture.height * texture.width


def plot(rows: list[Row], path: Path) -> None:
    """Draw 1 - mean IoU against processor time a million texels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    axis = figure.subplots()
    for row in rows:
        seconds = 1e6 / row.rate
        axis.plot(seconds, 1 - row.quality.mean_iou, "s" if row.name in PEERS else "o")
        axis.annotate(
            row.name, (seconds, 1 - row.quality.mean_iou), xytext=(4, 3), textcoords="offset points", fontsize=8
        )
    axis.set_xscale("log")
    axis.set_xlabel("processor seconds a million texels")
    axis.set_ylabel("1 - mean intersection over union")
    FigureCanvasAgg(figure).print_png(str(path), metadata={"Software": "skyshine"})  # type: ignore[no-untyped-call]
