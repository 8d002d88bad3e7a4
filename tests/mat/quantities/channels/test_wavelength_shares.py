"""Shares of wavelengths in channels: found again where they are planted, held where nothing tells them apart."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.wavelength_shares import (
    PartedLight,
    SamplePaths,
    WavelengthShares,
    _balanced,
    _shares,
)
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths, parted
from skyshine.mat.radiometry.blackbody import SpectralResponse

RESPONSE = SpectralResponse.rectangular(4.0, 4.2)


@pytest.fixture(scope="module")
def air():
    band = points_of_band(AbsorptionTable.open(), RESPONSE)
    return BandAtmosphere.of(AtmosphericState.from_profile("midlatitude_summer"), band)


@pytest.fixture(scope="module")
def paths():
    generator = np.random.default_rng(3)
    return SamplePaths(
        10 ** generator.uniform(1, 4.5, 40),
        generator.uniform(2.0, 3000.0, 40),
        np.radians(generator.uniform(-60, 60, 40)),
        np.radians(generator.uniform(2, 80, 40)),
    )


def light_of(air, irradiance):
    return PartedLight.of(air.band.wavenumber, air.band.radiance_weight, irradiance)


def test_channels_that_stand_for_themselves_lie_where_their_points_are(air, paths):
    every = air.air, light_of(air, solar_irradiance(air.band.wavenumber))
    nodes = band_wavelengths(RESPONSE)
    shares = WavelengthShares.fitted(nodes, paths, every, every)
    own = parted(1e4 / air.band.wavenumber, nodes)
    assert shares.thermal == pytest.approx(own, abs=1e-6) and shares.source == pytest.approx(own, abs=1e-6)


def test_shares_that_paths_tell_apart_are_found_again():
    """Light of four channels behind twelve paths, parted among three wavelengths; the start is elsewhere."""
    generator = np.random.default_rng(1)
    channels, planted = np.exp(-generator.uniform(0, 3, (12, 4))), generator.dirichlet(np.ones(3), 4)
    started = np.roll(planted, 1, axis=1)
    assert _shares(channels @ planted, channels, started) == pytest.approx(planted, abs=2e-3)


@pytest.mark.parametrize("light", [0.0, 1e-300])
def test_a_channel_without_light_keeps_the_wavelength_of_its_point(light):
    own = np.eye(3)[[0, 2]]
    channels = np.array([[light, 0.0], [light, 0.0]])
    assert _shares(channels @ own, channels, own) == pytest.approx(own)


def test_no_source_and_no_path_leave_the_points_own_wavelengths(air):
    every = air.air, light_of(air, np.zeros(air.band.weight.size))
    nodes = band_wavelengths(RESPONSE)
    inside = SamplePaths(
        np.array([5e4]), np.array([10.0]), np.radians([-80.0]), np.radians([30.0])
    )  # ends in the ground
    shares = WavelengthShares.fitted(nodes, inside, every, every)
    assert shares.source == pytest.approx(parted(1e4 / air.band.wavenumber, nodes))
    assert np.all(np.isfinite(shares.thermal)) and shares.thermal.sum(axis=1) == pytest.approx(1.0)


def test_without_air_channels_emit_at_each_wavelength_what_a_black_body_does(air, paths):
    """Of every seventh point, which alone would leave wavelengths that are opaque to long paths up to a third short."""
    nodes, dark = band_wavelengths(RESPONSE), np.zeros(air.band.weight.size)
    every, index = (air.air, light_of(air, dark)), np.arange(0, dark.size, 7)
    few = PartedLight(*(values[index] for values in vars(every[1]).values()))
    shares = WavelengthShares.fitted(nodes, paths, every, (air.air.part(index), few))
    emitted, wanted = few.thermal @ shares.thermal, every[1].thermal @ parted(1e4 / every[1].wavenumber, nodes)
    assert emitted / emitted.sum() == pytest.approx(wanted / wanted.sum(), rel=1e-3)
    assert shares.thermal.sum(axis=1) == pytest.approx(1.0, abs=1e-12)


def test_balancing_leaves_balanced_shares_and_gives_a_wavelength_without_channels_its_light():
    generator = np.random.default_rng(2)
    light, shares = generator.uniform(1, 2, 5), generator.dirichlet(np.ones(3), 5)
    assert _balanced(shares, light, light @ shares) == pytest.approx(shares, abs=1e-6)
    shares = np.column_stack([shares[:, :2] / shares[:, :2].sum(axis=1, keepdims=True), np.zeros(5)])
    wanted = light.sum() * np.array([0.5, 0.3, 0.2])
    assert light @ _balanced(shares, light, wanted) == pytest.approx(wanted, rel=1e-6)
    assert np.array_equal(_balanced(shares, np.zeros(5), wanted), shares)
