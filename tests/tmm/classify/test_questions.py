"""Where an answer is worth most: numbers worked out by hand, and what any choice must hold to."""

import numpy as np
import pytest

from skyshine.tmm.classify.questions import (
    RARE,
    RARE_CONTESTED,
    SETTLED,
    choose,
    clearness,
    contest,
    doubt,
    middles,
    reach,
    strangeness,
)
from skyshine.tmm.classify.superpixels import Superpixels


def _choose(told, texels, wrong, count=4, shares=None, allowed=None, strange=None):
    number = len(texels)
    return choose(
        np.asarray(told, np.float32),
        np.asarray(texels, float),
        np.asarray(wrong, float),
        np.ones((number, 1)) if shares is None else np.asarray(shares, float),
        np.ones(number) if allowed is None else np.asarray(allowed, float),
        np.ones(number) if strange is None else np.asarray(strange, float),
        count,
    )


def test_gains_by_hand():
    """Two alike (an answer tells 0.5 of the other), one by itself, one that is sure already."""
    told = np.eye(4)
    told[0, 1] = told[1, 0] = 0.5
    places = _choose(told, [30, 20, 10, 40], [0.4, 0.6, 0.9, 0.0])
    # The first: 30 x 0.4 + 0.5 x 20 x 0.6 = 18 of 100 texels, against 12 + 6 = 18 of the second: 12 + 0.5 x 12.
    # Then 10 x 0.9 = 9 for the one by itself, and 0.5 x 12 = 6 is left of the first two's other.
    assert [place.superpixel for place in places] == [0, 2, 1, 3]
    np.testing.assert_allclose([place.gain for place in places], [0.18, 0.09, 0.06, 0], atol=1e-7)


def test_less_is_gained_where_seeds_look_alike():
    told = np.eye(2)
    near, far = _choose(told, [60, 40], [0.5, 0.5], 2, strange=[0, 1])
    assert (near.superpixel, far.superpixel) == (0, 1)
    assert near.gain == pytest.approx(0.3 * SETTLED) and far.gain == pytest.approx(0.2)


def test_clear_places_are_preferred():
    """Of two halves of a sheet the flat one is asked about, though the other is a little larger."""
    label = np.zeros((10, 21), int)
    label[:, 10:] = 1
    halves = Superpixels(label, np.array([100.0, 110.0]), np.empty((2, 0), int), np.empty(0))
    lab = np.full((3, 10, 21), 50, np.float32)
    lab[0, :, :10] += np.where(np.arange(10) % 2, 1, -1)  # variance 1
    lab[0, :, 10:] += np.where(np.arange(11) % 2, 5, -5)[np.newaxis]
    clear = clearness(halves, lab, np.ones(2, bool))
    assert 1 > clear[0] > 0.8 > clear[1] > 0
    assert _choose(np.eye(2), halves.size, [0.5, 0.5], 1, allowed=clear)[0].superpixel == 0
    assert clearness(halves, lab, np.array([True, False]))[1] == 0
    flat = clearness(halves, np.zeros_like(lab), np.ones(2, bool))
    np.testing.assert_array_equal(flat, 1)


def test_rare_materials_are_asked_for_first():
    shares = np.array([[1, 0], [1, 0], [1, 0], [0, 1.0]])
    places = _choose(np.eye(4), [40, 30, 20, 10], [0.1, 0.1, 0.1, 0.3], 1, shares)
    # Weights: 40 x 0.1 x 0.9^-p against 10 x 0.3 x 0.1^-p; without rarity 4 > 3.
    assert 3 * 0.1**-RARE > 4 * 0.9**-RARE and places[0].superpixel == 3
    assert places[0].gain == pytest.approx(0.03)


def test_gains_never_exceed_what_is_wrong_and_nothing_is_asked_twice():
    random = np.random.default_rng(5)
    told = reach(random.normal(size=(60, 4)))
    texels, wrong = random.uniform(1, 50, 60), random.uniform(0, 1, 60)
    shares = random.dirichlet(np.ones(3), 60)
    allowed = random.random(60) < 0.7
    places = _choose(told, texels, wrong, 1000, shares, allowed)
    chosen = [place.superpixel for place in places]
    assert sorted(chosen) == np.flatnonzero(allowed).tolist()
    assert all(place.gain >= 0 for place in places)
    assert sum(place.gain for place in places) <= wrong @ texels / texels.sum() + 1e-6


