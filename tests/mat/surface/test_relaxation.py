"""The batch iteration: Anderson acceleration against its theory, guesses against closed forms, iterations counted."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.surface import relaxation
from skyshine.mat.surface.acceleration import Anderson
from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.relaxation import Relaxation, first_guess, imbalance_of, sampled
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

SIGMA = 5.670374419e-8
SOIL = Layer(0.2, 0.8, 1600.0, 1200.0)
STACK = ThermalStack(Layer(2e-3, 0.8, 1600.0, 1200.0), (SOIL, SOIL), Back("adiabatic"))
SNOW = Layer(0.2, 0.2, 250.0, 2050.0)
PACK = ThermalStack(Layer(5e-3, 0.2, 250.0, 2050.0), (SNOW, SNOW), Back("adiabatic"))
DRY = SurfaceProperties(0.005, 0.0, 0.0, False, False)


def day(steps=96, columns=40, **changes):
    """Columns of a clear day with noons of 300 to 900 W/m2."""
    hours = np.arange(steps) * 24.0 / steps
    sun = np.linspace(300, 900, columns)[:, None] * np.maximum(np.cos(np.pi * (hours - 12) / 14), 0.0)
    zero = np.zeros((columns, steps))
    values = {
        "shortwave_direct": sun,
        "shortwave_diffuse": zero,
        "shortwave_reflected": zero,
        "longwave_sky": zero + 300,
        "longwave_ground": zero,
        "air_temperature": zero + 288 + 6 * np.cos(np.pi * (hours - 15) / 12),
        "vapour_pressure": zero + 900,
        "pressure": zero + 95e3,
        "wind_speed": zero + 3.0,
        "cos_slope": np.ones((columns, 1)),
    }
    return Forcing(**(values | changes))


def material(stack=STACK, surface=DRY, absorptance=0.8, emissivity=0.95):
    return SurfaceMaterial("ground", stack, surface, absorptance, emissivity)


@pytest.mark.parametrize("rows, iterates", [(1, 3), (2, 4)])
def test_anderson_solves_a_linear_problem_in_as_many_steps_as_it_has_dimensions(rows, iterates):
    """Walker and Ni (2011), theorem 2.2: on a linear map acceleration is equivalent to GMRES, which ends after as many
    steps as the matrix has dimensions."""
    matrix = np.array([[0.9, 0.3], [-0.4, 0.7]])[:rows, :rows]
    offset, unknown = np.array([[1.0, 2.0]])[:, :rows], np.zeros((1, rows))
    exact = np.linalg.solve(np.eye(rows) - matrix, offset[0])
    memory = Anderson()
    for _ in range(iterates - 1):
        target = unknown @ matrix.T + offset
        unknown = memory.next(target, target - unknown)
    assert unknown[0] == pytest.approx(exact, rel=1e-12)


def test_columns_are_accelerated_each_on_its_own():
    """The iterates of a column do not depend on its neighbours."""
    rates, offset = np.array([[0.9, 0.2], [-0.8, 0.5]]), np.array([[1.0, 2.0], [3.0, -1.0]])

    def iterates(chosen):
        memory, unknown = Anderson(), np.zeros((len(chosen), 2))
        for _ in range(5):
            target = rates[chosen] * unknown + offset[chosen]
            unknown = memory.next(target, target - unknown)
        return unknown

    assert np.array_equal(iterates([0, 1])[1:], iterates([1]))


def test_a_sample_holds_both_ends_and_all_of_a_few():
    assert list(sampled(5)) == [0, 1, 2, 3, 4]
    assert (sampled(1000)[0], sampled(1000)[-1], len(sampled(1000))) == (0, 999, 32)


def test_without_air_the_first_guess_radiates_the_mean():
    """Mean of 0 and 1000 W/m2, absorbed to 0.8, with 200 W/m2 of longwave: eps sigma T^4 = 400 + 190 W/m2."""
    sun = np.where(np.arange(96) % 2, 1000.0, 0.0)[None]
    vacuum = day(columns=1, shortwave_direct=sun, longwave_sky=np.full((1, 96), 200.0), pressure=np.zeros((1, 1)))
    guess = first_guess(Balance(vacuum, material()))
    assert guess == pytest.approx(((400.0 + 190.0) / (0.95 * SIGMA)) ** 0.25, rel=1e-9)


def test_imbalance_is_all_that_leaves_less_the_source():
    """A black surface at 300 K in still vacuum over an adiabatic stack at rest: sigma T^4 = 459.3 W/m2."""
    dark = day(columns=1, shortwave_direct=np.zeros((1, 96)), longwave_sky=np.zeros((1, 96)), pressure=np.zeros((1, 1)))
    chosen = material(emissivity=1.0)
    temperature = np.full((1, 96), 300.0)
    loss, imbalance = imbalance_of(
        Balance(dark, chosen), Conduction(STACK, 96, 86400.0), np.full((1, 1), 60.0), temperature
    )
    assert loss == pytest.approx(SIGMA * 300.0**4)
    assert imbalance == pytest.approx(SIGMA * 300.0**4 - 60.0)


def solved(chosen, forcing):
    conduction = Conduction(chosen.thermal, forcing.shape[1], 86400.0)
    source = np.zeros((forcing.shape[0], 1))
    relaxed = Relaxation.of(chosen, forcing, conduction, source)
    return relaxed, relaxed.solve(Balance(forcing, chosen), conduction, source)


def test_a_usual_day_settles_in_few_iterations():
    """Forty columns whose noons differ by a factor of three, with one matrix."""
    _, (temperature, melt, _, imbalance, iterations) = solved(material(), day())
    assert np.abs(imbalance).max() <= relaxation.TOLERANCE and np.all(melt == 0)
    assert iterations[0] <= 12
    assert np.all(np.diff(temperature.mean(axis=1)) > 0)


def test_melting_snow_settles_with_complementary_melt():
    """Where melt flows the temperature is 273.15 K, and nowhere above; the sum of both carries the balance."""
    chosen = material(PACK, replace(DRY, snow=True, wetness=1.0), 0.3, 0.98)
    thaw = day(air_temperature=np.full((40, 96), 275.0), vapour_pressure=np.full((40, 96), 500.0))
    relaxed, (temperature, melt, _, imbalance, iterations) = solved(chosen, thaw)
    assert relaxed.cap == 273.15 and relaxed.melting > 0
    assert np.abs(imbalance).max() <= relaxation.TOLERANCE and iterations[0] <= 60
    assert temperature.max() == 273.15 and melt.min() >= 0 and melt.max() > 50
    assert np.all(melt * (273.15 - temperature) == 0)


def test_the_matrix_is_the_inverse_of_slope_and_conduction():
    relaxed, _ = solved(material(), day())
    conduction = Conduction(STACK, 96, 86400.0)
    assert np.allclose(relaxed.inverse.T @ (np.diag(relaxed.slope) + conduction.matrix), np.eye(96), atol=1e-9)
    # 4 eps sigma T^3 of radiation and some 13 W/m2K of wind of 3 m/s lie within these.
    assert np.all((relaxed.slope > 10) & (relaxed.slope < 40))


def test_coarse_temperatures_are_joined_by_straight_lines():
    coarse = np.array([[280.0, 290.0, 300.0, 290.0]])
    assert relaxation._between(coarse, 8)[0] == pytest.approx([280, 285, 290, 295, 300, 295, 290, 285])


def test_single_precision_ends_near_the_solution():
    """Within some times the rounding of 300 K, melting included, before double precision takes over."""
    snow = material(PACK, replace(DRY, snow=True, wetness=1.0), 0.3, 0.98)
    thaw = day(air_temperature=np.full((40, 96), 275.0), vapour_pressure=np.full((40, 96), 500.0))
    for chosen, weather in ((material(), day()), (snow, thaw)):
        relaxed, (temperature, melt, _, _, _) = solved(chosen, weather)
        unknown, count, _ = relaxed._approach(Balance(weather, chosen), np.zeros((40, 1)), 5e-4)
        exact = temperature + melt / relaxed.melting
        assert np.abs(unknown - exact).max() < 0.02 and count < 60
