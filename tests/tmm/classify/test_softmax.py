"""Softmax regression against scikit-learn, and what a prior and few places do."""

import numpy as np
import pytest

from skyshine.tmm.classify.softmax import PENALTY, softmax_posterior

EVEN = np.log(np.full(3, 1 / 3))


@pytest.fixture
def clouds():
    """Three clouds of seeds in four dimensions, of 40 each, and places to ask about."""
    random = np.random.default_rng(0)
    middles = 2 * random.normal(size=(3, 4))
    material = np.repeat(np.arange(3), 40)
    return middles[material] + random.normal(size=(120, 4)), material, 3 * random.normal(size=(50, 4))


def test_agrees_with_scikit_learn(clouds):
    linear = pytest.importorskip("sklearn.linear_model")
    features, material, asked = clouds
    # Its penalty is 1 / (2 C) beside the sum over seeds, ours beside their mean.
    peer = linear.LogisticRegression(C=4 / (PENALTY * len(features)), tol=1e-8, max_iter=1000).fit(features, material)
    ours = softmax_posterior(features, material, EVEN, 3, asked)
    np.testing.assert_allclose(ours, peer.predict_proba(asked), atol=2e-3)


def test_materials_count_alike_however_many_seeds(clouds):
    features, material, asked = clouds
    once = softmax_posterior(features, material, EVEN, 3, asked)
    more = np.concatenate([np.arange(120), *[np.arange(40)] * 5])
    np.testing.assert_allclose(softmax_posterior(features[more], material[more], EVEN, 3, asked), once, atol=2e-3)


def test_prior_scales_the_odds(clouds):
    features, material, asked = clouds
    even = softmax_posterior(features, material, EVEN, 3, asked)
    prior = softmax_posterior(features, material, np.log([0.5, 0.25, 0.25]), 3, asked)
    np.testing.assert_allclose(prior[:, 0] / prior[:, 1], 2 * even[:, 0] / even[:, 1], rtol=1e-6)


def test_few_places_are_trusted_less(clouds):
    features, material, asked = clouds
    few, many = (softmax_posterior(features, material, EVEN, places, asked).max(axis=1).mean() for places in (1, 20))
    assert few < many - 0.02
