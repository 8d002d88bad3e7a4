"""Periodic solutions against closed forms, convergence of a manufactured one, and columns that no kind scene has."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.surface import newton, solver
from skyshine.mat.surface.back_boundary import BackFlux
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction, surface_admittance
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solution import Method
from skyshine.mat.surface.solver import bound_excess, solve_columns
from skyshine.mat.surface.stress import random_forcing, random_material
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

SIGMA = 5.670374419e-8
DRY = SurfaceProperties(1e-6, 0.0, 0.0, False, False, "plate")
WALL = ThermalStack(
    Layer(0.0, 1.0, 1.0, 1.0),
    (Layer(0.1, 1.4, 2100.0, 880.0), Layer(0.05, 0.035, 30.0, 1400.0)),
    Back("convective", 293.0, 8.0),
)
PLATE = ThermalStack(Layer(1e-3, 45.0, 7800.0, 480.0), (Layer(1e-3, 45.0, 7800.0, 480.0),) * 2, Back("adiabatic"))
SOIL_LAYER = Layer(0.2, 0.8, 1600.0, 1200.0)
SOIL = ThermalStack(Layer(2e-3, 0.8, 1600.0, 1200.0), (SOIL_LAYER, SOIL_LAYER), Back("fixed", 288.0))


def material(stack=PLATE, surface=DRY, absorptance=0.8, emissivity=0.9, name="plate"):
    return SurfaceMaterial(name, stack, surface, absorptance, emissivity)


def steady(steps=96, **changes):
    values = {
        "shortwave_direct": 0.0,
        "shortwave_diffuse": 0.0,
        "shortwave_reflected": 0.0,
        "longwave_sky": 0.0,
        "longwave_ground": 0.0,
        "air_temperature": 290.0,
        "vapour_pressure": 1000.0,
        "pressure": 101325.0,
        "wind_speed": 3.0,
        "cos_slope": 1.0,
    }
    values.update(changes)
    cosine = np.atleast_2d(values.pop("cos_slope"))
    rows = {name: np.atleast_2d(np.asarray(value, float)) + np.zeros((1, steps)) for name, value in values.items()}
    return Forcing(**rows, cos_slope=cosine)


def solve(chosen, forcing_at, **options):
    parts = [part for part in solve_columns(chosen, forcing_at, **options) if len(part[0])]
    assert len(parts) == 1
    return parts[0][1]


def test_steady_radiative_equilibrium():
    """alpha S + eps L = eps sigma T^4 without air: 0.8 x 1000 + 0.9 x 200 W/m2 make 372.2571 K."""
    solution = solve(material(), lambda n: steady(n, shortwave_direct=1000.0, longwave_sky=200.0, pressure=0.0))
    assert solution.temperature == pytest.approx((980.0 / (0.9 * SIGMA)) ** 0.25, abs=2e-4)
    assert solution.temperature[0, 0] == pytest.approx(372.2571, abs=2e-4)


def test_steady_convective_equilibrium():
    """A body that neither absorbs nor emits takes the air's temperature; one in sunlight h (T - Ta) = alpha S."""
    still = solve(material(absorptance=0.0, emissivity=0.0), lambda n: steady(n))
    assert still.temperature == pytest.approx(290.0, abs=1e-3)
    heated = solve(material(absorptance=1.0, emissivity=0.0), lambda n: steady(n, shortwave_direct=200.0))
    forced, natural = 5.678 * 0.50 * (0.7229474 * 3.0 / 0.3048) ** 0.78, 9.482 / 6.238
    difference = 10.0
    for _ in range(60):
        difference = 200.0 / np.cbrt(8.0 + forced**3 + natural**3 * difference)
    assert heated.temperature == pytest.approx(290.0 + difference, abs=1e-3)


def test_wet_bulb():
    """Psychrometer: 18.090 C in air of 30 C and 30 %, psychrometer constant 67.38 Pa/K; IAPWS-95 at 30 C, 4247.0 Pa."""
    wet = replace(DRY, wetness=1.0)
    vapour = 0.3 * saturation_pressure(303.15)
    solution = solve(
        material(surface=wet, emissivity=0.0), lambda n: steady(n, air_temperature=303.15, vapour_pressure=vapour)
    )
    assert solution.temperature - 273.15 == pytest.approx(18.090, abs=2e-3)


