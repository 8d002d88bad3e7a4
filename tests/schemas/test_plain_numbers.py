"""Numbers as text: the forms that tables write, and those that only Python reads."""

import pytest

from skyshine.mat.commands.query import _pair
from skyshine.mat.surface.weather_readings import AIR_COLUMNS
from skyshine.materials.files import load_spectrum
from skyshine.schemas.csv_table import parse_table
from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number

SLIPS = (
    "2_9.7",
    "1_000",
    "\u0662\u0669.\u0667",
    "\uff12\uff19",
    "nan",
    "inf",
    "Infinity",
    "1e999",
    "",
    "0x1F",
    "29,7",
    "2 9",
)


@pytest.mark.parametrize("text", ["29.7", "-.5", "+3", "7.", "1e-3", "2.5E+08", " 4 "])
def test_numbers_as_the_field_writes_them(text):
    assert plain_number(text) == float(text)


@pytest.mark.parametrize("text", SLIPS)
def test_other_forms_are_refused(text):
    with pytest.raises(ValueError, match="allowed"):
        plain_number(text)


@pytest.mark.parametrize("text", [slip for slip in SLIPS if slip not in ("", "29,7")])
def test_a_table_refuses_them_at_their_pair(text):
    with pytest.raises(InputError, match="t.csv:3:3: b: found"):
        parse_table(f"a,b\n1,2\n1,{text}\n", "t.csv")
    with pytest.raises(ValueError, match="found"):
        AIR_COLUMNS["pressure"].to_si(text, "")
    with pytest.raises(InputError, match="allowed: a number"):
        _pair(f"range={text}")


def test_a_range_in_the_header_of_a_spectrum_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("# range: 0.3 1_4 measured; note\nwavelength_um,reflectance\n0.3,0.1\n14,0.2\n")
    with pytest.raises(InputError, match="a.csv:1:1: found 'range:"):
        load_spectrum(tmp_path / "a.csv")
