"""Training of classifiers, on the seeds of one texture or of a library of textures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.mapper import GaussianModel, fit, log_prior
from skyshine.tmm.classify.trained import TYPICAL, Network, TrainedModel
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.features.shadow import luminance, shadow_limits
from skyshine.tmm.features.textured import MARGIN, features, in_other_light, in_shadow, light_planes, names
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.load import load_texture, open_texture
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.model import Classifier, TmmJob
from skyshine.tmm.quality.held_out import HeldOut, at_seeds, folds, held_out, untested

SAMPLE = 3000  # seed texels of a material in one texture that a network is trained on
LIBRARY_SAMPLE = 500_000  # of all materials in all textures of a library, 200 bytes each
LEAST_SAMPLE = 200  # of a material in one texture of many
TILE = 256  # texels: features are computed about the seeds of one such tile at a time
HIDDEN, LIBRARY_HIDDEN = 32, 64  # units
PENALTY, LIBRARY_PENALTY = 1.0, 0.1  # on the squares of the weights; the many examples of a library need less
ROUNDS = 60  # over all examples, at most
VISITS = 1_000_000  # of examples, in all rounds: with many examples a few rounds do


@dataclass(frozen=True)
class Examples:
    """Features of seeds, as they are and in shadow.

    Attributes
    ----------
    texel : (N,) int
        Which of the seeds each is.
    plain, shaded : (N, F) float32
        As they are; with shadows drawn on them and, of a library, in the light of another photograph.
    material : (N,) int
        Index into the names of the seeds.
    """

    texel: np.ndarray
    plain: np.ndarray
    shaded: np.ndarray
    material: np.ndarray


def examples(
    texture: Windowed, seeds: SeedTexels, random_seed: int, sample: int = SAMPLE, other_light: bool = False
) -> Examples:
    """Features at a random sample of the seeds, of `sample` texels a material at most."""
    random = np.random.default_rng(random_seed)
    chosen = []
    for k in range(len(seeds.names)):
        mine = np.flatnonzero(seeds.material == k)
        chosen.append(mine if len(mine) <= sample else random.choice(mine, sample, replace=False))
    texel = np.sort(np.concatenate(chosen))
    plain, shaded = (np.empty((len(texel), len(names())), np.float32) for _ in range(2))
    tile = seeds.rows[texel] // TILE * (texture.width // TILE + 1) + seeds.columns[texel] // TILE
    for number in np.unique(tile):
        mine = np.flatnonzero(tile == number)
        rows, columns = seeds.rows[texel[mine]], seeds.columns[texel[mine]]
        top, left = max(rows.min() - MARGIN, 0), max(columns.min() - MARGIN, 0)
        bottom, right = (
            min(n.max() + MARGIN + 1, size) for n, size in ((rows, texture.height), (columns, texture.width))
        )
        pixels, valid = texture.window(slice(top, bottom), slice(left, right))
        pixels = np.where(valid[..., np.newaxis], pixels, pixels.dtype.type(0))
        at = (slice(None), rows - top, columns - left)
        plain[mine] = _features(pixels, valid, texture.encoding)[at].T
        dimmed = in_shadow(pixels, texture.encoding, random)[0]
        if other_light:
            dimmed = in_other_light(dimmed, random)
        shaded[mine] = _features(dimmed, valid, "linear")[at].T
    return Examples(texel, plain, shaded, seeds.material[texel])


def _features(pixels: np.ndarray, valid: np.ndarray, encoding: str) -> np.ndarray:
    planes = light_planes(pixels.reshape(-1, pixels.shape[2]), encoding)
    return features(*(part.reshape(3, *valid.shape) for part in planes), valid)


def train_textured(
    known: list[Examples], names_of: list[tuple[str, ...]], settings: Classifier, random_seed: int
) -> TrainedModel:
    """Train a network on the examples of textures, whose materials have these names.

    Raises
    ------
    ModuleNotFoundError
        scikit-learn (the extra ``train``) is not installed.
    """
    everything = tuple(dict.fromkeys(name for names_ in names_of for name in names_))
    material = [
        np.array([everything.index(n) for n in own])[part.material] for part, own in zip(known, names_of, strict=True)
    ]
    used, target = np.unique(np.concatenate(material), return_inverse=True)
    found = tuple(everything[k] for k in used)
    both = np.concatenate([part.plain for part in known] + [part.shaded for part in known])
    target = np.concatenate([target, target])
    size = (HIDDEN, PENALTY) if len(known) == 1 else (LIBRARY_HIDDEN, LIBRARY_PENALTY)
    network = _network(both, target, found, settings, random_seed, *size)
    colour = fit(both[:, TYPICAL].astype(np.float64), target, found)
    return TrainedModel(found, colour, network)


def _network(
    both: np.ndarray,
    target: np.ndarray,
    found: tuple[str, ...],
    settings: Classifier,
    random_seed: int,
    hidden: int,
    penalty: float,
) -> Network:
    mean, scale = both.mean(axis=0), np.maximum(both.std(axis=0), 1e-3)
    if len(found) == 1:
        empty = np.zeros((len(mean), 1), np.float32)
        return Network(
            mean, scale, empty, np.zeros(1, np.float32), np.zeros((1, 1), np.float32), np.zeros(1, np.float32)
        )
    inner, outer, inner_offset, outer_offset = _perceptron((both - mean) / scale, target, random_seed, hidden, penalty)
    counts = np.bincount(target).astype(float)
    # The seeds' own frequencies are the prior that a network learns.
    outer_offset = outer_offset + log_prior(found, counts, settings.prior) - np.log(counts / counts.sum())
    return Network(*(part.astype(np.float32) for part in (mean, scale, inner, inner_offset, outer, outer_offset)))


def _perceptron(
    scaled: np.ndarray, target: np.ndarray, random_seed: int, hidden: int, penalty: float
) -> tuple[np.ndarray, ...]:
    """Weights and offsets of both layers; of two materials, scikit-learn keeps one output, the log-odds."""
    import warnings

    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPClassifier

    rounds = int(np.clip(VISITS // len(scaled), 5, ROUNDS))
    learner = MLPClassifier((hidden,), alpha=penalty, max_iter=rounds, random_state=random_seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # to stop early is part of the method
        learner.fit(scaled, target)
    (inner, outer), (inner_offset, outer_offset) = learner.coefs_, learner.intercepts_
    if outer.shape[1] == 1:
        outer, outer_offset = np.hstack([0 * outer, outer]), np.append(0 * outer_offset, outer_offset)
    return inner, outer, inner_offset, outer_offset


def _fit_seeds(
    seeds: SeedTexels, encoding: str, settings: Classifier, chosen: np.ndarray | None = None
) -> GaussianModel:
    """Fit the model to the seeds of a texture, or to those that `chosen` (N,) bool keeps."""
    keep = np.ones(len(seeds.rows), bool) if chosen is None else chosen
    names, material = np.unique(seeds.material[keep], return_inverse=True)
    coordinates = to_coordinates(seeds.colours[keep], encoding)
    return fit(coordinates, material, tuple(seeds.names[i] for i in names), settings.prior)


def train_on_seeds(
    texture: Windowed,
    seeds: SeedTexels,
    settings: Classifier,
    known: Examples | None,
    random_seed: int,
    chosen: np.ndarray | None,
) -> TrainedModel:
    """Train on the seeds of one texture, or on those that `chosen` (N,) bool keeps; `known` are its `examples`, if
    textured.
    """
    if known is None:
        colour = _fit_seeds(seeds, texture.encoding, settings, chosen)
        return TrainedModel(colour.names, colour, None)
    keep = np.ones(len(known.texel), bool) if chosen is None else chosen[known.texel]
    part = Examples(known.texel[keep], known.plain[keep], known.shaded[keep], known.material[keep])
    return train_textured([part], [seeds.names], settings, random_seed)


def library_examples(texture: Windowed, seeds: SeedTexels, count: int, random_seed: int) -> Examples:
    """Examples of one of `count` textures of a library, no more than that those of all fit memory."""
    sample = int(np.clip(LIBRARY_SAMPLE // count // len(seeds.names), LEAST_SAMPLE, SAMPLE))
    return examples(texture, seeds, random_seed, sample, other_light=count > 1)


def train_library(job: TmmJob, folder: Path, library) -> tuple[TrainedModel, HeldOut]:
    """Train one classifier on the seeds of all textures of a job, with the classifier settings of its first texture.

    The calibration and the quality come from textures held out: dealt out over the parts of the first texture's
    `held_out`, each is classified by a classifier of the other parts' textures.

    Raises
    ------
    InputError
        A texture has no seeds, or a file cannot be read.
    """
    first = job.textures[0]
    settings, random_seed = first.classifier, first.held_out.random_seed
    for texture_job in job.textures:
        if texture_job.seeds is None:
            raise InputError(f"'{texture_job.name}' has no seeds; allowed for training: textures with seeds")
    count, textured = len(job.textures), settings.method == "textured"
    # Images are read one by one and again for the test: those of a large library together would not fit memory.
    seeds_of, encodings, known = [], [], []
    for texture_job in job.textures:
        texture, _, _, seeds = load_texture(texture_job, folder, library)
        seeds_of.append(seeds)
        encodings.append(texture.encoding)
        if textured:
            known.append(library_examples(texture, seeds, count, random_seed))
    order = np.random.default_rng(random_seed).permutation(count)
    part = np.empty(count, int)
    part[order] = np.arange(count) % first.held_out.folds

    def train(chosen: np.ndarray) -> TrainedModel:
        used = np.flatnonzero(chosen)
        own = [seeds_of[i] for i in used]
        if textured:
            return train_textured([known[i] for i in used], [seeds.names for seeds in own], settings, random_seed)
        names = tuple(dict.fromkeys(name for seeds in own for name in seeds.names))
        lab = [to_coordinates(seeds_of[i].colours, encodings[i]) for i in used]
        material = [np.array([names.index(name) for name in seeds.names])[seeds.material] for seeds in own]
        colour = fit(np.concatenate(lab), np.concatenate(material), names, settings.prior)
        return TrainedModel(names, colour, None)

    model = train(np.ones(count, bool))
    if count == 1:
        return model, untested(len(model.names))
    held = _held_out_textures(job, folder, seeds_of, part, train, model.names)
    return replace(model, calibration=held.calibration), held


def _held_out_textures(
    job: TmmJob, folder: Path, seeds_of: list[SeedTexels], part: np.ndarray, train, names: tuple[str, ...]
) -> HeldOut:
    """Quality at the seeds of textures that the classifier was not trained on."""
    rows = []
    for number in np.unique(part):
        model = train(part != number)
        for i in np.flatnonzero(part == number):
            texture, seeds = open_texture(job.textures[i], folder), seeds_of[i]
            fold = np.where(folds(job.textures[i], seeds, smallest=1) >= 0, 0, -1)
            mapper = model.mapper(texture, DistinctColours(texture), job.textures[0].classifier.radius, tabulate=False)
            found, confidence, _ = at_seeds({0: mapper}, seeds, fold)
            light = luminance(seeds.colours, texture.encoding)
            dark = light < shadow_limits(light, seeds.material, len(seeds.names))[seeds.material]
            index = np.array([*(names.index(name) for name in seeds.names), -1])
            # A texture counts once in the calibration, as a region does within one.
            columns = (
                index[seeds.material],
                index[found],
                confidence,
                dark,
                np.full(len(fold), i),
                np.full(len(fold), number),
            )
            rows.append([column[fold == 0] for column in columns])
    return held_out(len(names), *(np.concatenate(column) for column in zip(*rows, strict=True)))
