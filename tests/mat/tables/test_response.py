"""Changes of temperature by other heat, on responses whose answer is known in closed form."""

import numpy as np
import pytest
from numpy_response import ColumnResponse

from skyshine.mat.tables.response import FORCING_STEPS

SLOPE = 20.0  # W m^-2 K^-1 of heat loss
MELTING_POINT = 273.15


def melting_lump(melt):
    """A surface at its melting point all day, which spends heat [W m^-2] on melting and is always in balance."""
    hours, offset = 24, np.array([-100.0, 100.0])
    return ColumnResponse(
        lag=np.array([-12.0]),
        offset=offset,
        kernel=np.full((1, hours, 1), 1 / SLOPE),
        reference=np.full((1, hours), MELTING_POINT),
        slope=np.full((1, hours), SLOPE),
        excess=np.zeros((1, hours, offset.size)),
        melt=np.full((1, hours), melt),
    )


@pytest.mark.parametrize(
    ("heat", "expected"), [(200.0, 0.0), (-30.0, 0.0), (-50.0, 0.0), (-80.0, -1.5), (-250.0, -10.0)]
)
def test_a_surface_that_melts_cools_by_what_melting_does_not_give_up(heat, expected):
    """Of 50 W/m2 spent on melting the first 50 lost cost no temperature, the others 1 K for each 20 W/m2."""
    temperature = np.full((1, FORCING_STEPS), MELTING_POINT)
    change = melting_lump(50.0).change(np.full((1, FORCING_STEPS), heat), temperature, np.array([MELTING_POINT]))
    np.testing.assert_allclose(change, expected, atol=1e-9)


def test_a_surface_below_its_melting_point_has_no_heat_of_melting():
    temperature = np.full((1, FORCING_STEPS), MELTING_POINT)
    change = melting_lump(0.0).change(np.full((1, FORCING_STEPS), -40.0), temperature, np.array([MELTING_POINT + 5.0]))
    np.testing.assert_allclose(change, -2.0, atol=1e-9)
