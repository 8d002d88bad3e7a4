"""`mat materials handbooks`: the library beside the ranges of handbooks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.whole_files import write_whole

if TYPE_CHECKING:
    from skyshine.materials.handbooks import Comparison
    from skyshine.materials.library import MaterialLibrary


@click.command("handbooks", epilog="Example: mat materials handbooks --page handbooks.md")
@click.option("--page", type=click.Path(dir_okay=False, path_type=Path), help="Write the table as a page in Markdown.")
@json_option
def handbooks(page: Path | None, as_json: bool) -> None:
    """Put solar absorptance and thermal emissivity of the materials beside the ranges of handbooks.

    A value is outside where it misses the range of all handbooks that list the material by more than 0.05.
    """
    from skyshine.mat.scene.material_summary import material_summary
    from skyshine.materials.handbooks import compare, load_handbooks
    from skyshine.materials.library import load_library

    library, handbook_rows = load_library(), load_handbooks()
    listed = {name for row in handbook_rows.rows for name in row.materials}
    values = {name: material_summary(library[name]) for name in library.names if name in listed}
    comparisons = compare(handbook_rows, values)
    if as_json:
        emit_json(
            {"data_version": library.version, "comparisons": [_comparison(comparison) for comparison in comparisons]}
        )
    elif page:
        write_whole(page, _handbook_page(library, comparisons))
        click.echo(page)
    else:
        for comparison in comparisons:
            verdict = "within" if comparison.within else f"outside: {comparison.reason or 'no reason given'}"
            click.echo(
                f"{comparison.material:<30} {comparison.quantity:<18} {comparison.value:5.2f}  "
                f"{_span(comparison):<12} {verdict}"
            )
        click.echo(f"{sum(comparison.within for comparison in comparisons)} of {len(comparisons)} within")


def _span(comparison: Comparison) -> str:
    return (
        f"{comparison.lower:.2f}"
        if comparison.lower == comparison.upper
        else f"{comparison.lower:.2f} to {comparison.upper:.2f}"
    )


def _comparison(comparison: Comparison) -> dict[str, Any]:
    return {
        "material": comparison.material,
        "quantity": comparison.quantity,
        "value": comparison.value,
        "range": [comparison.lower, comparison.upper],
        "within": comparison.within,
        "handbooks": [{"handbook": row.handbook, "row": row.row, "checked": row.checked} for row in comparison.rows],
        "reason": comparison.reason,
    }


def _handbook_page(library: MaterialLibrary, comparisons: list[Comparison]) -> str:
    within, twice = (
        sum(comparison.within for comparison in comparisons),
        sum(comparison.checked >= 2 for comparison in comparisons),
    )
    lines = [
        "# Materials beside handbooks",
        "",
        f"Written by `mat materials handbooks --page`, library {library.version}. Solar absorptance is weighted by",
        "sunlight at the ground (ASTM G173), emissivity by blackbody radiation of 300 K. A range spans all handbooks",
        "that list the material; values within 0.05 of it count as within, because handbooks round and a sample is one",
        "of many. Numbers in parentheses are recalled and were not checked in the book.",
        f"{within} of {len(comparisons)} numbers lie within; {twice} are compared with two handbooks or more.",
        "",
        "| material | quantity | library | handbooks | | what they list |",
        "|---|---|---|---|---|---|",
    ]
    for comparison in comparisons:
        rows = "; ".join(
            f"[{row.handbook}] {row.row}" if row.checked else f"([{row.handbook}] {row.row})" for row in comparison.rows
        )
        mark = "" if comparison.within else f"**outside**: {comparison.reason}"
        name = comparison.quantity.replace("_", " ")
        lines.append(
            f"| `{comparison.material}` | {name} | {comparison.value:.2f} | {_span(comparison)} | {mark} | {rows} |"
        )
    cited = dict.fromkeys(row.handbook for comparison in comparisons for row in comparison.rows)
    lines += ["", "## References", "", *(f"- [{key}] {library.references[key]}" for key in cited)]
    return "\n".join(lines) + "\n"
