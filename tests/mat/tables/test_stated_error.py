"""Errors that tables state."""

import numpy as np
import pytest

from skyshine.mat.tables.stated_error import (
    accuracy_group,
    measure,
    of_worst_region,
    with_independent,
    worst_kelvin,
)
from skyshine.schemas.hdf5 import Group


def table(*errors):
    measures = [measure(name, np.array(kelvin) / 10, np.array(kelvin)) for name, kelvin in errors]
    return Group({}, {}, {"accuracy": accuracy_group(measures, {}, {}, {})}, {})


def test_the_quantity_that_errs_most_speaks_for_a_table():
    found = worst_kelvin(table(("tau", [0.1, -0.2]), ("direct", [0.3, -0.5]), ("band", [np.nan, np.nan])))
    assert found == {"quantity": "direct", "p99": 0.498, "maximum": 0.5}


@pytest.mark.parametrize(("tolerance", "asked"), [("0.4 K", 0.4), ("0.5 K", None), ("0.1 %", None), ("", None)])
def test_a_tolerance_that_is_exceeded_is_named(tolerance, asked):
    group = table(("direct", [0.3, -0.5]))
    group.groups["accuracy"].attributes["tolerance"] = tolerance
    assert worst_kelvin(group).get("asked") == asked


def test_a_table_without_kelvin_states_none():
    assert worst_kelvin(table(("tau", [np.nan]))) is None
    assert worst_kelvin(table(("tau", []))) is None
    assert worst_kelvin(Group({}, {}, {}, {})) is None


def test_errors_of_parts_are_those_of_their_points_alone():
    error = np.array([0.1, -0.2, 3.0, 4.0])
    day = np.array([True, True, False, False])
    regions = {"day": day, "night": ~day, "dusk": np.zeros(4, bool)}
    measured = measure("tau", error, 10 * error, 100 * error, regions=regions)
    group = accuracy_group([measured, measure("faces", error, error)], {}, {}, {})
    assert list(group.axes["region"].values) == ["day", "night", "dusk"]
    values = {name: np.asarray(variable.data) for name, variable in group.variables.items()}
    np.testing.assert_array_equal(values["region_points"], [[2, 2, 0], [0, 0, 0]])
    np.testing.assert_allclose(values["region_maximum"][0], [0.2, 4.0, np.nan])
    np.testing.assert_allclose(values["region_p99_kelvin"][0], [1.99, 39.9, np.nan])
    np.testing.assert_allclose(values["region_maximum_percent"][0, :2], [20.0, 400.0])
    assert values["maximum_percent"][0] == 400.0 and np.isnan(values["maximum_percent"][1])
    np.testing.assert_allclose(values["p99"][1], 3.97)


def test_tables_without_parts_or_percent_have_no_such_arrays():
    group = accuracy_group([measure("solver", np.ones(3), np.ones(3))], {}, {}, {})
    assert "region" not in group.axes
    assert not [name for name in group.variables if "percent" in name or "region" in name]


def test_errors_of_another_cause_are_added_in_squares_and_the_largest_plainly():
    """By region; those of all where a region has none of its own."""
    regions = {"day": np.ones(1, bool), "sky": np.ones(1, bool)}
    measured = measure("tau", np.array([0.3]), np.array([3.0]), np.array([6.0]), regions=regions)
    kelvin = {"all": dict.fromkeys(("max", "p99", "p95", "rms"), 4.0), "sky": dict.fromkeys(("max", "p99"), 1.25)}
    kelvin["sky"] |= {"p95": 2.25, "rms": 0.0}
    percent = {"all": {"max": 1.0, "p99": 8.0}, "sky": {"max": 2.0, "p99": 2.5}}
    whole = with_independent(measured, kelvin, percent, "all")
    for one in (whole, whole.regions["day"]):
        assert (one.maximum_kelvin, one.p99_kelvin, one.p95_kelvin, one.rms_kelvin) == (7.0, 5.0, 5.0, 5.0)
        assert (one.maximum_percent, one.p99_percent) == (7.0, 10.0)
        assert one.p99 == 0.3
    sky = whole.regions["sky"]
    assert (sky.maximum_kelvin, sky.p99_kelvin, sky.p95_kelvin, sky.rms_kelvin) == (4.25, 3.25, 3.75, 3.0)
    assert (sky.maximum_percent, sky.p99_percent) == (8.0, 6.5)
    assert with_independent(measured, {}, {}, "all") == measured


def test_rare_pixels_speak_for_a_table_where_they_err_most():
    """99 % of all reads hide the ground where it is 1 % of them; the worst region does not."""
    error = np.concatenate([np.full(990, 0.1), np.full(10, 2.0)])
    ground, day = np.arange(1000) >= 990, np.ones(1000, bool)
    pooled = measure("path", error, 10 * error, 30 * error, regions={"ground": ground, "air": ~ground, "day": day})
    assert pooled.p99 == pytest.approx(0.1, abs=0.1)
    stated = of_worst_region(pooled, ("ground", "air", "sky"))
    assert (stated.p99, stated.p95, stated.rms) == pytest.approx((2.0, 2.0, 2.0))
    assert (stated.p99_kelvin, stated.p95_kelvin, stated.rms_kelvin, stated.p99_percent) == pytest.approx(
        (20,) * 3 + (60,)
    )
    assert (stated.maximum, stated.points, stated.regions) == (pooled.maximum, pooled.points, pooled.regions)
    assert of_worst_region(pooled, ("sky",)) == pooled
