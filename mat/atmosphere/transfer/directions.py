"""Directions at which diffuse radiance is tabulated, and that radiance from the source function."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.node_cubics import NodeCubics
from skyshine.mat.atmosphere.transfer.segments import source_weights
from skyshine.schemas.arrays import Floats, Reals

# Number and lowest of the directions of each hemisphere at which radiance is tabulated where all may be asked for, they
# are even in arctanh(sin(angle from the vertical)): about the angle itself near the vertical, the logarithm of the
# cosine near the horizon. So many, down to this cosine; plane layers have no end along the horizon itself.
_COUNT, _LOWEST = 12, 0.02
_STEEP = np.arcsin(np.tanh(np.linspace(0.0, np.arctanh(np.sqrt(1 - _LOWEST**2)), _COUNT)))
DIRECTIONS: tuple[float, ...] = tuple(np.concatenate([_STEEP, np.pi - _STEEP[::-1]]).tolist())
# Directions below the horizon follow those above, in order: from here on less what they are even in.
_TURN = 100.0


def angles_along(upward_cosine: npt.ArrayLike) -> tuple[float, ...]:
    """Angles of a table for some directions alone, increasing: the largest and the smallest of them, exact there, and
    those of `DIRECTIONS` between; in place of the horizon's the nearest of those.
    """
    angle = np.arccos(np.clip(upward_cosine, -1.0, 1.0))
    grid = np.array(DIRECTIONS)
    low, high = float(np.min(angle)), float(np.max(angle))
    if abs(np.cos(low)) < _LOWEST:
        low = float(grid[_COUNT - 1])
    if abs(np.cos(high)) < _LOWEST:
        high = float(grid[_COUNT])
    if high - low < 1e-9:
        return (low,)
    return low, *grid[(grid > low + 1e-9) & (grid < high - 1e-9)].tolist(), high


@lru_cache(maxsize=64)
def direction_cubics(angles: tuple[float, ...]) -> tuple[NodeCubics, int]:
    """Cubics through directions at increasing angles, and the number of those above the horizon."""
    cosine = np.cos(angles)
    above = int(np.count_nonzero(cosine > 0))
    coordinate = _even(cosine)
    nodes = np.concatenate([coordinate[:above], _TURN - coordinate[above:]])
    return NodeCubics.of(nodes, [above] if 0 < above < len(angles) else []), above


def _even(cosine: Floats) -> Floats:
    """What directions are even in, from 0 at the vertical on."""
    sine = np.sqrt(np.maximum(1 - cosine**2, 0.0))
    coordinate: Floats = np.arctanh(np.minimum(sine, 1 - 1e-12))
    return coordinate


def along_directions(cosine: Floats, depth: Floats, emitted: Reals, ground: Floats) -> Reals:
    """Radiances at the levels in directions, from the light that each layer adds.

    Parameters
    ----------
    cosine : (X,) array
        Cosines of the directions, positive up; none is 0.
    depth : (N-1, P) array
        Optical depth of the layers, from the ground up.
    emitted : (N-1, X, U, P) array
        Radiance that leaves each layer out of its own source; single or double precision.
    ground : (U, P) array
        Radiance of the ground, the same in all directions.

    Returns
    -------
    (N, X, U, P) array
    """
    result = np.zeros((len(depth) + 1, *emitted.shape[1:]), emitted.dtype)
    up, down = np.flatnonzero(cosine > 0), np.flatnonzero(cosine < 0)
    result[0, up] = ground
    transmittance = np.exp(-depth[:, None] / np.abs(cosine)[:, None]).astype(emitted.dtype)[:, :, None]
    for k in range(len(depth)):
        result[k + 1, up] = result[k, up] * transmittance[k, up] + emitted[k, up]
    for k in range(len(depth) - 1, -1, -1):
        result[k, down] = result[k + 1, down] * transmittance[k, down] + emitted[k, down]
    return result


def from_parts(cosine: Floats, depth: Floats, below: Reals, above: Reals, bend: Reals | None) -> Reals:
    """Light (K, X, U, P) that leaves parts of layers in directions (X,), of a source quadratic in optical depth.

    Parameters
    ----------
    cosine : (X,) array
    depth : (K, P) array
    below, above : (K, X, U, P) arrays
        Source function at the lower and at the upper end of each part.
    bend : (K, X, U, P) array or None
        Half its second derivative; None where it is linear.
    """
    slant = depth[:, None] / np.abs(cosine)[:, None]  # (K, X, P)
    near, far = source_weights(slant)
    rises = (cosine > 0)[:, None]
    emitted = np.where(rises, far, near)[:, :, None] * below
    emitted += np.where(rises, near, far)[:, :, None] * above
    if bend is not None:
        emitted += (_bend_weight(slant) * cosine[:, None] ** 2)[:, :, None] * bend
    return emitted


def _bend_weight(depth: Floats) -> Floats:
    """Integral of s (s - d) exp(-s) from 0 to d, by d."""
    series = -(depth**3) / 6 * (1 - depth / 2 + 3 * depth**2 / 20 - depth**3 / 30)
    return np.where(depth < 0.03, series, 2 - depth - (2 + depth) * np.exp(-depth))
