"""Damped Newton where the batch iteration does not reach: long records of melting snow."""

import json
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.commands.temperature import command
from skyshine.mat.surface import newton, solver
from skyshine.mat.surface.balance import MELTING_POINT, Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.stress import random_snow
from skyshine.materials.records import Back, Layer, ThermalStack


def solve(material, forcing, period):
    steps = forcing.shape[1]
    ((_, solution),) = solve_columns(material, lambda _: forcing, steps=steps, fine_steps=None, period=period)
    return solution


@pytest.mark.validation  # 4 s
def test_forty_melting_records_are_solved():
    """Melt is not negative, flows at the melting point alone, and closes the energy; the albedos span 0.2 to 0.95."""
    melting, albedos = 0, []
    for number in range(40):
        material, forcing, period = random_snow(np.random.default_rng([13, number]))
        assert forcing.shape[1] > newton.DENSE_STEPS
        solution = solve(material, forcing, period)
        assert solution.residual[0] <= solver.TOLERANCE and abs(solution.energy_closure[0]) <= solver.TOLERANCE, number
        assert solution.melt.min() >= 0 and solution.temperature.max() <= MELTING_POINT, number
        assert np.all(solution.temperature[solution.melt > 0] == MELTING_POINT), number
        melting += solution.melt.max() > 0
        albedos.append(1 - material.solar_absorptance)
    assert melting >= 30
    assert min(albedos) < 0.3 and max(albedos) > 0.85


def test_energy_of_a_melting_record_closes_term_by_term():
    """Over a period that repeats an adiabatic pack keeps no heat: absorbed = emitted + convection + evaporation + melt,
    each summed here over the record."""
    number = 0
    while True:
        material, forcing, period = random_snow(np.random.default_rng([17, number]))
        solution = solve(material, forcing, period)
        if material.thermal.back.kind == "adiabatic" and solution.melt.mean() > 5:
            break
        number += 1
    fluxes = Balance(forcing, material).fluxes(solution.temperature)
    gain = fluxes["shortwave_absorbed"] + fluxes["longwave_absorbed"]
    loss = fluxes["longwave_emitted"] + fluxes["convection"] + fluxes["evaporation"] + solution.melt
    assert gain.mean() == pytest.approx(loss.mean(), abs=1e-6)


def test_the_krylov_step_is_that_of_the_dense_matrix(monkeypatch):
    """The solution of a melting record does not depend on how its linear systems are solved."""
    material, forcing, period = random_snow(np.random.default_rng([13, 31]))
    by_krylov = solve(material, forcing, period)
    monkeypatch.setattr(newton, "DENSE_STEPS", 5000)
    dense = solve(material, forcing, period)
    assert by_krylov.melt.max() > 50
    assert np.abs(by_krylov.temperature - dense.temperature).max() < 1e-5
    assert np.abs(by_krylov.melt - dense.melt).max() < 1e-3


def test_melting_times_reach_the_cap_in_one_krylov_step():
    material, forcing, period = random_snow(np.random.default_rng([13, 1]))
    conduction = Conduction(material.thermal, forcing.shape[1], period)
    problem = newton._Problem(Balance(forcing, material), conduction, np.zeros((1, 1)), MELTING_POINT)
    temperature = np.full(forcing.shape, MELTING_POINT - 3.0)
    _, defect, slope = problem.evaluate(temperature, np.arange(1))
    melting = problem._melting(temperature, defect)
    step = problem.step(temperature, defect, slope)
    assert 0 < melting.mean() < 1
    assert step[melting] == pytest.approx(3.0, abs=1e-12)


def test_the_command_takes_twenty_days_of_melting_snow(tmp_path):
    """Hourly readings over 20 days are 1,920 steps of a quarter of an hour."""
    hours = np.arange(480.0)
    sun = 600 * np.maximum(np.sin(2 * np.pi * (hours - 6) / 24), 0.0)
    air = 1.0 + 4 * np.cos(2 * np.pi * (hours - 15) / 24) + 3 * np.sin(2 * np.pi * hours / 171)
    times = np.datetime64("2026-03-01T00:00:00") + hours.astype("timedelta64[h]")
    rows = [f"{t}Z,{s:.1f},270,{a:.2f},80,3,900" for t, s, a in zip(times, sun, air, strict=True)]
    file = tmp_path / "march.csv"
    file.write_text(
        "\n".join(["time,sw_down,lw_down,air_temperature[C],relative_humidity,wind_speed,pressure[hPa]", *rows])
    )
    for absorptance in (0.1, 0.3, 0.6):
        arguments = ["--material", "snow_medium", "--forcing", str(file), "--json", "--absorptance", absorptance]
        result = CliRunner().invoke(command, [str(argument) for argument in arguments])
        assert result.exit_code == 0, result.exception
        output = json.loads(result.output)
        assert max(output["temperature"]["values"]) == pytest.approx(273.15, abs=1e-9)
        assert max(output["melt"]["values"]) > 20


