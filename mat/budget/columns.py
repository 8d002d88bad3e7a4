"""Surface temperatures at single places, solved directly: what a temperature table is judged against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from skyshine.mat.surface.back_boundary import at_hours
from skyshine.mat.surface.days import joined_days, solve_days
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.reading import at_hours_of_day
from skyshine.mat.surface.sun_path import SunPath
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats


def temperatures_at(
    materials: Sequence[SurfaceMaterial],
    inputs: tuple[SunPath, NearSurfaceAir, Sky],
    altitude_km: Floats,
    azimuth_deg: Floats,
    slope_deg: Floats,
    time_h: Floats,
    *,
    steps: int,
    material_temperatures: Mapping[str, float | tuple[float, ...]] | None = None,
    surroundings: Sequence[Surroundings] | None = None,
) -> Floats:
    """Temperature of every material at every place.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    inputs : SunPath, NearSurfaceAir, Sky
        Inputs from `scene.surface.scene_inputs`.
    altitude_km, azimuth_deg, slope_deg, time_h : (n,) arrays
    steps : int
        Solver times of a day, a divisor of 576.
    material_temperatures : mapping, optional
        Temperatures of materials that are not computed, as for `surface.table.temperature_table`.
    surroundings : sequence of n Surroundings, optional
        Surroundings of each place; by default none.

    Returns
    -------
    (n, M) ndarray
        K; linear between the solver's times.
    """
    columns = [np.asarray(a, float) for a in (altitude_km, azimuth_deg, slope_deg, time_h)]
    altitude, azimuth, slope, time = columns
    per_row = [None] * time.size if surroundings is None else list(surroundings)
    scenes = [
        Scene(*inputs, altitude[row : row + 1] * 1e3, slope[row : row + 1], azimuth[row : row + 1], per_row[row])
        for row in range(time.size)
    ]
    days = joined_days(scenes) if scenes else []
    result = np.empty((time.size, len(materials)))
    for number, material in enumerate(materials):
        if material_temperatures and material.name in material_temperatures:
            result[:, number] = at_hours(material_temperatures[material.name], time)
            continue
        for rows, solution in solve_days(material, days, steps=steps) if scenes else ():
            result[rows, number] = _at_time(solution.temperature, time[rows])
    return result


def _at_time(temperature: Floats, time_h: Floats) -> Floats:
    """Interpolated periodic temperatures (n, N), each row at its own hour, as tables are read from a solution."""
    rows = zip(temperature, time_h, strict=True)
    return np.array([at_hours_of_day(day[None], np.array([hour]))[0, 0] for day, hour in rows])
