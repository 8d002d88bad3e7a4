"""Fields of scattered light between solved points of a band: as if solved at each, in air that absorbs in lines."""

from dataclasses import replace

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.response_points import points_of_band
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.radiometry.blackbody import SpectralResponse


@pytest.fixture(scope="module", params=["clear", "cloud"])
def air(request):
    """64 points of the water band at 0.94 um, under two elevations of the Sun."""
    clouds = [CloudLayer("water", 1e3, 2e3, 10.0, 3.0)] if request.param == "cloud" else []
    state = AtmosphericState.from_profile("midlatitude_summer", clouds=clouds, surface_albedo=0.3)
    band = points_of_band(AbsorptionTable.open(), SpectralResponse.rectangular(0.925, 0.955))
    index = np.arange(64)
    air = SpectralAir.of(state, band.points.subset(index), band.gases, band.weight[index])
    return replace(air, elevations=(10.0, 60.0), azimuthal=2, nodes=2, spherical=False)


def scattered(air):
    """Light along three lines of sight, (3, P), and sky light of the ground, (P,)."""
    ranges, up = np.full((3, 1), 1e5), np.radians([2.0, 30.0, 90.0])
    sources = LineSources.at(np.radians([60.0]), np.radians([40.0]))
    along = [
        air.scattered_light.along(
            path.segments, path.segment_depths, sources.to_source(path.ends), sources.deflection(path.ends)
        )[0, 0]
        for path in lines_of_sight(air, ranges, np.full(3, 10.0), up)
    ]
    return np.array(along), air.diffuse_light.sky(np.zeros(1), np.radians([60.0]))[0, 0]


def test_the_field_between_solved_points_is_nearly_their_own(air):
    (line, sky), (shared_line, shared_sky) = scattered(air), scattered(air.with_field_between(4))
    assert sky.max() > 3 * sky.min()  # lines absorb most of it
    for own, shared in ((line, shared_line), (sky[None], shared_sky[None])):
        assert shared.mean(axis=-1) == pytest.approx(own.mean(axis=-1), rel=0.006)
        assert np.std(shared - own, axis=-1) == pytest.approx(
            0.0, abs=0.05 * own.mean()
        )  # air of one depth absorbs at other heights
    assert np.any(shared_sky != sky)


def test_a_field_of_its_own_at_every_point_is_the_field(air):
    (line, sky), (same_line, same_sky) = scattered(air), scattered(air.with_field_between(1))
    assert same_line == pytest.approx(line, rel=1e-6) and same_sky == pytest.approx(sky, rel=1e-6)
