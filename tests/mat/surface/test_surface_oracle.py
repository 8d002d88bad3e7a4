"""The solver against an independent statement of the same balance: finite volumes and collocation in casadi."""

import numpy as np
import pytest

from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.oracle import solve_oracle
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

pytest.importorskip("casadi")

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
}


def forcing_at(seconds):
    hours = np.asarray(seconds)[None, :] / 3600
    turn = 2 * np.pi / 24
    air = 293 + 7 * np.cos(turn * (hours - 15))
    sun = 750 * np.exp(2.5 * (np.cos(turn * (hours - 12)) - 1))
    none = np.zeros_like(hours)
    return Forcing(
        0.8 * sun, 0.2 * sun, none, 0.78 * 5.67e-8 * air**4, none, air, 1200 + 100 * np.cos(turn * hours), none + 1e5,
        2 + np.cos(turn * (hours - 14)), np.array([[0.8]]),
    )  # fmt: skip


@pytest.mark.parametrize("name", COLUMNS)
def test_solver_agrees_with_the_oracle(name):
    thermal, surface = COLUMNS[name]
    material = SurfaceMaterial(name, thermal, surface, 0.8, 0.95)
    oracle = solve_oracle(material, forcing_at, intervals=96, cells=30)
    for scheme, tolerance in (("bdf2", 0.05), ("spectral", 0.02)):
        (_, found), *_ = solve_columns(
            material, lambda n: forcing_at(np.arange(n) * 86400.0 / n), fine_steps=None, scheme=scheme
        )
        assert np.abs(np.roll(found.temperature[0], -1) - oracle.surface).max() < tolerance


def test_oracle_does_not_melt():
    thermal, _ = COLUMNS["dry soil"]
    snow = SurfaceMaterial("snow", thermal, SurfaceProperties(1e-3, 1.0, 0.0, False, True), 0.3, 0.98)
    with pytest.raises(InputError, match="surfaces that do not melt"):
        solve_oracle(snow, forcing_at)
