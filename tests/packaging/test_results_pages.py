"""Pages show what was measured last."""

import json

import bench_results
import limb_results
import line_results
import needs_results
import pytest
import report_results
import stability_results
import window_results
from result_blocks import with_block


@pytest.mark.parametrize(
    "results",
    [bench_results, limb_results, line_results, report_results, stability_results, needs_results, window_results],
    ids=lambda module: module.__name__,
)
def test_the_page_quotes_the_results(results):
    page = results.PAGE.read_text(encoding="utf-8")
    kept = json.loads(results.RESULTS.read_text(encoding="utf-8"))
    assert page == with_block(page, results.RESULTS.name, results.block(kept))
