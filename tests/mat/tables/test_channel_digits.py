"""Digits of arrays that a file of channels leaves out."""

import numpy as np

from skyshine.mat.tables.channels import _rounded

VALUES = np.concatenate([[0.0, 1e-9, -2.3e-4], 10.0 ** np.random.default_rng(4).uniform(-8, 3, 5000)])


def test_values_keep_their_bits_and_no_digits_below_the_step():
    for step in (0.0, 1e-3):
        error = np.abs(_rounded(VALUES, 13, step=step) - VALUES)
        assert np.all(error <= np.maximum(2.0**-14 * np.abs(VALUES) * 2, step / 2))
    kept = _rounded(VALUES, 13, step=1e-3)
    # The power of two below 0.001; of 0 to 1, that leaves a thousand values.
    assert np.array_equal(kept * 1024, np.round(kept * 1024)) and np.any(kept * 512 != np.round(kept * 512))
    assert np.unique(kept[VALUES < 1]).size < 1100 < np.unique(_rounded(VALUES[VALUES < 1], 13)).size


def test_light_keeps_more_bits_than_a_ratio():
    coarse, fine = (np.abs(_rounded(VALUES, bits) / np.where(VALUES, VALUES, 1) - 1)[1:].max() for bits in (13, 16))
    assert 2.0**-15 < coarse <= 2.0**-13 and 2.0**-18 < fine <= 2.0**-16


def test_values_below_single_precision_are_none():
    # Light of the Sun through opaque air, in a band at 100 um.
    assert np.array_equal(_rounded(np.array([5e-324, 1e-310, -1e-200])), np.zeros(3))
