"""Tables without a line of column names."""

import pytest

from skyshine.schemas.csv_table import parse_table
from skyshine.schemas.errors import InputError


def test_a_header_that_is_given_leaves_all_rows_to_be_numbers():
    table = parse_table("1,2\n3,4\n5,6\n", "a.csv", header="wavelength[um],response")
    assert table.names == ("wavelength", "response") and table.units == ("um", "")
    assert table.values.tolist() == [[1, 2], [3, 4], [5, 6]]


def test_rows_are_counted_below_a_header_that_is_given():
    with pytest.raises(InputError, match="found 1 rows of numbers; allowed: 2 to"):
        parse_table("1,2\n", "a.csv", header="wavelength[um],response")
