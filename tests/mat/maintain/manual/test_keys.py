"""The reference of job keys names each key of its schema with its description."""

import json
from pathlib import Path

import pytest

from mat.maintain.manual import keys
from skyshine import schemas

CHECKOUT = Path(__file__).parents[4]


def described(rule):
    """All keys of a schema with their rules, wherever they stand."""
    if isinstance(rule, dict):
        properties = rule.get("properties")
        if isinstance(properties, dict):
            yield from properties.items()
        for part in rule.values():
            yield from described(part)
    elif isinstance(rule, list):
        for part in rule:
            yield from described(part)


def test_each_packaged_schema_of_yaml_has_a_page():
    assert {path.name for path in schemas.path("x").parent.glob("*.schema.json")} == set(keys.TITLES)


@pytest.mark.parametrize("name", keys.TITLES)
def test_the_checkout_has_the_page_of_today(name):
    page = CHECKOUT / "schemas" / "keys" / keys.file_name(name)
    assert page.read_text(encoding="utf-8") == keys.page(name), "run python -m mat.maintain.job_schema schemas"


@pytest.mark.parametrize("name", keys.TITLES)
def test_the_page_names_each_key(name):
    schema = json.loads(schemas.path(name).read_text(encoding="utf-8"))
    # A number with a source beside it, {value, source}, is told in the row of the number.
    wanted = {key for key, _ in described(schema)} - {"value", "source"}
    rows = {line.split("`")[1] for line in keys.page(name).splitlines() if line.startswith("| `")}
    assert wanted - rows == set()


@pytest.mark.parametrize("name", keys.TITLES)
def test_no_row_of_a_page_lacks_its_description(name):
    rows = [line for line in keys.page(name).splitlines() if line.startswith("| `")]
    assert rows
    for row in rows:
        cells = row.replace("\\|", "").strip("| ").split(" | ")
        assert len(cells) == 4 and all((cells[1].strip(), cells[3].strip())), row


@pytest.mark.parametrize("name", keys.TITLES)
def test_links_of_a_page_lead_to_its_sections(name):
    text = keys.page(name)
    targets = set(keys.anchors([line.removeprefix("## ") for line in text.splitlines() if line.startswith("## ")]))
    links = {part.partition(")")[0] for part in text.split("](#")[1:]}
    assert links == targets


@pytest.mark.parametrize(
    ("key", "unit"),
    [
        ("range_km", "km"),
        ("wind_speed_m_s", "m/s"),
        ("temperatures_c", "Celsius"),
        ("heat_w_m2_k", "W m^-2 K^-1"),
        ("fwhm_deg", "degree"),
    ],
)
def test_units_stand_by_the_key(key, unit):
    assert keys._unit(key) == f" [{unit}]"
    assert keys._unit("material") == ""
