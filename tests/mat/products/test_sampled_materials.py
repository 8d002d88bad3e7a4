"""Errors of temperatures of each of many states are measured on some materials, others on each date."""

import datetime as dt

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import MEASURED_ON
from skyshine.mat.products.temperature import _measured

DAY = dt.date(2026, 6, 1)


@pytest.fixture
def state(tiny_job, tmp_path):
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    return load_job(tmp_path / "job.yaml").trimmed.states[0]


def test_other_materials_are_measured_on_each_date_and_all_within_some_weeks(state):
    days = [_measured(state.as_one_of_many(), DAY + dt.timedelta(days=n), 1, 82) for n in range(60)]
    assert all(rows.size == np.unique(rows).size == MEASURED_ON for rows in days)
    assert len({tuple(rows) for rows in days}) == len(days)
    np.testing.assert_array_equal(np.unique(np.concatenate(days)), np.arange(82))
    np.testing.assert_array_equal(days[0], _measured(state.as_one_of_many(), DAY, 1, 82))


@pytest.mark.parametrize("count", [0, 1, MEASURED_ON])
def test_few_materials_are_measured_whole(state, count):
    np.testing.assert_array_equal(_measured(state.as_one_of_many(), DAY, 1, count), np.arange(count))


def test_a_state_by_itself_is_measured_whole(state):
    np.testing.assert_array_equal(_measured(state, DAY, 1, 100), np.arange(100))
