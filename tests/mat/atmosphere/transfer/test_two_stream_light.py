"""Light scattered more than once: energy, limits of optical depth, ground, twilight."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.atmosphere.transfer.two_stream_light import diffuse_fluxes, upward_share

EDGES = np.array([9000.0, 9005.0])
SUN = np.array([0.2, 0.6, 1.0])
DEPTHS = (0.0, 1e-12, 1e-3, 0.1, 1.0, 10.0, 100.0, 1e4)


def slab(depth, single_scattering_albedo=1.0, asymmetry=0.0, albedo=0.0, layers=10):
    """Fluxes in a plane homogeneous slab: rising, falling, direct, all (layers + 1, sources)."""
    layer = np.full((layers, 1), depth / layers)
    beam = (np.arange(layers, -1, -1) * depth / layers)[:, None, None] / SUN[:, None]
    scattering = layer * single_scattering_albedo
    upward = scattering[:, None] * (0.5 - 0.75 * asymmetry * SUN)[:, None]  # Eddington's phase function
    rising, falling = diffuse_fluxes(layer, scattering, scattering * asymmetry, upward, beam, SUN, albedo)
    return rising[..., 0], falling[..., 0], SUN * np.exp(-beam[..., 0])


@pytest.mark.parametrize("depth", DEPTHS)
@pytest.mark.parametrize("asymmetry", [-0.3, 0.0, 0.5])
@pytest.mark.parametrize("albedo", [0.0, 0.3, 1.0])
def test_pure_scattering_keeps_all_energy(depth, asymmetry, albedo):
    rising, falling, direct = slab(depth, asymmetry=asymmetry, albedo=albedo)
    for flux in (rising, falling):
        assert np.all(np.isfinite(flux)) and np.all(flux >= 0)
    net = (direct + falling - rising) / SUN
    assert net == pytest.approx(np.broadcast_to(net[-1], net.shape), abs=1e-3)
    assert rising[0] == pytest.approx(albedo * (direct + falling)[0], rel=1e-9, abs=1e-15)
    if albedo == 1:
        assert rising[-1] == pytest.approx(SUN, rel=1e-3)


@pytest.mark.parametrize("depth", [0.3, 3.0, 30.0, 300.0])
@pytest.mark.parametrize("asymmetry", [0.0, 0.5])
def test_conservative_slab_meets_the_closed_form(depth, asymmetry):
    """Two-stream reflection without absorption (Toon et al. 1989, equations 12, 23 and 24, in the limit of no
    decay).
    """
    g1 = 0.75 * (1 - asymmetry)
    g3 = 0.5 - 0.75 * asymmetry * SUN
    expected = (g1 * depth + (g3 - g1 * SUN) * -np.expm1(-depth / SUN)) / (1 + g1 * depth)
    assert slab(depth, asymmetry=asymmetry)[0][-1] / SUN == pytest.approx(expected, rel=1e-6)


def test_share_that_goes_up():
    """Closed forms: all phase functions from a source on the horizon, Eddington's from any."""
    cosine = np.cos(PHASE_ANGLES)
    sine = np.array([-1.0, -0.3, 0.0, 0.2, 0.7, 1.0])
    peaked = 0.19 / (1.81 - 1.8 * cosine) ** 1.5
    phase = np.stack([np.ones_like(cosine), 1 + 0.9 * cosine, peaked], axis=1)[:, None]
    isotropic, eddington, forward = upward_share(phase, sine)[0].T
    assert isotropic == pytest.approx(0.5, abs=1e-4)
    assert eddington == pytest.approx(0.5 - 0.75 * 0.3 * sine, abs=1e-4)
    assert forward[2] == pytest.approx(0.5, abs=1e-4)
    # The backward half of Henyey and Greenstein's, (1 - g^2) / (2 g) (1 / sqrt(1 + g^2) - 1 / (1 + g)).
    assert forward[-1] == pytest.approx(0.19 / 1.8 * (1 / np.sqrt(1.81) - 1 / 1.9), rel=1e-3)


def test_a_thin_layer_scatters_once():
    rising, falling, _ = slab(1e-6, 0.7, 0.4)
    back = 0.5 - 0.75 * 0.4 * SUN
    assert rising[-1] == pytest.approx(0.7e-6 * back, rel=1e-4)
    assert falling[0] == pytest.approx(0.7e-6 * (1 - back), rel=1e-4)


def test_the_cut_into_layers_does_not_matter():
    for one, many in zip(slab(2.0, 0.9, 0.4, 0.2, 1), slab(2.0, 0.9, 0.4, 0.2, 40), strict=True):
        assert one[[0, -1]] == pytest.approx(many[[0, -1]], rel=1e-9)


def test_black_particles_scatter_nothing():
    rising, falling, _ = slab(2.0, 0.0)
    assert np.all(rising == 0) and np.all(falling == 0)


@pytest.fixture(scope="module")
def hazy(synthetic_points, isothermal):
    def make(albedo, sections=(0.0,), **settings):
        settings = {"aerosol": Aerosol("rural", visibility_km=10.0), "surface_albedo": albedo, **settings}
        return SpectralAir.of(isothermal(**settings), synthetic_points(EDGES, {"CO2": list(sections)}))

    return make


