"""Gaussian maximum likelihood in L*a*b* with shrunk covariances, and posteriors averaged over a box.

Class covariances of few seeds are shrunk to the pooled one (Friedman 1989, "Regularized discriminant analysis",
J. Am. Stat. Assoc. 84:165-175), and the pooled one, where it rests on few seeds itself, to an isotropic prior: a job
with one seed texel a material, or with a flat texture, still has an answer.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.tmm.features.colour import DistinctColours, to_lab
from skyshine.tmm.job import Classifier
from skyshine.tmm.seeds import SeedTexels
from skyshine.tmm.texture import Texture

PRIOR_SPREAD = 6.0  # CIELAB units: standard deviation within a material, the median over labelled aerial photographs
PRIOR_WEIGHT = (
    4.0  # seeds that this prior counts as: one more than the dimensions, so that any real sample outweighs it
)
SHRINKAGE_WEIGHT = 20.0  # seeds at which a class's own covariance and the pooled one count alike
SPREAD_FLOOR = 1.0  # CIELAB units: about one just noticeable difference, and the rounding of 8 bit colours
RELATIVE_FLOOR = 1e-9  # of the trace: far above the rounding of float64, far below any real ratio of spreads
POSTERIOR_ONE = 65535  # posteriors are summed as 16 bit integers: with MAX_RADIUS a sum stays below 2^32
BLOCK_TEXELS = 1 << 18  # texels of a block of rows: small enough for the cache, large enough for numpy


@dataclass(frozen=True)
class GaussianModel:
    """One normal distribution in L*a*b* for each material.

    Attributes
    ----------
    names : tuple of str
        K materials.
    means : (K, 3) float64
    covariances : (K, 3, 3) float64
    log_prior : (K,) float64
    """

    names: tuple[str, ...]
    means: np.ndarray
    covariances: np.ndarray
    log_prior: np.ndarray

    def squared_distance(self, lab: np.ndarray) -> np.ndarray:
        """Squared Mahalanobis distance of colours (N, 3) to each material, (K, N)."""
        # Distances in whitened coordinates: the inverse of a 3 x 3 Cholesky factor, applied to all colours at once.
        whitening = np.linalg.inv(np.linalg.cholesky(self.covariances))
        columns = np.ascontiguousarray(lab.T)
        pairs = zip(whitening, self.means[..., np.newaxis])
        return np.stack([np.sum((factor @ (columns - mean)) ** 2, axis=0) for factor, mean in pairs])

    def log_posterior(self, squared_distance: np.ndarray) -> np.ndarray:
        """Logarithm of the posterior probability of each material, (K, N), normalised by log-sum-exp."""
        from scipy.special import logsumexp

        log_volume = 0.5 * np.linalg.slogdet(self.covariances)[1]
        joint = (self.log_prior - log_volume)[:, np.newaxis] - 0.5 * squared_distance
        return joint - logsumexp(joint, axis=0)


@dataclass(frozen=True)
class Classified:
    """What a classifier says of each texel.

    Attributes
    ----------
    material : (H, W) int16
        Index into the model's names, -1 where there is no data.
    confidence : (H, W) float32
        Posterior of that material averaged over the box; 0 without data.
    typicality : (H, W) float32
        Share of the material's own texels that would lie farther from its mean than this one (upper tail of chi-squared
        with 3 degrees of freedom); 0 without data.
    """

    material: np.ndarray
    confidence: np.ndarray
    typicality: np.ndarray


def fit(lab: np.ndarray, material: np.ndarray, names: tuple[str, ...], prior: str | dict[str, float]) -> GaussianModel:
    """Fit the model to seeds.

    Parameters
    ----------
    lab : (N, 3) float64
        Colours of the seeds.
    material : (N,) int
        Index into `names`; each occurs.
    prior : "equal", "seeds" or dict
        Relative prior probability of the materials; a dict may leave materials at 1.
    """
    counts = np.bincount(material, minlength=len(names)).astype(float)
    means = np.stack([np.bincount(material, lab[:, i], len(names)) / counts for i in range(3)], axis=1)
    residual = lab - means[material]
    scatter = np.stack([residual[material == k].T @ residual[material == k] for k in range(len(names))])
    isotropic = PRIOR_WEIGHT * PRIOR_SPREAD**2 * np.eye(3)
    pooled = (scatter.sum(axis=0) + isotropic) / (len(lab) - len(names) + PRIOR_WEIGHT)
    freedom = (counts - 1 + SHRINKAGE_WEIGHT)[:, np.newaxis, np.newaxis]
    covariances = (scatter + SHRINKAGE_WEIGHT * pooled) / freedom
    # The second floor keeps high dynamic range, with spreads of many orders, within what can be factorised.
    floor = SPREAD_FLOOR**2 + RELATIVE_FLOOR * np.trace(covariances, axis1=1, axis2=2)
    covariances += floor[:, np.newaxis, np.newaxis] * np.eye(3)
    if prior == "equal":
        weights = np.ones(len(names))
    elif prior == "seeds":
        weights = counts
    else:
        weights = np.array([prior.get(name, 1.0) for name in names])
    return GaussianModel(names, means, covariances, np.log(weights / weights.sum()))


def fit_seeds(
    texture: Texture, seeds: SeedTexels, settings: Classifier, chosen: np.ndarray | None = None
) -> GaussianModel:
    """Fit the model to the seeds of a texture, or to those that `chosen` (N,) bool keeps."""
    keep = np.ones(len(seeds.rows), bool) if chosen is None else chosen
    lab = to_lab(texture.pixels[seeds.rows[keep], seeds.columns[keep]], texture.encoding)
    names, material = np.unique(seeds.material[keep], return_inverse=True)
    return fit(lab, material, tuple(seeds.names[i] for i in names), settings.prior)


class TextureClassifier:
    """A model applied to a texture, block by block; each distinct colour is classified once.

    Without `tabulate` the colours of a window are classified for it alone: for a few small windows.
    """

    def __init__(
        self, texture: Texture, colours: DistinctColours, model: GaussianModel, radius: int, tabulate: bool = True
    ):
        self.texture, self.model, self.radius = texture, model, radius
        self._colours = colours
        self._shared = self._tables(colours.colours) if tabulate and colours.colours is not None else None

    def _tables(self, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Posterior in units of 1 / POSTERIOR_ONE, and typicality, both (K, U), of distinct colours (U, 3)."""
        from scipy.special import chdtrc

        posterior = np.empty((len(self.model.names), len(colours)), np.uint16)
        typicality = np.empty(posterior.shape, np.float32)
        for start in range(0, len(colours), BLOCK_TEXELS):
            block = slice(start, start + BLOCK_TEXELS)
            distance = self.model.squared_distance(to_lab(colours[block], self.texture.encoding))
            posterior[:, block] = np.rint(np.exp(self.model.log_posterior(distance)) * POSTERIOR_ONE)
            typicality[:, block] = chdtrc(3, distance)
        return posterior, typicality

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify the texels of rows `top` to `bottom` and columns `left` to `right` (the ends excluded)."""
        radius = self.radius
        y, x = max(top - radius, 0), max(left - radius, 0)
        rows = slice(y, min(bottom + radius, self.texture.height))
        columns = slice(x, min(right + radius, self.texture.width))
        inner = np.s_[top - y : bottom - y, left - x : right - x]
        colours, index = self._colours.of(rows, columns)
        if self._shared is None and colours is None:
            used, index = np.unique(index, return_inverse=True)
            colours, index = self._colours.colours[used], index.reshape(rows.stop - rows.start, -1)
        posterior, typicality = self._shared or self._tables(colours)
        valid = self.texture.valid[rows, columns]
        if radius == 0:
            material, total, members = *_strongest_colour(posterior, index), 1
        else:
            material, total = _strongest(posterior, index, valid, radius, inner)
            members = _members(valid, radius)[inner]
        confidence = np.minimum(total / (np.float32(POSTERIOR_ONE) * members), np.float32(1))
        number = np.multiply(material, typicality.shape[1], dtype=np.intp)
        number += index[inner]
        typical = np.take(typicality.ravel(), number)
        for array, none in ((material, -1), (confidence, 0), (typical, 0)):
            np.copyto(array, array.dtype.type(none), where=~valid[inner])
        return Classified(material, confidence, typical)

    def whole(self) -> Classified:
        """Classify every texel."""
        shape = height, width = self.texture.height, self.texture.width
        result = Classified(np.empty(shape, np.int16), np.empty(shape, np.float32), np.empty(shape, np.float32))
        step = max(BLOCK_TEXELS // width, 2 * self.radius + 1)
        for top in range(0, height, step):
            rows = slice(top, min(top + step, height))
            block = self.window(rows.start, rows.stop, 0, width)
            result.material[rows] = block.material
            result.confidence[rows], result.typicality[rows] = block.confidence, block.typicality
        return result


def _strongest_colour(posterior: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Material of the largest posterior of each texel's own colour, and that posterior as float32."""
    material = posterior.argmax(axis=0).astype(np.int16)
    return np.take(material, index), np.take(posterior.max(axis=0).astype(np.float32), index)


