"""Parts of the day and of the slopes of which errors of temperature are stated."""

import numpy as np

from skyshine.mat.products.temperature import _regions
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath


def test_places_lie_in_the_part_of_their_hour_and_slope():
    hours = np.arange(SUN_STEPS) * 24 / SUN_STEPS
    elevation = -60 * np.cos(np.pi * hours / 12)  # 0 at 6 and 18 h, -6 at 5.617 and 18.383 h
    zero = np.zeros(SUN_STEPS)
    sun = SunPath(0.0, elevation, zero, 1.0)
    slope, time = (
        np.array([0.0, 10.0, 60.0, 90.0, 135.0])[:, None],
        np.array([0.0, 5.5, 5.8, 6.2, 12.0, 18.2, 18.6, 29.8]),
    )
    found = _regions(sun, (np.zeros((1, 1)), np.zeros((1, 1)), np.zeros((1, 1)), slope, time))
    assert found["day"].ravel().tolist() == [False, False, False, True, True, False, False, False]
    assert found["twilight"].ravel().tolist() == [False, False, True, False, False, True, False, True]
    assert found["night"].ravel().tolist() == [True, True, False, False, False, False, True, False]
    parts = [found[name].ravel().tolist() for name in ("level", "steep", "overhanging")]
    assert parts == [
        [True, True, False, False, False],
        [False, False, True, True, False],
        [False, False, False, False, True],
    ]
