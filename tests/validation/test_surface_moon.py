"""The lunar equator: no air, a month for a day, and Diviner's temperatures of the night."""

import numpy as np
import pytest

from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import solve_columns
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]

MONTH = 29.530589 * 86400.0  # s, synodic
# K, of the equator over a month: Vasavada et al. (2012), J. Geophys. Res. 117, E00H18, figure 9a.
MEAN_TEMPERATURE = 213.0


def regolith():
    """Two layers with the properties of Vasavada et al. (1999), Icarus 141, 179-193, at the equator's mean temperature:
    2 cm of 1300 kg/m3 over 1800 kg/m3, conductivity k (1 + chi (T / 350 K)^3), heat capacity of lunar fines; albedo
    0.12 and emissivity 0.95
    as Hayne et al. (2017), J. Geophys. Res. Planets 122, 2371-2400."""
    temperature = MEAN_TEMPERATURE
    capacity = np.polynomial.Polynomial([-3.6125, 2.7431, 2.3616e-3, -1.2340e-5, 8.9093e-9])(temperature)

    def layer(thickness, conductivity, chi, density):
        return Layer(thickness, conductivity * (1 + chi * (temperature / 350) ** 3), density, float(capacity))

    top = (9.22e-4, 1.48, 1300.0)
    stack = ThermalStack(layer(1e-4, *top), (layer(0.02, *top), layer(1.5, 9.3e-3, 0.073, 1800.0)), Back("adiabatic"))
    return SurfaceMaterial("regolith", stack, SurfaceProperties(1e-3, 0.0, 0.0, False, False), 0.88, 0.95)


def month(steps):
    """Sunlight from noon on."""
    sun = 1361.0 * np.maximum(np.cos(2 * np.pi * np.arange(steps) / steps), 0.0)[None, :]
    none = 0 * sun
    return Forcing(sun, none, none, none, none, none + 250.0, none, np.zeros((1, 1)), none, np.array([[1.0]]))


def test_lunar_equator(shared_data, quoted):
    """Noon, nine hours of the night and the mean within 5 K, with one conductivity for a range of 290 K."""
    ((_, found),) = (
        part for part in solve_columns(regolith(), month, steps=576, fine_steps=None, period=MONTH) if len(part[0])
    )
    temperature = found.temperature[0]
    hours = np.arange(576) * 24.0 / 576
    table = np.loadtxt(shared_data / "heat" / "lunar" / "diviner_regtemp_lat00.csv", delimiter=",", skiprows=1)
    difference = np.interp(table[:, 0], hours, temperature) - table[:, 1]
    midnight, sunset = np.interp([12.0, 6.0], hours, temperature)
    print(
        f"\nnoon {temperature[0]:.1f} K, sunset {sunset:.1f} K, midnight {midnight:.1f} K, mean"
        f" {temperature.mean():.1f} K; night less Diviner {difference.min():+.1f} to {difference.max():+.1f} K"
    )
    quoted("surface.moon.night", f"{np.abs(difference).max():.1f}", "K")
    quoted("surface.moon.noon", f"{abs(temperature[0] - 386.1):.1f}", "K")
    assert temperature[0] == pytest.approx(386.1, abs=1.0)
    assert temperature.mean() == pytest.approx(MEAN_TEMPERATURE, abs=5.0)
    assert np.abs(difference).max() < 5.0
    assert found.residual[0] < 1e-3 and found.bound_excess[0] < 0.1
