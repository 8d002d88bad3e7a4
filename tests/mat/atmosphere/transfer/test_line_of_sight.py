"""Lines of sight: the air at the observer, and what lies behind the ground."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight


@pytest.fixture(scope="module")
def air():
    points = AbsorptionTable.open().points(1000.0, 1005.0)
    return SpectralAir.of(AtmosphericState.from_profile("midlatitude_summer"), points, points.gases)


def line(air, altitude, ranges=(10.0,), elevation=0.0):
    (path,) = lines_of_sight(air, np.array([ranges]), np.array([altitude]), np.radians([elevation]))
    return path


def test_the_air_at_an_observer_between_two_levels_is_between_theirs(air):
    levels, extinction = air.shells.altitude, air.optics.extinction
    low, high = (np.exp(np.log(air.shells.number_density[n])) * extinction[n] for n in (3, 4))
    at = line(air, 0.75 * levels[3] + 0.25 * levels[4])
    assert (at.local_layer, at.local_share) == (3, pytest.approx(0.25))
    assert np.all(at.local_extinction <= np.maximum(low, high)) and np.all(at.local_extinction >= np.minimum(low, high))
    # Density falls as an exponential, extinction of a molecule as a line.
    density = air.shells.number_density[3] ** 0.75 * air.shells.number_density[4] ** 0.25
    np.testing.assert_allclose(at.local_extinction, density * (0.75 * extinction[3] + 0.25 * extinction[4]))


def test_a_short_level_line_has_the_depth_of_the_air_around_it(air):
    for altitude in (2.0, 700.0, 5500.0):
        path = line(air, altitude, (1.0, 100.0))
        np.testing.assert_allclose(path.depth[1], 100 * path.local_extinction, rtol=2e-3)
