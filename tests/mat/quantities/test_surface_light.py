"""Light on a white surface as the observer sees it: Beer's law of the beam, weights of what the path lets through."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.mat.quantities.surface_light import ambient, direct, radiance_weight

EDGES = np.array([900.0, 1000.0, 1100.0])
WEIGHT = np.array([0.25, 0.75])  # um


@pytest.fixture(scope="module")
def make(synthetic_points, isothermal):
    def made(*sections):
        points = synthetic_points(EDGES, {"CO2": np.array(sections)})
        return replace(SpectralAir.of(isothermal(270.0), points), scatters=False), BandPoints(points, WEIGHT)

    return made


def line(air, *ranges, altitude=1000.0, elevation=-90.0):
    (path,) = lines_of_sight(air, np.array([ranges]), np.array([altitude]), np.radians([elevation]))
    return path


def test_through_clear_air_the_weights_are_those_of_the_band_over_pi(make):
    air, band = make(1e-32, 1e-32)
    # From um to cm^-1: dlambda [um] = 1e4 / wavenumber^2, at 950 and 1050 cm^-1.
    expected = WEIGHT * np.array([950.0, 1050.0]) ** 2 / 1e4 / np.pi
    np.testing.assert_allclose(radiance_weight(band, line(air, 0.0, 500.0)), [expected] * 2, rtol=1e-6)


def test_a_grey_path_changes_no_weight_however_thick(make):
    (clear, band), (thick, _) = make(1e-32, 1e-32), make(1e-21, 1e-21)
    path = line(thick, 0.0, 1000.0)
    assert path.depth[-1].min() > 1000  # its transmittance is below the smallest number
    np.testing.assert_allclose(radiance_weight(band, path), radiance_weight(band, line(clear, 0.0, 1000.0)), rtol=1e-6)


def test_only_what_the_path_lets_through_counts(make):
    """Mean transmittance is 0.25, so that the clear point counts fourfold and the dark one not at all."""
    air, band = make(1e-32, 1e-21)
    near, far = radiance_weight(band, line(air, 0.0, 1000.0))
    assert far == pytest.approx([4 * near[0], 0.0], rel=1e-6)


def test_beer_law_of_the_beam(synthetic_points):
    """Air above the ground: p / (M g) = 101325 / (28.964 u x 9.80665) = 2.148e29 molecules m^-2."""
    state = AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none"))
    section = 0.5 / (2.148e29 * state.mole_fraction["CO2"][0])
    points = synthetic_points(EDGES, {"CO2": np.full(2, section)})
    air, band = SpectralAir.of(state, points), BandPoints(points, WEIGHT)
    weight, path = radiance_weight(band, line(air, 1000.0)), line(air, 1000.0)
    irradiance, elevation = np.array([2.0, 2.0]), np.radians([90.0, 30.0, -10.0])
    found = direct(air, path, weight, elevation, irradiance)[0]
    white = 2.0 * weight.sum()
    # g falls with height, by 0.3 % where the air is; the path of 30 degrees is a little less than 2 air masses.
    assert found / white == pytest.approx([np.exp(-0.5), np.exp(-1.0), 0.0], rel=0.01)


def test_a_white_surface_shows_the_irradiance_over_pi(make):
    air, band = make(1e-32, 1e-32)
    path = line(air, 0.0, 1000.0)
    sky = SkyTable(air, np.array([0.0, 1000.0]), np.log([[[5.0, 5.0]], [[2.0, 2.0]]]))
    # The white surface is at the end of each range: at the observer, and on the ground.
    band_width = np.sum(WEIGHT * np.array([950.0, 1050.0]) ** 2 / 1e4)
    found = ambient(path, radiance_weight(band, path), sky)
    assert found[:, 0] == pytest.approx(np.array([2.0, 5.0]) * band_width / np.pi, rel=1e-6)
