"""Light of a low Sun: orders of scattering in spherical shells."""

from dataclasses import replace

import numpy as np
import pytest
from light_parts import scattered_once

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES, ScaledLayers, solved_moments
from skyshine.mat.atmosphere.transfer.ordinates import ordinates
from skyshine.mat.atmosphere.transfer.scattering_orders import first_orders
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS, elevation_weights, elevations_from
from skyshine.mat.atmosphere.transfer.spherical_orders import LowSun

EDGES = np.array([15000.0, 15005.0])
ALBEDO = 0.3


@pytest.fixture(scope="module")
def air_of(synthetic_points, isothermal):
    def make(sections=(0.0,), **settings):
        settings = {"aerosol": Aerosol("rural", visibility_km=23.0), "surface_albedo": ALBEDO, **settings}
        return SpectralAir.of(isothermal(**settings), synthetic_points(EDGES, {"CO2": list(sections)}))

    return make


def orders(air, count=2):
    """The lines, and the first orders in spherical shells and in plane layers, averaged over azimuth."""
    moments = solved_moments(air.optics, NODES)
    layers = ScaledLayers.of(air.shells, air.optics, moments, air.delta_fraction, molecules=True, azimuthal=6)
    low = LowSun.of(air.shells, NODES, np.array([-1.0]))
    albedo, paths = np.full(air.optics.wavenumber.size, ALBEDO), air.scaled_source_paths
    around = low.orders(layers, air.scaled_extinction, paths, albedo, count)
    sine = low.paths.sine
    beam = paths.optical_depth(paths.levels, np.broadcast_to(sine, (paths.levels.size, sine.size))).astype(float)
    flat = first_orders(ordinates(NODES, 1), layers.depth, layers.weighted, beam, sine, albedo, count)
    return low, around, [np.concatenate(part, axis=2)[:, 0] for part in flat]


def test_light_scattered_once_is_that_of_the_exact_single_scattering(air_of):
    air = air_of(aerosol=Aerosol("none"))
    low, around, _ = orders(air, 1)
    node, level = low.ordinates.node, low.paths.level
    sines, azimuth = low.paths.sine, low.paths.azimuth
    for place in (0, 4, 9):
        for number in range(NODES):
            rays = geometry.trace(
                air.shells, air.state.altitude[level[place]][None], np.arcsin(node[number : number + 1])
            )
            segments = Segments.of(rays, 0)
            depths = Depths(segments.column(air.optics.extinction))
            for elevation in (-4.0, -1.0, 2.0):
                chosen = int(np.argmin(np.abs(sines - np.sin(np.radians(elevation)))))
                sources = np.full(azimuth.size, np.radians(elevation)), azimuth
                to_source = geometry.source_cosine(rays, *sources)[0, segments.ends]
                deflection = geometry.scattering_cosine(rays, *sources)[0, segments.ends]
                exact = scattered_once(air).along(segments, depths, to_source, deflection)[0, :, 0]
                found = around[0][place, NODES + number, :, chosen, 0]
                faint = 0.01 * float(exact.max())
                assert found == pytest.approx(exact, rel=0.04, abs=faint), (place, number, elevation)


def test_a_higher_sun_sees_plane_layers(air_of):
    low, around, flat = orders(air_of())
    height = air_of().state.altitude[low.paths.level] < 10e3
    for spherical, plane in zip(around, flat, strict=True):
        mean = spherical.mean(axis=2)[height][:, :, -1]  # the highest elevation, 10 degree
        steep = np.r_[1:NODES, NODES + 1 : 2 * NODES]
        ratio = mean / plane[low.paths.level][height][:, :, -1]
        assert ratio[:, steep] == pytest.approx(1.0, abs=0.06)


def test_air_in_the_shadow_is_lit_from_the_side_of_the_sun(air_of):
    air = air_of()
    low, around, flat = orders(air)
    ground = np.concatenate([part[:1].mean(axis=2) for part in around]), np.concatenate([part[:1] for part in flat])
    dark = int(np.argmin(np.abs(low.paths.sine - np.sin(np.radians(-5.0)))))
    ratio = ground[0][:, NODES, dark] / ground[1][:, NODES, dark]  # from the horizon
    assert np.all(ratio > 1.3)
    toward, away = around[0][0, NODES, 0, dark], around[0][0, NODES, -1, dark]
    assert np.all(toward > 3 * away)


SKIES = {
    "no particles": {"aerosol": Aerosol("none")},
    "haze": {"aerosol": Aerosol("rural", visibility_km=5.0)},
    "dense fog": {"aerosol": Aerosol("rural", visibility_km=0.1)},
}


