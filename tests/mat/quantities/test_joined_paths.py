"""Lines computed together send the light that each sends alone: high, low, to the ground, and through no air."""

import numpy as np
import pytest
from numpy_light import peak_is_near

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.quantities.joined_paths import JoinedPaths, in_groups
from skyshine.mat.quantities.line_sources import LineSources
from skyshine.mat.quantities.path_radiance import radiance_along

EDGES = np.linspace(2500.0, 3300.0, 5)
RANGES = np.array([0.0, 50.0, 2e3, 40e3])
ALTITUDE = np.array([0.0, 900.0, 3e5, 20.0, 9e3])
ELEVATION = np.radians([30.0, -20.0, 5.0, 0.3, -2.0])  # the third sees space alone
SOURCE, AZIMUTH = (
    np.radians([[30.0, 2.0], [-4.0, 60.0], [5.0, 5.0], [1.0, 40.0], [10.0, -8.0]]),
    np.radians([0.0, 90.0]),
)


@pytest.mark.parametrize("visibility_km", [0.5, 23.0])
def test_lines_together_are_the_lines_alone(synthetic_points, visibility_km):
    state = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol(visibility_km=visibility_km))
    points = synthetic_points(EDGES, {"CO2": np.geomspace(1e-28, 1e-24, 4)})
    air, band = SpectralAir.of(state, points), BandPoints(points, np.array([0.3, 0.7, 0.2, 0.8]))
    paths = list(lines_of_sight(air, np.tile(RANGES, (5, 1)), ALTITUDE, ELEVATION))
    sources = [LineSources.at(elevation, AZIMUTH) for elevation in SOURCE]
    together = JoinedPaths.of(paths)
    assert (together.segments.lower + together.segments.upper == 0).sum() == 4
    absorbed = 1 - np.exp(-together.depth) @ band.weight / band.weight.sum()
    irradiance = 1e3 * np.ones(4)
    ratios = radiance_along(air, band, together, sources, irradiance).ratio(air, band, together, absorbed)
    for number, path in enumerate(paths):
        alone = JoinedPaths.of([path])
        light = radiance_along(air, band, alone, sources[number : number + 1], irradiance)
        ratio = light.ratio(air, band, alone, absorbed[number : number + 1])[0]
        assert ratios[number] == pytest.approx(ratio, rel=2e-5)
        assert np.any(path.beyond > 0) == (number == 1)


def test_every_line_is_in_one_group_and_no_group_is_large():
    for lines, sources in ((1, 1), (70, 2), (33, 40), (5, 10_000)):
        groups = list(in_groups(lines, sources))
        assert [line for some in groups for line in range(some.start, some.stop)] == list(range(lines))
        assert all((some.stop - some.start - 1) * sources < 640 for some in groups)


@pytest.mark.parametrize("visibility_km", [0.5, 23.0])
def test_spectra_of_joined_lines_are_those_of_each_alone(synthetic_points, visibility_km):
    """With few parts of layers and with many, next to the source and away from it."""
    state = AtmosphericState.from_profile("midlatitude_summer", aerosol=Aerosol(visibility_km=visibility_km))
    air = SpectralAir.of(state, synthetic_points(EDGES, {"CO2": np.geomspace(1e-28, 1e-24, 4)}))
    elevation = np.radians([30.0, -20.0, 0.3])
    paths = list(lines_of_sight(air, np.full((3, 1), 40e3), np.array([0.0, 900.0, 20.0]), elevation))
    sources = LineSources.at(np.radians([30.0, 2.0]), np.radians([1.0, 0.5]))
    together = JoinedPaths.of(paths)
    angles = [
        [angle(sources, path.ends) for path in paths] for angle in (LineSources.to_source, LineSources.deflection)
    ]
    light = air.scattered_light.along(together.segments, together.depths, *map(np.concatenate, angles))
    near = peak_is_near(air.forward_peak, together.segments, together.depths, *map(np.concatenate, angles))
    assert light.shape == (3, 2, 4) and near.any() and not near.all()
    for number, path in enumerate(paths):
        alone = air.scattered_light.along(path.segments, path.segment_depths, *(part[number] for part in angles))[0]
        assert light[number] == pytest.approx(alone, rel=1e-5)
