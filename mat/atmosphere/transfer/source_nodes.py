"""Interpolation of the field of diffuse light: between elevations of the source, and between levels of the air."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.schemas.arrays import Floats, Integers, Singles

# Elevations of the source at which the field is solved, degree; between them its ratio to `typical_light` is linear in
# the sine.
ELEVATIONS: tuple[float, ...] = (
    *(-20, -10, -8, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3.5),
    *(5.5, 8, 12, 17, 23, 30, 38, 47, 57, 70, 90),
)
# In twilight, scattered light near the ground falls by a factor e for each degree, high up more slowly; this rate,
# degree^-1, below the first of two elevations, degree, and none above the second, is between.
_FALL, _FALLING = 0.7, (-2.0, 1.0)


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
    """The elevations between which a source stands along a ray, and their weights.

    Parameters
    ----------
    sine : (U,) array
        Of the elevations of the source at which the field is solved.
    cosine : (K+1, S) array
        Of the source's zenith angle at the segment ends.

    Returns
    -------
    nodes : (V,) int array
        The elevations that are needed, increasing.
    weight : (K, S, V) array
        Of each in the middle of each segment; single precision.
    """
    weight = elevation_weights(sine, 0.5 * (cosine[:-1] + cosine[1:]))
    nodes = np.flatnonzero(np.any(weight > 0, axis=(0, 1)))
    return nodes, weight[..., nodes].astype(np.float32)


def elevation_weights(sine: Floats, cosine: Floats) -> Floats:
    """Weights (..., U) of fields under sources at elevations of sines (U,), for cosines (...) of zenith angles; held
    beyond both ends.
    """
    inside = np.clip(cosine, sine[0], sine[-1])
    place = np.interp(inside, sine, np.arange(sine.size))
    weight: Floats = np.maximum(1 - np.abs(place[..., None] - np.arange(sine.size)), 0.0)
    weight *= typical_light(inside)[..., None] / typical_light(sine)
    return weight


def typical_light(sine: Floats) -> Floats:
    """Scattered light under a source whose elevation has this sine, about as it falls in twilight; 1 by day."""
    low, high = _FALLING
    above = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0))) - low
    fall = np.maximum(high - low - np.maximum(above, 0.0), 0.0) ** 2 / (2 * (high - low)) - np.minimum(above, 0.0)
    light: Floats = np.exp(-_FALL * fall)
    return light


def layer_weights(segments: Segments, levels: Floats, extinction: Floats, depths: Depths) -> tuple[Singles, Singles]:
    """Weights of the source function at the two levels of each segment's layer in the radiance at the observer.

    They hold for a source linear in optical depth between the segment's ends, whose mean counts each level by its
    extinction.

    Parameters
    ----------
    segments : Segments
    levels : (N,) array
        Altitude, m.
    extinction : (N, P) array
        m^2 per molecule.
    depths : Depths

    Returns
    -------
    lower, upper : (K, P) arrays
        Not negative; single precision.
    """
    near, far = depths.source_weights
    total = near + far
    climb = (0.5 * np.diff(segments.altitude) / np.diff(levels)[segments.layer]).astype(near.dtype)[:, None]
    upper = segments.upper_part(extinction, depths.per_segment)
    above = np.clip(total * upper + (far - near) * climb, 0, total)
    below = total - above
    transmittance = depths.transmittance
    return (
        (transmittance * below).astype(np.float32, copy=False),
        (transmittance * above).astype(np.float32, copy=False),
    )
