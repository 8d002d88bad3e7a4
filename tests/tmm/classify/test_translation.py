"""What a library's classes say of the materials of seeds: by hand, by Bayes' rule, and what any word must hold to."""

import numpy as np
import pytest

from skyshine.tmm.classify.translation import SLIPS, TRUST, and_unknown, library_classes, translated


def test_classes_by_name_then_by_group():
    groups = {"oak": "tree", "elm": "tree", "fir": "tree", "mud": "soil", "ice": "water"}
    shares = library_classes(("oak", "fir", "ice"), ("oak", "elm", "mud"), groups)
    # Fir is no seed: it stands for the tree that the library does not name. Ice stands for nothing.
    assert shares.tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 0]]
    assert and_unknown(shares, ("oak", "elm", "mud")).tolist() == [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]]
    named = library_classes(("oak", "fir", "ice"), ("oak", "elm", "unknown"), groups)
    assert and_unknown(named, ("oak", "elm", "unknown")).tolist() == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    # Where the library names all trees of the seeds, other trees stand for these: they are trees, and no mud.
    shares = library_classes(("oak", "fir", "elm", "ice"), ("oak", "elm", "mud"), groups)
    assert shares.tolist() == [[1, 0, 0], [0.5, 0.5, 0], [0, 1, 0], [0, 0, 0]]
    assert and_unknown(np.eye(2), ("oak", "elm")).tolist() == [[1, 0], [0, 1]]


def test_before_the_first_click_names_decide():
    """Bayes' rule by hand for two materials: a class that is sure of one of them, up to the library's slips."""
    own, other = 1 - SLIPS / 2, SLIPS / 2
    found = translated(np.array([[1.0, 0], [0, 1], [0.5, 0.5]]), np.eye(2), np.eye(2), np.zeros(2))
    np.testing.assert_allclose(found, [[own, other], [other, own], [0.5, 0.5]], rtol=1e-12)


def test_clicks_are_weighed_against_names_by_their_number():
    """As many clicks as the names count for, all into the other's class: half of what the material is called."""
    heard, classes = np.array([[1.0, 0], [1, 0]]), np.eye(2)
    found = translated(np.array([[1.0, 0], [0.5, 0.5]]), classes, heard, np.array([0, TRUST]))
    field, lake = 1 - SLIPS / 2, (SLIPS / 2 + 1) / 2
    called_field = np.array([field, lake]) / (field + lake)
    called_lake = np.array([1 - field, 1 - lake]) / (2 - field - lake)
    np.testing.assert_allclose(found, [called_field, (called_field + called_lake) / 2], rtol=1e-12)


def test_many_clicks_turn_a_library_that_takes_each_for_the_other():
    found = translated(np.eye(2), np.eye(2), np.eye(2)[::-1], np.array([1000, 1000]))
    assert found[0, 1] > 0.98 and found[1, 0] > 0.98


def test_materials_that_no_class_stands_for_are_learned_from_clicks():
    """Without names all are alike before the first click; with many, each is what the library calls it."""
    word, nameless, heard = np.eye(3), np.zeros((3, 2)), np.array([[0.9, 0.1, 0], [0, 0.1, 0.9]])
    np.testing.assert_allclose(translated(word, nameless, heard, np.zeros(2)), 0.5)
    found = translated(word, nameless, heard, np.array([500, 500]))
    assert found[0, 0] > 0.95 and found[2, 1] > 0.95
    np.testing.assert_allclose(found[1], 0.5)


def test_two_classes_of_one_material_and_two_materials_of_one_class():
    found = translated(np.eye(3), np.array([[1.0, 0], [1, 0], [0, 1]]), np.zeros((2, 3)), np.zeros(2))
    np.testing.assert_allclose(found[0], found[1])
    assert found[0, 0] > 0.9 and found[2, 1] > 0.9
    np.testing.assert_allclose(translated(np.eye(1), np.ones((1, 2)) / 2, np.ones((2, 1)), np.ones(2)), 0.5)


@pytest.mark.parametrize("number", [0, 1, 1e6])
def test_shares_are_finite_and_sum_to_one(number):
    random = np.random.default_rng(0)
    library, heard = random.dirichlet(np.full(5, 0.1), 50), random.dirichlet(np.full(5, 0.1), 4)
    classes = np.eye(5)[:, :4] * random.integers(0, 2, (5, 1))
    found = translated(library, classes, heard, np.full(4, number))
    assert np.isfinite(found).all() and (found > 0).all()
    np.testing.assert_allclose(found.sum(axis=1), 1)
