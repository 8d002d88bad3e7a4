"""Training of one classifier on a library of textures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.model import TextureJob, TmmJob
from skyshine.tmm.quality.held_out import HeldOut, HeldOutTexels, held_out, untested
from skyshine.tmm.training.examples import SAMPLE, Examples, examples
from skyshine.tmm.training.train import train_textured

LIBRARY_SAMPLE = 500_000  # library sample of all materials in all textures of a library, 200 bytes each
LEAST_SAMPLE = 200  # smallest sample of a material in one texture of many


def library_examples(texture: Windowed, seeds: SeedTexels, count: int, random_seed: int) -> Examples:
    """Examples of one of `count` textures of a library, no more than that those of all fit memory."""
    sample = int(np.clip(LIBRARY_SAMPLE // count // len(seeds.names), LEAST_SAMPLE, SAMPLE))
    return examples(texture, seeds, random_seed, sample, other_light=count > 1)


def train_library(job: TmmJob, folder: Path, library: MaterialLibrary) -> tuple[TrainedModel, HeldOut]:
    """Train one classifier on the seeds of all textures of a job, with the classifier settings of its first texture.

    The calibration and the quality come from textures held out: dealt out over the parts of the first texture's
    `held_out`, each is classified by a classifier of the other parts' textures.

    Raises InputError: a texture has no seeds, or a file cannot be read.
    """
    settings = job.textures[0]
    prior, random_seed = settings.classifier.prior, settings.held_out.random_seed
    _require_seeds(job)
    count = len(job.textures)
    # Images are read one by one: those of a large library together would not fit memory.
    seeds_of: list[SeedTexels] = []
    examples: list[Examples] = []
    for texture_job in job.textures:
        texture, _, _, seeds = load_texture(texture_job, folder, library)
        if seeds is None:
            raise _without_seeds(texture_job)
        seeds = seeds.of_materials()
        seeds_of.append(seeds)
        examples.append(library_examples(texture, seeds, count, random_seed))
    order = np.random.default_rng(random_seed).permutation(count)
    part = np.empty(count, int)
    part[order] = np.arange(count) % settings.held_out.folds

    def train(chosen: npt.NDArray[np.bool_]) -> TrainedModel:
        training = np.flatnonzero(chosen)
        return train_textured(
            [examples[i] for i in training], [seeds_of[i].names for i in training], prior, random_seed
        )

    model = train(np.ones(count, bool))
    if count == 1:
        return model, untested(len(model.names))
    quality = _held_out_textures(examples, seeds_of, part, train, model.names)
    return replace(model, calibration=quality.calibration), quality


def _require_seeds(job: TmmJob) -> None:
    for texture_job in job.textures:
        if texture_job.seeds is None:
            raise _without_seeds(texture_job)


def _without_seeds(job: TextureJob) -> InputError:
    return InputError(f"'{job.name}' has no seeds; allowed for training: textures with seeds")


def _held_out_textures(
    examples: list[Examples],
    seeds_of: list[SeedTexels],
    part: npt.NDArray[Any],
    train: Callable[[npt.NDArray[np.bool_]], TrainedModel],
    names: tuple[str, ...],
) -> HeldOut:
    """Quality at the examples of textures that the classifier was not trained on, averaged over each place as a map
    averages over a box.
    """
    tested = []
    for number in np.unique(part):
        model = train(part != number)
        index = np.array([names.index(name) for name in model.names])
        for i in np.flatnonzero(part == number):
            seeds, mine = seeds_of[i], examples[i]
            area = np.unique(seeds.region[mine.texel], return_inverse=True)[1]
            planes = model.network.posterior(np.ascontiguousarray(mine.plain.T))
            mean = np.stack([np.bincount(area, plane) for plane in planes]) / np.bincount(area)
            texels = HeldOutTexels(
                np.array([names.index(name) for name in seeds.names])[mine.material],
                index[mean.argmax(axis=0)][area],
                mean.max(axis=0).astype(np.float32)[area],
                region=np.full(len(area), i),  # a texture counts once in the calibration, as a place does within one
                fold=np.full(len(area), number),
                typicality=np.ones(len(area), np.float32),
            )
            tested.append(texels)
    return held_out(len(names), HeldOutTexels.joined(tested))
