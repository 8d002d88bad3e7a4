"""The library beside handbooks: who lies outside has a reason, and the comparison finds what it should."""

import json

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.scene.material_summary import material_summary
from skyshine.materials.handbooks import QUANTITIES, HandbookRow, Handbooks, compare, load_handbooks
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def comparisons():
    library, known = load_library(), load_handbooks()
    listed = {name for row in known.rows for name in row.materials}
    return compare(known, {name: material_summary(library[name]) for name in sorted(listed)})


def test_rows_speak_of_materials_and_books_that_there_are():
    library, known = load_library(), load_handbooks()
    for row in known.rows:
        assert set(row.materials) <= set(library.names), row.row
        assert row.handbook in library.references, row.row
    for key in known.reasons:
        name, quantity = key.split(".")
        assert name in library and quantity in QUANTITIES, key


def test_who_misses_all_handbooks_has_a_reason_and_nobody_else(comparisons):
    for each in comparisons:
        assert bool(each.reason) == (not each.within), (
            each.material,
            each.quantity,
            each.value,
            each.lower,
            each.upper,
        )


def test_most_of_the_library_is_what_handbooks_say(comparisons):
    assert len(comparisons) > 110
    assert sum(each.within for each in comparisons) > 0.85 * len(comparisons)
    assert sum(each.checked >= 2 for each in comparisons) > 40


@pytest.mark.parametrize("value, within", [(0.54, False), (0.56, True), (0.7, True), (0.84, True), (0.86, False)])
def test_range_spans_the_handbooks_and_their_rounding(value, within):
    rows = [
        HandbookRow(handbook="a", row="x", solar_absorptance=(0.6, 0.6), materials=["it"]),
        HandbookRow(handbook="b", row="x", solar_absorptance=(0.7, 0.8), materials=["it"], checked=False),
        HandbookRow(handbook="c", row="x", thermal_emissivity=(0.9, 0.9), materials=["other"]),
    ]
    (found,) = compare(Handbooks(rows=rows), {"it": {"solar_absorptance": value, "thermal_emissivity": 0.1}})
    assert (found.lower, found.upper, found.within, found.checked) == (0.6, 0.8, within, 1)


def test_row_without_a_rising_range_is_refused(tmp_path):
    file = tmp_path / "handbooks.yaml"
    file.write_text("rows:\n  - {handbook: a, row: x, solar_absorptance: [0.8, 0.6], materials: [it]}\n")
    with pytest.raises(InputError, match="no range, or one that falls"):
        load_handbooks(file)


def test_command_prints_writes_and_dumps(tmp_path):
    run = CliRunner()
    listed = run.invoke(main, ["materials", "handbooks"])
    assert listed.exit_code == 0 and "galvanised_new" in listed.output and " within" in listed.output.splitlines()[-1]
    page = tmp_path / "page.md"
    assert run.invoke(main, ["materials", "handbooks", "--page", str(page)]).exit_code == 0
    text = page.read_text()
    assert (
        "| `galvanised_new` | solar absorptance | 0.64 |" in text and "([incropera]" in text and "- [flir] FLIR" in text
    )
    dumped = json.loads(run.invoke(main, ["materials", "handbooks", "--json"]).output)
    assert {"material", "value", "range", "within", "handbooks", "reason"} <= set(dumped["comparisons"][0])
