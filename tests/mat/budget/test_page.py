"""Numbers on the page of the error budget."""

import pytest

from skyshine.schemas.quantity import short


@pytest.mark.parametrize(
    "value, text",
    [(None, "-"), (0.0, "0"), (0.00012345, "0.000123"), (3.14159, "3.14"), (-271.8, "-272"), (1234.5, "1.23e+03")],
)
def test_three_digits_and_a_dash_for_what_is_not_known(value, text):
    assert short(value) == text
