"""Gaussian maximum likelihood in L*a*b* with shrunk covariances.

Class covariances of few seeds are shrunk to the pooled one (Friedman 1989, "Regularized discriminant analysis",
J. Am. Stat. Assoc. 84:165-175), and the pooled one, where it rests on few seeds itself, to an isotropic prior: a job
with one seed texel a material, or with a flat texture, still has an answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import POSTERIOR_ONE
from skyshine.tmm.features.colour import to_coordinates

PRIOR_SPREAD = 6.0  # CIELAB units: standard deviation within a material, the median over labelled aerial photographs
PRIOR_WEIGHT = 4.0  # seeds that this prior counts as: one more than the dimensions; any real sample outweighs it
SHRINKAGE_WEIGHT = 20.0  # seeds at which a class's own covariance and the pooled one count alike
SPREAD_FLOOR = 1.0  # CIELAB units: about one just noticeable difference, and the rounding of 8 bit colours
RELATIVE_FLOOR = 1e-9  # floor of the trace: far above the rounding of float64, far below any real ratio of spreads
BLOCK_COLOURS = 1 << 16  # colours whose posteriors are computed at a time


@dataclass(frozen=True)
class GaussianModel:
    """One normal distribution for each material, in the D coordinates of `to_coordinates`: L*a*b*, or one more.

    names : tuple of str; K materials.
    means : (K, D) float64
    covariances : (K, D, D) float64
    log_prior : (K,) float64
    """

    names: tuple[str, ...]
    means: npt.NDArray[np.float64]
    covariances: npt.NDArray[np.float64]
    log_prior: npt.NDArray[np.float64]

    def only(self, classes: Sequence[int]) -> GaussianModel:
        """The model of some of its materials alone, whose prior probabilities sum to 1."""
        from scipy.special import logsumexp

        part = list(classes)
        prior = self.log_prior[part] - logsumexp(self.log_prior[part])
        return GaussianModel(tuple(self.names[k] for k in part), self.means[part], self.covariances[part], prior)

    def squared_distance(self, lab: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
        """Squared Mahalanobis distance of colours (N, D) to each material, (K, N)."""
        # Distances in whitened coordinates: the inverse of a small Cholesky factor, applied to all colours at once.
        whitening = np.linalg.inv(np.linalg.cholesky(self.covariances))
        columns = np.ascontiguousarray(lab.T)
        pairs = zip(whitening, self.means[..., np.newaxis], strict=True)
        return np.stack([np.sum((factor @ (columns - mean)) ** 2, axis=0) for factor, mean in pairs])

    def log_posterior(self, squared_distance: npt.NDArray[np.float64]) -> npt.NDArray[Any]:
        """Logarithm of the posterior probability of each material, (K, N), normalised by log-sum-exp."""
        from scipy.special import logsumexp

        log_volume = 0.5 * np.linalg.slogdet(self.covariances)[1]
        joint = (self.log_prior - log_volume)[:, np.newaxis] - 0.5 * squared_distance
        posterior: npt.NDArray[np.float64] = joint - logsumexp(joint, axis=0)
        return posterior

    def tables(self, colours: npt.NDArray[Any], encoding: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Posterior (K, U) uint16 in units of 1 / POSTERIOR_ONE, and typicality (U,) float32, of colours (U, C).

        The typicality is that of the material of which a colour is the most typical.
        """
        from scipy.special import chdtrc

        posterior = np.empty((len(self.names), len(colours)), np.uint16)
        typicality = np.empty(len(colours), np.float32)
        for start in range(0, len(colours), BLOCK_COLOURS):
            block = slice(start, start + BLOCK_COLOURS)
            distance = self.squared_distance(to_coordinates(colours[block], encoding))
            posterior[:, block] = np.rint(np.exp(self.log_posterior(distance)) * POSTERIOR_ONE)
            typicality[block] = chdtrc(self.means.shape[1], distance.min(axis=0))
        return posterior, typicality


def fit(
    lab: npt.NDArray[np.float64],
    material: npt.NDArray[Any],
    names: tuple[str, ...],
    prior: str | dict[str, float] = "equal",
) -> GaussianModel:
    """Fit the model to seeds.

    lab : (N, D) float64; coordinates of the seeds.
    material : (N,) int; index into `names`; each occurs.
    prior : "equal", "seeds" or dict; relative prior probability of the materials; a dict may leave materials at 1.
    """
    dimensions = np.eye(lab.shape[1])
    counts = np.bincount(material, minlength=len(names)).astype(float)
    means = np.stack([np.bincount(material, column, len(names)) / counts for column in lab.T], axis=1)
    residual = lab - means[material]
    scatter = np.stack([residual[material == k].T @ residual[material == k] for k in range(len(names))])
    isotropic = PRIOR_WEIGHT * PRIOR_SPREAD**2 * dimensions
    pooled = (scatter.sum(axis=0) + isotropic) / (len(lab) - len(names) + PRIOR_WEIGHT)
    freedom = (counts - 1 + SHRINKAGE_WEIGHT)[:, np.newaxis, np.newaxis]
    covariances = (scatter + SHRINKAGE_WEIGHT * pooled) / freedom
    # The second floor keeps high dynamic range, with spreads of many orders, within what can be factorised.
    floor = SPREAD_FLOOR**2 + RELATIVE_FLOOR * np.trace(covariances, axis1=1, axis2=2)
    covariances += floor[:, np.newaxis, np.newaxis] * dimensions
    return GaussianModel(names, means, covariances, log_prior(names, counts, prior))


def log_prior(
    names: tuple[str, ...], counts: npt.NDArray[np.float64], prior: str | dict[str, float]
) -> npt.NDArray[Any]:
    """Logarithm of the prior probability (K,) of materials with these counts (K,) of seeds; `prior` as for `fit`."""
    if isinstance(prior, dict):
        weights = np.array([prior.get(name, 1.0) for name in names])
    else:
        weights = counts if prior == "seeds" else np.ones(len(names))
    logarithm: npt.NDArray[np.float64] = np.log(weights / weights.sum())
    return logarithm
