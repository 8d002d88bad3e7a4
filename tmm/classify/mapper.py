"""Gaussian maximum likelihood in L*a*b* with shrunk covariances, and posteriors averaged over a box.

Class covariances of few seeds are shrunk to the pooled one (Friedman 1989, "Regularized discriminant analysis",
J. Am. Stat. Assoc. 84:165-175), and the pooled one, where it rests on few seeds itself, to an isotropic prior: a job
with one seed texel a material, or with a flat texture, still has an answer.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.images.texture import Windowed

PRIOR_SPREAD = 6.0  # CIELAB units: standard deviation within a material, the median over labelled aerial photographs
PRIOR_WEIGHT = (
    4.0  # seeds that this prior counts as: one more than the dimensions, so that any real sample outweighs it
)
SHRINKAGE_WEIGHT = 20.0  # seeds at which a class's own covariance and the pooled one count alike
SPREAD_FLOOR = 1.0  # CIELAB units: about one just noticeable difference, and the rounding of 8 bit colours
RELATIVE_FLOOR = 1e-9  # of the trace: far above the rounding of float64, far below any real ratio of spreads
POSTERIOR_ONE = 65535  # posteriors are summed as 16 bit integers: with MAX_RADIUS a sum stays below 2^32
TABLE_ENTRIES = 1 << 24  # posteriors of all distinct colours that are kept at hand: 170 MB
BLOCK_COLOURS = 1 << 16  # colours whose posteriors are worked out at a time


@dataclass(frozen=True)
class GaussianModel:
    """One normal distribution for each material, in the D coordinates of `to_coordinates`: L*a*b*, or one more.

    Attributes
    ----------
    names : tuple of str
        K materials.
    means : (K, D) float64
    covariances : (K, D, D) float64
    log_prior : (K,) float64
    """

    names: tuple[str, ...]
    means: np.ndarray
    covariances: np.ndarray
    log_prior: np.ndarray

    def only(self, k: int) -> GaussianModel:
        """The model of one of its materials alone."""
        part = slice(k, k + 1)
        return GaussianModel(self.names[part], self.means[part], self.covariances[part], self.log_prior[part])

    def squared_distance(self, lab: np.ndarray) -> np.ndarray:
        """Squared Mahalanobis distance of colours (N, D) to each material, (K, N)."""
        # Distances in whitened coordinates: the inverse of a small Cholesky factor, applied to all colours at once.
        whitening = np.linalg.inv(np.linalg.cholesky(self.covariances))
        columns = np.ascontiguousarray(lab.T)
        pairs = zip(whitening, self.means[..., np.newaxis], strict=True)
        return np.stack([np.sum((factor @ (columns - mean)) ** 2, axis=0) for factor, mean in pairs])

    def log_posterior(self, squared_distance: np.ndarray) -> np.ndarray:
        """Logarithm of the posterior probability of each material, (K, N), normalised by log-sum-exp."""
        from scipy.special import logsumexp

        log_volume = 0.5 * np.linalg.slogdet(self.covariances)[1]
        joint = (self.log_prior - log_volume)[:, np.newaxis] - 0.5 * squared_distance
        return joint - logsumexp(joint, axis=0)

    def tables(self, colours: np.ndarray, encoding: str) -> tuple[np.ndarray, np.ndarray]:
        """Posterior (K, U) uint16 in units of 1 / POSTERIOR_ONE, and typicality (K, U) float32, of colours (U, C)."""
        from scipy.special import chdtrc

        posterior = np.empty((len(self.names), len(colours)), np.uint16)
        typicality = np.empty(posterior.shape, np.float32)
        for start in range(0, len(colours), BLOCK_COLOURS):
            block = slice(start, start + BLOCK_COLOURS)
            distance = self.squared_distance(to_coordinates(colours[block], encoding))
            posterior[:, block] = np.rint(np.exp(self.log_posterior(distance)) * POSTERIOR_ONE)
            typicality[:, block] = chdtrc(self.means.shape[1], distance)
        return posterior, typicality


@dataclass(frozen=True)
class Classified:
    """What a classifier says of each texel.

    Attributes
    ----------
    material : (h, w) int16
        Index into the names of the materials, -1 where there is no data or no material.
    confidence : (h, w) float32
        Posterior of that material averaged over the box; 0 without data.
    typicality : (h, w) float32
        Share of the material's own texels that would lie farther from its mean than this one (upper tail of
        chi-squared); 0 without data.
    """

    material: np.ndarray
    confidence: np.ndarray
    typicality: np.ndarray


class Mapper(Protocol):
    """A way to find the material of the texels of one texture."""

    names: tuple[str, ...]

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify the texels of rows `top` to `bottom` and columns `left` to `right` (the ends excluded)."""


