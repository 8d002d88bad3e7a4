"""Levels where particles are dense."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.state.levels import with_particles
from skyshine.mat.atmosphere.state.state import AtmosphericState


@pytest.mark.parametrize("depth", [0.0, 0.05, 3.0, 1e2, 1e5])
def test_layers_are_thin_at_the_edges_of_particles_and_the_old_levels_stay(depth):
    altitude = np.array([0.0, 250.0, 500.0, 750.0, 1000.0])
    extinction = np.array([0.0, 0.0, 1.0, 1.0, 0.0]) * depth / 500.0
    fine = with_particles(altitude, extinction)
    assert np.all(np.isin(altitude, fine)) and np.all(np.diff(fine) >= 1.0)
    assert fine.size < 60
    at_levels = np.interp(fine, altitude, extinction)
    layer = 0.5 * (at_levels[1:] + at_levels[:-1]) * np.diff(fine)
    through = np.append(0.0, np.cumsum(layer))
    edge = np.minimum(through, through[-1] - through)
    if depth <= 1e2:  # denser particles would need levels closer than a metre
        assert np.all(layer <= 2.0 * np.maximum(0.1, 0.7 * np.minimum(edge[1:], edge[:-1])))


def test_air_of_good_visibility_keeps_its_levels_and_cloud_gets_more():
    clear, cloudy, foggy = (
        AtmosphericState.from_profile("us_standard", **more)
        for more in (
            {"aerosol": Aerosol("rural")},
            {"clouds": [CloudLayer("water", 1000.0, 1500.0, 10.0, 20.0)]},
            {"aerosol": Aerosol("fog_advection")},
        )
    )
    assert clear.altitude.size == AtmosphericState.from_profile("us_standard", aerosol=Aerosol("none")).altitude.size
    for dense in (cloudy, foggy):
        assert clear.altitude.size + 5 < dense.altitude.size < clear.altitude.size + 30
