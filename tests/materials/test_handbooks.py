"""The library beside handbooks: who lies outside has a reason, and the comparison finds what it should."""

import pytest

from mat.maintain.materials import handbooks
from mat.maintain.materials.handbooks import QUANTITIES, HandbookRow, Handbooks, compare, load_handbooks
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def comparisons():
    return handbooks.compared(load_library())


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


def test_the_page_in_the_checkout_is_the_one_that_is_written(capsys, pytestconfig):
    handbooks.main()
    page = pytestconfig.rootpath / "materials" / "HANDBOOKS.md"  # no part of the wheel
    assert capsys.readouterr().out == page.read_text(encoding="utf-8")
