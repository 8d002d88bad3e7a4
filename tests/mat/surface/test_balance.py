"""The surface fluxes against published values, limits and their own derivatives."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skyshine.mat.surface.balance import Balance, Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.errors import InputError

LAYER = Layer(0.1, 1.0, 2000.0, 1000.0)
STACK = ThermalStack(LAYER, (LAYER, LAYER), Back("adiabatic"))
SMOOTH = SurfaceProperties(1e-6, 0.0, 0.0, False, False)


def material(surface=SMOOTH, absorptance=0.7, emissivity=0.9):
    return SurfaceMaterial("plate", STACK, surface, absorptance, emissivity)


def forcing(**changes):
    values = {
        "shortwave_direct": 400.0,
        "shortwave_diffuse": 80.0,
        "shortwave_reflected": 20.0,
        "longwave_sky": 250.0,
        "longwave_ground": 100.0,
        "air_temperature": 290.0,
        "vapour_pressure": 1000.0,
        "pressure": 101325.0,
        "wind_speed": 2.0,
        "cos_slope": 1.0,
    }
    values.update(changes)
    return Forcing(**{name: np.atleast_2d(np.asarray(value, float)) for name, value in values.items()})


@given(st.floats(0, 611), st.floats(0.01, 1), st.floats(0, 40), st.floats(3e4, 1.05e5))
@settings(max_examples=60, deadline=None)
def test_freezing_leaves_the_loss_increasing(vapour, wetness, wind, pressure):
    """However dry the air: a surface with two equilibria would have no one temperature."""
    surface = SurfaceProperties(1e-3, wetness, 0.0, False, False)
    air = forcing(vapour_pressure=vapour, wind_speed=wind, pressure=pressure, air_temperature=272.0)
    _, slope = Balance(air, material(surface)).loss_and_slope(np.linspace(270, 275, 51)[None, :])
    assert np.all(slope > 0)


def test_frost_forms_from_air_that_is_dry_over_water():
    """At -20 C and 90 % over water the air is saturated over ice: frost grows and warms the surface."""
    wet = SurfaceProperties(1e-3, 1.0, 0.0, False, False)
    vapour = 0.9 * saturation_pressure(253.15)
    balance = Balance(forcing(vapour_pressure=vapour, air_temperature=253.15), material(wet))
    assert balance.fluxes(np.array([[253.15]]))["evaporation"][0, 0] < 0


@given(st.floats(220, 380), st.floats(0, 1), st.floats(0, 400), st.floats(0, 40), st.floats(-1, 1), st.floats(0, 4000))
@settings(max_examples=80, deadline=None)
def test_slope_is_the_derivative(temperature, wetness, resistance, wind, tilt, vapour):
    surface = SurfaceProperties(1e-3, wetness, resistance, False, False)
    balance = Balance(forcing(wind_speed=wind, cos_slope=tilt, vapour_pressure=vapour), material(surface))
    around = np.array([[temperature - 1e-3, temperature, temperature + 1e-3]])
    loss, slope = balance.loss_and_slope(around)
    assert slope[0, 1] == pytest.approx((loss[0, 2] - loss[0, 0]) / 2e-3, rel=2e-3, abs=1e-3)


def test_convection_never_stands_still_in_air():
    temperature = np.linspace(285, 295, 201)[None, :]
    fluxes = Balance(forcing(wind_speed=0.0), material()).fluxes(temperature)
    difference = temperature - 290.0
    assert np.all(np.abs(fluxes["convection"]) >= 2.0 * np.abs(difference) - 1e-9)


def test_vacuum_has_neither_convection_nor_evaporation():
    wet = SurfaceProperties(1e-3, 1.0, 0.0, False, False)
    fluxes = Balance(forcing(pressure=0.0), material(wet)).fluxes(np.full((1, 1), 350.0))
    assert fluxes["convection"] == 0 and fluxes["evaporation"] == 0


def test_dew_warms_and_evaporation_cools():
    wet = SurfaceProperties(1e-3, 1.0, 0.0, False, False)
    balance = Balance(forcing(vapour_pressure=1500.0), material(wet))
    cold, warm = balance.fluxes(np.array([[280.0, 295.0]]))["evaporation"][0]
    assert cold < 0 < warm


@pytest.mark.parametrize(
    "name, value", [("air_temperature", np.nan), ("shortwave_direct", -5.0), ("wind_speed", np.inf)]
)
def test_forcing_that_cannot_be_is_refused(name, value):
    series = np.full((1, 4), 1.0 if name != "air_temperature" else 290.0)
    series[0, 2] = value
    with pytest.raises(InputError, match=f"{name} = .* in column 0 at time step 2"):
        forcing(**{name: series}).check()


def test_air_in_some_columns_only_is_refused():
    with pytest.raises(InputError, match="pressure 0 in some columns"):
        Balance(forcing(pressure=[[0.0], [1e5]]), material())


def test_absorptance_outside_its_range_is_refused():
    with pytest.raises(InputError, match="solar_absorptance 1.2"):
        material(absorptance=1.2)