def test_flux_wave_into_a_wall():
    """The linear problem is the transfer matrix's: amplitude q / 12.3128, lag 70.519 degrees, mean over U = 0.61538."""

    def forcing(n):
        return steady(n, shortwave_direct=150 + 100 * np.cos(2 * np.pi * np.arange(n) / n), pressure=0.0)

    solution = solve(material(WALL, absorptance=1.0, emissivity=0.0), forcing, scheme="spectral")
    wave = np.fft.rfft(solution.temperature[0]) / (solution.temperature.shape[1] / 2)
    assert abs(wave[1]) == pytest.approx(100 / 12.3128, rel=2e-5)
    assert -np.degrees(np.angle(wave[1])) == pytest.approx(70.519, abs=1e-3)
    assert solution.temperature.mean() == pytest.approx(293.0 + 150 / 0.61538, abs=2e-3)


def manufactured(steps):
    """A wet two-layer surface under the forcing that makes it exactly 293 + 9 cos + 2 sin 2 K."""
    wet = SurfaceProperties(1e-3, 0.7, 60.0, False, False)
    chosen = material(SOIL, wet, 1.0, 1.0, "made up")
    angle = 2 * np.pi * np.arange(steps) / steps
    exact = 293 + 9 * np.cos(angle) + 2 * np.sin(2 * angle)
    steady_part, first, second = surface_admittance(SOIL, 1j * 2 * np.pi / 86400 * np.arange(3.0))
    flux = steady_part.real * (293 - 288.0)
    flux = flux + (9 * first * np.exp(1j * angle)).real + (-2j * second * np.exp(2j * angle)).real
    dark = steady(steps, wind_speed=1 + 0.5 * np.cos(angle), air_temperature=290 + 5 * np.sin(angle))
    needed = flux + Balance(dark, chosen).loss(exact[None, :])[0]
    return chosen, replace(dark, longwave_sky=needed[None, :]), exact


def test_order_of_convergence_on_a_manufactured_solution():
    errors = {}
    for steps in (96, 192, 384):
        chosen, forcing, exact = manufactured(steps)
        given = {"steps": steps, "fine_steps": None}
        solution = solve(chosen, lambda n, forcing=forcing: forcing, **given, scheme="bdf2")
        errors[steps] = np.abs(solution.temperature[0] - exact).max()
        waves = solve(chosen, lambda n, forcing=forcing: forcing, **given)
        assert np.abs(waves.temperature[0] - exact).max() < 2e-3  # two waves: what the residual leaves
    assert errors[96] < 0.05
    assert np.log2(errors[96] / errors[192]) == pytest.approx(2, abs=0.15)
    assert np.log2(errors[192] / errors[384]) == pytest.approx(2, abs=0.1)


def test_random_columns_settle_within_bounds_and_close_their_energy():
    for seed in range(40):
        generator = np.random.default_rng([7, seed])
        solution = solve(random_material(generator), random_forcing(generator))
        assert np.all(np.isfinite(solution.temperature)), seed
        assert solution.residual[0] <= solver.TOLERANCE, seed
        assert abs(solution.energy_closure[0]) <= solver.TOLERANCE, seed
        assert solution.bound_excess[0] <= 0.5, seed


def day(n, noon=800.0, **changes):
    hours = np.arange(n) * 24.0 / n
    sun = noon * np.maximum(np.cos(np.pi * (hours - 12) / 14), 0) * (np.abs(hours - 12) < 7)
    values = {
        "shortwave_direct": sun,
        "longwave_sky": 280.0,
        "air_temperature": 290 + 6 * np.cos(np.pi * (hours - 15) / 12),
    }
    return steady(n, **(values | changes))


def test_calm_wet_steel():
    solution = solve(material(surface=replace(DRY, wetness=1.0)), lambda n: day(n, wind_speed=0.0))
    assert solution.residual[0] <= solver.TOLERANCE
    assert 265 < solution.temperature.min() < solution.temperature.max() < 330


def test_polar_night():
    solution = solve(material(SOIL), lambda n: day(n, noon=0.0, air_temperature=235.0, longwave_sky=120.0))
    assert np.ptp(solution.temperature) < 1e-3
    assert 220 < solution.temperature.mean() < 288


