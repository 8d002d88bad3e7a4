"""The last of consecutive days: what the ground keeps of the days before comes back as a flux to its surface.

Y(s) T(s) of `conduction`, sampled in steps, is a sum over the steps before, however long ago. Steps of the day itself
make a triangular matrix; those of each day before make a matrix of their own, whose product with that day's known
temperatures is a source. So each day is solved as a periodic one is, and nothing inside the stack is stored. Before the
first day lies that day, over and over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import numpy as np

from skyshine.mat.surface.back_boundary import BackFlux, back_drive
from skyshine.mat.surface.canopy_days import solve_canopy
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction, delayed_responses
from skyshine.mat.surface.day_blocks import day_block, left_by_days_before, mean_air
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.penetrating_light import absorbed_sunlight, delayed_light, penetrating_light_matrix
from skyshine.mat.surface.solution import Method, Solution
from skyshine.mat.surface.solver import (
    DAY,
    METHODS,
    STEPS,
    STURDY_STEPS,
    by_sturdier_schemes,
    clock,
    solve_by,
    solve_columns,
)
from skyshine.schemas.arrays import Floats, Integers, Reals


@dataclass(frozen=True, eq=False)
class OneDay(Conduction):
    """Conduction of a day that does not repeat: flux = C T of its own temperatures alone, C lower triangular."""

    @cached_property
    def matrix(self) -> Floats:
        response, _ = delayed_responses(self.stack, self.period / self.steps, self.steps, self.scheme)
        return day_block(response, self.steps, 0)

    def flux(self, temperature: Reals) -> Floats:
        return temperature @ self.matrix.T

    def mean_flux(self, temperature: Floats) -> Floats:
        mean: Floats = temperature @ self.matrix.mean(axis=0)
        return mean


def solve_days(
    material: SurfaceMaterial,
    days: Sequence[Callable[[int], Forcing]],
    *,
    steps: int = STEPS,
    fine_steps: int | None = STURDY_STEPS,
) -> list[tuple[Integers, Solution]]:
    """Solve all columns of a material through consecutive days.

    Parameters
    ----------
    material : SurfaceMaterial
        A back whose temperature is the mean of the air has that of all days.
    days : sequence of D callables
        Each as `solve_columns` takes it, oldest first, all with the same columns. One day repeats.
    steps, fine_steps
        As `solve_columns` takes them; several days are solved by BDF2, whose response ends with the present.

    Returns
    -------
    list of (index, Solution)
        Of the last day; the `energy_closure` is that of its balance.

    Raises
    ------
    InputError
        The forcing contains values that no balance can have.
    ConvergenceError
        No method solves a column of one of the days.
    """
    if material.canopy is not None:
        return solve_canopy(material, days, steps=steps, fine_steps=fine_steps)
    if len(days) == 1:
        return solve_columns(material, days[0], steps=steps, fine_steps=fine_steps)
    forcings = [day(max(fine_steps or steps, steps)) for day in days]
    for forcing in forcings:
        forcing.check()

    def solve(name: str, chosen: Integers) -> Solution:
        return _last_day(material, [forcing.columns(chosen) for forcing in forcings], METHODS[name], chosen)

    return by_sturdier_schemes("bdf2", forcings[-1].shape[0], solve)


def joined_days(scenes: Sequence[Scene]) -> list[Callable[[int], Forcing]]:
    """`Scene.days` of several scenes with the same days before, the columns of all one after the other."""
    return [lru_cache(maxsize=None)(partial(_joined, parts)) for parts in zip(*(s.days for s in scenes), strict=True)]


def _joined(parts: Sequence[Callable[[int], Forcing]], steps: int) -> Forcing:
    return Forcing.stacked([part(steps) for part in parts])


def _last_day(material: SurfaceMaterial, forcings: Sequence[Forcing], method: Method, names: Integers) -> Solution:
    """The last day by one scheme; all steps are those of the forcings."""
    steps = forcings[0].shape[1]
    periodic = Conduction(material.thermal, steps, DAY, "euler" if method == Method.EULER else "bdf2")
    hours, air = clock(periodic), mean_air(forcings)
    responses = delayed_responses(material.thermal, DAY / steps, len(forcings) * steps, periodic.scheme)
    surface, back = ([day_block(response, steps, day) for day in range(len(forcings))] for response in responses)
    one_day = OneDay(material.thermal, steps, DAY, periodic.scheme)
    solution: Solution | None = None
    before: list[Floats] = []
    film: Floats | None = None
    drives: list[Floats] = []
    for forcing in forcings:
        back_flux = BackFlux.of(material, forcing, periodic, hours, air)
        drives.append(back_drive(material, forcing, hours, air))
        if before:
            source = drives[-1] * periodic.steady_transfer
            if drives[-1].shape[1] > 1:
                source = drives[-1] @ back[0].T + left_by_days_before(drives[:-1], back, periodic.back_matrix)
            if material.thermal.light:
                light = _light_of_days(material, forcings[: len(before) + 1], periodic)
                source, back_flux = source + light, back_flux.with_heat(light)
            source = source - left_by_days_before(before, surface, periodic.matrix)
            ends = np.array([(day.min(axis=1), day.max(axis=1)) for day in (*before, *drives[:-1])])
            back_flux = back_flux.after(source, ends[:, 0].min(axis=0)[:, None], ends[:, 1].max(axis=0)[:, None])
        conduction = one_day if before else periodic
        solution = solve_by(material, forcing, conduction, back_flux, method, names, film_before=film)
        film = None if solution.film is None else solution.film[:, -1]
        before.append(solution.temperature)
    assert solution is not None
    return solution


def _light_of_days(material: SurfaceMaterial, forcings: Sequence[Forcing], periodic: Conduction) -> Floats:
    """`penetrating_light_flux` on the last of some days, of the light of all (columns, N) [W m^-2]."""
    steps = periodic.steps
    response = delayed_light(periodic.stack, DAY / steps, len(forcings) * steps, periodic.scheme)
    blocks = [day_block(response, steps, day) for day in range(len(forcings))]
    absorbed = [absorbed_sunlight(material, forcing) for forcing in forcings]
    total: Floats = absorbed[-1] @ blocks[0].T + left_by_days_before(
        absorbed[:-1], blocks, penetrating_light_matrix(periodic)
    )
    return total
