"""Transfer against closed forms: isothermal and transparent air, thin and homogeneous scattering, sky and shadow."""

from dataclasses import replace

import numpy as np
import pytest
from light_parts import scattered_once
from numpy_light import source_ends

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import geometry
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import rayleigh_phase
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments, mean_attenuation, source_weights
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.radiometry.blackbody import planck_wavenumber

EDGES = np.array([900.0, 905.0])
# From nothing to optical depths of 1e5 and beyond on long paths.
SECTIONS = np.array([0.0, 1e-40, 1e-32, 1e-28, 1e-26, 1e-24, 1e-22, 1e-20])
PATHS = [
    (0.0, 90.0, None),
    (0.0, 30.0, 20e3),
    (0.0, 0.0, 50e3),
    (0.0, 0.0, 1.0),
    (1e3, -90.0, None),
    (1e3, -0.9, None),
    (12e3, -3.0, None),
    (12e3, -2.0, 500e3),
    (100e3, -9.0, None),
    (100e3, 10.0, None),
    (700e3, -25.0, None),
    (700e3, -60.0, None),
]


def path(air, altitude, elevation, distance):
    ranges = None if distance is None else np.array([[distance]])
    rays = geometry.trace(air.shells, np.array([altitude]), np.radians([elevation]), ranges)
    segments = Segments.of(rays, 0)
    if distance is not None:
        segments = segments.first(min(int(np.searchsorted(segments.distance, distance)), segments.index.size))
    return rays, segments, segments.column(air.optics.extinction)


@pytest.mark.parametrize(("altitude", "elevation", "distance"), PATHS)
def test_isothermal_air_emits_as_much_as_it_absorbs(synthetic_points, isothermal, altitude, elevation, distance):
    air = SpectralAir.of(isothermal(280.0), synthetic_points(EDGES, {"CO2": SECTIONS}))
    _, segments, depth = path(air, altitude, elevation, distance)
    expected = -np.expm1(-depth.sum(axis=0)) * planck_wavenumber(902.5, 280.0)
    assert air.thermal_radiance(segments, Depths(depth)).sum(axis=0) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("altitude", "elevation", "distance"), [(0.0, 30.0, 20e3), (12e3, -3.0, None), (1e3, -90.0, None)]
)
def test_a_source_linear_in_altitude_has_its_values_at_the_ends_of_segments(
    synthetic_points, isothermal, altitude, elevation, distance
):
    air = SpectralAir.of(isothermal(280.0), synthetic_points(EDGES, {"CO2": SECTIONS}))
    _, segments, _ = path(air, altitude, elevation, distance)
    levels = air.state.altitude
    mean = (100.0 + 1e-3 * levels)[:, None]
    near, far = source_ends(segments, mean[segments.layer], mean[segments.layer + 1], levels)
    assert (far - near)[:, 0] == pytest.approx(1e-3 * np.diff(segments.altitude), abs=1e-12)
    assert (far + near)[:, 0] / 2 == pytest.approx(
        segments.column(mean)[:, 0] / (segments.lower + segments.upper), rel=1e-12
    )


def test_transparent_air_emits_nothing(synthetic_points):
    state = AtmosphericState.from_profile("tropical", aerosol=Aerosol("none"))
    air = SpectralAir.of(state, synthetic_points(EDGES, {"CO2": np.zeros(2)}))
    clear = replace(air.optics, extinction=np.zeros_like(air.optics.extinction))
    _, segments, _ = path(air, 0.0, 0.0, None)
    depth = segments.column(clear.extinction)
    assert np.all(air.thermal_radiance(segments, Depths(depth)) == 0.0)


