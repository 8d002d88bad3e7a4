"""Random shadows and walls: their shares, and what is in the shade at the time of its view."""

import numpy as np
import pytest

from skyshine.mat.budget.circumstances import (
    SHADED_BEFORE,
    SHADED_NOW,
    SKY_VIEWS,
    WALL_EXCESS_K,
    WALLED,
    Circumstances,
    random_circumstances,
)
from skyshine.mat.surface.surroundings import shaded_share

TIME = np.random.default_rng(5).uniform(0.0, 24.0, 2000)


@pytest.fixture(scope="module")
def around():
    return random_circumstances(TIME, 290.0, np.random.default_rng(6))


def test_shares_are_those_that_are_stated(around):
    assert around.in_shade.mean() == pytest.approx(SHADED_NOW, abs=0.04)
    assert around.shaded.mean() == pytest.approx(SHADED_NOW + SHADED_BEFORE, abs=0.04)
    assert around.walled.mean() == pytest.approx(WALLED, abs=0.04)


def test_a_face_is_in_the_shade_exactly_where_its_shadow_covers_the_time(around):
    covered = [shaded_share(around.surroundings[row].shade, np.array([hour]), 1e-3)[0] for row, hour in enumerate(TIME)]
    assert np.array_equal(np.array(covered) > 0.5, around.in_shade)


def test_walls_hide_a_part_of_the_sky_and_differ_from_the_air(around):
    walled = around.walled
    assert np.all((around.sky_view[walled] >= SKY_VIEWS[0]) & (around.sky_view[walled] <= SKY_VIEWS[1]))
    excess = around.wall_temperature[walled] - 290.0
    assert excess.min() >= WALL_EXCESS_K[0] and excess.max() <= WALL_EXCESS_K[1] and np.ptp(excess) > 20
    assert all(alone.sky_view == 1 and alone.facing is None for alone in around.shadows_alone)


def test_none_stand_in_the_open():
    none = Circumstances.none(3)
    assert len(none.surroundings) == 3 and not none.shaded.any() and not none.walled.any() and not none.in_shade.any()
