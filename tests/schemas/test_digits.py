"""Digits of arrays that a file leaves out."""

import numpy as np
import pytest

from skyshine.schemas.digits import rounded_bits, rounded_to

VALUES = np.concatenate([[0.0, 1e-9, -2.3e-4], 10.0 ** np.random.default_rng(4).uniform(-8, 3, 5000)])


@pytest.mark.parametrize("step", [1e-3, 0.0625, 3.0])
def test_values_are_whole_numbers_of_the_power_of_two_at_or_below_the_step(step):
    rounded, unit = rounded_to(VALUES, step), 2.0 ** np.floor(np.log2(step))
    assert np.abs(rounded - VALUES).max() <= unit / 2
    assert np.array_equal(rounded, np.rint(rounded / unit) * unit)


def test_each_value_has_its_own_step_and_single_precision_the_last_digits():
    assert np.array_equal(rounded_to([[1.3, 1.3]], [[1.0, 0.25]]), [[1.0, 1.25]])
    # Light of the Sun through opaque air, in a band at 100 um.
    assert np.array_equal(rounded_to([5e-324, 1e-310, -1e-200], 0.0), np.zeros(3))


@pytest.mark.parametrize("bits", [6, 13])
def test_values_keep_so_many_bits(bits):
    singles = VALUES.astype(np.float32)
    error = np.abs(rounded_bits(singles, bits) / np.where(singles, singles, 1) - 1)[1:].max()
    assert 2.0 ** -(bits + 2) < error <= 2.0**-bits
    assert rounded_bits(singles, bits)[0] == 0
