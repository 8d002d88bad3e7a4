"""The solver against an independent statement of the same balance: finite volumes and collocation in casadi."""

from dataclasses import replace

import numpy as np
import pytest
from surface_oracle import solve_oracle

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.mat.surface.symbolic_balance import FORCING, SymbolicMaterial, forcing_rows, loss
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

casadi = pytest.importorskip("casadi")

SOIL = Layer(0.1, 0.5, 1500.0, 1200.0)
CONCRETE, FOAM = Layer(0.08, 1.5, 2300.0, 900.0), Layer(0.05, 0.035, 30.0, 1400.0)
COLUMNS = {
    "dry soil": (
        ThermalStack(Layer(0.002, 0.5, 1500.0, 1200.0), (SOIL, Layer(np.inf, 0.5, 1500.0, 1200.0)), Back("adiabatic")),
        SurfaceProperties(0.005, 0.0, 0.0, False, False),
    ),
    "wet concrete on foam": (
        ThermalStack(Layer(0.001, 1.5, 2300.0, 900.0), (CONCRETE, FOAM), Back("convective", 294.0, 8.0)),
        SurfaceProperties(1e-4, 0.6, 80.0, False, False),
    ),
    "canopy": (
        ThermalStack(Layer(0.001, 0.3, 300.0, 3000.0), (SOIL, SOIL), Back("fixed")),
        SurfaceProperties(0.1, 1.0, 120.0, True, False),
    ),
    "vehicle": (
        ThermalStack(Layer(0.002, 45.0, 7800.0, 480.0), (FOAM, FOAM), Back("convective", None, 3.0)),
        SurfaceProperties(1e-4, 0.0, 0.0, False, False, "plate"),
    ),
    "roof": (
        ThermalStack(Layer(0.001, 0.2, 1000.0, 1000.0), (CONCRETE, FOAM), Back("convective", 294.0, 8.0)),
        SurfaceProperties(1e-3, 0.0, 0.0, False, False, "roof"),
    ),
    "wall": (
        ThermalStack(Layer(0.001, 0.8, 1800.0, 900.0), (CONCRETE, FOAM), Back("convective", 294.0, 8.0)),
        SurfaceProperties(2e-3, 0.0, 0.0, False, False, "wall"),
    ),
}


def forcing_at(seconds):
    hours = np.asarray(seconds)[None, :] / 3600
    turn = 2 * np.pi / 24
    air = 293 + 7 * np.cos(turn * (hours - 15))
    sun = 750 * np.exp(2.5 * (np.cos(turn * (hours - 12)) - 1))
    none = np.zeros_like(hours)
    return Forcing(  # leaves of a plane in half the light open to the light of open ground
        0.8 * sun,
        0.2 * sun,
        none,
        0.78 * 5.67e-8 * air**4,
        none,
        air,
        1200 + 100 * np.cos(turn * hours),
        none + 1e5,
        2 + np.cos(turn * (hours - 14)),
        np.array([[0.8]]),
        open_light=300 + 1.5 * sun,
    )


@pytest.mark.parametrize("name", COLUMNS)
def test_solver_agrees_with_the_oracle(name):
    thermal, surface = COLUMNS[name]
    material = SurfaceMaterial(name, thermal, surface, 0.8, 0.95)
    oracle = solve_oracle(material, forcing_at, intervals=96, cells=30)
    for scheme, tolerance in (("bdf2", 0.05), ("spectral", 0.02)):
        (_, solution), *_ = solve_columns(
            material, lambda n: forcing_at(np.arange(n) * 86400.0 / n), steps=96, fine_steps=None, scheme=scheme
        )
        assert np.abs(np.roll(solution.temperature[0], -1) - oracle.surface).max() < tolerance


def random_state(generator):
    """A forcing of one time in which no field is that of another, and a temperature near its air."""
    air = generator.uniform(285, 303)
    return air + generator.uniform(-10, 30), {
        "shortwave_direct": generator.uniform(100, 800),
        "shortwave_diffuse": generator.uniform(50, 200),
        "shortwave_reflected": generator.uniform(10, 100),
        "longwave_sky": generator.uniform(200, 400),
        "longwave_ground": generator.uniform(10, 100),
        "air_temperature": air,
        "vapour_pressure": generator.uniform(700, 1200),
        "pressure": generator.uniform(7e4, 1.02e5),
        "wind_speed": generator.uniform(1, 8),
        "cos_slope": generator.uniform(-0.5, 0.9),
        "wind_height": generator.uniform(3, 12),
        "air_height": generator.uniform(1, 4),
        "open_light": generator.uniform(100, 900),
    }


