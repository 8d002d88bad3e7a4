"""Blocks of pages that are written from results files, between marks of the file's name."""

import json


def with_block(page, name, text):
    """A page with a text between its marks ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->``."""
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    before, rest = page.split(begin)
    return f"{before}{begin}\n\n{text}\n{end}{rest.split(end)[1]}"


def keep(found, results, page, block):
    """Write what was found to its results file, and its block to the page."""
    results.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    page.write_text(with_block(page.read_text(encoding="utf-8"), results.name, block(found)), encoding="utf-8")
