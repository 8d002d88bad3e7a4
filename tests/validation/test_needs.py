"""What the needs of three scenes save of a build, and that no read changes by more than both builds state.

Run: python -m pytest -m validation -s tests/validation/test_needs.py
"""

import pytest

from mat.maintain.bench.scene_needs import CASES, measured, shares

pytestmark = pytest.mark.validation

# Largest shares of bytes and of processor seconds. The job of the street is written for this street alone: its scene
# needs most of it.
LIMITS = {"terrain": (0.25, 0.4), "street": (0.8, 0.85), "starter": (0.25, 0.4)}


@pytest.mark.parametrize("case", CASES)
def test_a_build_for_a_scene_costs_less_and_reads_the_same_within_its_bound(tmp_path, monkeypatch, case):
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    result = measured(case, tmp_path)
    share = shares(result)
    print(f"\n{case}: {share}; {result['without_needs']}, {result['with_needs']}")
    assert share["difference"] <= 1.0
    most_bytes, most_seconds = LIMITS[case]
    assert share["bytes"] <= most_bytes and share["seconds"] <= most_seconds
