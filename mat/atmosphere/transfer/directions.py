"""Directions at which source functions are tabulated, and radiances in those directions from the source function."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.segments import source_weights
from skyshine.schemas.arrays import Floats, Integers, Reals

# Angles from the vertical at which a source function is tabulated, rad, where all directions may be asked for; between
# them it is linear in the angle.
DIRECTIONS: tuple[float, ...] = tuple(np.linspace(0.0, np.pi, 16).tolist())
_LEVEL = np.radians(1.0)  # no direction is nearer to the horizon's, in which plane layers have no end


def angles_along(upward_cosine: npt.ArrayLike) -> tuple[float, ...]:
    """Angles of a table for some directions alone: the largest and the smallest of them, exact there, and those of
    `DIRECTIONS` between; two at least.
    """
    angle = np.arccos(np.clip(upward_cosine, -1.0, 1.0))
    grid = np.array(DIRECTIONS)
    low, high = float(np.min(angle)), float(np.max(angle))
    if abs(low - 0.5 * np.pi) < _LEVEL:
        low = float(grid[grid < 0.5 * np.pi][-1])
    if abs(high - 0.5 * np.pi) < _LEVEL:
        high = float(grid[grid > 0.5 * np.pi][0])
    if high - low < 1e-9:  # a second one, away from the horizon
        step = 0.1 if (low < 0.1 or 0.5 * np.pi < low < np.pi - 0.1) else -0.1
        low, high = sorted((low, low + step))
    return low, *grid[(grid > low + 1e-9) & (grid < high - 1e-9)].tolist(), high


def place(upward_cosine: Floats, angles: Floats) -> tuple[Integers, Floats]:
    """Lower neighbour (K,) of directions among increasing angles (X,), and the weight (K,) of the next."""
    index = np.interp(np.arccos(np.clip(upward_cosine, -1.0, 1.0)), angles, np.arange(angles.size))
    first = np.minimum(index.astype(int), angles.size - 2)
    return first, index - first


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


def from_parts(cosine: Floats, depth: Floats, below: Floats, above: Floats, bend: Floats) -> Floats:
    """Light (K, X, U, P) that leaves parts of layers in directions (X,), of a source quadratic in optical depth.

    Parameters
    ----------
    cosine : (X,) array
    depth : (K, P) array
    below, above : (K, X, U, P) arrays
        Source function at the lower and at the upper end of each part.
    bend : (K, X, U, P) array
        Half its second derivative.
    """
    slant = depth[:, None] / np.abs(cosine)[:, None]  # (K, X, P)
    near, far = source_weights(slant)
    rises = (cosine > 0)[:, None]
    emitted = np.where(rises, far, near)[:, :, None] * below
    emitted += np.where(rises, near, far)[:, :, None] * above
    emitted += (_bend_weight(slant) * cosine[:, None] ** 2)[:, :, None] * bend
    return emitted


def level_weights(cosine: Floats, lower: Floats, upper: Floats) -> tuple[Floats, Floats]:
    """Weights (N-1, X, P) of the source function at the lower and at the upper level of layers, in the light that
    crosses them in directions (X,).

    They are those of `source_nodes.layer_weights` and, but for its limits, of `segments.Segments.source_ends` for lines
    of sight through whole layers: the source's mean counts each level by its part of the optical depth, `lower` or
    `upper` (N-1, P).
    """
    depth = lower + upper
    share = (upper / np.where(depth > 0, depth, 1.0))[:, None]
    near, far = source_weights(depth[:, None] / np.abs(cosine)[:, None])
    slope = 0.5 * (far - near) * np.where(cosine > 0, -1.0, 1.0)[:, None]
    above = np.clip((near + far) * share + slope, 0.0, near + far)
    return near + far - above, above


def _bend_weight(depth: Floats) -> Floats:
    """Integral of s (s - d) exp(-s) from 0 to d, by d."""
    series = -(depth**3) / 6 * (1 - depth / 2 + 3 * depth**2 / 20 - depth**3 / 30)
    return np.where(depth < 0.03, series, 2 - depth - (2 + depth) * np.exp(-depth))