def test_a_brighter_ground_brightens_the_sky_and_the_path(hazy):
    elevation = np.radians([30.0])
    found = []
    for albedo in (0.0, 0.5, 1.0):
        air = hazy(albedo)
        sky = sky_irradiance(air, np.zeros(1), elevation).scattered[0, 0, 0]
        rays = geometry.trace(air.shells, np.array([3e3]), np.radians([-60.0]))
        segments = Segments.of(rays, 0)
        ends = np.append(segments.index, segments.index[-1] + 1)
        to_source, deflection = (
            angle(rays, elevation, np.zeros(1))[0, ends]
            for angle in (geometry.source_cosine, geometry.scattering_cosine)
        )
        depths = Depths(segments.column(air.optics.extinction))
        direct = direct_transmittance(air.source_paths, np.zeros(1), elevation)[0, 0, 0]
        found.append((sky, air.scattered_radiance(segments, depths, to_source, deflection)[0, 0]))
    black, grey, white = np.array(found)
    assert np.all(grey > black * 1.01) and np.all(white > grey)
    # What the ground sends up comes back in the share that the air reflects: a geometric series in the albedo.
    ratio = (white[0] - black[0]) / (grey[0] - black[0])
    assert 2.0 < ratio < 2.0 / (1 - white[0] / direct)
    assert white[0] - black[0] < 0.5 * (np.sin(elevation[0]) * direct + white[0])


@pytest.mark.parametrize("visibility", [0.1, 300.0])
def test_opaque_and_clear_air_are_finite(hazy, visibility):
    air = hazy(1.0, (0.0, 1e-28, 1e-24, 1e-20), aerosol=Aerosol("rural", visibility_km=visibility))
    light = air.diffuse_light
    for values in (light.mean, light.tilt):
        assert np.all(np.isfinite(values))
    assert np.all(light.mean >= np.abs(light.tilt) - 1e-9)
    sky = sky_irradiance(air, np.array([0.0, 1e3, 2e4]), np.radians([-10.0, 0.0, 45.0, 90.0])).scattered
    assert np.all(np.isfinite(sky)) and np.all(sky >= 0)
    assert np.all(sky < 1.2)  # of a unit beam; a white ground below thin haze adds to it


def test_a_band_is_the_sum_of_its_points(hazy):
    air = hazy(0.4, np.geomspace(1e-28, 1e-24, 6))
    rays = geometry.trace(air.shells, np.array([500.0]), np.radians([-2.0]))
    segments = Segments.of(rays, 0)
    ends = np.append(segments.index, segments.index[-1] + 1)
    sources = np.radians([50.0, 5.0, -4.0]), np.radians([0.0, 120.0, 60.0])
    angles = (f(rays, *sources)[0, ends] for f in (geometry.source_cosine, geometry.scattering_cosine))
    to_source, deflection = angles
    depths = Depths(segments.column(air.optics.extinction))
    weight = np.linspace(1.0, 2.0, 6)
    spectral = air.scattered_radiance(segments, depths, to_source, deflection) @ weight
    band = air.scattered_in_band(segments, depths, to_source, deflection, weight)
    assert band[-1] == pytest.approx(spectral, rel=2e-3)  # the band's light is interpolated in elevation as a whole
    faint = air.scattered_in_band(segments, depths, to_source, deflection, weight * 1e-40)
    assert faint == pytest.approx(band * 1e-40, rel=1e-5, abs=0)
    assert np.all(np.diff(band, axis=0) >= 0)


def test_night_falls_smoothly(hazy):
    sine = np.sin(np.radians(np.arange(-25.0, 20.0, 0.5)))
    light = hazy(1.0).diffuse_light
    here = light.at(0, 0.0, 0.0, sine)[:, 0]
    assert np.all(here >= 0) and np.all(np.diff(here) >= -1e-12)
    assert here[0] < 1e-9 * here[-1]
    day = here > 1e-3 * here[-1]
    assert np.abs(np.diff(np.log(here[day]))).max() < 1.0


def test_without_particles_scaling_changes_nothing(hazy):
    air = hazy(0.1, aerosol=Aerosol("none"))
    assert np.array_equal(air.scaled_extinction, air.optics.extinction)
    assert air.scaled_source_paths is air.source_paths


def test_no_place_is_darker_over_a_brighter_ground(hazy):
    air = hazy(0.0)
    same = replace(air, state=replace(air.state, surface_albedo=0.8))
    assert np.all(same.diffuse_light.mean >= air.diffuse_light.mean)


def test_few_directions_are_enough_for_the_sky_of_peaked_particles(hazy):
    air, elevation = hazy(0.1), np.radians([5.0, 20.0, 50.0, 90.0])
    few = sky_irradiance(air, np.zeros(1), elevation).scattered
    many = sky_irradiance(air, np.zeros(1), elevation, zeniths=24, azimuths=24).scattered
    assert few[:, :3] == pytest.approx(many[:, :3], rel=0.01)
    assert few == pytest.approx(many, rel=0.025)
