"""The windows at 2.1 and 4 um: the results file of the page is what the packaged tables give (`window_results`)."""

import json

import pytest
import window_results


def test_the_results_file_is_what_the_tables_give():
    kept = json.loads(window_results.RESULTS.read_text(encoding="utf-8"))
    for row, old in zip(window_results.computed(), kept, strict=True):
        assert row == pytest.approx(old, abs=0.002)
