"""Surface temperatures at single places, solved directly: what a temperature table is judged against."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from skyshine.mat.surface.back_boundary import at_hours
from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.sun_path import SunPath
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats, Integers

_BATCH = 24  # places whose altitudes x planes are set up together; only the pairs asked for are solved


def temperatures_at(
    materials: Sequence[SurfaceMaterial],
    inputs: tuple[SunPath, NearSurfaceAir, Sky],
    altitude_km: Floats,
    azimuth_deg: Floats,
    slope_deg: Floats,
    time_h: Floats,
    *,
    steps: int,
    given: Mapping[str, float | tuple[float, ...]] | None = None,
) -> Floats:
    """Temperature of every material at every place.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    inputs : SunPath, NearSurfaceAir, Sky
        Of `scene.surface.scene_inputs`.
    altitude_km, azimuth_deg, slope_deg, time_h : (n,) arrays
    steps : int
        Solver times of a day, a divisor of 576.
    given : mapping, optional
        As `surface.table.temperature_table`.

    Returns
    -------
    (n, M) ndarray
        K; linear between the solver's times.
    """
    columns = [np.asarray(a, float) for a in (altitude_km, azimuth_deg, slope_deg, time_h)]
    count = columns[0].size
    result = np.empty((count, len(materials)))
    for start in range(0, count, _BATCH):
        part = slice(start, min(start + _BATCH, count))
        altitude, azimuth, slope, time = (column[part] for column in columns)
        scene = Scene(*inputs, altitude * 1e3, slope, azimuth)
        # Of all pairs of altitude and plane, those that belong to one place.
        forcing_at = _forcing_of(scene, np.arange(altitude.size) * (altitude.size + 1))
        for number, material in enumerate(materials):
            if given and material.name in given:
                result[part, number] = at_hours(given[material.name], time)
                continue
            for rows, solution in solve_columns(material, forcing_at, steps=steps):
                result[start + rows, number] = _at_time(solution.temperature, time[rows])
    return result


def _forcing_of(scene: Scene, columns: Integers) -> Callable[[int], Forcing]:
    """Forcing of some columns of a scene by the number of times, each number set up once."""
    forcings: dict[int, Forcing] = {}

    def forcing_at(count: int) -> Forcing:
        if count not in forcings:
            forcings[count] = scene.forcing(count).columns(columns)
        return forcings[count]

    return forcing_at


def _at_time(temperature: Floats, time_h: Floats) -> Floats:
    """Interpolate periodic temperatures (n, N), each row at its own hour."""
    steps = temperature.shape[1]
    place = np.mod(time_h, 24.0) * steps / 24.0
    before = np.floor(place).astype(int)
    share, row = place - before, np.arange(len(temperature))
    at_time: Floats = temperature[row, before % steps] * (1 - share) + temperature[row, (before + 1) % steps] * share
    return at_time
