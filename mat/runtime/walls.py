"""Ambient light of faces beside walls: the formula of ``schemas/formats/atmq-4.md``."""

from __future__ import annotations

import numpy as np

from skyshine.mat.surface.surroundings import WALL_EMISSIVITY
from skyshine.schemas.arrays import Floats


def beside_walls(
    ambient: Floats,
    level: Floats,
    wall: Floats,
    ground: Floats,
    sky_view: Floats,
    upward: Floats,
    emissivity: Floats | float = WALL_EMISSIVITY,
) -> Floats:
    """Ambient light of faces, some of whose sky a wall hides.

    Parameters
    ----------
    ambient, level : (n,) or (n, B) array
        Of the faces in the open, and of level faces there.
    wall, ground : (n,) or (n, B) array
        What black bodies with the temperatures of wall and ground emit.
    sky_view, upward : (n,) array
        Open share of the sky above each face; cosine of its slope.
    emissivity : float or (n,) array
        Of the wall.
    """
    hidden = (1 - sky_view) * 0.5 * (1 + upward)
    shine = np.broadcast_to(np.asarray(emissivity, float), hidden.shape)
    if ambient.ndim > hidden.ndim:
        hidden, shine = hidden[..., None], shine[..., None]
    wall = shine * wall + (1 - shine) * 0.5 * (level + ground)
    light: Floats = ambient + hidden * (wall - level)
    return light
