"""Interpolation of the field of diffuse light: between elevations of the source, and between levels of the air."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.schemas.arrays import Floats, Integers, Singles

# Elevations of the source at which the field is solved, degree; between them it is linear in the sine.
ELEVATIONS: tuple[float, ...] = (
    *(-20, -14, -10, -7, -5, -3.5, -2, -1, 0, 1, 2, 3.5),
    *(5.5, 8, 12, 17, 23, 30, 38, 47, 57, 70, 90),
)


def elevations_around(sine: npt.ArrayLike) -> tuple[float, ...]:
    """Those of `ELEVATIONS` [degree] between which sources stand whose elevations have these sines."""
    nodes = np.sin(np.radians(ELEVATIONS))
    low, high = np.min(sine), np.max(sine)
    first = np.clip(np.searchsorted(nodes, low, side="right") - 1, 0, nodes.size - 2)
    last = np.clip(np.searchsorted(nodes, high, side="left"), first + 1, nodes.size - 1)
    return ELEVATIONS[first : last + 1]


def source_nodes(sine: Floats, cosine: Floats) -> tuple[Integers, Singles]:
    """The elevations between which a source stands along a ray, and their linear weights.

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
    middle = np.clip(0.5 * (cosine[:-1] + cosine[1:]), sine[0], sine[-1])
    place = np.interp(middle, sine, np.arange(sine.size))
    nodes = np.union1d(np.floor(place), np.ceil(place)).astype(int)
    return nodes, np.maximum(1 - np.abs(place[..., None] - nodes), 0.0).astype(np.float32)


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