def test_optical_depth_is_cross_section_times_amount_of_gas(synthetic_points, isothermal):
    state = isothermal()
    air = SpectralAir.of(state, synthetic_points(EDGES, {"CO2": SECTIONS[3:]}))
    for distance in (1e-3, 1.0, 100.0):
        _, _, depth = path(air, 0.0, 0.0, distance)
        per_metre = SECTIONS[3:] * state.mole_fraction["CO2"][0] * state.number_density[0]
        rayleigh = air.optics.rayleigh[0] * state.number_density[0]
        assert depth.sum(axis=0) == pytest.approx((per_metre + rayleigh) * distance, rel=1e-6)


def test_source_weights_are_exact_at_any_optical_depth():
    depth = np.concatenate([[0.0], np.geomspace(1e-12, 1e5, 400)])
    near, far = source_weights(depth)
    assert near + far == pytest.approx(-np.expm1(-depth), rel=1e-12)
    assert np.all(far >= 0) and np.all(near >= far - 1e-15)
    thin = depth[1:100]
    assert far[1:100] == pytest.approx(thin / 2, rel=2 * thin.max() + 1e-12)
    assert near[-1] == pytest.approx(1 - 1e-5, rel=1e-9)  # (1 - 1 / t) of the near end for large t
    assert np.all(np.diff(far[depth < 1.5]) > 0)  # no seam between series and closed form


def test_emission_with_a_source_linear_in_optical_depth():
    # J = a + b t over total depth T gives a + b - (a + b + b T) exp(-T), however finely it is cut.
    a, b, total = 2.0, 3.0, 1.7
    for cuts in (1, 2, 7):
        edge = np.linspace(0, total, cuts + 1)
        depth = np.diff(edge)[:, None]
        source = (a + b * edge)[:, None]
        near, far = source_weights(depth)
        found = ((near * source[:-1] + far * source[1:]) * Depths(depth).transmittance).sum()
        assert found == pytest.approx(a + b - (a + b + b * total) * np.exp(-total), rel=1e-12)


def test_mean_attenuation_is_exact_from_equal_to_far_apart_depths():
    first = np.array([0.0, 1.0, 5.0, 0.0, 30.0, 1e4, 2.0])
    last = np.array([0.0, 1.0, 5.00001, 40.0, 0.0, 1e4, 1e4])
    expected = [1.0, np.exp(-1), np.exp(-5), 1 / 40, 1 / 30, 0.0, np.exp(-2) / 9998]
    assert mean_attenuation(first, last) == pytest.approx(expected, rel=1e-5)


def test_thin_single_scattering(synthetic_points, isothermal):
    """Where nothing is thick, scattered radiance is the scattering optical depth times phase function over 4 pi."""
    air = SpectralAir.of(isothermal(), synthetic_points(EDGES, {"CO2": np.zeros(1)}))
    source = np.radians([10.0, 40.0, 90.0, 25.0]), np.radians([0.0, 90.0, 0.0, 180.0])
    for altitude, elevation in ((0.0, 20.0), (0.0, 90.0), (5e3, 0.0), (5e3, -60.0)):
        rays, segments, depth = path(air, altitude, elevation, None)
        to_source = geometry.source_cosine(rays, *source)[0]
        deflection = geometry.scattering_cosine(rays, *source)[0]
        ends = np.append(segments.index, segments.index[-1] + 1)
        found = scattered_once(air).along(segments, Depths(depth), to_source[ends], deflection[ends])[0, :, 0]
        e, (s, a) = np.radians(elevation), source
        angle = np.sin(e) * np.sin(s) + np.cos(e) * np.cos(s) * np.cos(a)
        expected = depth.sum() * rayleigh_phase(angle, air.optics.rayleigh_anisotropy) / (4 * np.pi)
        assert found == pytest.approx(expected, rel=3e-3)  # refraction turns the horizontal path by 0.3 degree


