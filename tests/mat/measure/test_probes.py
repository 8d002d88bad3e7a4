"""Lines of sight on which tables are measured: no error where a table is linear, and each error in its region."""

from types import SimpleNamespace

import numpy as np
import pytest

from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS
from skyshine.mat.measure.probes import PIXELS, Probes, measured
from skyshine.mat.measure.scale import Scale
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.tables.gridded import QUANTITIES, Gridded

BASE = PathGrid([0.1, 1.0, 10.0, 30.0], [0.0, 1.0, 4.0], [-90.0, -5.0, 0.0, 90.0], [-5.0, 0.0, 60.0], [0.0, 180.0])


class LinearAir:
    """Quantities that are linear in every coordinate; behind 25 km they are not valid."""

    scope = ALL_PATHS
    air = SimpleNamespace(
        shells=Shells.of(np.array([0.0, 1e4, 1e5]), np.array([2.5e25, 8e24, 1e20]), 1000.0),
    )

    def along_lines(self, ranges, altitude, elevation, source, azimuth, ambient_at, irradiance, *, quantities):
        path = ranges + altitude[:, None] + elevation[:, None]
        lit = path[:, :, None] + source[:, None] + azimuth[:, None]
        row = np.arange(len(ambient_at))
        ambient = path[row, ambient_at] + source[: row.size, 0]
        direct = path[:, :, None] + source[:, None]
        return AtmosphericQuantities(path, lit, ambient, direct, ranges < 25, np.ones_like(path))


def table_of(grid):
    r, a, e, s, z = np.meshgrid(*vars(grid).values(), indexing="ij")
    path = (r + a + e)[..., 0, 0]
    direct = path[..., None] + grid.source_elevation_deg
    quantities = AtmosphericQuantities(path, r + a + e + s + z, direct, direct, path > 0, np.ones_like(path))
    return {name: Gridded(grid, getattr(quantities, key), quantities.valid) for name, (key, _) in QUANTITIES.items()}


@pytest.fixture
def probes():
    return Probes.drawn(LinearAir(), BASE, np.zeros(1), np.random.default_rng(3))


def test_sources_are_spread_over_their_cells(probes):
    assert np.mean(probes.coordinates["source_elevation"] < 0) == pytest.approx(0.5, abs=0.05)


def test_linear_tables_have_no_error_and_a_wrong_node_shows(probes):
    for name, error in probes.errors(table_of(BASE), None).items():
        assert np.abs(error).max() < 1e-9, name
    wrong = table_of(BASE)
    wrong["beta_star"].values[1, 1, 1] += 3.0
    error = probes.errors(wrong, None)["beta_star"]
    assert 1.0 < np.abs(error).max() <= 3.0 and np.mean(np.abs(error) > 1e-9) < 0.8


def test_points_behind_the_ground_do_not_count(probes):
    valid = np.count_nonzero(probes.truth.valid)
    errors = probes.errors(table_of(BASE), None)
    assert errors["beta_star"].size == valid < probes.truth.valid.size
    assert errors["path_radiance_ratio"].size == 2 * valid


def test_each_error_lies_in_one_region_of_where_and_one_of_when(probes):
    for name in ("beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance"):
        errors, regions = probes.errors({name: table_of(BASE)[name]}, None)[name], probes.regions(name)
        kinds = [("ground", "air", "sky", "limb")]
        kinds += [] if name == "beta_star" else [("day", "twilight", "night")]
        assert list(regions) == [region for kind in kinds for region in kind]
        for kind in kinds:
            together = np.sum([regions[region] for region in kind], axis=0)
            assert together.shape == errors.shape and np.all(together == 1)


def test_regions_are_where_they_say(probes):
    regions = probes.regions("direct_radiance")
    shape = (*probes.truth.valid.shape, 2)
    counted = np.broadcast_to(probes.truth.valid[:, :, None], shape)

    def places(name):
        return np.broadcast_to(probes.coordinates[name], shape)[counted]

    assert np.all(places("source_elevation")[regions["day"]] > 0)
    assert np.all(places("source_elevation")[regions["twilight"]] <= 0)
    assert not regions["night"].any()  # the job's source is never lower than 5 degree down
    # Altitude, range and direction: the end of a line to the ground lies on it, that of one to the sky far above.
    end = places("altitude") + places("range") * np.sin(np.radians(places("elevation")))
    assert np.all(np.abs(end[regions["ground"]]) < 0.1) and np.all(end[regions["sky"]] > 19.9)
    assert np.all(places("elevation")[regions["limb"]] < 0) and np.all(places("elevation")[regions["sky"]] > 0)
    assert regions["ground"].any() and regions["limb"].any() and regions["air"].any() and regions["sky"].any()


@pytest.fixture
def pixels():
    return Probes.of_pixels(LinearAir(), BASE, np.zeros(1), np.random.default_rng(4))


def test_pixels_show_the_ground_from_all_heights(pixels):
    """Of an aircraft as many as of a mast, at one range each."""
    height, sine = pixels.scene_lines.altitude_km, np.sin(np.radians(pixels.scene_lines.elevation_deg))
    end = height + pixels.scene_lines.range_km[:, 0] * sine
    # A refracted line over a round Earth; most of 120 that were drawn meet the ground within 30 km.
    assert PIXELS / 2 < height.size <= PIXELS and np.all(np.abs(end) < 0.1)
    assert np.mean(height > 1.0) > 0.4 and np.mean(height < 0.2) > 1 / 8
    everywhere = pixels.regions("path_radiance_ratio")
    assert everywhere["ground"].all() and not everywhere["air"].any()


def test_jobs_that_look_up_have_no_pixels_of_the_ground():
    upward = PathGrid([0.1, 1.0], [0.0, 1.0], [5.0, 90.0], [0.0, 60.0], [0.0, 180.0])
    assert Probes.of_pixels(LinearAir(), upward, np.zeros(1), np.random.default_rng(4)) is None


def test_errors_of_pixels_count_among_those_of_the_ground_and_of_paths_alone(probes, pixels):
    tables = table_of(BASE)
    tables["path_radiance_ratio"].values[...] += 2.0
    tables["beta_star"].values[...] += 1000.0  # not zero
    kelvin = Scale(1.0, 1.0, 1.0)
    lines, both = (
        {m.quantity: m for m in measured(groups, tables, kelvin, kelvin)} for groups in ([probes], [probes, pixels])
    )
    for name in ("beta_star", "path_radiance_ratio"):
        reads = pixels.errors({name: tables[name]}, None)[name].size
        assert both[name].points == lines[name].points + reads
        assert both[name].regions["ground"].points == lines[name].regions["ground"].points + reads
        assert both[name].regions["air"].points == lines[name].regions["air"].points
    assert both["direct_radiance"].points == lines["direct_radiance"].points
    assert both["path_radiance_ratio"].regions["ground"].p99 == pytest.approx(2.0)