def test_what_is_contested_by_hand():
    """Margins of 0.8, 0.2 and 0; the last has seeds. Each two are alike: the doubt around is that of the others."""
    shares, told = np.array([[0.9, 0.1], [0.4, 0.6], [0.5, 0.5]]), np.full((3, 3), 0.5) + 0.5 * np.eye(3)
    seeded, texels = np.array([False, False, True]), np.array([4.0, 9, 3])
    found = contest(told.astype(np.float32), texels, shares, np.ones(3), seeded)
    share = np.array([0.9 * 4 + 0.4 * 9 + 0.5 * 3, 0.1 * 4 + 0.6 * 9 + 0.5 * 3]) / 16
    rare = shares @ share**-RARE_CONTESTED
    np.testing.assert_allclose(found, [0.2 * 0.4 * 2 * rare[0], 0.8 * 0.1 * 3 * rare[1], 0], rtol=1e-6)
    # What the library takes for none of the materials is contested by all.
    assert contest(told.astype(np.float32), texels, shares, np.array([0, 1, 1]), seeded)[0] > 4 * found[0]


def test_contested_places_differ():
    """The most contested and one alike: the second question goes to the one that is not."""
    told = np.array([[1, 0.95, 0], [0.95, 1, 0], [0, 0, 1]])
    arguments = told.astype(np.float32), np.ones(3), np.full(3, 0.5), np.ones((3, 1)), np.ones(3), np.ones(3), 3
    places = choose(*arguments, contested=np.array([1.0, 0.9, 0.3]))
    assert [place.superpixel for place in places] == [0, 2, 1]
    assert sum(place.gain for place in places) <= 0.5


def test_without_seeds_each_kind_of_ground_is_asked_about():
    """Five groups far apart, one of them a tenth of the size of the others: five questions, one in each."""
    random = np.random.default_rng(2)
    group = np.repeat(np.arange(5), [50, 50, 50, 50, 5])
    means = random.normal(size=(5, 6))[group] * 10 + random.normal(0, 0.1, (len(group), 6))
    told = reach(means)
    nothing = doubt(np.ones((len(group), 1)), np.zeros(len(group)), np.zeros(len(group), bool), np.ones(len(group)))
    np.testing.assert_array_equal(nothing, 1)
    places = _choose(told, np.ones(len(group)), nothing, 5)
    assert {group[place.superpixel] for place in places} == {0, 1, 2, 3, 4}


def test_reach_is_whole_for_itself_and_symmetric():
    means = np.random.default_rng(3).normal(size=(40, 5))
    told = reach(means)
    np.testing.assert_allclose(np.diag(told), 1, atol=1e-4)
    np.testing.assert_allclose(told, told.T, atol=1e-6)
    assert (told >= 0).all() and (told <= 1 + 1e-6).all()
    np.testing.assert_allclose(reach(means * [1, 10, 100, 1e3, 1e-3] + 7), told, atol=1e-3)
    np.testing.assert_allclose(reach(np.ones((3, 2))), 1)


def test_doubt_is_none_where_seeds_are_and_larger_where_they_are_strange():
    told = np.array([[1, 1, 0], [1, 1, 0], [0, 0, 1]], float)
    shares = np.array([[0.9, 0.1]] * 3)
    seeded = np.array([True, False, False])
    strange = strangeness(told, seeded)
    assert strange.tolist() == [0, 0, 1] and strangeness(told, np.zeros(3, bool)).tolist() == [1, 1, 1]
    wrong = doubt(shares, np.ones(3), seeded, strange)
    assert wrong[0] == 0 and wrong[1] == pytest.approx(0.1) and wrong[2] > wrong[1]
    # What the library takes for a material without seeds is wrong for certain.
    assert doubt(shares, np.array([1, 1, 0.0]), seeded, strange)[2] == 1


def test_middles_lie_deepest_and_have_data():
    label = np.zeros((9, 18), int)
    label[:, 9:] = 1
    valid = np.ones(label.shape, bool)
    pixels = Superpixels(label, np.array([81.0, 81.0]), np.empty((2, 0), int), np.empty(0))
    rows, columns, depth = middles(pixels, valid)
    # Of 9 x 9 texels the middle one is 4 from the outermost that still belongs.
    assert list(zip(rows, columns, depth, strict=True)) == [(4, 4, 4), (4, 13, 4)]
    valid[:, 9:] = False
    assert middles(pixels, valid)[2].tolist() == [4, -1]
    valid[:, :] = False
    valid[2, 3] = True
    rows, columns, depth = middles(pixels, valid)
    assert (rows[0], columns[0], depth[0]) == (2, 3, 0)