LEAF = SurfaceProperties(0.1, 1.0, 120.0, True, False)
MOIST = SurfaceProperties(0.01, 0.5, 200.0, False, False)
MATTERS = {"canopy": (LEAF, ()), "moist field": (MOIST, ("open_light",))}  # and what does not matter to each


@pytest.mark.parametrize("name", MATTERS)
def test_every_setting_moves_the_oracle_s_loss_as_it_moves_the_solver_s(name):
    """Each field of the forcing and number of the skin, changed by a hundredth, changes both losses alike, not by 0."""
    surface, without_effect = MATTERS[name]
    thermal, _ = COLUMNS["canopy"]
    surface_temperature, parameter = casadi.SX.sym("T"), casadi.SX.sym("p", len(FORCING))

    def losses(values, temperature, absorptance=0.8, emissivity=0.95, **changed):
        material = SurfaceMaterial(name, thermal, replace(surface, **changed), absorptance, emissivity)
        forcing = Forcing(**{field: np.array([[value]]) for field, value in values.items()})
        law = loss(casadi, SymbolicMaterial.of(material), surface_temperature, parameter)
        symbolic = casadi.Function("loss", [surface_temperature, parameter], [law])
        solver = Balance(forcing, material).loss(np.array([[temperature]]))
        rows = forcing_rows(forcing, 1, material, by_time=False)
        return np.array([float(solver[0, 0]), float(symbolic(temperature, rows[:, 0]))])

    generator = np.random.default_rng(5)
    for _ in range(10):
        temperature, values = random_state(generator)
        base = losses(values, temperature)
        assert base[1] == pytest.approx(base[0], abs=1e-6)
        moved = {field: losses(values | {field: 1.01 * value}, temperature) for field, value in values.items()}
        moved |= {
            "absorptance": losses(values, temperature, absorptance=0.81),
            "emissivity": losses(values, temperature, emissivity=0.94),
            "wetness": losses(values, temperature, wetness=0.99 * surface.wetness),
            "surface_resistance": losses(values, temperature, surface_resistance=1.01 * surface.surface_resistance),
            "roughness_length": losses(values, temperature, roughness_length=1.01 * surface.roughness_length),
        }
        for setting, changed in moved.items():
            solver, symbolic = changed - base
            assert symbolic == pytest.approx(solver, rel=1e-4, abs=1e-8), setting
            assert (abs(solver) > 1e-9) != (setting in without_effect), setting


def test_steel_plate_cools_into_space():
    """10 mm of steel at one temperature, 350 K at first, black on one side: 1/T^3 grows by 3 sigma t / (rho c d), and T
    is
    293.4416 K after an hour."""
    steel = (45.0, 7850.0, 480.0)
    stack = ThermalStack(Layer(0.009998, *steel), (Layer(1e-6, *steel), Layer(1e-6, *steel)), Back("adiabatic"))
    plate = SurfaceMaterial("plate", stack, SurfaceProperties(1e-4, 0.0, 0.0, False, False), 0.0, 1.0)

    def space(seconds):
        none = np.zeros((1, len(seconds)))
        return Forcing(none, none, none, none, none, none + 300.0, none, np.zeros((1, 1)), none, np.array([[1.0]]))

    solution = solve_oracle(plate, space, period=3600.0, intervals=24, cells=2, start=350.0)
    assert solution.surface[-1] == pytest.approx(293.4416, abs=5e-5)
    cubes = 350.0**-3 + 3 * 5.670374419e-8 * solution.time / (0.01 * 7850 * 480)
    assert solution.surface == pytest.approx(cubes ** (-1 / 3), abs=1e-4)


def test_oracle_does_not_melt():
    thermal, _ = COLUMNS["dry soil"]
    snow = SurfaceMaterial("snow", thermal, SurfaceProperties(1e-3, 1.0, 0.0, False, True), 0.3, 0.98)
    with pytest.raises(InputError, match="surfaces that do not melt"):
        solve_oracle(snow, forcing_at)
