"""Lines of sight on which tables are measured: every cell as often as every other, and no error where a table is
linear.
"""

import numpy as np
import pytest

from skyshine.mat.measure.probes import Probes
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.results import AtmosphericQuantities
from skyshine.mat.tables.gridded import Gridded

BASE = PathGrid([0.1, 1.0, 10.0, 30.0], [0.0, 1.0, 4.0], [-90.0, -5.0, 0.0, 90.0], [-5.0, 0.0, 60.0], [0.0, 180.0])


class LinearAir:
    """Quantities that are linear in every coordinate; behind 20 km there is ground."""

    def along_lines(self, ranges, altitude, elevation, source, azimuth, ambient_at, irradiance, *, wanted):
        path = ranges + altitude[:, None] + elevation[:, None]
        lit = path[:, :, None] + source[:, None] + azimuth[:, None]
        row = np.arange(len(ambient_at))
        ambient = path[row, ambient_at] + source[: row.size, 0]
        direct = path[:, :, None] + source[:, None]
        return AtmosphericQuantities(path, lit, ambient, direct, ranges < 20, np.ones_like(path))


def table_of(grid):
    r, a, e, s, z = np.meshgrid(*vars(grid).values(), indexing="ij")
    path = (r + a + e)[..., 0, 0]
    direct = path[..., None] + grid.source_elevation_deg
    quantities = AtmosphericQuantities(path, r + a + e + s + z, direct, direct, path > 0, np.ones_like(path))
    return Gridded.all_of(quantities, grid)


@pytest.fixture
def probes():
    return Probes.drawn(LinearAir(), BASE, np.zeros(1), np.random.default_rng(3))


def test_every_cell_is_measured_as_often(probes):
    axes = ("altitude", BASE.altitude_km), ("elevation", BASE.elevation_deg)
    cells = [np.searchsorted(nodes, probes.places[name].ravel()) for name, nodes in axes]
    counts = np.unique(np.array(cells), axis=1, return_counts=True)[1]
    assert counts.size == 6 and np.ptp(counts) <= 1
    assert np.mean(probes.places["source_elevation"] < 0) == pytest.approx(0.5, abs=0.05)
    inside = np.searchsorted(BASE.range_km, probes.places["range"][:, :, 0])
    assert np.all(inside == [1, 2, 3])


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


def test_each_error_lies_in_one_part_of_each_kind(probes):
    for name in ("beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance"):
        errors, parts = probes.errors({name: table_of(BASE)[name]}, None)[name], probes.regions(name)
        kinds = [("near", "far"), ("down", "up")]
        kinds += [] if name == "beta_star" else [("day", "twilight", "night")]
        assert list(parts) == [part for kind in kinds for part in kind]
        for kind in kinds:
            together = np.sum([parts[part] for part in kind], axis=0)
            assert together.shape == errors.shape and np.all(together == 1)
    # A third of the cells of range lies below a kilometre, a half of those that are above the ground.
    assert np.mean(probes.regions("beta_star")["near"]) == pytest.approx(0.5, abs=0.1)


def test_parts_are_where_they_say(probes):
    parts = probes.regions("direct_radiance")
    place = np.broadcast_to(probes.places["source_elevation"], (*probes.truth.valid.shape, 2))
    counted = place[np.broadcast_to(probes.truth.valid[:, :, None], place.shape)]
    assert np.all(counted[parts["day"]] > 0) and np.all(counted[parts["twilight"]] <= 0)
    assert not parts["night"].any()  # the job's source is never lower than 5 degree down
