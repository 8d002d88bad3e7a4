"""What an opened database refuses: arrays laid out, or filled, as none may be."""

import re

import numpy as np
import pytest

from skyshine.mat.tables.limits import LIMITS, refuse_values
from skyshine.schemas.errors import InputError


@pytest.mark.parametrize("name", sorted(LIMITS))
def test_a_value_outside_its_limits_is_refused_and_one_inside_is_not(name):
    limits = LIMITS[name]
    inside = min(limits.high, limits.low + 1.0)
    refuse_values("file", f"/{name}", np.array([inside], np.float32))
    for wrong in (limits.low - 1.0, np.nan, np.inf):
        with pytest.raises(InputError, match=name):
            refuse_values("file", f"/{name}", np.array([inside, wrong], np.float32))


@pytest.mark.parametrize("name", sorted(name for name in LIMITS if " to " in LIMITS[name].words))
def test_the_message_names_the_limits(name):
    limits = LIMITS[name]
    low, high = re.findall(r"(-?[\d.e+]+) to (-?[\d.e+]+)", limits.words.replace(",", ""))[-1]
    assert limits.low == float(low)
    assert limits.high == pytest.approx(float(high), rel=1e-4)
    with pytest.raises(InputError, match=name):
        refuse_values("file", f"/{name}", np.array([float(high) + 0.01 * abs(float(high))]))


def test_unknown_stated_errors_and_integers_pass():
    refuse_values("file", "/accuracy/maximum", np.array([np.nan]))
    refuse_values("file", "/material", np.array([7]))
