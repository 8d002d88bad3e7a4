"""Surfaces that lie in the shade all day, as a photograph shows them."""

from __future__ import annotations

from typing import Any

import numpy as np

from skyshine.mat.surface.surroundings import Exposure
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.response import forcing_hours, need_parts, need_response
from skyshine.mat.tables.shade import AIR
from skyshine.schemas.arrays import Floats, Integers

# Open share of the sky above ground in the shade where nothing else is said: half, as at the foot of a long wall.
SHADED_SKY = 0.5
_BLOCK = 1024  # faces computed together


def shaded_temperature(
    surface: TemperatureTable,
    material: Integers,
    sky_view: Floats,
    *,
    altitude: Floats,
    azimuth: Floats,
    slope: Floats,
    time: Floats,
) -> Floats:
    """Temperatures (n, H) of faces in the shade all day, each under a sky of its own [K].

    Parameters
    ----------
    material : (n,) int array
        Codes.
    sky_view : (n,) array
        Open share of the sky above each face; the rest is a wall of the temperature of the air.
    altitude, azimuth, slope : (n,) array
        [km], [degree], [degree]
    time : (n, H) array
        Local clock [h].

    Raises
    ------
    InputError
        A value outside an axis, or the table has no response to shade.
    """
    kelvin, shaded = np.empty(time.shape), np.ones((1, forcing_hours().size))
    for start in range(0, material.size, _BLOCK):
        rows = slice(start, start + _BLOCK)
        exposure = Exposure(shaded, np.asarray(sky_view, float)[rows, None])
        where: dict[str, Any] = {"altitude": altitude[rows], "azimuth": azimuth[rows], "slope": slope[rows]}
        where["material"] = material[rows]
        change = surface.exposed_change(exposure, **where)
        columns = {name: values[:, None] for name, values in where.items()}
        kelvin[rows] = surface.temperature(**columns, time=time[rows], absorbed_change=change[:, None])
    return kelvin


def air_temperature(surface: TemperatureTable, altitude: Floats, time: Floats) -> Floats:
    """Temperature (n,) of the air at altitudes [km] and clock times [h], that of walls around faces [K].

    Raises
    ------
    InputError
        The table has no response to shade, of which the air is a part.
    """
    need_response(surface.root)
    need_parts(surface.root, [AIR])
    nodes = np.asarray(surface.root.axes["altitude"].values, float)
    return surface.value(AIR, altitude=np.clip(altitude, nodes[0], nodes[-1]), forcing_time=time)