def test_night_in_vacuum_stays_above_absolute_zero():
    dust = Layer(0.05, 0.01, 1300.0, 800.0)
    stack = ThermalStack(Layer(1e-5, 0.01, 1300.0, 800.0), (dust, Layer(1.0, 0.01, 1800.0, 800.0)), Back("adiabatic"))
    solution = solve(
        material(stack, absorptance=0.9, emissivity=0.95),
        lambda n: day(n, noon=1361.0, pressure=0.0, longwave_sky=0.0),
        period=29.53 * 86400,
    )
    assert 60 < solution.temperature.min() < 130
    assert solution.temperature.max() == pytest.approx((0.9 * 1361 / (0.95 * SIGMA)) ** 0.25, abs=6)


def test_step_shadow_breaks_no_bound():
    thin = Layer(2e-4, 0.2, 900.0, 1500.0)
    stack = ThermalStack(thin, (thin, thin), Back("adiabatic"))
    shade = lambda n: day(n, shortwave_direct=900.0 * (np.arange(n) * 24 / n % 6 < 3), pressure=0.0)  # noqa: E731
    solution = solve(material(stack, emissivity=0.5), shade, fine_steps=None)
    hottest = ((0.8 * 900 + 0.5 * 280) / (0.5 * SIGMA)) ** 0.25
    coldest = (280 / SIGMA) ** 0.25
    assert coldest - 0.2 <= solution.temperature.min() and solution.temperature.max() <= hottest + 0.2


SNOW_LAYER = Layer(0.2, 0.2, 250.0, 2050.0)
SNOW = ThermalStack(Layer(5e-3, 0.2, 250.0, 2050.0), (SNOW_LAYER, SNOW_LAYER), Back("fixed", 268.0))


def test_snow_melts_instead_of_warming():
    """Melting heat is not negative, flows only at the melting point, and closes the energy."""
    snow = material(SNOW, replace(DRY, snow=True, wetness=1.0), absorptance=0.3, emissivity=0.98, name="snow")
    solution = solve(snow, lambda n: day(n, air_temperature=274.0, vapour_pressure=500.0))
    assert solution.temperature.max() == pytest.approx(273.15, abs=1e-6)
    assert solution.melt.min() == 0 and solution.melt.max() > 10
    assert np.all(solution.melt * (273.15 - solution.temperature) < 1e-3)
    assert solution.residual[0] <= solver.TOLERANCE and abs(solution.energy_closure[0]) <= solver.TOLERANCE


def test_cold_snow_is_as_any_other_surface():
    weather = lambda n: day(n, noon=300.0, air_temperature=255.0, vapour_pressure=100.0, longwave_sky=180.0)  # noqa: E731
    snow = material(SNOW, replace(DRY, snow=True), absorptance=0.3)
    bare = material(SNOW, DRY, absorptance=0.3)
    assert np.allclose(solve(snow, weather).temperature, solve(bare, weather).temperature, rtol=0.0, atol=1e-9)


def test_newton_and_batch_iteration_agree(monkeypatch):
    weather = lambda n: day(n, wind_speed=0.5)  # noqa: E731
    batch = solve(material(SOIL), weather)
    monkeypatch.setattr(solver, "DENSE_STEPS", 10)
    by_newton = solve(material(SOIL), weather)
    monkeypatch.setattr(newton, "DENSE_STEPS", 10)
    by_krylov = solve(material(SOIL), weather)
    assert batch.method[0] == Method.SPECTRAL
    assert by_newton.method[0] == by_krylov.method[0] == Method.SPECTRAL_NEWTON
    assert np.allclose(batch.temperature, by_newton.temperature, atol=1e-3)
    assert np.allclose(batch.temperature, by_krylov.temperature, atol=1e-3)


def test_a_column_that_does_not_converge_is_named(monkeypatch):
    monkeypatch.setattr(solver, "DENSE_STEPS", 10)
    monkeypatch.setattr(newton, "_ITERATIONS", 1)
    with pytest.raises(solver.ConvergenceError, match="material 'plate', column 0: .*residual of"):
        solve_columns(material(SOIL), day)


def test_forcing_that_is_not_a_number_is_refused():
    with pytest.raises(InputError, match="air_temperature = nan in column 0 at time step 0"):
        solve_columns(material(), lambda n: day(n, air_temperature=np.nan))


