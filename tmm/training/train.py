"""Training of classifiers: distributions of colour of one texture's seeds, a network of a library of textures."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.gaussian import GaussianModel, fit, log_prior
from skyshine.tmm.classify.trained import TYPICAL, Network, TrainedModel
from skyshine.tmm.features.colour import to_coordinates
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.training.examples import Examples

HIDDEN, PENALTY = 64, 0.1  # units; on the squares of the weights
ROUNDS = 60  # over all examples, at most
VISITS = 1_000_000  # visits of examples, in all rounds: with many examples a few rounds do


def train_textured(
    examples: list[Examples], names_of: list[tuple[str, ...]], prior: str | dict[str, float], random_seed: int
) -> TrainedModel:
    """Train a network on the examples of textures, whose materials have these names.

    Raises ModuleNotFoundError: scikit-learn (the extra ``train``) is not installed.
    """
    everything = tuple(dict.fromkeys(name for names_ in names_of for name in names_))
    material = [
        np.array([everything.index(name) for name in texture_names])[part.material]
        for part, texture_names in zip(examples, names_of, strict=True)
    ]
    present, target = np.unique(np.concatenate(material), return_inverse=True)
    materials = tuple(everything[k] for k in present)
    both = np.concatenate([part.plain for part in examples] + [part.shaded for part in examples])
    target = np.concatenate([target, target])
    network = _network(both, target, materials, prior, random_seed)
    colour = fit(both[:, TYPICAL].astype(np.float64), target, materials)
    return TrainedModel(materials, colour, network)


def _network(
    both: npt.NDArray[Any],
    target: npt.NDArray[Any],
    materials: tuple[str, ...],
    prior: str | dict[str, float],
    random_seed: int,
) -> Network:
    mean, scale = both.mean(axis=0), np.maximum(both.std(axis=0), 1e-3)
    if len(materials) == 1:
        empty = np.zeros((len(mean), 1), np.float32)
        return Network(
            mean, scale, empty, np.zeros(1, np.float32), np.zeros((1, 1), np.float32), np.zeros(1, np.float32)
        )
    inner, outer, inner_offset, outer_offset = _perceptron((both - mean) / scale, target, random_seed)
    counts = np.bincount(target).astype(float)
    # The seeds' own frequencies are the prior that a network learns.
    outer_offset = outer_offset + log_prior(materials, counts, prior) - np.log(counts / counts.sum())
    return Network(*(part.astype(np.float32) for part in (mean, scale, inner, inner_offset, outer, outer_offset)))


def _perceptron(scaled: npt.NDArray[Any], target: npt.NDArray[Any], random_seed: int) -> tuple[npt.NDArray[Any], ...]:
    """Weights and offsets of both layers; of two materials, scikit-learn keeps one output, the log-odds."""
    import warnings

    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPClassifier

    rounds = int(np.clip(VISITS // len(scaled), 5, ROUNDS))
    learner = MLPClassifier((HIDDEN,), alpha=PENALTY, max_iter=rounds, random_state=random_seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # to stop early is part of the method
        learner.fit(scaled, target)
    (inner, outer), (inner_offset, outer_offset) = learner.coefs_, learner.intercepts_
    if outer.shape[1] == 1:
        outer, outer_offset = np.hstack([0 * outer, outer]), np.append(0 * outer_offset, outer_offset)
    return inner, outer, inner_offset, outer_offset


def fit_seeds(
    seeds: SeedTexels, encoding: str, prior: str | dict[str, float], chosen: npt.NDArray[np.bool_] | None = None
) -> GaussianModel:
    """Fit distributions of colour to the seeds of a texture, or to those that `chosen` (N,) bool keeps."""
    keep = np.ones(len(seeds.rows), bool) if chosen is None else chosen
    names, material = np.unique(seeds.material[keep], return_inverse=True)
    coordinates = to_coordinates(seeds.colours[keep], encoding)
    return fit(coordinates, material, tuple(seeds.names[i] for i in names), prior)