def test_single_scattering_of_a_thick_homogeneous_atmosphere(synthetic_points, isothermal):
    """Looking up and down through plane-parallel absorbing and scattering air: Chandrasekhar's closed forms."""
    state = isothermal()
    air = SpectralAir.of(state, synthetic_points(EDGES, {"CO2": [1e-25, 3e-24, 3e-23]}))
    # The same single-scattering albedo everywhere.
    extinction = np.broadcast_to(air.optics.extinction[0], air.optics.extinction.shape)
    optics = replace(air.optics, extinction=extinction)
    source_paths = SourcePaths.of(air.source_rays, extinction)
    sun = np.radians([35.0]), np.zeros(1)
    mu0, albedo = np.sin(sun[0][0]), optics.rayleigh[0] / extinction[0]
    total = state._column(state.number_density, 0.0) * extinction[0]
    for altitude, elevation, closed in (
        (0.0, 50.0, lambda t, mu: (np.exp(-t / mu0) - np.exp(-t / mu)) * mu0 / (mu0 - mu)),
        (100e3, -90.0, lambda t, mu: -np.expm1(-t * (1 / mu0 + 1 / mu)) * mu0 / (mu0 + mu)),
    ):
        rays = geometry.trace(air.shells, np.array([altitude]), np.radians([elevation]))
        segments = Segments.of(rays, 0)
        depth = segments.column(extinction)
        ends = np.append(segments.index, segments.index[-1] + 1)
        to_source, deflection = (f(rays, *sun)[0, ends] for f in (geometry.source_cosine, geometry.scattering_cosine))
        once = scattered_once(air, optics, source_paths, extinction)
        found = once.along(segments, Depths(depth), to_source, deflection)[0, 0]
        phase = rayleigh_phase(np.cos(np.radians(elevation - 35.0)), optics.rayleigh_anisotropy)
        expected = albedo * phase / (4 * np.pi) * closed(total, np.sin(np.radians(abs(elevation))))
        assert found == pytest.approx(expected, rel=5e-3)  # the Earth is round, the closed form flat


def test_source_paths_agree_with_traced_rays(synthetic_points, isothermal):
    air = SpectralAir.of(isothermal(), synthetic_points(EDGES, {"CO2": [3e-26]}))
    altitude = np.array([0.0, 100.0, 1.3e3, 7.7e3, 20e3, 45e3])
    for degree in (0.0, 0.7, 3.3, 12.0, 33.0, 90.0):
        apparent = np.full(altitude.size, np.radians(degree))
        rays = geometry.trace(air.shells, altitude, apparent)
        geometric = np.pi / 2 - geometry.departure_angle(rays)
        traced = [Segments.of(rays, row).column(air.optics.extinction).sum() for row in range(altitude.size)]
        found = air.source_paths.optical_depth(altitude, np.sin(geometric)[:, None])[:, 0, 0]
        assert found == pytest.approx(traced, rel=0.01)


def test_the_earth_hides_the_source(synthetic_points, isothermal):
    air = SpectralAir.of(isothermal(), synthetic_points(EDGES, {"CO2": [3e-26]}))
    altitude = np.array([0.0, 1e3, 20e3, 99e3, 700e3])
    light = direct_transmittance(air.source_paths, altitude, np.radians([-90.0, -30.0, -0.4, 0.0, 90.0]))[..., 0]
    assert np.all(light[:, 0] == 0)
    assert np.all(light[:4, 1] == 0)
    assert light[0, 2] > 0  # lifted above the horizon by refraction
    assert np.all(light[:, 3:] > 0)
    dip = np.degrees(np.arccos(geometry.EARTH_RADIUS / (geometry.EARTH_RADIUS + 700e3)))
    seen = direct_transmittance(air.source_paths, np.array([700e3]), np.radians([-dip - 2, -dip + 3]))[0, :, 0]
    assert seen[0] == 0 and seen[1] == pytest.approx(1.0, abs=1e-3)


def test_an_opaque_isothermal_sky_is_a_black_hemisphere(synthetic_points, isothermal):
    air = SpectralAir.of(isothermal(290.0), synthetic_points(EDGES, {"CO2": [1e-20]}))
    sky = sky_irradiance(air, np.array([0.0, 2e3]), np.zeros(0))
    assert sky.thermal[:, 0] == pytest.approx(np.pi * planck_wavenumber(902.5, 290.0), rel=1e-6)
    assert sky.scattered.shape == (2, 0, 1)


