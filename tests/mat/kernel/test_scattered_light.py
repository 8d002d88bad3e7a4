"""Light of a source along lines of sight: the kernel against numpy in double precision."""

from dataclasses import replace

import numpy as np
import pytest
from light_cases import FEW, MANY, STATES, lines_through
from numpy_light import Scattered, source_depth

from skyshine.mat.atmosphere.transfer import kernel_arrays
from skyshine.mat.atmosphere.transfer.scattered_light import ScatteredLight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments

# Of the largest of a result: 1e-6 is reached. Of the largest of each spectral point or line: there, between ends whose
# depths differ by 1, the kernel's series of a mean transmittance leaves 3.1e-6 out.
TOLERANCE, OF_ROW = 3e-6, 4e-6
DARK = 1e-20  # sr^-1: less than this is none in single precision


def assert_close(light, wanted, *, axis=None):
    """Within the tolerance of the largest along an axis or axes, or of all."""
    assert light.shape == wanted.shape and np.all(np.isfinite(light))
    largest = np.abs(wanted).max(axis=axis, keepdims=True)
    error = np.abs(light - wanted) / np.maximum(largest, DARK)
    assert error.max() < (TOLERANCE if axis is None else OF_ROW)


@pytest.fixture(scope="module", params=[*((name, FEW) for name in STATES), ("haze", MANY)], ids=str)
def lit(request, case):
    air, lines = case(*request.param)
    return air, lines, Scattered.of(air, *lines.arguments)


def test_along_lines(lit):
    air, lines, wanted = lit
    light = air.scattered_light.along(*lines.arguments)
    assert np.all(light >= 0) and light.max() > 1e-3
    for axis in (None, (0, 1), 2):
        assert_close(light, wanted.along(), axis=axis)


def test_in_a_band_up_to_each_end(lit):
    """A band of even weights, and one of moonlight."""
    air, lines, wanted = lit
    weight = np.linspace(1.0, 2.0, air.optics.wavenumber.size)
    light = air.scattered_light.in_band(*lines.arguments, weight)
    for axis in (None, 0):
        assert_close(light, wanted.in_band(weight), axis=axis)
    faint = air.scattered_light.in_band(*lines.arguments, 1e-45 * weight[::-1])
    assert_close(1e45 * faint, wanted.in_band(weight[::-1]))
    assert not np.any(air.scattered_light.in_band(*lines.arguments, 0 * weight))


@pytest.mark.parametrize("source", range(14))
def test_of_segments(lit, source):
    air, lines, wanted = lit
    light = air.scattered_light.of_segments(*lines.of_source(source))
    expected = wanted.once[:, source] + np.maximum(wanted.again[:, source], 0)
    for axis in (None, 0):
        assert_close(light, expected, axis=axis)


def test_depths_to_the_source(lit):
    """Also to one that the Earth hides, and from space."""
    air, lines, _ = lit
    for paths in (air.source_paths, air.scaled_source_paths):
        depth = paths.optical_depth(lines.segments.altitude, lines.to_source)
        wanted = source_depth(paths, lines.segments.altitude, lines.to_source)
        assert depth.dtype == np.float32 and np.all(np.isfinite(depth))
        np.testing.assert_allclose(depth, wanted, rtol=2e-5)  # 1e-30 is the least: its logarithm is -69
        assert np.array_equal(depth == 0, wanted == 0) and np.array_equal(depth >= 1e4, wanted >= 1e4)
        assert np.any(depth == 0) and np.any(depth >= 1e4)


def test_the_cases_have_what_they_are_for(lit):
    air, lines, wanted = lit
    has_particles = bool(np.any(air.optics.aerosol_scattering))
    assert air.diffuse_light.parts.is_cut == (air.diffuse_light.straight is not None) == has_particles
    assert wanted.near.any() == has_particles and not wanted.near.all()
    assert min(path.segments.index.size for path in lines.paths) == 0
    assert lines.depths.per_segment.max() > 1e4


@pytest.mark.parametrize("points", [1, 7, 8, 16])
def test_any_number_of_points_gives_the_light_of_all(case, points):
    air, lines = case("haze", MANY)
    some = np.arange(points) * 3
    part, few = air.part(some), Depths(lines.depths.per_segment[:, some], lines.depths.starts)
    few_lines = replace(lines, depths=few)
    light = part.scattered_light.along(*few_lines.arguments)
    assert_close(light, Scattered.of(part, *few_lines.arguments).along(), axis=(0, 1))


def test_depths_in_single_precision(case):
    air, lines = case("cloud")
    single = replace(lines, depths=Depths(lines.depths.per_segment.astype(np.float32), lines.depths.starts))
    light = air.scattered_light.along(*single.arguments)
    assert_close(light, Scattered.of(air, *lines.arguments).along(), axis=2)


