"""Ambient light on faces of any direction: closed forms, extreme cases, harmonics against the direct integral."""

from dataclasses import replace

import numpy as np
import pytest
from face_light import facet_irradiance

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES
from skyshine.mat.quantities.ambient_harmonics import (
    GROUND_TEMPERATURES,
    HarmonicSky,
    ambient_harmonics,
    ground_emission,
)
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.facet_light import Facets, Walls, light_among_walls
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.quantities.radiance_field import Directions, cell_phases
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.radiometry.spherical_harmonics import COUNTS, HARMONICS, ambient_of_faces, harmonics_at, zonal

KELVIN = 290.0
EDGES = np.array([2400.0, 2600.0])
RESPONSE = SpectralResponse.rectangular(1e4 / EDGES[1], 1e4 / EDGES[0])
UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])


def faces(count=40):
    normal = np.random.default_rng(8).normal(size=(count, 3))
    return np.concatenate([normal / np.linalg.norm(normal, axis=1, keepdims=True), [UP, DOWN, [1, 0, 0], [-1, 0, 0]]])


@pytest.fixture(scope="module")
def band(synthetic_points):
    return band_points(synthetic_points(EDGES, {"CO2": np.array([3e-28, 3e-27, 3e-26, 1e-23])}), RESPONSE)


@pytest.fixture(scope="module")
def lit(band):
    """Summer air with aerosol over ground that is warmer than the air, and the Sun's irradiance at its points."""
    state = AtmosphericState.from_profile("midlatitude_summer", surface_temperature=310.0, surface_albedo=0.2)
    return BandAtmosphere.of(state, band), np.array([0.02, 0.03, 0.04, 0.05])


def by_harmonics(atmosphere, altitude, elevation, irradiance, count, normal, ground_temperature):
    """Spectral irradiance (F, P) of faces from harmonics at a place, and level irradiance from their directions."""
    air = atmosphere.air
    sky = HarmonicSky.of(air, np.array([altitude]), np.array([elevation]), irradiance, count)
    radiance, ground = sky.at(np.array([altitude]))
    level = sky.sky.at(np.array([altitude]))[0, 0] / np.pi
    emitted = (1 - air.state.surface_albedo) * planck_wavenumber(air.optics.wavenumber, ground_temperature)
    return np.pi * ambient_of_faces(level, radiance[0, 0], ground[0], emitted, normal[:, None])


@pytest.mark.parametrize("height", [0.0, 3000.0])
@pytest.mark.parametrize("elevation", [-30.0, 0.0, 15.0, 60.0, 90.0])
def test_harmonics_agree_with_the_hemispheres_of_faces(lit, height, elevation):
    """From the polar night to the Sun in the zenith, at the ground and above it."""
    atmosphere, irradiance = lit
    normal, source = faces(), np.radians(elevation)
    air = atmosphere.air
    exact = facet_irradiance(air, np.array([height]), np.array([source]), normal[None], irradiance, np.array([330.0]))[
        0
    ]
    errors = []
    for count in COUNTS:
        found = by_harmonics(atmosphere, height, source, irradiance, count, normal, 330.0)
        errors.append(np.abs(found - exact).max() / exact.max())
    assert errors[0] < 0.01
    assert errors[1] < 0.008


def test_a_table_over_high_ground_begins_at_it(band):
    state = AtmosphericState.from_profile("midlatitude_summer", surface_altitude=1200.0)
    air = BandAtmosphere.of(state, band).air
    sky = HarmonicSky.over_ground(air, np.zeros(1), np.zeros(4), 6)
    assert sky.sky.altitude[0] == 1200.0 and np.all(np.diff(sky.sky.altitude) > 0)


def test_without_a_source_azimuth_does_not_matter(lit):
    atmosphere, _ = lit
    sky = HarmonicSky.of(atmosphere.air, np.zeros(1), np.zeros(1), np.zeros(4), 11)
    radiance, _ = sky.at(np.zeros(1))
    turned = [place for place, code in enumerate(HARMONICS) if code % 10]
    assert np.abs(radiance[..., turned]).max() < 1e-12 * np.abs(radiance).max()


