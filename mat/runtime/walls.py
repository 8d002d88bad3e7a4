"""Ambient light of faces beside walls: the formula of ``schemas/formats/atmq-1.md``."""

from __future__ import annotations

import numpy as np

from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY
from skyshine.mat.tables.band import BandTable
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
        Ambient radiance of the faces in the open, and of level faces there.
    wall, ground : (n,) or (n, B) array
        What black bodies with the temperatures of wall and ground emit.
    sky_view, upward : (n,) array
        Open share of the sky above each face; cosine of its slope.
    emissivity : float or (n,) array
        Emissivity of the wall.
    """
    hidden = (1 - sky_view) * 0.5 * (1 + upward)
    shine = np.broadcast_to(np.asarray(emissivity, float), hidden.shape)
    if ambient.ndim > hidden.ndim:
        hidden, shine = hidden[..., None], shine[..., None]
    wall = shine * wall + (1 - shine) * 0.5 * (level + ground)
    light: Floats = ambient + hidden * (wall - level)
    return light


def wall_as_it_shines(
    band: BandTable, emitted: Floats, reflectance: Floats | float, incident: Floats | float, sunlit: Floats | float
) -> Floats:
    """Temperature (n,) [K] of a wall of emissivity `WALL_EMISSIVITY` without sunlight that shines as other walls do.

    Parameters
    ----------
    emitted : (n,) array
        Radiance that the walls emit, in the band [W m^-2 sr^-1].
    reflectance : float or (n,) array
        Reflectance of the walls in the band.
    incident : float or (n,) array
        Mean of the ambient light of level faces and of what the ground emits as a black body [W m^-2 sr^-1].
    sunlit : float or (n,) array
        Direct light that the walls reflect: reflectance, share of the light on a surface across it, and
        `direct_radiance` multiplied [W m^-2 sr^-1].
    """
    plain = emitted + sunlit + (reflectance - (1 - WALL_EMISSIVITY)) * incident
    return equivalent_temperature(band, plain / WALL_EMISSIVITY)