class ColourModel(Protocol):
    """What tells materials by colour alone."""

    names: tuple[str, ...]

    def tables(self, colours: np.ndarray, encoding: str) -> tuple[np.ndarray, np.ndarray]:
        """Posterior and typicality of distinct colours; see `GaussianModel.tables`."""


def fit(
    lab: np.ndarray, material: np.ndarray, names: tuple[str, ...], prior: str | dict[str, float] = "equal"
) -> GaussianModel:
    """Fit the model to seeds.

    Parameters
    ----------
    lab : (N, D) float64
        Coordinates of the seeds.
    material : (N,) int
        Index into `names`; each occurs.
    prior : "equal", "seeds" or dict
        Relative prior probability of the materials; a dict may leave materials at 1.
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


def log_prior(names: tuple[str, ...], counts: np.ndarray, prior: str | dict[str, float]) -> np.ndarray:
    """Logarithm of the prior probability (K,) of materials with these counts (K,) of seeds; `prior` as for `fit`."""
    if prior == "equal":
        weights = np.ones(len(names))
    elif prior == "seeds":
        weights = counts
    else:
        weights = np.array([prior.get(name, 1.0) for name in names])
    return np.log(weights / weights.sum())


class ColourMapper:
    """A colour model applied to a texture, window by window; each distinct colour is classified once.

    Without `tabulate` the colours of a window are classified for it alone: for a few small windows.
    """

    def __init__(
        self, texture: Windowed, colours: DistinctColours, model: ColourModel, radius: int, tabulate: bool = True
    ):
        self.texture, self.model, self.names, self.radius = texture, model, model.names, radius
        self._colours, self._shared = colours, None
        shared = colours.colours
        if tabulate and shared is not None and len(shared) * len(model.names) <= TABLE_ENTRIES:
            self._shared = self._prepared(shared)

    def _prepared(self, colours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Posterior of colours, in pairs where it is to be averaged, and their typicality."""
        posterior, typicality = self.model.tables(colours, self.texture.encoding)
        return (pairs_of(posterior) if self.radius else posterior), typicality

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        rows, columns, inner = with_margin(self.texture, top, bottom, left, right, self.radius)
        pixels, valid = self.texture.window(rows, columns)
        colours, index = self._colours.of(pixels, valid)
        if self._shared is None and colours is None:
            used, index = np.unique(index, return_inverse=True)
            colours, index = self._colours.colours[used], index.reshape(valid.shape)
        posterior, typicality = self._shared or self._prepared(colours)
        index = index.astype(np.intp, copy=False)  # numpy gathers faster by its own index type
        if self.radius == 0:
            material, confidence = _strongest_colour(posterior, index)
        else:
            gathered = (np.take(pair, index) for pair in posterior)
            material, confidence = strongest(gathered, len(posterior), valid, self.radius, inner)
        number = np.multiply(material, typicality.shape[1], dtype=np.intp)
        number += index[inner]
        return without_data(Classified(material, confidence, np.take(typicality.ravel(), number)), valid[inner])


def with_margin(
    texture: Windowed, top: int, bottom: int, left: int, right: int, margin: int
) -> tuple[slice, slice, tuple[slice, slice]]:
    """Rows and columns of a window with a margin, as far as the texture goes, and the window within them."""
    y, x = max(top - margin, 0), max(left - margin, 0)
    rows, columns = slice(y, min(bottom + margin, texture.height)), slice(x, min(right + margin, texture.width))
    return rows, columns, np.s_[top - y : bottom - y, left - x : right - x]


def without_data(classified: Classified, valid: np.ndarray) -> Classified:
    """Take the answer away, in place, from texels without data and from those that no material claims."""
    if not (classified.confidence.all() and valid.all()):
        none = ~valid | (classified.confidence == 0)
        for array, nothing in ((classified.material, -1), (classified.confidence, 0), (classified.typicality, 0)):
            np.copyto(array, array.dtype.type(nothing), where=none)
    return classified


