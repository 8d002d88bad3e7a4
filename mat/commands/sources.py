"""`mat materials sources`: sources of the numbers of the library."""

from __future__ import annotations

from collections import Counter

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option


@click.command("sources", epilog="Example: mat materials sources")
@json_option
def sources(as_json: bool) -> None:
    """Count the values of all materials by field and kind of source.

    cited: a reference; derived: from other numbers of the file or a cited law; definition: what the stack represents;
    estimate: no measurement available; user: a plain number of your own files. Spectra have origins by range and do not
    count.
    """
    from skyshine.materials.library import load_library
    from skyshine.materials.sources import KINDS, count_kinds

    library = load_library()
    counts = count_kinds(library)
    total = sum(counts.values(), Counter())
    if as_json:
        by_field = {field: {kind: count[kind] for kind in KINDS} for field, count in counts.items()}
        result = {"data_version": library.version, "materials": len(library), "fields": by_field}
        emit_json(result | {"total": {kind: total[kind] for kind in KINDS}})
        return
    rows = [[field, *(str(count[kind]) for kind in KINDS)] for field, count in counts.items()]
    rows.append(["all", *(str(total[kind]) for kind in KINDS)])
    echo_table(["field", *KINDS], rows)
