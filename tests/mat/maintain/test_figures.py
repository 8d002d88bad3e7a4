"""Figures that pages quote are those of one file, which is made of what validations and a build wrote."""

import json

import pytest

from mat.maintain import figures

ENTRIES = {"pixel.rms": {"value": "0.29", "unit": "K", "source": "here"}}


def test_the_file_has_what_the_validations_wrote():
    kept = json.loads(figures.FIGURES.read_text(encoding="utf-8"))
    measured = figures.of_validations()
    assert {name: kept.get(name) for name in measured} == measured
    assert set(kept) - set(measured) == {name for name in kept if name.startswith("starter.")}


def test_pages_quote_the_file():
    kept = json.loads(figures.FIGURES.read_text(encoding="utf-8"))
    quoting = 0
    for page in figures.pages():
        text = page.read_text(encoding="utf-8")
        quoting += bool(figures.BLOCK.search(text) or figures.QUOTE.search(text))
        assert figures.with_figures(text, kept) == text, page
        assert text.count("<!-- figure ") == len(figures.QUOTE.findall(text)), page  # each mark follows a number
    assert quoting >= 4


def test_another_figure_in_a_page_is_replaced_and_one_that_the_file_lacks_is_refused():
    assert figures.with_figures("rms 0.31<!-- figure pixel.rms --> K", ENTRIES) == "rms 0.29<!-- figure pixel.rms --> K"
    with pytest.raises(KeyError, match="pixel.unknown"):
        figures.with_figures("0.31<!-- figure pixel.unknown -->", ENTRIES)
