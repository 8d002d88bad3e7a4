"""Upper tail of chi-squared against scipy's."""

import numpy as np
import pytest
from scipy.special import chdtrc

from skyshine.tmm.classify.chi_squared import upper_tail


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 5, 30])
def test_the_tail_is_that_of_scipy(freedom):
    """Between the steps of its table too, near 0, where that of one degree is steep, and far beyond the last step."""
    value = np.concatenate([[0.0, 1e-300, 1e9, np.inf], np.linspace(0, 300, 100_001), np.logspace(-12, 3, 5000)])
    np.testing.assert_allclose(upper_tail(freedom, value), chdtrc(freedom, value), rtol=0, atol=1e-7)
    assert upper_tail(freedom, np.empty(0)).shape == (0,)
