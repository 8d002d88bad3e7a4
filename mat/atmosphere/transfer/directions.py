"""Directions at which diffuse radiance is tabulated, and that radiance from the source function."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.segments import source_weights
from skyshine.schemas.arrays import Floats, Reals

# Of the directions of each hemisphere at which radiance is tabulated where all may be asked for, they are even in
# arctanh(sin(angle from the vertical)): about the angle itself near the vertical, the logarithm of the cosine near the
# horizon. So many, down to this cosine; plane layers have no end along the horizon itself.
_COUNT, _LOWEST = 12, 0.02
_STEEP = np.arcsin(np.tanh(np.linspace(0.0, np.arctanh(np.sqrt(1 - _LOWEST**2)), _COUNT)))
DIRECTIONS: tuple[float, ...] = tuple(np.concatenate([_STEEP, np.pi - _STEEP[::-1]]).tolist())


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


def direction_weights(upward_cosine: Floats, angles: Floats) -> Floats:
    """Weights (K, X) of increasing angles (X,) for directions: of a cubic through the four nearest of the hemisphere,
    or of a straight line through two; held beyond the last.
    """
    weight = np.zeros((upward_cosine.size, angles.size))
    tabulated, wanted = np.cos(angles), np.clip(upward_cosine, -1.0, 1.0)
    above, rises = tabulated > 0, wanted > 0
    if np.all(above) or not np.any(above):  # all directions are asked of the one hemisphere there is
        rises = np.full(wanted.size, above[0])
    for rows, nodes in ((np.flatnonzero(rises == side), np.flatnonzero(above == side)) for side in (True, False)):
        if rows.size:
            known, place = (
                np.arctanh(np.sqrt(1 - np.clip(c, -1, 1) ** 2).clip(0, 1 - 1e-12))
                for c in (tabulated[nodes], wanted[rows])
            )
            order = np.argsort(known)
            weight[rows[:, None], nodes[order]] = line_or_cubic(known[order], place)
    return weight


def line_or_cubic(known: Floats, wanted: Floats) -> Floats:
    """Weights (K, X) of values at increasing places (X,) for places (K,) between, held beyond both ends: of a cubic
    through the four around, if there are so many, or of a straight line through two.
    """
    inside = np.clip(wanted, known[0], known[-1])
    count = 4 if known.size >= 4 else min(known.size, 2)
    lower = np.clip(np.searchsorted(known, inside, side="right") - 1, 0, max(known.size - 2, 0))
    nodes = np.clip(lower - (count - 1) // 2, 0, known.size - count)[:, None] + np.arange(count)
    weight = np.zeros((inside.size, known.size))
    there = known[nodes]
    beyond = inside[:, None] - there
    for i in range(count):
        part = np.ones(inside.size)
        for j in range(count):
            if j != i:
                part *= beyond[:, j] / (there[:, i] - there[:, j])
        weight[np.arange(inside.size), nodes[:, i]] = part
    return weight


def along_directions(cosine: Floats, depth: Floats, emitted: Reals, ground: Floats) -> Reals:
    """Radiances at the levels in directions, from the light that each layer adds.

    Parameters
    ----------
    cosine : (X,) array
        Of the directions, positive up; none is 0.
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
