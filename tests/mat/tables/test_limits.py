"""What an opened database refuses: arrays laid out, or filled, as none may be."""

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


def test_unknown_stated_errors_and_integers_pass():
    refuse_values("file", "/accuracy/maximum", np.array([np.nan]))
    refuse_values("file", "/material", np.array([7]))
