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

    library, known = load_library(), load_handbooks()
    listed = {name for row in known.rows for name in row.materials}
    values = {name: material_summary(library[name]) for name in library.names if name in listed}
    found = compare(known, values)
    if as_json:
        emit_json({"data_version": library.version, "comparisons": [_comparison(each) for each in found]})
    elif page:
        write_whole(page, _handbook_page(library, found))
        click.echo(page)
    else:
        for each in found:
            place = "within" if each.within else f"outside: {each.reason or 'no reason given'}"
            click.echo(f"{each.material:<30} {each.quantity:<18} {each.value:5.2f}  {_span(each):<12} {place}")
        click.echo(f"{sum(each.within for each in found)} of {len(found)} within")


def _span(each: Comparison) -> str:
    return f"{each.lower:.2f}" if each.lower == each.upper else f"{each.lower:.2f} to {each.upper:.2f}"


def _comparison(each: Comparison) -> dict[str, Any]:
    return {
        "material": each.material,
        "quantity": each.quantity,
        "value": each.value,
        "range": [each.lower, each.upper],
        "within": each.within,
        "handbooks": [{"handbook": row.handbook, "row": row.row, "checked": row.checked} for row in each.rows],
        "reason": each.reason,
    }


def _handbook_page(library: MaterialLibrary, found: list[Comparison]) -> str:
    within, twice = sum(each.within for each in found), sum(each.checked >= 2 for each in found)
    lines = [
        "# Materials beside handbooks",
        "",
        f"Written by `mat materials handbooks --page`, library {library.version}. Solar absorptance is weighted by",
        "sunlight at the ground (ASTM G173), emissivity by blackbody radiation of 300 K. A range spans all handbooks",
        "that list the material; values within 0.05 of it count as within, because handbooks round and a sample is one",
        "of many. Numbers in parentheses are recalled and were not checked in the book.",
        f"{within} of {len(found)} numbers lie within; {twice} are compared with two handbooks or more.",
        "",
        "| material | quantity | library | handbooks | | what they list |",
        "|---|---|---|---|---|---|",
    ]
    for each in found:
        rows = "; ".join(
            f"[{row.handbook}] {row.row}" if row.checked else f"([{row.handbook}] {row.row})" for row in each.rows
        )
        mark = "" if each.within else f"**outside**: {each.reason}"
        name = each.quantity.replace("_", " ")
        lines.append(f"| `{each.material}` | {name} | {each.value:.2f} | {_span(each)} | {mark} | {rows} |")
    cited = dict.fromkeys(row.handbook for each in found for row in each.rows)
    lines += ["", "## References", "", *(f"- [{key}] {library.references[key]}" for key in cited)]
    return "\n".join(lines) + "\n"
