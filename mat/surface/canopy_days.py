"""Temperatures of leaves and of the soil in their gaps through a period or the last of consecutive days.

Rain falls through the gaps seen from above; the rest fills the film of the leaves, whose overflow drips to the soil.
Both films evaporate through the air of their own paths (`canopy`).

References
----------
Interception by the covered share, and drip of what exceeds the storage: Rutter et al. (1971), Agric. Meteorol. 9,
367-384, with the film's share of the leaves as evaporation has it (`wet_skin`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from skyshine.mat.surface.back_boundary import BackFlux, back_drive
from skyshine.mat.surface.canopy import CanopyBalance, gap_towards, seen_temperature
from skyshine.mat.surface.canopy_conduction import CanopyConduction, CanopyDay
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction, delayed_responses
from skyshine.mat.surface.day_blocks import day_block, left_by_days_before, mean_air
from skyshine.mat.surface.film import LATENT_HEAT, WetSkin, evaporated, film_of, solve_with_film
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.newton import DENSE_STEPS, solve_newton
from skyshine.mat.surface.relaxation import TOLERANCE, Relaxation, first_guess
from skyshine.mat.surface.solution import Method, Solution
from skyshine.mat.surface.solver import (
    DAY,
    METHODS,
    STURDY_STEPS,
    bound_excess,
    by_sturdier_schemes,
    chunks,
    clock,
    refuse_unsettled,
)
from skyshine.mat.surface.vapour import surface_vapour
from skyshine.mat.surface.wet_skin import FilmSkin
from skyshine.schemas.arrays import Floats, Integers


@dataclass(frozen=True, eq=False)
class WetStand(WetSkin):
    """Films of leaves, then of the soil, in rows of twice as many times; the latter in kg by m^2 of ground."""

    sources = 2

    def filmed(self, forcing: Forcing, share: Floats) -> Forcing:
        leaves, soil = np.split(share, 2, axis=1)
        return replace(forcing, film=leaves, film_below=soil)

    def loss(self, forcing: Forcing, temperature: Floats) -> Floats:
        return np.asarray(CanopyBalance(forcing, self.material).loss(temperature), float)

    def temperature(self, solution: Solution) -> Floats:
        assert solution.sources is not None
        return solution.sources

    def next_film(
        self, forcing: Forcing, temperature: Floats, step: float, before: Floats | None
    ) -> tuple[Floats, Floats]:
        canopy = self.material.canopy
        assert canopy is not None and forcing.rain is not None
        leaves, soil = np.split(temperature, 2, axis=1)
        rain = forcing.rain * np.maximum(forcing.cos_slope, 0.0) + np.zeros(forcing.shape)
        through = float(gap_towards(canopy.leaf_area, 1.0))
        wet = CanopyBalance(self.filmed(forcing, np.ones((1, 2))), self.material)
        starts = (None, None) if before is None else (before[:, 0], before[:, 1])
        caught = rain * (1 - through) / wet.cover
        film, share, drip = _film(
            canopy.leaves.film, evaporated(canopy.leaves, forcing, leaves), caught, step, starts[0]
        )
        lost = wet.soil.latent_of_film(soil) * wet.gap
        vapour, ratio = surface_vapour(soil)
        if wet.soil.filmed:
            deficit = vapour - wet.soil.vapour_pressure
            lost = lost + wet.cover * deficit * ratio * wet.calm / wet.soil.psychrometer
        below, below_share, _ = _film(
            canopy.soil.film, lost / (LATENT_HEAT * ratio), rain * through + wet.cover * drip, step, starts[1]
        )
        return np.concatenate([film, below], axis=1), np.concatenate([share, below_share], axis=1)


def _film(
    skin: FilmSkin | None, flux: Floats, supply: Floats, step: float, before: Floats | None
) -> tuple[Floats, Floats, Floats]:
    """Film [kg m^-2], its share and what runs off [kg m^-2 s^-1], of evaporation and supply (columns, N)."""
    if skin is None:
        return np.zeros(supply.shape), np.zeros(supply.shape), supply
    gain, demand = np.maximum(-flux, 0.0) + supply, np.maximum(flux, 0.0)
    film, share = film_of(skin, gain, demand, step, before)
    earlier = np.roll(film, 1, axis=1)
    if before is not None:
        earlier[:, 0] = before
    return film, share, np.maximum((earlier - film) / step + gain - demand * share, 0.0)


def solve_canopy(
    material: SurfaceMaterial,
    days: Sequence[Callable[[int], Forcing]],
    *,
    steps: int,
    fine_steps: int | None = STURDY_STEPS,
    period: float = DAY,
    start_hour: float = 0.0,
    scheme: str = "spectral",
) -> list[tuple[Integers, Solution]]:
    """Solve all columns of a material with a canopy.

    Parameters
    ----------
    days : sequence of callables
        Functions as in `days.solve_days`; a single one repeats after the period.
    steps, fine_steps, scheme
        As `solver.solve_columns` takes them; several days are solved by BDF2.
    period : float
        [s]
    start_hour : float
        Clock hour at which the period begins.

    Returns
    -------
    list of (index, Solution)
        As `days.solve_days`; `sources` of each contains the temperatures of leaves and soil.

    Raises
    ------
    InputError
        The forcing contains values that no balance can have, or there is no air.
    ConvergenceError
        Newton's method does not solve a column.

    Notes
    -----
    Leaves and soil are solved together: the unknowns of a column are the temperatures of both at all times, the balance
    is diagonal in them and all that joins them, between each other and between times, is linear.
    """
    scheme_name = "bdf2" if len(days) > 1 else scheme
    fine = max(fine_steps or steps, steps)

    def solve(name: str, chosen: Integers) -> Solution:
        forcings = [day(steps if name == scheme else fine) for day in days]
        for forcing in forcings:
            forcing.check()
        return _last_day(material, [each.columns(chosen) for each in forcings], name, (period, start_hour), chosen)

    return by_sturdier_schemes(scheme_name, days[-1](steps).shape[0], solve)


def _last_day(
    material: SurfaceMaterial,
    forcings: Sequence[Forcing],
    scheme: str,
    clocked: tuple[float, float],
    names: Integers,
) -> Solution:
    """The last day by one scheme."""
    canopy = material.canopy
    assert canopy is not None
    (period, start_hour), steps = clocked, forcings[0].shape[1]
    soil = canopy.soil
    ground = Conduction(soil.thermal, steps, period, scheme)
    periodic = CanopyConduction(canopy, steps, period, scheme)
    hours, air = clock(ground, start_hour), mean_air(forcings) if len(forcings) > 1 else None
    one_day, lagged, back = periodic, [], []
    if len(forcings) > 1:
        one_day, lagged = CanopyDay(canopy, steps, period, scheme), periodic.delayed(len(forcings))
        _, from_back = delayed_responses(soil.thermal, period / steps, len(forcings) * steps, scheme)
        back = [day_block(from_back, steps, day) for day in range(len(forcings))]
    before: list[Floats] = []
    film: Floats | None = None
    drives: list[Floats] = []
    solution: Solution | None = None
    for forcing in forcings:
        below = BackFlux.of(soil, forcing, ground, hours, air)
        drives.append(back_drive(soil, forcing, hours, air))
        to_soil = below.source
        if before and drives[-1].shape[1] > 1:
            to_soil = drives[-1] @ back[0].T + left_by_days_before(drives[:-1], back, ground.back_matrix)
        to_soil = to_soil + np.zeros(forcing.shape)
        source = np.concatenate([np.zeros(forcing.shape), to_soil], axis=1)
        if before:
            source = source - left_by_days_before(before, lagged, periodic.matrix)
            ends = np.array([(day.min(axis=1), day.max(axis=1)) for day in (*before, *drives[:-1])])
            below = below.after(to_soil, ends[:, 0].min(axis=0)[:, None], ends[:, 1].max(axis=0)[:, None])
        method = METHODS[scheme]
        operator, problem = one_day if before else periodic, replace(below, source=source)
        solve = partial(_solve_parts, material, operator, problem, method, names)
        if forcing.rain is None:
            solution = solve(forcing, np.arange(forcing.shape[0]))
        else:
            solution = solve_with_film(WetStand(material), forcing, period / steps, solve, film)
            assert solution.film is not None
            film = solution.film[:, [steps - 1, 2 * steps - 1]]
        assert solution.sources is not None
        before.append(solution.sources)
    assert solution is not None
    return solution


def _solve_parts(
    material: SurfaceMaterial,
    operator: CanopyConduction,
    back_flux: BackFlux,
    method: Method,
    names: Integers,
    forcing: Forcing,
    chosen: Integers,
) -> Solution:
    """Some columns, whose forcing this is, part by part."""
    parts = []
    for part in chunks(forcing.shape[0], operator.steps):
        rows = chosen[part]
        balance = CanopyBalance(forcing.columns(part), material)
        parts.append(_solve(balance, operator, back_flux.columns(rows), method, names[rows]))
    return Solution.stacked(parts)


def _solve(
    balance: CanopyBalance, conduction: CanopyConduction, back_flux: BackFlux, method: Method, names: Integers
) -> Solution:
    """Leaves and soil of one period together: as a batch, and those that do not settle by damped Newton from the
    temperature of the air.
    """
    source = back_flux.source
    columns, unknowns = balance.shape
    temperature = first_guess(balance)
    residual: Floats = np.full(columns, np.inf)
    iterations: Integers = np.zeros(columns, np.int32)
    methods = np.full(columns, method, np.uint8)
    if unknowns <= DENSE_STEPS:
        relaxation = Relaxation.of_all_steps(balance, conduction, source)
        temperature, _, _, imbalance, iterations = relaxation.solve(balance, conduction, source)
        residual = np.abs(imbalance).max(axis=1)
    unconverged = np.flatnonzero(~(residual <= TOLERANCE))
    if unconverged.size:
        unsettled = balance.columns(unconverged)
        result = solve_newton(unsettled, conduction, source[unconverged], first_guess(unsettled), None, TOLERANCE)
        refuse_unsettled(result.residual, balance.material, conduction, names[unconverged])
        temperature[unconverged], residual[unconverged] = result.temperature, result.residual
        iterations[unconverged] += result.iterations
        methods[unconverged] = Method(method + 1)
    loss = balance.loss(temperature)
    total = balance.by_ground(loss + conduction.flux(temperature) - source)
    return Solution(
        seen_temperature(balance.canopy, temperature),
        np.zeros((columns, unknowns // 2)),
        residual,
        total.mean(axis=1),
        bound_excess(balance, temperature, loss, back_flux, None),
        methods,
        iterations,
        sources=temperature,
    )