def test_backward_euler_takes_over_where_bounds_break(monkeypatch):
    """Euler obeys the maximum principle exactly and stays near the solution that it replaces."""
    usual = solve(material(SOIL), day)
    monkeypatch.setattr(solver, "BOUND_TOLERANCE", -1.0)
    replaced = solve(material(SOIL), day)
    assert replaced.method[0] == Method.EULER and replaced.temperature.shape == (1, solver.STURDY_STEPS)
    assert replaced.bound_excess[0] == 0.0
    assert np.abs(replaced.temperature[:, ::2] - usual.temperature).max() < 0.5


def test_a_column_that_rings_goes_to_bdf2_alone():
    """Foil in vacuum follows square shadows at once, which waves overshoot; soil beside it settles slowly."""
    foil = Layer(1e-5, 200.0, 2700.0, 900.0)
    stack = ThermalStack(foil, (foil, Layer(0.05, 0.03, 30.0, 1400.0)), Back("adiabatic"))

    def shadows(n):
        steady_light, square = np.full(n, 500.0), 900.0 * (np.arange(n) * 24 / n % 6 < 3)
        return day(n, shortwave_direct=np.stack([steady_light, square]), pressure=0.0, air_temperature=290.0)

    parts = solve_columns(material(stack, emissivity=0.5), shadows)
    assert [list(columns) for columns, _ in parts] == [[0], [1]]
    assert [int(solution.method[0]) for _, solution in parts] == [Method.SPECTRAL, Method.BDF2]
    assert [solution.temperature.shape[1] for _, solution in parts] == [solver.STEPS, solver.STURDY_STEPS]
    assert all(solution.bound_excess[0] <= solver.BOUND_TOLERANCE for _, solution in parts)


def bounds_of(temperature, chosen, forcing):
    steps = forcing.shape[1]
    conduction = Conduction(chosen.thermal, steps, 86400.0)
    back_flux = BackFlux.of(chosen, forcing, conduction, np.arange(steps) * 24.0 / steps)
    series = np.full((1, steps), float(temperature))
    return bound_excess(Balance(forcing, chosen), series, Balance(forcing, chosen).loss(series), back_flux, None)[0]


@pytest.mark.parametrize("offset, excess", [(2.0, 2.0), (0.0, 0.0), (-2.0, 2.0)])
def test_bound_excess_is_the_distance_from_the_equilibrium(offset, excess):
    """A plate in vacuum at rest has one equilibrium, 372.2571 K: what lies beside it by 2 K exceeds by 2 K."""
    forcing = steady(shortwave_direct=1000.0, longwave_sky=200.0, pressure=0.0)
    insulated = material(replace(PLATE, back=Back("heated", heat_flux=0.0)))
    assert bounds_of(372.2571 + offset, insulated, forcing) == pytest.approx(excess, abs=0.03)


@pytest.mark.parametrize("temperature, excess", [(340.0, 0.0), (290.0, 0.0), (287.0, 1.0), (373.2571, 1.0)])
def test_a_back_of_other_temperature_widens_the_bounds(temperature, excess):
    """Soil on a back of 288 K under the same light may have any temperature between both."""
    forcing = steady(shortwave_direct=1000.0, longwave_sky=200.0, pressure=0.0)
    assert bounds_of(temperature, material(SOIL), forcing) == pytest.approx(excess, abs=0.03)


def test_energy_closes_term_by_term_over_a_day():
    """Soil on a back of 288 K: what the fluxes of the day leave over goes through both layers, 0.4 m of 0.8 W/mK."""
    solution = solve(material(SOIL), day)
    fluxes = Balance(day(solution.temperature.shape[1]), material(SOIL)).fluxes(solution.temperature)
    gain = fluxes["shortwave_absorbed"] + fluxes["longwave_absorbed"]
    loss = fluxes["longwave_emitted"] + fluxes["convection"] + fluxes["evaporation"]
    assert (gain - loss).mean() == pytest.approx((solution.temperature.mean() - 288.0) * 0.8 / 0.4, abs=2e-3)


def test_usual_columns_need_no_newton():
    """The batch iteration alone solves a dry and a wet soil in at most a dozen iterations."""
    for chosen in (material(SOIL), material(SOIL, replace(DRY, wetness=0.5, surface_resistance=50.0))):
        solution = solve(chosen, day)
        assert solution.method[0] == Method.SPECTRAL and solution.iterations[0] <= 12
