"""Thermal radiation along lines of sight: the kernel against numpy in double precision."""

import numpy as np
import pytest
from light_cases import FEW, MANY, STATES, lines_through
from numpy_light import thermal

from skyshine.mat.atmosphere.transfer.segments import Depths

# Of the largest of each spectral point: 5e-7 and 1e-14 are reached.
TOLERANCE = {np.float32: 3e-6, np.float64: 1e-12}


def assert_close(radiance, wanted, real):
    assert radiance.dtype == real and radiance.shape == wanted.shape and np.all(np.isfinite(radiance))
    largest = np.abs(wanted).max(axis=0)
    assert np.all(np.abs(radiance - wanted) <= TOLERANCE[real] * largest)


def of(depths, real):
    return Depths(depths.per_segment.astype(real), depths.starts)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("name", STATES)
def test_of_segments(case, name, real):
    air, lines = case(name)
    assert (air.thermal.field is None) == (name in ("clear", "below the sea"))
    radiance = air.thermal_radiance(lines.segments, of(lines.depths, real))
    assert_close(radiance, thermal(air, lines.segments, lines.depths), real)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("points", [1, 7, 8, MANY])
def test_any_number_of_points(case, points, real):
    air, lines = case("haze", MANY)
    some = np.arange(points)
    part, few = air.part(some), Depths(lines.depths.per_segment[:, some], lines.depths.starts)
    assert_close(part.thermal_radiance(lines.segments, of(few, real)), thermal(part, lines.segments, few), real)


@pytest.mark.parametrize(("name", "real"), [("clear", np.float64), ("cloud", np.float32)])
@pytest.mark.parametrize("depth", [0.0, 1e-12, 1e-3, 0.34, 0.36, 5.0, 1e4, 1e30])
def test_depths_of_any_size(case, name, depth, real):
    air, lines = case(name)
    deep = lines.of_depth(depth).depths
    assert_close(air.thermal_radiance(lines.segments, of(deep, real)), thermal(air, lines.segments, deep), real)


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("name", ["clear", "fog"])
def test_lines_joined_in_any_groups_send_the_same_bytes(case, name, real):
    air, lines = case(name)
    joined, first = air.thermal_radiance(lines.segments, of(lines.depths, real)), lines.depths.starts
    for number, path in enumerate(lines.paths):
        alone = air.thermal_radiance(path.segments, of(path.segment_depths, real))
        assert np.array_equal(alone, joined[first[number] :][: len(alone)])


def test_no_segment_gives_no_light(case):
    for name in ("clear", "haze"):
        air, _ = case(name)
        none = lines_through(air, ((3e5, 5.0, 1e6),))
        assert air.thermal_radiance(none.segments, none.depths).shape == (0, FEW)
