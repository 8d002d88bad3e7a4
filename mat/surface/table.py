"""The temperature table of a state: every material, altitude, azimuth, slope and time of day."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.back_boundary import at_hours
from skyshine.mat.surface.days import solve_days
from skyshine.mat.surface.forcing import Scene, Sky
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.reading import at_hours_of_day
from skyshine.mat.surface.solution import Method, Solution
from skyshine.mat.surface.solver import STEPS
from skyshine.mat.surface.sun_path import SunPath
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats, Integers, Singles
from skyshine.schemas.digits import rounded_bits, rounded_to
from skyshine.schemas.errors import InputError

# Columns whose forcing is held at once where more altitudes than one are: some 15 arrays of so many at 576 times take
# 140 MB.
_COLUMNS = 2048
# Step to which temperatures are rounded, so that they pack well, where no tolerance says how well they are read [K]: by
# 0.009 K root mean square. Where one does, an eighth of it, which adds 2 % to rms errors of 0.096 K at 0.5 K.
FINEST = 1 / 32
_PARTS_OF_TOLERANCE = 8
_DIGITS = 6  # binary, of residuals and closures
_DIAGNOSTICS = {"residual": "f4", "energy_closure": "f4", "bound_excess": "f4", "method": "u1", "iterations": "i4"}


@dataclass(frozen=True, eq=False)
class SurfaceTemperatures:
    """Surface temperatures on five axes, with how each column was solved.

    Attributes
    ----------
    temperature : ndarray of float32, shape (M, A, Z, S, T)
        Material, altitude, azimuth, slope, time of day [K].
    residual : ndarray, shape (M, A, Z, S)
        Largest imbalance of fluxes at any solver time [W m^-2].
    energy_closure : ndarray, shape (M, A, Z, S)
        Daily mean of the fluxes [W m^-2].
    bound_excess : ndarray, shape (M, A, Z, S)
        How far a temperature leaves its physical bounds [K].
    method : ndarray of uint8, shape (M, A, Z, S)
        A `skyshine.mat.surface.solution.Method`.
    iterations : ndarray, shape (M, A, Z, S)
    """

    temperature: Singles
    residual: Singles
    energy_closure: Singles
    bound_excess: Singles
    method: npt.NDArray[np.uint8]
    iterations: Integers

    @property
    def method_names(self) -> str:
        """The numbers of `method` with their names, on one line."""
        return ", ".join(f"{method.value} {method.name.lower()}" for method in Method)


def temperature_table(
    materials: Sequence[SurfaceMaterial],
    sun: SunPath,
    weather: NearSurfaceAir,
    sky: Sky,
    altitudes_m: Sequence[float],
    azimuths_deg: Sequence[float],
    slopes_deg: Sequence[float],
    times_h: Sequence[float],
    *,
    steps: int = STEPS,
    prescribed: Mapping[str, float | tuple[float, ...]] | None = None,
    progress: Callable[[float], None] | None = None,
) -> SurfaceTemperatures:
    """Solve the heat balance of all columns.

    Parameters
    ----------
    materials : sequence of M SurfaceMaterial
    sun, weather, sky
        See `skyshine.mat.surface.sun_path`, `weather` and `forcing`.
    altitudes_m : (A,) sequence
        Altitudes of the surfaces above sea level.
    azimuths_deg : (Z,) sequence
        Direction a surface faces, from north eastward.
    slopes_deg : (S,) sequence
        0 faces up, 90 is a wall, 180 faces down.
    times_h : (T,) sequence
        Local clock hours of the day: the clock by which `sun` is given.
    steps : int
        Solver times of a day, a divisor of 576.
    prescribed : mapping, optional
        Temperatures [K] by name of material, which replace its heat balance: one, or 24 at the hours 0 to 23.
    progress : callable, optional
        Called with 1 after each material, or with parts of 1 where they are solved in parts.

    Raises
    ------
    InputError
        An axis is empty or out of range, or the forcing contains values that no balance can have.
    skyshine.mat.surface.solver.ConvergenceError
        No method solves a column.
    """
    slopes, azimuths = _checked_axes(materials, slopes_deg, azimuths_deg, altitudes_m, times_h)
    planes, plane_of = _planes(slopes, azimuths)
    scene = Scene(sun, weather, sky, np.asarray(altitudes_m, float), planes[:, 0], planes[:, 1])
    shape = (len(materials), len(altitudes_m), len(azimuths), len(slopes))
    hours = np.asarray(times_h, float)
    table = SurfaceTemperatures(
        np.empty((*shape, len(hours)), np.float32), *(np.empty(shape, kind) for kind in _DIAGNOSTICS.values())
    )
    for part, start in _parts(scene):
        days = part.days
        for number, material in enumerate(materials):
            if prescribed and material.name in prescribed:
                _fill_given(table, number, at_hours(prescribed[material.name], hours))
            else:
                for columns, solution in solve_days(material, days, steps=steps):
                    _fill(table, number, columns + start * len(planes), solution, plane_of, len(planes), hours)
            if progress is not None:
                progress(len(part.altitude) / len(scene.altitude))
    return table


def _parts(scene: Scene) -> Iterator[tuple[Scene, int]]:
    """Scenes, one after the other, whose forcing is held at once, with the number of the first altitude of each: few
    columns, and one altitude where days before come with it, or a month of them would take gigabytes.
    """
    together = 1 if scene.weather.before else max(1, _COLUMNS // len(scene.slope))
    for start in range(0, len(scene.altitude), together):
        yield replace(scene, altitude=scene.altitude[start : start + together]), start


def _checked_axes(
    materials: Sequence[SurfaceMaterial],
    slopes_deg: Sequence[float],
    azimuths_deg: Sequence[float],
    altitudes_m: Sequence[float],
    times_h: Sequence[float],
) -> tuple[Floats, Floats]:
    """Slopes and azimuths, once all axes are within their limits."""
    limits = {"slope": (slopes_deg, 0, 180), "azimuth": (azimuths_deg, -360, 360), "time": (times_h, 0, 24)}
    for name, (values, low, high) in limits.items():
        if len(values) == 0 or not all(low <= value <= high for value in values):
            raise InputError(f"the {name} axis: found {list(values)}; allowed: one or more values of {low} to {high}")
    if len(altitudes_m) == 0 or len(materials) == 0:
        raise InputError("found no altitude or no material; allowed: one or more of each")
    return np.asarray(slopes_deg, float), np.asarray(azimuths_deg, float)


def _planes(slopes: Floats, azimuths: Floats) -> tuple[Floats, Integers]:
    """Distinct planes (P, 2) as slope and azimuth, and which of them each (azimuth, slope) is, (Z, S).

    Level planes face no azimuth: one column serves all azimuths.
    """
    level = (slopes == 0) | (slopes == 180)
    pairs = np.stack(np.broadcast_arrays(slopes[None, :], azimuths[:, None] % 360.0), axis=-1)
    pairs[:, level, 1] = 0.0
    planes, index = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    return planes, index.reshape(len(azimuths), len(slopes))


def rounded(table: SurfaceTemperatures, tolerance: float | None = None) -> SurfaceTemperatures:
    """The table as a file has it: temperatures to `FINEST` or an eighth of the tolerance [K] at most, residuals and
    closures to two digits.
    """
    step = FINEST if tolerance is None else tolerance / _PARTS_OF_TOLERANCE
    return replace(
        table,
        temperature=rounded_to(table.temperature, step).astype(np.float32),
        residual=rounded_bits(table.residual, _DIGITS),
        energy_closure=rounded_bits(table.energy_closure, _DIGITS),
        bound_excess=rounded_bits(table.bound_excess, _DIGITS),
    )


def _fill(
    table: SurfaceTemperatures,
    number: int,
    columns: Integers,
    solution: Solution,
    plane_of: Integers,
    planes: int,
    times_h: Floats,
) -> None:
    """Put solved columns, altitudes x planes, at all azimuths and slopes of their planes."""
    rows = np.full((table.residual.shape[1], planes), -1)
    rows.ravel()[columns] = np.arange(len(columns))
    rows = rows[:, plane_of]
    solved = rows >= 0
    values = at_hours_of_day(solution.temperature.astype(np.float32), times_h)
    table.temperature[number][solved] = values[rows[solved]]
    for name in _DIAGNOSTICS:
        getattr(table, name)[number][solved] = getattr(solution, name)[rows[solved]]


def _fill_given(table: SurfaceTemperatures, number: int, temperature: Floats) -> None:
    """Put a temperature by time (T,) at all columns of a material."""
    table.temperature[number] = temperature
    for name in _DIAGNOSTICS:
        getattr(table, name)[number] = Method.GIVEN if name == "method" else 0
