"""Path radiance of air at one temperature: Kirchhoff's and Beer's laws at every range."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.quantities.joined_paths import JoinedPaths
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.path_radiance import radiance_along, scattered_light, thermal_light
from skyshine.mat.quantities.scattering_points import ScatteringPoints

EDGES = np.array([900.0, 1000.0, 2400.0])
KELVIN = 270.0
RANGES = np.array([0.0, 0.5, 100.0, 3e3, 20e3, 60e3])
DARK = np.zeros(4)
NIGHT = LineSources.at(np.radians([-30.0, -60.0]), np.array([0.0, 1.0]))


def planck(wavenumber, kelvin):
    """W m^-2 sr^-1 (cm^-1)^-1, with the radiation constants of CODATA 2018."""
    return 1.191042972e-8 * wavenumber**3 / np.expm1(1.438776877 * wavenumber / kelvin)


@pytest.fixture(scope="module")
def make(synthetic_points, isothermal):
    """Air and band of four points with cross sections of CO2 [m2]."""

    def made(*sections):
        points = synthetic_points(EDGES, {"CO2": np.array(sections)})
        band = BandPoints(points, np.array([0.3, 0.7, 0.2, 0.8]))
        return replace(SpectralAir.of(isothermal(KELVIN), points), scatters=False), band

    return made


def line(air, altitude, elevation, ranges=RANGES):
    (path,) = lines_of_sight(air, ranges[None], np.array([altitude]), np.radians([elevation]))
    return path


def ratio(air, band, path, irradiance=DARK):
    mean = (1 - np.exp(-path.depth)) @ band.weight / band.weight.sum()
    lines = JoinedPaths.of([path])
    return radiance_along(air, band, lines, [NIGHT], irradiance).ratio(air, band, lines, mean[None])[0]


def test_a_path_emits_what_it_absorbs(make):
    air, band = make(1e-26, 1e-25, 1e-24, 1e-23)
    path = line(air, 0.0, 4.0)
    absorbed = 1 - np.exp(-path.segment_depths.cumulative)
    expected = absorbed @ (band.radiance_weight * planck(band.wavenumber, KELVIN))
    found = radiance_along(air, band, JoinedPaths.of([path]), [NIGHT], DARK).along
    assert found.shape == (expected.size, 2) and expected[-1] > 10 * expected[1] > 0
    np.testing.assert_allclose(found, np.stack([expected, expected], axis=1), rtol=1e-4)


@pytest.mark.parametrize("altitude, elevation", [(0.0, 0.0), (0.0, 90.0), (2e3, -5.0), (2e3, -90.0)])
def test_grey_air_is_a_black_body_over_its_absorptance_at_all_ranges(make, altitude, elevation):
    """Also at range 0, and behind the ground, where the line goes on through the same air."""
    air, band = make(*[4e-25] * 4)
    path = line(air, altitude, elevation)
    expected = band.radiance_weight @ planck(band.wavenumber, KELVIN)
    assert np.any(path.beyond > 0) == (elevation < 0)
    np.testing.assert_allclose(ratio(air, band, path), np.full((RANGES.size, 2), expected), rtol=1e-3)


def test_at_range_0_each_point_counts_by_its_absorption(make):
    sections = np.array([1e-24, 2e-24, 1e-26, 1e-25])
    air, band = make(*sections)
    found = ratio(air, band, line(air, 500.0, 10.0))[:2, 0]
    strength = sections / (sections @ band.weight / band.weight.sum())
    limit = strength @ (band.radiance_weight * planck(band.wavenumber, KELVIN))
    assert found == pytest.approx([limit, limit], rel=1e-3)
    assert limit != pytest.approx(band.radiance_weight @ planck(band.wavenumber, KELVIN), rel=0.1)


def test_air_that_does_not_scatter_shows_no_light_of_the_source(make):
    air, band = make(1e-25, 1e-25, 1e-24, 1e-24)
    path, day = line(air, 0.0, 20.0), LineSources.at(np.radians([40.0]), np.array([0.1]))
    dark, lit = (radiance_along(air, band, JoinedPaths.of([path]), [day], light).along for light in (DARK, np.ones(4)))
    assert np.array_equal(dark, lit)


def test_scattered_light_is_in_proportion_to_the_source_and_never_negative(make):
    air, band = make(1e-26, 1e-26, 1e-26, 1e-26)
    air, sources = replace(air, scatters=True), LineSources.at(np.radians([40.0, -40.0]), np.array([0.1, 0.1]))
    path = line(air, 0.0, 20.0)
    dark, once, thrice = (
        radiance_along(air, band, JoinedPaths.of([path]), [sources], light * np.ones(4)).along
        for light in (0.0, 1e6, 3e6)
    )
    assert np.all(once >= dark) and np.all(np.diff(once[:, 0] - dark[:, 0]) >= 0) and once[-1, 0] > dark[-1, 0]
    np.testing.assert_allclose(thrice - dark, 3 * (once - dark), rtol=1e-4, atol=1e-9 * once.max())
    assert once[-1, 1] == dark[-1, 1]  # the second source is far below the horizon


@pytest.mark.parametrize(
    ("settings", "place"),
    [
        ({"aerosol": Aerosol("none")}, (700.0, 10.0)),
        ({"aerosol": Aerosol("none")}, (700.0, 0.0)),
        ({"aerosol": Aerosol("fog_radiation")}, (20.0, 30.0)),
        ({"aerosol": Aerosol("rural", visibility_km=5.0)}, (0.0, 0.0)),
        ({"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 8.0)]}, (1.5e3, 0.0)),
        ({"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 8.0)]}, (1.5e3, -35.0)),
        ({"clouds": [CloudLayer("water", 1e3, 2e3, 10.0, 8.0)]}, (2e3, 90.0)),
    ],
    ids=str,
)
def test_the_limit_for_short_ranges_is_that_of_short_ranges(synthetic_points, isothermal, settings, place):
    """Thermal and scattered, at levels and between, of a source behind, near the line, and below the horizon."""
    points = synthetic_points(EDGES, {"CO2": np.array([1e-28, 1e-26, 1e-25, 1e-24])})
    band = BandPoints(points, np.array([0.3, 0.7, 0.2, 0.8]))
    air = replace(SpectralAir.of(isothermal(KELVIN, **settings), points), spherical=False)
    (path,) = lines_of_sight(air, np.array([[0.0, 1e-3, 1.0]]), np.array([place[0]]), np.radians([place[1]]))
    sources = LineSources.at(np.radians([40.0, max(place[1], 3.0), -2.0]), np.radians([170.0, 2.0, 30.0]))
    lines = JoinedPaths.of([path])
    absorbed = -np.expm1(-path.depth) @ band.weight / band.weight.sum()
    lit = ScatteringPoints.every(air, band, np.ones(4))
    for part in (thermal_light(air, band, lines), scattered_light(air, band, lines, [sources], lit)):
        light = part.ratio(air, band, lines, absorbed[None])[0]
        assert np.all(np.isfinite(light)) and np.all(light[:, :2] > 0)
        assert light[0] == pytest.approx(light[1], rel=1e-4, abs=1e-9 * light[0].max())
        assert light[0] == pytest.approx(light[2], rel=2e-2, abs=1e-9 * light[0].max())
