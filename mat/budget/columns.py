"""Surface temperatures at single places, solved directly: what a temperature table is judged against."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from skyshine.mat.surface.back_boundary import at_hours
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.sun_path import SunPath
from skyshine.mat.surface.weather import NearSurfaceAir

_BATCH = 24  # places whose altitudes x planes are set up together; only the pairs asked for are solved


def temperatures_at(
    materials: Sequence[SurfaceMaterial],
    inputs: tuple[SunPath, NearSurfaceAir, Sky],
    altitude_km,
    azimuth_deg,
    slope_deg,
    time_h,
    *,
    steps: int,
    given: Mapping[str, float | tuple[float, ...]] | None = None,
) -> np.ndarray:
    """Temperature of every material at every place.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    inputs : SunPath, NearSurfaceAir, Sky
        Of `surface_inputs.scene_inputs`.
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
        own = np.arange(altitude.size) * (altitude.size + 1)  # the pairs of one place, among altitudes x planes
        forcings: dict[int, object] = {}

        def forcing_at(n, scene=scene, own=own, forcings=forcings):
            if n not in forcings:
                forcings[n] = scene.forcing(n).columns(own)
            return forcings[n]

        for number, material in enumerate(materials):
            if given and material.name in given:
                result[part, number] = at_hours(given[material.name], time)
                continue
            for rows, solution in solve_columns(material, forcing_at, steps=steps):
                result[start + rows, number] = _at_time(solution.temperature, time[rows])
    return result


def _at_time(temperature: np.ndarray, time_h: np.ndarray) -> np.ndarray:
    """Periodic temperatures (n, N), each row at its own hour."""
    steps = temperature.shape[1]
    place = np.mod(time_h, 24.0) * steps / 24.0
    before = np.floor(place).astype(int)
    share, row = place - before, np.arange(len(temperature))
    return temperature[row, before % steps] * (1 - share) + temperature[row, (before + 1) % steps] * share
