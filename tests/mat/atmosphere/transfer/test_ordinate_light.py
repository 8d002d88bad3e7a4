"""Light scattered more than once: ground, limits of optical depth, twilight, the sum over points."""

from dataclasses import replace

import numpy as np
import pytest
from light_parts import scattered_again

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.directions import angles_along
from skyshine.mat.atmosphere.transfer.ordinate_light import level_light
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS, elevations_along

EDGES = np.array([9000.0, 9005.0])


@pytest.fixture(scope="module")
def hazy(synthetic_points, isothermal):
    def make(albedo, sections=(0.0,), **settings):
        settings = {"aerosol": Aerosol("rural", visibility_km=10.0), "surface_albedo": albedo, **settings}
        return SpectralAir.of(isothermal(**settings), synthetic_points(EDGES, {"CO2": list(sections)}))

    return make


def angles(rays, segments, sources):
    ends = np.append(segments.index, segments.index[-1] + 1)
    return [f(rays, *sources)[0, ends] for f in (geometry.source_cosine, geometry.scattering_cosine)]


def test_a_brighter_ground_brightens_the_sky_and_the_path(hazy):
    elevation = np.radians([30.0])
    light = []
    for albedo in (0.0, 0.5, 1.0):
        air = hazy(albedo)
        sky = sky_irradiance(air, np.zeros(1), elevation).scattered[0, 0, 0]
        rays = geometry.trace(air.shells, np.array([3e3]), np.radians([-60.0]))
        segments = Segments.of(rays, 0)
        depths = Depths(segments.column(air.optics.extinction))
        direct = direct_transmittance(air.source_paths, np.zeros(1), elevation)[0, 0, 0]
        path = air.scattered_light.along(segments, depths, *angles(rays, segments, (elevation, np.zeros(1))))[0]
        light.append((sky, path[0, 0]))
    black, grey, white = np.array(light)
    assert np.all(grey > black * 1.01) and np.all(white > grey)
    # What the ground sends up comes back in the share that the air reflects: a geometric series in the albedo.
    ratio = (white[0] - black[0]) / (grey[0] - black[0])
    assert 2.0 < ratio < 2.0 / (1 - white[0] / direct)
    assert white[0] - black[0] < 0.5 * (np.sin(elevation[0]) * direct + white[0])


@pytest.mark.parametrize("visibility", [0.1, 300.0])
def test_opaque_and_clear_air_are_finite(hazy, visibility):
    air = hazy(1.0, (0.0, 1e-28, 1e-24, 1e-20), aerosol=Aerosol("rural", visibility_km=visibility))
    assert np.all(np.isfinite(air.diffuse_light.source))
    sky = sky_irradiance(air, np.array([0.0, 1e3, 2e4]), np.radians([-10.0, 0.0, 45.0, 90.0])).scattered
    assert np.all(np.isfinite(sky)) and np.all(sky >= 0)
    assert np.all(sky < 1.2)  # of a unit beam; a white ground below thin haze adds to it


def test_a_band_is_the_sum_of_its_points(hazy):
    air = hazy(0.4, np.geomspace(1e-28, 1e-24, 6))
    rays = geometry.trace(air.shells, np.array([500.0]), np.radians([-2.0]))
    segments = Segments.of(rays, 0)
    to_source, deflection = angles(rays, segments, (np.radians([50.0, 5.0, -4.0]), np.radians([0.0, 120.0, 60.0])))
    depths = Depths(segments.column(air.optics.extinction))
    weight = np.linspace(1.0, 2.0, 6)
    spectral = air.scattered_light.along(segments, depths, to_source, deflection)[0] @ weight
    band = air.scattered_light.in_band(segments, depths, to_source, deflection, weight)
    assert band[-1] == pytest.approx(spectral, rel=1e-5)
    faint = air.scattered_light.in_band(segments, depths, to_source, deflection, weight * 1e-40)
    assert faint == pytest.approx(band * 1e-40, rel=1e-4, abs=1e-44 * band.max())
    assert np.all(np.diff(band, axis=0) >= 0)


def test_light_of_many_sources_is_that_of_each_alone(hazy):
    """Many share their azimuthal moments, one has none to share; the sky of a bright Sun depends on azimuth."""
    air = hazy(0.4, np.geomspace(1e-28, 1e-24, 6))
    rays = geometry.trace(air.shells, np.array([500.0]), np.radians([4.0]))
    segments = Segments.of(rays, 0)
    elevation, azimuth = np.radians([40.0, 40.0, 40.0, 8.0, 8.0, -3.0, 70.0, 1.0]), np.radians(np.linspace(10, 170, 8))
    to_source, deflection = angles(rays, segments, (elevation, azimuth))
    depths = Depths(segments.column(air.optics.extinction))
    light = scattered_again(air)
    together = light.along(segments, depths, to_source, deflection)[0]
    for k in range(8):
        alone = light.along(segments, depths, to_source[:, k : k + 1], deflection[:, k : k + 1])[0]
        assert together[k] == pytest.approx(alone[0], rel=1e-5)
    assert together[0, 0] > 1.05 * together[2, 0]


