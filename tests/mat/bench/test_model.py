"""Settings that are not built: thinned tables, and times by the numbers of their values."""

import numpy as np
import pytest

from skyshine.mat.bench.model import BY_VALUES, TimeModel, _between, interval_factor
from skyshine.mat.bench.rungs import STAGES, BuildTime, TaskTime
from skyshine.mat.bench.thinned import (
    _spread,
    _thinned_directions,
    thinned,
    value_counts,
    without_harmonics,
    without_response,
)
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.job.load import load_job


class Built:
    """A rung of known times."""

    def __init__(self, tables, temperature, compiled, size=1000):
        times = {"compile": compiled, "tables": tables}
        tasks = TaskTime("atmosphere", 1, times), TaskTime("temperature", 0, {"tables": temperature})
        self.cost, self.size = BuildTime(tables + temperature + compiled + 1.0, 5.0, tasks), size


def model_of(rungs, values):
    return TimeModel(rungs, np.array(values, float))


def test_times_go_by_the_values_and_all_others_are_the_mean():
    rungs = [Built(4.0, 2.0, 8.0), Built(8.0, 3.0, 9.0), Built(16.0, 5.0, 10.0)]
    model = model_of(rungs, [(1000, 100), (3000, 200), (7000, 400)])  # 2 s a thousand, 1 s a hundred
    seconds, uncertainty = model.stages((500, 50))
    assert seconds["tables"] == pytest.approx(3.0) and seconds["temperature"] == pytest.approx(1.5)
    assert seconds["compile"] == pytest.approx(9.0) and set(seconds) == set(STAGES) and set(BY_VALUES) <= set(STAGES)
    assert uncertainty == pytest.approx(1.0)  # the middle build is met, and compiling takes 8 to 10 s
    assert model.stages((5000, 300))[0]["tables"] == pytest.approx(12.0)


def test_a_middle_build_that_the_others_miss_makes_the_model_uncertain():
    straight = [Built(4.0, 2.0, 8.0), Built(8.0, 2.0, 8.0), Built(16.0, 2.0, 8.0)]
    bent = [straight[0], Built(5.0, 2.0, 8.0), straight[2]]
    values = [(1000, 100), (3000, 200), (7000, 400)]
    certain, uncertain = (model_of(rungs, values).stages((5000, 300)) for rungs in (straight, bent))
    assert certain[1] == pytest.approx(0.0, abs=1e-9)
    assert uncertain[1] == pytest.approx(0.6 * uncertain[0]["tables"])  # 8 s modelled, 5 s measured
    assert model_of(straight[:2], values[:2]).stages((500, 50))[1] > 0.2 * 3.0  # untested


def test_a_time_never_falls_below_zero_nor_with_more_values():
    assert _between(np.array([1e3, 2e3]), np.array([1.0, 3.0]), 0.0) == 0.0
    assert _between(np.array([1e3, 2e3]), np.array([3.0, 1.0]), 5e3) == pytest.approx(3.0)
    assert _between(np.array([1e3]), np.array([3.0]), 5.0) == 3.0


@pytest.mark.parametrize(("count", "factor", "left"), [(9, 1, 9), (9, 2, 5), (9, 100, 2), (2, 3, 2), (1, 3, 1)])
def test_ends_remain_however_much_is_thinned(count, factor, left):
    index = _spread(count, factor)
    assert index.size == left and index[0] == 0 and index[-1] == count - 1


def test_the_three_parts_of_the_directions_keep_their_ends():
    directions = np.concatenate([np.linspace(0, 1, 9), np.linspace(2, 3, 11), np.linspace(3, 4, 7)[1:]])
    remaining = directions[_thinned_directions(directions, 50.0)]
    assert {0.0, 1.0, 2.0, 3.0, 4.0} <= set(remaining) and remaining.size < directions.size / 2


@pytest.fixture(scope="module")
def tables(small_job, small_build):
    """Tables of a small job."""
    return Tables.open(small_build, 1, 1, "sun", load_job(small_job).trimmed)


def test_thinned_tables_read_what_the_tables_have_at_the_nodes_that_remain(tables):
    same, thinner = (thinned(tables, factor, factor) for factor in (1.0, 2.0))
    assert value_counts(same) == value_counts(tables)
    assert value_counts(thinner)[0] < value_counts(tables)[0] and value_counts(thinner)[1] <= value_counts(tables)[1]
    axes = thinner.surface.root.axes
    where = {name: axes[name].values[-1] for name in ("material", "altitude", "azimuth", "slope", "time")}
    assert thinner.surface.value("temperature", **where) == tables.surface.value("temperature", **where)
    line = {"range": 3.0, "altitude": 0.5, "elevation": -2.0}
    fine, coarse = (air.air.value("beta_star", **line) for air in (tables, thinner))
    assert 0 < abs(coarse / fine - 1) < 0.2
    assert tables.shades and not without_response(tables).shades


def test_without_harmonics_all_other_light_is_read_as_before(tables):
    level = without_harmonics(tables)
    line = {"range": 3.0, "altitude": 0.5, "elevation": -2.0, "source_elevation": 30.0}
    assert level.air.value("ambient_radiance", **line) == tables.air.value("ambient_radiance", **line)
    assert tables.has_harmonics and not level.has_harmonics


def test_intervals_of_a_coarser_tolerance_err_as_much_more():
    """What lies linear between nodes of a smooth curve errs by the tolerances' ratio where the model says so."""
    fine = np.linspace(0.0, np.pi, 2001)

    def error(intervals):
        nodes = np.linspace(0.0, np.pi, round(intervals) + 1)
        return np.abs(np.interp(fine, nodes, np.sin(nodes)) - np.sin(fine)).max()

    assert error(96 / interval_factor(2.0, 0.5)) / error(96) == pytest.approx(4.0, rel=0.02)
    assert interval_factor(0.3, 0.5) == 1.0
