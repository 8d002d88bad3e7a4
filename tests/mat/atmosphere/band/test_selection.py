"""Choice of spectral points: exactness where it is possible, and what must always hold."""

import numpy as np
import pytest

from skyshine.mat.atmosphere.band.selection import _factor, _fits, select_points


def exponentials(points=200, seed=0):
    """Transmittances of many paths at points whose absorption spans eight decades."""
    rng = np.random.default_rng(seed)
    absorption = 10 ** rng.uniform(-4, 4, points)
    return np.exp(-absorption[:, None] * np.geomspace(1e-4, 1e4, 120))


def test_finds_the_points_that_the_mean_is_made_of():
    candidates = exponentials()
    reference = 0.2 * candidates[3] + 0.5 * candidates[50] + 0.3 * candidates[120]
    index, weight, ladder = select_points(candidates, reference, tolerance=1e-7, max_points=12, total_weight=5.0)
    assert ladder[-1] < 1e-5
    assert weight @ candidates[index] / 5.0 == pytest.approx(reference, abs=1e-4)


@pytest.mark.parametrize("exchanges", [0, 3])
def test_weights_are_positive_and_sum_to_the_total(exchanges):
    candidates = exponentials()
    index, weight, _ = select_points(
        candidates, candidates.mean(0), tolerance=0.0, max_points=10, total_weight=5.0, exchanges=exchanges
    )
    assert weight.min() > 0 and weight.sum() == pytest.approx(5.0, rel=1e-12)
    assert len(set(index.tolist())) == index.size <= 10


def test_error_falls_to_a_part_in_a_thousand_with_few_points():
    candidates = exponentials()
    _, _, ladder = select_points(candidates, candidates.mean(0), tolerance=0.0, max_points=16, total_weight=1.0)
    assert ladder[15] < 2e-3 < 0.03 < ladder[0]


def test_sets_are_nested_and_repeatable():
    candidates = exponentials()
    settings = {"tolerance": 0.0, "total_weight": 1.0}
    short = select_points(candidates, candidates.mean(0), max_points=5, **settings)
    long = select_points(candidates, candidates.mean(0), max_points=9, **settings)
    again = select_points(candidates, candidates.mean(0), max_points=9, **settings)
    assert set(short[0]) <= set(long[0]) | set(short[0][short[1] == 0])
    np.testing.assert_array_equal(long[2][:5], short[2])
    for first, second in zip(long, again, strict=True):
        np.testing.assert_array_equal(first, second)


def test_exchanges_do_not_make_it_worse():
    candidates = exponentials(seed=5)
    plain = select_points(candidates, candidates.mean(0), tolerance=0.0, max_points=8, total_weight=1.0)
    better = select_points(candidates, candidates.mean(0), tolerance=0.0, max_points=8, total_weight=1.0, exchanges=4)
    assert better[2][-1] <= plain[2][-1]


def test_stops_at_the_tolerance():
    candidates = exponentials()
    index, _, ladder = select_points(candidates, candidates.mean(0), tolerance=0.02, max_points=50, total_weight=1.0)
    assert ladder[-1] <= 0.02 and len(ladder) < 10 and index.size <= len(ladder)


def test_row_scale_decides_what_matters():
    candidates = exponentials()
    reference = candidates.mean(0)
    scale = np.where(np.arange(120) < 60, 1.0, 1e-4)
    index, weight, _ = select_points(
        candidates, reference, tolerance=0.0, max_points=4, total_weight=1.0, row_scale=scale
    )
    error = np.abs(weight @ candidates[index] - reference)
    assert error[:60].max() < 0.3 * error[60:].max()


def test_identical_and_opaque_candidates():
    same = np.ones((6, 10))
    _, weight, ladder = select_points(same, np.ones(10), tolerance=1e-9, max_points=4, total_weight=2.0)
    assert weight.sum() == pytest.approx(2.0) and ladder[-1] < 1e-9
    opaque = np.zeros((6, 10))
    _index, weight, _ = select_points(opaque, np.zeros(10), tolerance=1e-9, max_points=4, total_weight=2.0)
    assert weight.sum() == pytest.approx(2.0)


def test_bad_input_is_refused():
    with pytest.raises(ValueError, match="fit together"):
        select_points(np.ones((3, 4)), np.ones(5), tolerance=0.1, max_points=2, total_weight=1.0)
    with pytest.raises(ValueError, match="finite"):
        select_points(np.full((3, 4), np.nan), np.ones(4), tolerance=0.1, max_points=2, total_weight=1.0)


def test_weights_of_a_further_point_are_those_of_least_squares():
    candidates, truth = exponentials(), np.array([0.3, 0.2, 0.1])
    chosen = candidates[[3, 50, 120]]
    gram, moment = chosen @ chosen.T, chosen @ (truth @ chosen)
    factor = _factor(gram[:2, :2])
    rows = np.linalg.solve(factor, gram[:2, 2:])
    goal = np.linalg.solve(factor, moment[:2])
    root = np.sqrt(gram[2, 2] - np.sum(rows**2, axis=0))
    weights = _fits(factor, rows, root, goal, (moment[2] - goal @ rows) / root)
    assert weights[0] == pytest.approx(truth, rel=1e-6)
