"""The fit of a calibration against scipy's general minimiser of the same loss."""

import numpy as np
import pytest
from scipy.optimize import minimize

from skyshine.tmm.classify.calibration import LIMIT, fit_calibration


def _scipys(confidence, right, region):
    """Platt's loss with one regional vote each and a prior of one region at the identity, within the limits of 10."""
    weight = 1 / np.bincount(region)[region]
    inside = np.clip(confidence.astype(float), LIMIT, 1 - LIMIT)
    odds = np.log(inside / (1 - inside))
    yes, no = weight[right].sum(), weight[~right].sum()
    target = np.where(right, (yes + 1) / (yes + 2), 1 / (no + 2))

    def loss(at):
        z = at[0] * odds + at[1]
        return np.sum(weight * (np.logaddexp(0, z) - target * z)) + ((at[0] - 1) ** 2 + at[1] ** 2) / 2

    options = {"ftol": 1e-15, "gtol": 1e-9}
    return minimize(loss, [1, 0], method="L-BFGS-B", bounds=[(0, 10), (-10, 10)], options=options).x


@pytest.mark.parametrize("number", range(12))
def test_a_fit_is_that_of_scipy(number):
    """Of honest confidence, of what is always wrong or right, and of what is right the less the surer it is, where the
    slope ends at its limit.
    """
    random = np.random.default_rng(number)
    texels = int(random.integers(2, 3000))
    confidence = (random.random(texels) ** random.choice([0.02, 0.2, 1, 5])).astype(np.float32)
    chance = [confidence, 1 - confidence, np.zeros(texels), np.ones(texels)][number % 4]
    right, region = random.random(texels) < chance, np.arange(texels) // int(random.integers(1, 80))
    found = fit_calibration(confidence, right, region)
    np.testing.assert_allclose([found.slope, found.offset], _scipys(confidence, right, region), atol=2e-4)
