"""Broadband fluxes on the ground: against all points of the table, closed forms, bounds, clear errors."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.spectra.fluxes import (
    LONGWAVE,
    SHORTWAVE,
    BroadbandPoints,
    broadband_fluxes,
    packaged_points,
    sky_emission,
    sunlight_shares,
)
from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.mat.atmosphere.state.state import AerosolComponent, AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.schemas.errors import InputError

HEIGHTS = np.array([0.0, 1e3, 4e3])
ELEVATIONS = np.array([-90.0, -12.0, -3.0, 0.0, 5.0, 20.0, 60.0, 90.0])


@pytest.fixture(scope="module")
def state():
    return AtmosphericState.from_profile("us_standard", gas_amounts=GasAmounts(ppm={"CO2": 420}))


@pytest.fixture(scope="module")
def fluxes(state):
    return broadband_fluxes(state, HEIGHTS, ELEVATIONS, 0.2)


@pytest.mark.validation  # 12 s
def test_few_points_agree_with_all_of_the_table(state, fluxes):
    stated = packaged_points().errors
    points = AbsorptionTable.open().points(*LONGWAVE)
    whole = sky_emission(state, points, HEIGHTS[:1]) @ points.weight
    assert abs(fluxes.longwave_down[0] - whole[0]) <= stated["longwave_down"]["max"]
    points = AbsorptionTable.open().points(*SHORTWAVE)
    low, high = points.interval_edges.T
    sun = points.weight * solar_irradiance(0.5 * (low + high), high - low)[points.interval]
    direct = diffuse = 0.0
    for part in np.array_split(np.arange(points.wavenumber.size), 8):  # bounds memory
        both = sunlight_shares(SpectralAir.of(state, points.subset(part)), HEIGHTS[:1], ELEVATIONS[6:7], 0.2)
        direct, diffuse = (total + one[0, 0] @ sun[part] for total, one in zip((direct, diffuse), both, strict=True))
    assert abs(fluxes.direct_normal[0, 6] - direct) <= stated["direct_normal"]["max"]
    assert abs(fluxes.diffuse[0, 6] - diffuse) <= stated["diffuse"]["max"]


def test_light_under_a_cloud_is_that_of_tables_and_spectra():
    """A cloud that asks for more ordinates: field, scaled beam and forward light agree with those of a sky."""
    cloudy = AtmosphericState.from_profile(
        "us_standard", surface_albedo=0.2, clouds=[CloudLayer("water", 1e3, 2e3, 10.0, 3.0)]
    )
    points = AbsorptionTable.open().points(15380.0, 15390.0)
    elevation = np.array([30.0, 60.0])
    _, diffuse = sunlight_shares(SpectralAir.of(cloudy, points), HEIGHTS[:1], elevation, 0.2)
    sky = sky_irradiance(SpectralAir.of(cloudy, points), HEIGHTS[:1], np.radians(elevation))
    assert diffuse == pytest.approx(sky.scattered, rel=5e-4)


def test_the_stated_errors_are_small():
    stated = packaged_points().errors
    assert (
        stated["longwave_down"]["rms"] < 0.5 and stated["direct_normal"]["rms"] < 1.0 and stated["diffuse"]["rms"] < 0.5
    )


def test_longwave_is_below_the_black_body_of_the_warmest_air_and_falls_with_height(state, fluxes):
    assert np.all(np.diff(fluxes.longwave_down) < 0)
    assert 0.5 < fluxes.longwave_down[0] / (Stefan_Boltzmann * state.temperature.max() ** 4) < 1


@pytest.mark.parametrize("kelvin", [220.0, 320.0])
def test_dense_fog_of_one_temperature_radiates_as_a_black_body(state, kelvin):
    fog = AerosolComponent(AerosolModel.load("fog_advection"), np.where(state.altitude < 1500.0, 0.2, 0.0))
    opaque = replace(
        state, temperature=np.full(state.altitude.size, kelvin), aerosols=(fog,), surface_temperature=kelvin
    )
    found = broadband_fluxes(opaque, 0.0, 0.0, 0.2).longwave_down[0]
    assert found == pytest.approx(Stefan_Boltzmann * kelvin**4, rel=5e-3)


def test_above_the_air_the_beam_is_the_sun_itself(state):
    top = broadband_fluxes(state, state.altitude[-1], [30.0], 0.2)
    near = broadband_fluxes(state, state.altitude[-1], [30.0], 0.2, sun_distance=0.98)
    # 1361.1 W m^-2 (Gueymard 2018) less what lies below 0.3 um, 1.1 to 1.2 % of it (ASTM E490: 1.2 %).
    assert top.direct_normal[0, 0] == pytest.approx(1361.1 * (1 - 0.0115), rel=3e-3)
    assert near.direct_normal / top.direct_normal == pytest.approx(1 / 0.98**2, rel=1e-12)
    assert top.diffuse[0, 0] == pytest.approx(0.0, abs=0.01)


def test_what_arrives_is_never_more_than_was_sent(state):
    dark = broadband_fluxes(state, HEIGHTS, ELEVATIONS, 0.0)
    sine = np.maximum(np.sin(np.radians(ELEVATIONS)), 0.0)
    level = dark.direct_normal * sine + dark.diffuse
    day = sine > 0.05
    assert np.all(level[:, day] < 1361.1 * sine[day])
    assert np.all(np.diff(dark.direct_normal[:, ELEVATIONS >= 0], axis=0) > 0)


def test_twilight_fades_and_the_night_is_dark(fluxes):
    night = fluxes.diffuse[0]
    assert np.all(np.isfinite(fluxes.diffuse)) and np.all(fluxes.diffuse >= 0)
    assert np.all(fluxes.direct_normal[:, ELEVATIONS < -2] == 0)
    assert night[0] < 1e-6 and night[1] < 1e-3 < night[2] < 5 < night[3] < 20 < night[4]


def test_a_bright_ground_lights_the_sky(state, fluxes):
    snow = broadband_fluxes(state, HEIGHTS, ELEVATIONS, 0.8)
    assert np.all(snow.diffuse[:, 4:] > fluxes.diffuse[:, 4:])
    assert np.array_equal(snow.direct_normal, fluxes.direct_normal)


def test_points_of_another_table_are_refused():
    table = AbsorptionTable.open()
    table._content = "0" * 64
    with pytest.raises(InputError, match="chosen from another absorption table"):
        BroadbandPoints.open(table=table)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ((-10.0, 0.0, 0.2), "allowed: 0 to 100000 m"),
        ((np.nan, 0.0, 0.2), "found surface altitudes"),
        ((0.0, 91.0, 0.2), "allowed: -90 to 90"),
        ((0.0, 10.0, 1.2), "allowed: 0 to 1"),
        ((0.0, 10.0, np.nan), "allowed: 0 to 1"),
    ],
)
def test_bad_input_is_named(state, arguments, text):
    with pytest.raises(InputError, match=text):
        broadband_fluxes(state, *arguments)