def test_a_face_that_looks_down_sees_the_ground_alone(lit):
    """The ground emits and reflects all that reaches it."""
    atmosphere, irradiance = lit
    air, source = atmosphere.air, np.radians(30.0)
    albedo = air.state.surface_albedo
    sky = SkyTable.of(air, np.zeros(1), np.array([source]), irradiance).at(np.zeros(1))[0, 0]
    direct = np.exp(-air.source_paths.optical_depth(np.zeros(1), np.full((1, 1), 0.5)).astype(float))[0, 0]
    emitted = np.pi * planck_wavenumber(air.optics.wavenumber, 330.0)
    expected = (1 - albedo) * emitted + albedo * (sky + 0.5 * direct * irradiance)
    found = by_harmonics(atmosphere, 0.0, source, irradiance, 6, DOWN[None], 330.0)[0]
    np.testing.assert_allclose(found, expected, rtol=2e-3)


@pytest.mark.parametrize("albedo", [0.0, 0.3])
@pytest.mark.parametrize("height", [0.0, 500.0])
def test_an_isothermal_enclosure_is_black(band, albedo, height):
    """Under a thick cloud of one temperature with the ground every face is lit as by a black body."""
    cloud = CloudLayer("water", 1000.0, 3000.0, 10.0, 60.0)
    state = AtmosphericState.from_profile(
        "us_standard", clouds=[cloud], surface_temperature=KELVIN, surface_albedo=albedo
    )
    state = replace(state, temperature=np.full_like(state.temperature, KELVIN))
    atmosphere = BandAtmosphere.of(state, band)
    black = np.pi * planck_wavenumber(atmosphere.air.optics.wavenumber, KELVIN)
    normal = faces()
    found = by_harmonics(atmosphere, height, -1.0, np.zeros(4), 6, normal, KELVIN)
    np.testing.assert_allclose(found, np.broadcast_to(black, found.shape), rtol=0.03)
    exact = facet_irradiance(
        atmosphere.air, np.array([height]), np.array([-1.0]), normal[None], np.zeros(4), np.array([KELVIN])
    )[0]
    np.testing.assert_allclose(found, exact, rtol=0.004)


def test_walls_hide_the_sky_and_shine_in_its_place(lit):
    """Walls all around light a level face as a black body; none leave what `facet_irradiance` gives."""
    atmosphere, irradiance = lit
    air, source = atmosphere.air, np.full(3, np.radians(30.0))
    normal, ground = np.array([UP, UP, [1.0, 0.0, 0.0]]), np.full(3, 330.0)
    exact = facet_irradiance(air, np.zeros(1), source[:1], normal[None], irradiance, ground[:1])[0]

    def found(sky_view):
        walls = Walls(np.full(3, sky_view), np.full(3, 310.0), np.ones(3))
        return light_among_walls(air, np.zeros(3), source, irradiance, Facets(normal, ground, walls=walls))

    np.testing.assert_allclose(found(1.0), exact, rtol=1e-12)
    np.testing.assert_allclose(light_among_walls(air, np.zeros(3), source, irradiance, Facets(normal, ground)), exact)
    black = np.pi * planck_wavenumber(air.optics.wavenumber, 310.0)
    np.testing.assert_allclose(found(0.0)[:2], np.broadcast_to(black, (2, black.size)), rtol=1e-12)
    np.testing.assert_allclose(found(0.5), 0.5 * (found(0.0) + found(1.0)), rtol=1e-12)


def test_the_level_face_of_a_table_is_that_of_the_level_quantity(lit):
    """At range 0, over a long path, in a cell behind the ground, under all sources."""
    atmosphere, irradiance = lit
    grid = PathGrid([0.0, 2.0, 400.0], [0.5, 20.0], [-40.0, 0.0, 30.0], [-20.0, 20.0, 70.0], [0.0])
    level = atmosphere.table(grid, irradiance, quantities=("ambient",)).ambient
    for count in COUNTS:
        tables = ambient_harmonics(atmosphere, grid, irradiance, count)
        assert tables.radiance.shape == (*grid.shape[:4], count) and np.all(np.isfinite(tables.radiance))
        assert np.all(np.isfinite(tables.ground)) and tables.ground.shape[-1] == len(zonal(count))
        warm = tables.ground[..., :, None, 1, :]
        found = ambient_of_faces(level, tables.radiance, warm, np.float64(3.0), UP)
        np.testing.assert_allclose(found, level, rtol=1e-12, atol=1e-12 * level.max())