def test_diffusivity_of_a_thin_sky(synthetic_points, isothermal):
    # A thin plane layer of optical depth t radiates 2 pi B t (1 - 2 E3(t) for any t).
    from scipy.special import expn

    air = SpectralAir.of(isothermal(290.0), synthetic_points(EDGES, {"CO2": [1e-26, 1e-24, 1e-23]}))
    state = air.state
    depth = state._column(state.number_density, 0.0) * air.optics.extinction[0]
    found = sky_irradiance(air, np.array([0.0]), np.zeros(0)).thermal[0]
    assert found == pytest.approx(np.pi * planck_wavenumber(902.5, 290.0) * (1 - 2 * expn(3, depth)), rel=5e-3)


def test_scattered_sky_of_thin_air(synthetic_points, isothermal):
    """Half of what thin air scatters comes down: E = F t / 2, of a field of flat layers."""
    air = SpectralAir.of(isothermal(surface_albedo=0.0), synthetic_points(np.array([5000.0, 5005.0]), {"CO2": [0.0]}))
    depth = air.state._column(air.state.number_density, 0.0) * air.optics.rayleigh[0, 0]
    sky = sky_irradiance(air, np.array([0.0]), np.radians([30.0, 60.0, 90.0]), zeniths=24)
    assert sky.scattered[0, :, 0] == pytest.approx(0.5 * depth, rel=0.005)


def test_twilight_fades_without_a_jump_upwards(synthetic_points, isothermal):
    air = SpectralAir.of(
        isothermal(aerosol=Aerosol("rural")), synthetic_points(np.array([5000.0, 5005.0]), {"CO2": [0.0]})
    )
    elevation = np.radians(np.arange(-30.0, 11.0, 1.0))
    sky = sky_irradiance(air, np.array([0.0]), elevation).scattered[0, :, 0]
    assert np.all(np.isfinite(sky)) and np.all(sky >= 0)
    assert np.all(np.diff(sky) >= -1e-12)
    assert sky[0] < 1e-12 * sky[-1]


def test_where_rain_ends_it_scatters_by_its_own_phase_function(synthetic_points):
    """The haze above scatters backward thirty times the share of rain, and a thousandth in all: at the rain's last
    level a mean of both functions would add a fifth to the sunlight that comes back."""
    state = AtmosphericState.from_profile("midlatitude_summer", rain=RainLayer(10.0, 3e3))
    air = SpectralAir.of(state, synthetic_points((2596.0, 2600.0), {"CO2": np.zeros(2)}))
    _, segments, _ = path(air, 6e3, -90.0, None)
    cosine = np.cos(np.radians(150.0))
    number = np.array([2598.0])
    by_level = np.zeros(state.altitude.size)
    for component in state.particles:
        of_one = component.model.optics(number, state.relative_humidity)
        phase = component.model.phase_function(np.array([cosine]), number, state.relative_humidity)[0, :, 0]
        scattering = of_one.extinction[:, 0] * of_one.single_scattering_albedo[:, 0]
        by_level += component.extinction_550 / state.number_density * scattering * phase
    particles = replace(air.optics, rayleigh=np.zeros_like(air.optics.rayleigh))
    air_absorbs = np.zeros_like(air.optics.extinction)
    once = scattered_once(air, particles, SourcePaths.of(air.source_rays, air_absorbs), air_absorbs)
    angles = (np.full((segments.index.size + 1, 1), part) for part in (1.0, cosine))
    light = 4 * np.pi * once.of_segments(segments, Depths(segments.column(air_absorbs)), *angles)
    expected = segments.lower * by_level[segments.layer] + segments.upper * by_level[segments.layer + 1]
    assert light[:, 0] == pytest.approx(expected, rel=5e-3)
