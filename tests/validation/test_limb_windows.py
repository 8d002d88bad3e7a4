"""Limb radiance of the packaged table, as a user gets it, against RFM line by line (`limb_results`)."""

import json

import limb_results
import pytest
from limb_rays import shells

# By window, the range of the ratio at both heights. What explains it is said in atmospheres/absorption.md.
LIMITS = {
    790: (0.92, 1.02),
    805: (0.71, 1.02),
    825: (0.80, 1.02),
    845: (0.86, 1.02),
    865: (0.83, 1.02),
    885: (0.92, 1.04),
    920: (0.88, 1.02),
    1060: (0.985, 1.01),
    1160: (0.80, 1.02),
    1165: (0.72, 1.02),
    1260: (0.87, 1.02),
    1275: (0.91, 1.02),
    1285: (0.83, 1.02),
    1300: (0.95, 1.02),
    2220: (0.94, 1.02),
}


@pytest.fixture(scope="module")
def rows():
    return limb_results.computed()


def test_rays_bend_to_their_lowest_points():
    """By Edlen's refractivity in the air of the reference: 1.2, 0.6 and 0.1 km below their geometric heights."""
    assert shells(5)[2] == pytest.approx(3.8e3, abs=50)
    assert shells(10)[2] == pytest.approx(9.4e3, abs=50)
    assert shells(20)[2] == pytest.approx(19.9e3, abs=60)


def test_windows_are_as_near_to_the_reference_as_the_page_says(rows):
    kept = json.loads(limb_results.RESULTS.read_text(encoding="utf-8"))
    assert [row["low"] for row in rows] == [row["low"] for row in kept]
    assert [row["ratio"] for row in rows] == pytest.approx([row["ratio"] for row in kept], abs=0.003)
    outside = [row for row in rows if not LIMITS[row["low"]][0] <= row["ratio"] <= LIMITS[row["low"]][1]]
    assert not outside


def test_ozone_and_not_carbon_dioxide_is_seen_at_1064(rows):
    for row in rows:
        if row["low"] == 1060:
            assert list(row["shares"]) == ["O3"]
