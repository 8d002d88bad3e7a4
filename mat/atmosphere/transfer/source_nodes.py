"""Interpolation of the field of diffuse light between elevations of the source."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.node_cubics import NodeCubics
from skyshine.schemas.arrays import Floats, Integers, Singles

# Elevations of the source at which the field is solved, degree; between them its ratio to `typical_light` is linear in
# the sine, above `_SMOOTH` the field itself is a cubic of the elevation.
ELEVATIONS: tuple[float, ...] = (
    *(-20, -10, -8, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3.5),
    *(5.5, 8, 12, 17, 23, 30, 38, 47, 57, 70, 90),
)
_SMOOTH = 5.5  # elevation of the source [degree]
# In twilight, scattered light near the ground falls by a factor e for each degree, high up more slowly; this rate,
# degree^-1, below the first of two elevations, degree, and none above the second, is between.
FALL, FALLING = 0.7, (-2.0, 1.0)


def elevations_from(lowest: float) -> tuple[float, ...]:
    """Those of `ELEVATIONS` that sources at an elevation [degree] and above need."""
    return ELEVATIONS[max(int(np.searchsorted(ELEVATIONS, lowest, side="right")) - 1, 0) :]


def elevations_along(sine: npt.ArrayLike) -> tuple[float, ...]:
    """The lowest and the highest elevation [degree] of sources whose elevations have these sines, exact there, and
    those of `ELEVATIONS` between.
    """
    low, high = (float(np.degrees(np.arcsin(np.clip(edge(sine), -1.0, 1.0)))) for edge in (np.min, np.max))
    low, high = (min(max(edge, ELEVATIONS[0]), ELEVATIONS[-1]) for edge in (low, high))
    if high - low < 1e-6:
        return (low,)
    return low, *(node for node in ELEVATIONS if low + 1e-6 < node < high - 1e-6), high


def source_nodes(sine: Floats, cosine: Floats) -> tuple[Integers, Singles]:
    """The elevations between which a source is along a ray, and their weights.

    Parameters
    ----------
    sine : (U,) array
        Sine of the elevations of the source at which the field is solved.
    cosine : (K+1, S) array
        Cosine of the source's zenith angle at the segment ends.

    Returns
    -------
    nodes : (V,) int array
        The elevations that are needed, one after the other, increasing.
    weight : (K, S, V) array
        Of each in the middle of each segment; single precision.
    """
    weight = elevation_weights(sine, 0.5 * (cosine[:-1] + cosine[1:]))
    nonzero = np.flatnonzero(np.any(weight != 0, axis=(0, 1)))
    nodes = np.arange(nonzero[0], nonzero[-1] + 1) if nonzero.size else nonzero
    return nodes, weight[..., nodes].astype(np.float32)


def elevation_weights(sine: Floats, cosine: Floats) -> Floats:
    """Weights (..., U) of fields under sources at elevations of sines (U,), for cosines (...) of zenith angles; held
    beyond both ends. From `_SMOOTH` on they are those of a cubic through four elevations.
    """
    inside = np.clip(np.ravel(cosine), sine[0], sine[-1])
    weight = np.zeros((inside.size, sine.size))
    smooth_start = first_smooth(sine)
    cubics = elevation_cubics(sine, smooth_start)
    high = np.zeros(inside.size, bool) if cubics is None else inside >= sine[smooth_start]
    (low,) = np.nonzero(~high)
    if low.size:
        position = np.interp(inside[low], sine, np.arange(sine.size))
        below = np.minimum(position.astype(int), max(sine.size - 2, 0))
        light, at_nodes = typical_light(inside[low]), typical_light(sine)
        weight[low, below] = (1 - (position - below)) * light / at_nodes[below]
        above = np.minimum(below + 1, sine.size - 1)
        weight[low, above] += (position - below) * light / at_nodes[above]
    if cubics is not None and low.size < inside.size:
        (above,) = np.nonzero(high)
        nodes, near = cubics.weights(np.arcsin(inside[above]))
        rows = above[:, None] * sine.size + smooth_start + nodes[:, None] + np.arange(near.shape[1])
        weight.reshape(-1)[rows] = near
    return weight.reshape(*np.shape(cosine), sine.size)


def first_smooth(sine: Floats) -> int:
    """The first of the elevations, of sines (U,), from which the field is smooth."""
    return int(np.searchsorted(sine, np.sin(np.radians(_SMOOTH)) - 1e-9))


def elevation_cubics(sine: Floats, start: int) -> NodeCubics | None:
    """Cubics through the elevations from the first smooth one on; None where these are too few."""
    return _cubics(tuple(sine[start:].tolist())) if sine.size - start >= 4 else None


@lru_cache(maxsize=64)
def _cubics(sine: tuple[float, ...]) -> NodeCubics:
    """Cubics through elevations of increasing sines."""
    return NodeCubics.of(np.arcsin(sine))


def typical_light(sine: Floats) -> Floats:
    """Scattered light under a source whose elevation has this sine, about as it falls in twilight; 1 by day."""
    low, high = FALLING
    above = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0))) - low
    fall = np.maximum(high - low - np.maximum(above, 0.0), 0.0) ** 2 / (2 * (high - low)) - np.minimum(above, 0.0)
    light: Floats = np.exp(-FALL * fall)
    return light
