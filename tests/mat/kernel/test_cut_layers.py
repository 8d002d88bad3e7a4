"""Closed forms of the kernel: quadratics inside cut layers, light scattered straight forward."""

from itertools import pairwise

import numpy as np
import pytest
from light_parts import thermal_of, thermal_source
from scipy.integrate import quad

from skyshine.mat.atmosphere.particles.cloud import CloudLayer
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.line_of_sight import lines_of_sight
from skyshine.mat.atmosphere.transfer.ordinates import ordinates
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalField, ThermalSource
from skyshine.mat.quantities.joined_paths import JoinedPaths

LEVELS = np.array([0.0, 100.0, 300.0])
PARTS = LayerParts(np.array([1, 4]))
FUNCTIONS = ordinates(2, 1)  # the first of them is 1


def segments_of(altitude):
    """Vertical segments between altitudes, of even air of 1 molecule m^-2 for each metre."""
    altitude = np.asarray(altitude, float)
    middle = 0.5 * (altitude[1:] + altitude[:-1])
    layer = np.searchsorted(LEVELS, middle) - 1
    share = (middle - LEVELS[layer]) / np.diff(LEVELS)[layer]
    air, still = np.abs(np.diff(altitude)), np.zeros(altitude.size)
    return Segments(
        np.arange(layer.size),
        layer,
        air * (1 - share),
        air * share,
        altitude,
        still,
        still,
        abs(altitude - altitude[0]),
    )


def places():
    """Altitude of each place, m."""
    layer, _ = PARTS.inside
    inside = [LEVELS[k] + PARTS.shares(k) * np.diff(LEVELS)[k] for k in np.unique(layer)]
    return np.concatenate([LEVELS, *inside])


def light_of(source, straight, extinction, scaled, segments, real):
    table = np.zeros((PARTS.places, FUNCTIONS.pairs[0].size, 1))
    table[:, 0, 0] = source
    forward = np.full((3, len(DIRECTIONS), 1), straight)
    field = ThermalField(FUNCTIONS, PARTS, extinction, scaled, table, forward, np.array(DIRECTIONS))
    depths = Depths(segments.column(extinction).astype(real))
    return thermal_of(ThermalSource(LEVELS, np.zeros((3, 1)), None), field, segments, depths, real)


@pytest.mark.parametrize(("real", "error"), [(np.float64, 1e-9), (np.float32, 3e-6)])
@pytest.mark.parametrize("altitude", [[0, 100, 300], [300, 100, 0], [100, 130, 290], [260, 110], [20, 70]])
@pytest.mark.parametrize("depth", [1e-6, 0.03, 0.5, 20.0])
def test_a_source_quadratic_in_a_cut_layer_is_integrated_exactly(altitude, depth, real, error):
    """Depths are counted from the observer, all extinction being delta-scaled; the whole layer's source is linear."""
    segments, extinction = segments_of(altitude), np.full((3, 1), depth / 100)

    def source(height, layer):
        return np.where(layer == 0, 1 + height / 100, 3 + (height / 100 - 2) ** 2)

    table = source(places(), np.array([0, 0, 1, *PARTS.inside[0]]))  # the level between belongs to the whole layer
    found = light_of(table, 0.0, extinction, extinction, segments, real).sum()
    wanted, before = 0.0, 0.0
    for low, high in pairwise(altitude):
        whole = abs(high - low) * depth / 100

        def light(t, low=low, high=high, whole=whole):
            return float(source(low + (high - low) * t, int(low + high > 200))) * np.exp(-t * whole) * whole

        wanted += np.exp(-before) * quad(light, 0, 1, epsabs=0, epsrel=1e-10, points=[min(1, 1 / max(whole, 1))])[0]
        before += whole
    assert found == pytest.approx(wanted, rel=error)


@pytest.mark.parametrize(("real", "error"), [(np.float64, 1e-12), (np.float32, 1e-6)])
def test_light_scattered_straight_forward_is_what_all_extinction_leaves_less_of(real, error):
    segments, extinction = segments_of([0, 100, 300]), np.full((3, 1), 0.01)
    total = light_of(0.0, 1.0, extinction, 0.4 * extinction, segments, real)[:, 0]
    wanted = [np.exp(-0.4) - np.exp(-1), np.exp(-1) * (np.exp(-0.8) - np.exp(-2))]
    assert total == pytest.approx(wanted, rel=error)
    assert not np.any(light_of(0.0, 1.0, extinction, extinction, segments, real))


def test_a_level_path_on_the_upper_end_of_a_layer_is_inside_it(synthetic_points):
    cloud = CloudLayer("water", 1e3, 2e3, 10.0, 8.0)
    state = AtmosphericState.from_profile("midlatitude_summer", clouds=[cloud])
    air = SpectralAir.of(state, synthetic_points(np.array([900.0, 905.0]), {"CO2": [0.0, 1e-24]}))
    count = air.thermal.field.parts.count
    assert count[25] > count[26] == 1  # the cloud's top: the next layer has no parts
    for layer in np.flatnonzero(count > 1):
        at_end, below = (thermal_source(air, layer, share, 0.5) for share in (1.0, 1 - 1e-6))
        assert at_end == pytest.approx(below, rel=1e-4)


def test_what_is_no_number_stays_none_along_its_line_and_at_its_point(synthetic_points):
    state = AtmosphericState.from_profile("midlatitude_summer")
    air = SpectralAir.of(state, synthetic_points(np.array([2500.0, 2505.0]), {"CO2": [0.0, 1e-26, 1e-24]}))
    lines = JoinedPaths.of(
        list(lines_of_sight(air, np.full((2, 1), 1e4), np.array([1e3, 2e3]), np.array([0.1, -0.05])))
    )
    depth = lines.depths.per_segment.copy()
    depth[3, 1] = np.nan
    broken, shape = Depths(depth, lines.depths.starts), (len(depth) + 1, 1)
    angles = np.full(shape, 0.5), np.full(shape, 0.3)
    light = air.scattered_light.along(lines.segments, broken, *angles)
    assert np.isnan(light[:, 0]).tolist() == [[False, True, False], [False] * 3]
    assert np.isnan(air.scattered_light.in_band(lines.segments, broken, *angles, np.ones(3))).any()
    thermal = air.thermal_radiance(lines.segments, broken)
    assert np.isnan(thermal[:, 1]).any() and np.all(np.isfinite(thermal[:, [0, 2]]))