class Cubic:
    """f(T) = ((T - 300) / 10)^3 in place of a heat balance: its root is known, its slope vanishes there."""

    def loss(self, temperature):
        return ((temperature - 300.0) / 10.0) ** 3

    def loss_and_slope(self, temperature):
        return self.loss(temperature), 3 * (temperature - 300.0) ** 2 / 1e3

    def columns(self, rows):
        return self


def conduction():
    layer = Layer(0.1, 1.0, 2000.0, 1000.0)
    return Conduction(ThermalStack(layer, (layer, layer), Back("fixed")), 24, 86400.0)


def test_a_constant_source_through_layers_has_the_root_of_its_cubic():
    """With C T = 5 (T - 0) at rest: ((T - 300) / 10)^3 + 5 T = 1508 has the root 301.5997... = 300 + x with
    x^3 / 1000 + 5 x = 8."""
    x = 1.6
    for _ in range(60):
        x = (8 - x**3 / 1000) / 5
    result = newton.solve_newton(Cubic(), conduction(), np.full((1, 1), 1508.0), np.full((1, 24), 250.0), None, 1e-9)
    assert result.temperature == pytest.approx(300 + x, abs=1e-9)
    assert result.residual[0] < 1e-9 and result.iterations[0] < 12


def test_newton_converges_quadratically_once_near():
    """From 40 K away at most seven steps: each near one squares the error."""
    material, _, _ = random_snow(np.random.default_rng([13, 1]))
    dry = replace(material, surface=replace(material.surface, snow=False))
    steps = 96
    air = 285 + 5 * np.cos(2 * np.pi * np.arange(steps) / steps)[None]
    zero = np.zeros((1, steps))
    forcing = Forcing(zero, zero + 200, zero, zero + 250, zero, air, zero + 900, zero + 9e4, zero + 3, np.ones((1, 1)))
    stack = Conduction(material.thermal, steps, 86400.0)
    balance = Balance(forcing, dry)
    source = np.full((1, 1), stack.steady_transfer * 280.0)
    result = newton.solve_newton(balance, stack, source, np.full((1, steps), 325.0), None, 1e-6)
    assert result.iterations[0] <= 7 and result.residual[0] < 1e-6


def test_melt_is_the_heat_that_a_capped_surface_cannot_conduct():
    """At rest at the cap: m = source - f - 5 T_m exactly, and no time lies above the cap."""
    cap = 301.0
    result = newton.solve_newton(Cubic(), conduction(), np.full((1, 1), 1508.0), np.full((1, 24), 310.0), cap, 1e-9)
    assert np.all(result.temperature == cap)
    assert result.melt == pytest.approx(1508.0 - 1e-3 - 5.0 * cap, abs=1e-9)


class Flat:
    """A problem whose defect is the same everywhere, or a little larger."""

    def __init__(self, growth):
        self.growth = growth

    def evaluate(self, temperature, rows):
        return np.full(len(rows), 1.0 + self.growth), temperature, temperature


@pytest.mark.parametrize("growth, moves", [(-0.5, True), (-1e-12, False), (0.0, False), (5e-5, False)])
def test_a_step_that_does_not_lower_the_defect_is_not_taken(growth, moves):
    temperature = np.full((1, 3), 290.0)
    moved = newton._damp(Flat(growth), temperature, np.ones((1, 3)), np.arange(1), np.ones(1))
    assert bool(moved[0]) == moves
    assert np.all(temperature == (291.0 if moves else 290.0))


def test_melting_times_within_the_tolerance_are_put_at_the_cap():
    """A tenth of a millikelvin below the cap with 8 W/m2 to spare: it melts, and the melt takes all that is spare."""
    cap = 300.0
    problem = newton._Problem(Cubic(), conduction(), np.full((1, 1), 1508.0), cap)
    temperature, melt, imbalance = problem.complementary(np.full((1, 24), cap - 1e-4))
    assert np.all(temperature == cap)
    assert melt == pytest.approx(8.0, abs=1e-9) and np.abs(imbalance).max() < 1e-9
