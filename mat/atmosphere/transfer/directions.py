"""Directions at which source functions are tabulated, and radiances in those directions from the source function."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.transfer.segments import source_weights
from skyshine.schemas.arrays import Floats, Integers

# Angles from the vertical at which a source function is tabulated; between them it is linear in the angle.
DIRECTIONS = np.linspace(0.0, np.pi, 16)
COSINES = np.cos(DIRECTIONS)


def place(upward_cosine: Floats) -> tuple[Integers, Floats]:
    """Lower neighbour (K,) of directions among `DIRECTIONS`, and the weight (K,) of the next."""
    index = np.arccos(np.clip(upward_cosine, -1.0, 1.0)) / DIRECTIONS[1]
    first = np.minimum(index.astype(int), DIRECTIONS.size - 2)
    return first, index - first


def along_directions(lower: Floats, upper: Floats, source: Floats, ground: Floats) -> Floats:
    """Radiances at the levels in `DIRECTIONS`, from the source function.

    Parameters
    ----------
    lower, upper : (N-1, P) arrays
        The parts of the layers' optical depth, from the ground up, that follow from the properties of each layer's
        lower and upper level.
    source : (N, M, X, U, P) array
        Source function at the levels.
    ground : (U, P) array
        Radiance of the ground, the same in all directions.

    Returns
    -------
    (N, M, X, U, P) array
    """
    result = np.zeros_like(source)
    up, down = COSINES > 0, COSINES < 0
    result[0, 0, up] = ground
    depth = lower + upper
    share = (upper / np.where(depth > 0, depth, 1.0))[:, None]
    slant = depth[:, None] / np.abs(COSINES)[:, None]  # (N-1, X, P)
    near, far = source_weights(slant)
    # The source's mean counts each level by its extinction; its slope is limited so that no weight is negative.
    slope = 0.5 * (far - near) * np.where(up, -1.0, 1.0)[:, None]
    above = np.clip((near + far) * share + slope, 0.0, near + far)
    below = (near + far - above)[:, None, :, None]
    above, transmittance = above[:, None, :, None], np.exp(-slant)[:, None, :, None]
    emitted = below * source[:-1] + above * source[1:]
    for k in range(len(depth)):
        result[k + 1][:, up] = result[k][:, up] * transmittance[k][:, up] + emitted[k][:, up]
    for k in range(len(depth) - 1, -1, -1):
        result[k][:, down] = result[k + 1][:, down] * transmittance[k][:, down] + emitted[k][:, down]
    return result