@pytest.mark.parametrize("sky", list(SKIES))
def test_twilight_fades_steadily_to_darkness(air_of, sky):
    air = air_of((0.0, 1e-26, 1e-22), **SKIES[sky])
    elevation = np.radians([-90.0, -18.0, -12.0, -10.0, -8.0, *np.arange(-6.0, 8.0, 0.5)])
    light = sky_irradiance(air, np.array([0.0, 2e3, 1e5]), elevation).scattered
    assert np.all(np.isfinite(light)) and np.all(light >= 0)
    assert np.all(np.diff(light[:2], axis=1) >= 0)
    assert np.all(light[0, 5:, 0] > 0)  # from -6 degree on
    assert np.all(light[:, 0] == 0)
    gone = light[0, 5:-1, 0] / light[0, 6:, 0]
    assert np.all(gone > 0.45)  # half a degree takes less than half of the light: no jump at 5 degrees either


def brightest_later(light):
    """Light (places, elevations, points) below 2 degrees, and the brightest of all higher elevations, both but one."""
    light = np.abs(light[:, : ELEVATIONS.index(2)]).max(axis=2)
    brightest = np.maximum.accumulate(light[:, ::-1], axis=1)[:, ::-1]
    return light[:, :-1], np.maximum(brightest[:, 1:], 1e-12)


def test_no_air_is_brighter_under_a_lower_sun_however_opaque_it_is(air_of):
    # Plane layers are dark to the last digit at some levels of opaque air, not at all between them.
    light, later = brightest_later(air_of(10.0 ** np.arange(-27.0, -17.0, 0.5)).diffuse_light.source)
    assert np.all(light <= 3.0 * later)


@pytest.mark.parametrize("depth", [2.0, 8.0, 1e4])
def test_no_cloud_is_brighter_under_a_lower_sun(air_of, depth):
    """A source hidden from a cloud's top was 1e6 to 1e15 times too bright under -2 degrees."""
    light, later = brightest_later(air_of(clouds=[CloudLayer("water", 1e3, 2e3, 10.0, depth)]).diffuse_light.source)
    assert np.all(light <= 3.0 * later)


def test_plane_and_spherical_field_meet_at_five_degrees(air_of):
    air = air_of()
    elevation = np.radians([3.5, 4.5, 5.5, 8.0])
    both = [
        sky_irradiance(one, np.zeros(1), elevation).scattered[0, :, 0] for one in (air, replace(air, spherical=False))
    ]
    assert both[0][2:] == pytest.approx(both[1][2:], rel=1e-6)
    assert both[0][:2] == pytest.approx(both[1][:2], rel=0.01)
    twilight = [
        sky_irradiance(one, np.zeros(1), np.radians([-5.0])).scattered[0, 0, 0]
        for one in (air, replace(air, spherical=False))
    ]
    assert twilight[0] > 1.2 * twilight[1]


def test_without_scattering_there_is_no_light(air_of):
    air = air_of(aerosol=Aerosol("none"))
    none = replace(air, optics=replace(air.optics, rayleigh=np.zeros_like(air.optics.rayleigh)))
    assert not np.any(none.diffuse_light.source[:, :, : ELEVATIONS.index(0)])


def test_sources_that_stay_high_need_no_lines(air_of):
    assert LowSun.of(air_of().shells, NODES, np.sin(np.radians([5.5, 8.0]))) is None
    assert elevations_from(20.0) == (17, 23, 30, 38, 47, 57, 70, 90)
    assert elevations_from(17.0)[0] == 17
    assert elevations_from(-90.0) == elevations_from(-20.0) == ELEVATIONS
    assert elevations_from(90.0) == (90,)


def test_light_that_falls_exponentially_in_twilight_is_interpolated_closely():
    sine = np.sin(np.radians(ELEVATIONS))
    between = np.sin(np.radians(np.arange(-6.0, -1.0, 0.1)))
    for rate, error in ((1.1, 0.08), (0.7, 0.04), (0.4, 0.04)):  # e-folds a degree
        light = elevation_weights(sine, between) @ np.exp(rate * np.degrees(np.arcsin(sine)))
        assert light == pytest.approx(np.exp(rate * np.degrees(np.arcsin(between))), rel=error)
    assert np.sum(elevation_weights(sine, np.sin(np.radians([1.5, 33.0, 90.0]))), axis=-1) == pytest.approx(1.0)