@pytest.mark.parametrize("name", ["haze", "cloud"])
def test_phase_functions_given_by_line(case, name):
    air, lines = case(name)
    shape = len(lines.paths), air.state.altitude.size, lines.to_source.shape[1], len(air.optics.phase_share)
    phase = np.random.default_rng(5).uniform(0.1, 3.0, shape)
    light = air.scattered_light.along(*lines.arguments, phase)
    assert_close(light, Scattered.of(air, *lines.arguments, phase).along(), axis=2)
    assert np.abs(light / np.maximum(air.scattered_light.along(*lines.arguments), 1e-30) - 1).max() > 0.1


@pytest.mark.parametrize("depth", [0.0, 1e-9, 1e4, 1e30])
@pytest.mark.parametrize("name", ["clear", "cloud"])
def test_depths_of_any_size(case, name, depth):
    """Depths of the segments that are not those of the air: nothing overflows, and each counts as it should."""
    air, lines = case(name)
    deep = lines.of_depth(depth)
    wanted = Scattered.of(air, *deep.arguments)
    assert_close(air.scattered_light.along(*deep.arguments), wanted.along(), axis=2)
    weight = np.ones(air.optics.wavenumber.size)
    assert_close(air.scattered_light.in_band(*deep.arguments, weight), wanted.in_band(weight))


def test_no_segment_and_no_source_give_no_light(case):
    air, lines = case("haze")
    none = lines_through(air, ((3e5, 5.0, 1e6),))
    assert none.segments.index.size == 0
    assert np.array_equal(air.scattered_light.along(*none.arguments), np.zeros((1, 14, FEW)))
    assert np.array_equal(air.scattered_light.in_band(*none.arguments, np.ones(FEW)), np.zeros((1, 14)))
    assert air.scattered_light.of_segments(*none.of_source(0)).shape == (0, FEW)
    unlit = lines.segments, lines.depths, lines.to_source[:, :0], lines.deflection[:, :0]
    assert air.scattered_light.along(*unlit).shape == (len(lines.paths), 0, FEW)


@pytest.mark.parametrize("name", ["clear", "fog"])
def test_lines_joined_in_any_groups_send_the_same_bytes(case, name):
    air, lines = case(name)
    weight, first = np.linspace(1.0, 2.0, FEW), np.append(lines.depths.starts, len(lines.to_source))
    light, band = (
        air.scattered_light.along(*lines.arguments),
        air.scattered_light.in_band(*lines.arguments, weight),
    )
    for start, stop in ((0, 1), (2, 3), (4, 7), (8, 10), (9, 13)):
        ends = slice(first[start], first[stop])
        segments = Segments.joined([path.segments for path in lines.paths[start:stop]])[0]
        depths = Depths(lines.depths.per_segment[first[start] : first[stop] - 1], first[start:stop] - first[start])
        angles = lines.to_source[ends], lines.deflection[ends]
        assert np.array_equal(air.scattered_light.along(segments, depths, *angles), light[start:stop])
        assert np.array_equal(air.scattered_light.in_band(segments, depths, *angles, weight), band[ends])


def test_sources_together_send_the_light_of_each_alone(case):
    air, lines = case("cirrus")
    light = air.scattered_light.along(*lines.arguments)
    for source in (0, 5, 9, 13):
        alone = air.scattered_light.along(*lines.of_source(source))[:, 0]
        assert_close(alone, light[:, source], axis=1)


@pytest.mark.parametrize("name", ["clear", "haze", "fog"])
def test_nothing_is_read_of_memory_before_it_is_written(case, name, monkeypatch):
    air, lines = case(name)
    weight = np.ones(FEW)

    def lights():
        light = ScatteredLight(
            air.optics,
            air.scaled_source_paths,
            air.forward_peak if np.any(air.optics.aerosol_scattering) else None,
            air.diffuse_light,
        )
        single = Depths(lines.depths.per_segment.astype(np.float32), lines.depths.starts)
        return (
            light.along(*lines.arguments),
            light.in_band(*lines.arguments, weight),
            light.of_segments(*lines.of_source(9)),
            air.scaled_source_paths.optical_depth(lines.segments.altitude, lines.to_source),
            air.thermal_radiance(lines.segments, lines.depths),
            air.thermal_radiance(lines.segments, single),
        )

    expected = lights()

    class Filled(kernel_arrays.Scratch):
        def of(self, size):
            self._memory = np.full(-(-size // 8), np.nan)
            return self._memory.ctypes.data

    for module in ("scattered_light", "thermal_light", "source_paths"):
        monkeypatch.setattr(f"skyshine.mat.atmosphere.transfer.{module}.SCRATCH", Filled())
    for light, wanted in zip(lights(), expected, strict=True):
        assert np.array_equal(light, wanted)