def test_a_table_at_range_0_holds_the_light_around_its_altitude(lit):
    """No path lies before the surface: the harmonics there are those of the field at that altitude over the band."""
    atmosphere, irradiance = lit
    tables = ambient_harmonics(atmosphere, PathGrid([0.0], [3.0], [10.0], [20.0], [0.0]), irradiance, 6)
    height, source = np.array([3000.0]), np.radians([20.0])
    radiance, ground = HarmonicSky.of(atmosphere.air, height, source, irradiance, 6).at(height)
    emission = ground_emission(atmosphere.band) * atmosphere.band.radiance_weight
    expected = np.einsum("p,sph->sh", atmosphere.band.radiance_weight, radiance[0])
    np.testing.assert_allclose(tables.radiance[0, 0, 0], expected, rtol=1e-6, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_allclose(tables.ground[0, 0, 0], emission @ ground[0], rtol=1e-6)


def test_the_path_weighs_the_emission_of_the_ground(synthetic_points):
    """As equation (20): the mean of transmittance times emission over mean transmittance times mean emission."""
    sections = {"CO2": np.array([1e-28, 1e-27, 1e-26, 1e-25])}
    points = band_points(
        synthetic_points(np.linspace(2000.0, 2800.0, 5), sections), SpectralResponse.rectangular(3.6, 5)
    )
    atmosphere = BandAtmosphere.of(AtmosphericState.from_profile("us_standard", surface_albedo=0.0), points)
    grid = PathGrid([0.0, 5.0], [0.0], [0.0], [0.0], [0.0])
    tables = ambient_harmonics(atmosphere, grid, np.zeros(4), 6)
    through = atmosphere.spectral_at_points(LinesOfSight([5.0], [0.0], [0.0], [0.0], [0.0]), np.zeros(4)).transmittance[
        0
    ]
    emitted = planck_wavenumber(points.wavenumber, 300.0) * points.radiance_weight
    share = (through @ emitted) / (emitted.sum() * (through @ points.weight) / points.weight.sum())
    found = [np.interp(300.0, GROUND_TEMPERATURES, part) for part in tables.ground[:, 0, 0, :, 0]]
    assert abs(share - 1) > 0.1
    # Y_00 of a hemisphere of 1 is sqrt(pi); a path of length 0 weighs nothing.
    np.testing.assert_allclose(found, [np.sqrt(np.pi), np.sqrt(np.pi) * share], rtol=5e-3)


def test_directions_fill_the_sphere():
    directions = Directions.of(8, 6)
    assert directions.solid_angle.sum() * directions.azimuths == pytest.approx(4 * np.pi)
    assert np.diff(directions.edges).sum() == pytest.approx(2.0)
    assert np.all((directions.cosine > directions.edges[:, 0]) & (directions.cosine < directions.edges[:, 1]))
    values = harmonics_at(directions.vectors) * directions.solid_angle[..., None]
    integral = values.sum(axis=(0, 1))
    np.testing.assert_allclose(integral, np.sqrt(4 * np.pi) * (np.arange(len(HARMONICS)) == 0), atol=1e-12)


def test_phase_functions_are_linear_between_their_angles(lit):
    """Over a cell a constant gives itself and the angle gives the mean angle, both by the cell's size."""
    air, directions = lit[0].air, Directions.of(4, 3)
    even = replace(air, optics=replace(air.optics, phase=np.ones_like(air.optics.phase)))
    for row, phases in enumerate(cell_phases(even, directions, np.radians([10.0, 80.0]))):
        scale = np.diff(directions.edges[row])[0] / directions.weight[row]
        np.testing.assert_allclose(phases, scale, rtol=1e-12)
        linear = np.arange(even.optics.phase.shape[0]) * np.ones_like(even.optics.phase.T)
        angle = cell_phases(replace(even, optics=replace(even.optics, phase=linear.T)), directions, np.radians([10.0]))
        directly = np.arccos(directions.samples[row] @ [np.cos(np.radians(10.0)), 0.0, np.sin(np.radians(10.0))])
        mean = directly.mean(axis=1) / PHASE_ANGLES[1] * scale
        np.testing.assert_allclose(angle[row][0, :, 0], mean, rtol=1e-9)


def test_a_face_gathers_the_cosine_over_its_hemisphere():
    directions = Directions.of(16, 12)
    for normal in faces(10):
        assert directions.irradiance_weights(normal).sum() == pytest.approx(np.pi, rel=3e-3)
