"""The page of the physics shows the errors of a pixel that were measured last."""

import json

from report_results import PAGE, RESULTS, block, with_block


def test_the_page_quotes_the_results():
    page = PAGE.read_text(encoding="utf-8")
    assert page == with_block(page, block(json.loads(RESULTS.read_text(encoding="utf-8"))))