@pytest.mark.parametrize("sources", [1, 12])
def test_light_scattered_straight_forward_is_that_at_the_far_ends(hazy, sources):
    """Few sources and many, their azimuthal moments apart: the second has a part that follows the azimuth."""
    air = hazy(0.4, np.geomspace(1e-28, 1e-24, 6))
    light, height = air.diffuse_light, air.state.altitude[:, None, None] / 1000
    light = replace(light, source=np.zeros_like(light.source), straight=np.zeros_like(light.straight))
    light.straight[:, :, :, 0] = (1 + height)[..., None] * np.where(light.angles < np.pi / 2, 3.0, 1.0)[:, None]
    light.straight[:, :, :, 1] = 0.5 * light.straight[:, :, :, 0]
    rays = geometry.trace(air.shells, np.array([500.0]), np.radians([30.0]))
    segments = Segments.of(rays, 0)
    azimuth = np.linspace(0.0, np.pi, sources)
    to_source, deflection = angles(rays, segments, (np.full(sources, np.radians(40.0)), azimuth))
    depths, scaled = Depths(segments.column(air.optics.extinction)), Depths(segments.column(light.scaled))
    left = depths.transmittance * (np.exp(-scaled.per_segment) - np.exp(-depths.per_segment))
    of_azimuth = left.T @ (1 + segments.altitude[1:, None] / 1000)
    wanted = of_azimuth[:, 0] * (1 + 0.5 * np.cos(azimuth[:, None]))
    kernel = scattered_again(air, light)
    found = kernel.along(segments, depths, to_source, deflection)[0]
    assert found == pytest.approx(wanted, rel=2e-3)
    by_segment = kernel.of_segments(segments, depths, to_source[:, :1], deflection[:, :1])
    assert by_segment.sum(axis=0) == pytest.approx(wanted[0], rel=2e-3)
    weight = np.linspace(1.0, 2.0, 6)
    band = kernel.in_band(segments, depths, to_source, deflection, weight)
    assert band[-1] == pytest.approx(wanted @ weight, rel=2e-3)


def test_without_particles_scaling_changes_nothing(hazy):
    air = hazy(0.1, aerosol=Aerosol("none"))
    assert np.array_equal(air.scaled_extinction, air.optics.extinction)
    assert air.scaled_source_paths is air.source_paths


def test_the_flux_alone_is_that_of_the_whole_field(hazy):
    air = hazy(0.3, (0.0, 1e-26))
    light, sine = air.diffuse_light, np.sin(np.radians(ELEVATIONS))
    shared = air.state, air.shells, air.optics, air.delta_fraction, air.scaled_source_paths
    assert level_light(*shared, sine, 0.3)[1] == pytest.approx(light.falling, rel=2e-4, abs=1e-12)


def test_the_elevation_of_a_source_alone_gives_the_same_light_as_all(hazy):
    air, elevation = hazy(0.2), np.radians([38.0])
    few = replace(air, elevations=elevations_along(np.sin(elevation)))
    assert few.elevations == pytest.approx((38.0,))
    assert sky_irradiance(few, np.zeros(1), elevation).scattered == pytest.approx(
        sky_irradiance(air, np.zeros(1), elevation).scattered, rel=1e-4
    )


@pytest.mark.parametrize(
    ("sines", "nodes"),
    [([0.5], (30,)), ([-1.0], (-20,)), ([1.0], (90,)), ([-0.05, 0.05], (-2.866, -2, -1, 0, 1, 2, 2.866))],
)
def test_elevations_along_a_line_begin_and_end_with_those_of_the_source(sines, nodes):
    assert elevations_along(np.array(sines)) == pytest.approx(nodes, abs=1e-3)


@pytest.mark.parametrize("cosines", [[0.7], [1.0], [-1.0], [0.001], [-0.3, -0.1], [-0.005, 0.3]])
def test_directions_of_a_line_hold_its_own_and_none_is_level(cosines):
    angles = np.array(angles_along(cosines))
    assert angles.size and np.all(np.diff(angles) > 0) and np.all(np.abs(np.cos(angles)) > 0.0199)
    for cosine in cosines:
        own = np.min(np.abs(np.cos(angles) - cosine))
        assert own < 1e-12 or abs(cosine) < 0.02