def _strongest(
    posterior: np.ndarray, index: np.ndarray, valid: np.ndarray, radius: int, inner: tuple[slice, slice]
) -> tuple[np.ndarray, np.ndarray]:
    """Material of the largest sum of posteriors over the box about each inner texel, and that sum as float32."""
    whole = bool(valid.all())
    material, best = np.zeros(valid[inner].shape, np.int16), np.zeros(valid[inner].shape, np.uint32)
    for k, table in enumerate(posterior):
        plane = np.take(table, index)
        if not whole:
            plane *= valid
        total = _box_sum(plane, radius)[inner]
        np.copyto(material, np.int16(k), where=total > best)
        np.maximum(best, total, out=best)
    return material, best.astype(np.float32)


def _members(valid: np.ndarray, radius: int) -> np.ndarray:
    """Number of texels with data in the box about each texel, float32, at least 1: those that its mean is over."""
    if not valid.all():
        return np.maximum(_box_sum(valid, radius), 1).astype(np.float32)
    rows, columns = (_box_sum(np.ones((1, n), bool), radius)[0].astype(np.float32) for n in valid.shape)
    return np.multiply.outer(rows, columns)


def _box_sum(plane: np.ndarray, radius: int) -> np.ndarray:
    """Sum over the square of `radius` about each texel, with nothing beyond the edge: (H, W) to (H, W) uint32.

    Running sums in integers are exact, whatever the block; they may wrap, their differences are right while the sum
    itself fits, which MAX_RADIUS ensures.
    """
    (height, width), side = plane.shape, 2 * radius + 1
    running = np.zeros((height, width + side), np.uint32)
    np.cumsum(plane, axis=1, dtype=np.uint32, out=running[:, radius + 1 : radius + 1 + width])
    running[:, radius + 1 + width :] = running[:, radius + width, np.newaxis]
    across = running[:, side:] - running[:, :-side]
    running = np.zeros((height + side, width), np.uint32)
    for row in range(height):  # numpy's own cumsum down the columns is many times slower than adding rows
        np.add(running[radius + row], across[row], out=running[radius + row + 1])
    running[radius + 1 + height :] = running[radius + height]
    return running[side:] - running[:-side]
