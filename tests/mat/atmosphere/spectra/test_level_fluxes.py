"""Fluxes on the levels: black bodies in closed form, energy of light that nothing absorbs, and the fluxes elsewhere."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.spectra.fluxes import sky_emission, sunlight_shares
from skyshine.mat.atmosphere.spectra.level_fluxes import LevelFluxes
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.radiometry.blackbody import planck_wavenumber


@pytest.fixture(scope="module")
def state():
    return AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))


def test_air_as_warm_as_a_black_ground_emits_as_much_upward(state):
    even = replace(
        state, temperature=np.full_like(state.temperature, 280.0), surface_temperature=280.0, surface_albedo=0.0
    )
    points = AbsorptionTable.open().points(660.0, 665.0)
    fluxes = LevelFluxes.of(even, points, [])
    black = np.pi * planck_wavenumber(np.full(points.wavenumber.size, 662.5), 280.0)
    np.testing.assert_allclose(fluxes.thermal_up, np.broadcast_to(black, fluxes.thermal_up.shape), rtol=1e-4)
    np.testing.assert_allclose(fluxes.thermal_down[0], black, rtol=1e-3)  # the lowest air is opaque at 15 um
    assert np.all(fluxes.thermal_down[-1] == 0)


def test_light_that_nothing_absorbs_leaves_or_reaches_the_ground(state):
    clear = replace(state, mole_fraction={name: 0 * x for name, x in state.mole_fraction.items()}, surface_albedo=0.3)
    points = AbsorptionTable.open().points(22000.0, 22100.0)
    fluxes = LevelFluxes.of(clear, points, [60.0])
    net = fluxes.direct + fluxes.diffuse_down - fluxes.diffuse_up
    # Beams through shells bend and spread over more air with height: the flux is even to some thousandths.
    np.testing.assert_allclose(net, np.broadcast_to(net[:1], net.shape), rtol=4e-3)
    np.testing.assert_allclose(fluxes.diffuse_up[0], 0.3 * (fluxes.direct + fluxes.diffuse_down)[0], rtol=1e-6)


def test_light_falling_on_the_ground_is_that_of_the_broadband_fluxes():
    state = AtmosphericState.from_profile("midlatitude_summer", surface_albedo=0.2)
    points = AbsorptionTable.open().points(1000.0, 1010.0)
    fluxes = LevelFluxes.of(state, points, [50.0, 20.0])
    sky = sky_emission(state, points, state.altitude[:1])
    np.testing.assert_allclose(fluxes.thermal_down[0], sky[0], rtol=5e-3)  # lines of sight through shells
    direct, diffuse = sunlight_shares(SpectralAir.of(state, points), state.altitude[:1], np.array([50.0, 20.0]), 0.2)
    sine = np.sin(np.radians([50.0, 20.0]))[:, None]
    np.testing.assert_allclose(fluxes.direct[0], sine * direct[0], rtol=1e-9)
    np.testing.assert_allclose(fluxes.diffuse_down[0], diffuse[0], rtol=1e-6)


def test_a_band_is_the_sum_of_its_points(state):
    points = AbsorptionTable.open().points(1000.0, 1005.0)
    fluxes = LevelFluxes.of(state, points, [30.0])
    whole = fluxes.in_band(points.weight, 2 * points.weight)
    assert whole.thermal_up[3, 0] == pytest.approx(fluxes.thermal_up[3] @ points.weight)
    assert whole.direct[3, 0, 0] == pytest.approx(2 * fluxes.direct[3, 0] @ points.weight)