def _strongest_colour(posterior: np.ndarray, index: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Material of the largest posterior of each texel's own colour, and that posterior as float32."""
    material = posterior.argmax(axis=0).astype(np.int16)
    confidence = posterior.max(axis=0).astype(np.float32) / np.float32(POSTERIOR_ONE)
    return np.take(material, index), np.take(confidence, index)


def pairs_of(posterior: np.ndarray) -> np.ndarray:
    """Planes (K, ...) uint16 as pairs ((K + 1) // 2, ...) uint64, one in the lower and one in the upper 32 bits.

    Sums of a pair are the pair of the sums, at half the work; each fits 32 bits with MAX_RADIUS, so none carries over.
    """
    pairs = posterior[::2].astype(np.uint64)
    pairs[: len(posterior) // 2] |= posterior[1::2].astype(np.uint64) << np.uint64(32)
    return pairs


def strongest(
    pairs: Iterable[np.ndarray], number: int, valid: np.ndarray, radius: int, inner: tuple[slice, slice]
) -> tuple[np.ndarray, np.ndarray]:
    """Material of the largest mean posterior over the box about each inner texel, and that mean as float32.

    Parameters
    ----------
    pairs : iterable of (h, w) uint64
        Posteriors in units of 1 / POSTERIOR_ONE, as `pairs_of` makes them.
    number : int
        Of the pairs.
    valid : (h, w) bool
        Texels that count.
    """
    if not valid.all():
        pairs = (pair * valid for pair in pairs)
    sums = (_box_sum(pair, radius, inner) for pair in pairs)
    material, best = _largest(sums, number, POSTERIOR_ONE * (2 * radius + 1) ** 2)
    confidence = best.astype(np.float32) / (np.float32(POSTERIOR_ONE) * _members(valid, radius, inner))
    return material, np.minimum(confidence, np.float32(1))


def _largest(pairs: Iterable[np.ndarray], number: int, limit: int) -> tuple[np.ndarray, np.ndarray]:
    """Number (h, w) int16 of the plane with the largest value, the first among equals, and that value, uint32.

    Parameters
    ----------
    pairs : iterable of (h, w) uint64
        `number` pairs of planes; written to.
    limit : int
        The largest value that may occur.
    """
    last = 2 * number - 1
    bits = last.bit_length()
    if limit >> (32 - bits):
        return _largest_by_plane(pairs)
    # The plane's number, counted from the last, stands in the bits below its value: one maximum finds both.
    best = None
    for k, both in enumerate(pairs):
        both <<= np.uint64(bits)
        both |= np.uint64((last - 2 * k - 1) << 32 | (last - 2 * k))
        keys = both.view(np.uint32)
        best = keys if best is None else np.maximum(best, keys, out=best)
    best = np.maximum(best[:, ::2], best[:, 1::2])
    return np.int16(last) - (best & np.uint32((1 << bits) - 1)).astype(np.int16), best >> np.uint32(bits)


def _largest_by_plane(pairs: Iterable[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    material = best = None
    for k, both in enumerate(pairs):
        if best is None:
            material, best = np.zeros(both.shape, np.int16), np.zeros(both.shape, np.uint32)
        for half, value in enumerate((both.astype(np.uint32), (both >> np.uint64(32)).astype(np.uint32))):
            np.copyto(material, np.int16(2 * k + half), where=value > best)
            np.maximum(best, value, out=best)
    return material, best


def _members(valid: np.ndarray, radius: int, inner: tuple[slice, slice]) -> np.ndarray:
    """Number of texels with data in the box about each inner texel, float32, at least 1: those that its mean is
    over.
    """
    if not valid.all():
        return np.maximum(_box_sum(valid, radius, inner), 1).astype(np.float32)
    ends = zip(valid.shape, inner, strict=True)
    rows, columns = (_box_sum(np.ones((1, n), bool), radius, np.s_[:, part])[0].astype(np.float32) for n, part in ends)
    return np.multiply.outer(rows, columns)


def _box_sum(plane: np.ndarray, radius: int, inner: tuple[slice, slice]) -> np.ndarray:
    """Sum over the square of `radius` about each inner texel, with nothing beyond the edge: uint64 of pairs, else
    uint32.

    Running sums in integers are exact, whatever the block; they may wrap, their differences are right while the sum
    itself fits, which MAX_RADIUS ensures.
    """
    (height, width), side = plane.shape, 2 * radius + 1
    kind = np.uint64 if plane.dtype == np.uint64 else np.uint32
    running = np.zeros((height, width + side), kind)
    np.cumsum(plane, axis=1, dtype=kind, out=running[:, radius + 1 : radius + 1 + width])
    running[:, radius + 1 + width :] = running[:, radius + width, np.newaxis]
    across = running[:, side:][:, inner[1]] - running[:, :-side][:, inner[1]]
    running = np.zeros((height + side, across.shape[1]), kind)
    for row in range(height):  # numpy's own cumsum down the columns is many times slower than adding rows
        np.add(running[radius + row], across[row], out=running[radius + row + 1])
    running[radius + 1 + height :] = running[radius + height]
    return running[side:][inner[0]] - running[:-side][inner[0]]
