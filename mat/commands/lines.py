"""``mat lines``: the band model from line lists."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import emit_json, json_option, progress
from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable


@click.group("lines", epilog="Example: mat lines info --json")
def command() -> None:
    """Band model from line lists: build the absorption table, or show what a table contains."""


def _ranges(_context: click.Context, _parameter: click.Parameter, texts: tuple[str, ...]) -> list[tuple[float, float]]:
    """Limits LO:HI of each option."""
    pairs = []
    for text in texts:
        try:
            low, high = (plain_number(part) for part in text.split(":"))
        except ValueError:
            raise InputError(f"--wavenumber '{text}' is not a range; give LO:HI in cm-1, e.g. 750:1300") from None
        pairs.append((low, high))
    return pairs


@command.command()
@click.option(
    "--lines", required=True, type=click.Path(), help="Folder of HITRAN 160-column records (01_*.par[.gz|.xz] ...)."
)
@click.option(
    "--continua",
    required=True,
    type=click.Path(),
    help="Folder of the MT_CKD netCDF files and their notice, or lowtran7 for the packaged ones of LOWTRAN7.",
)
@click.option("--lookups", type=click.Path(), help="Folder of REPTRAN lookups, for O3 and N2O in ranges without lines.")
@click.option("--lowtran", type=click.Path(), help="File lowtran7.f; it gives the lookups their shape within a band.")
@click.option(
    "--generated",
    type=click.Path(),
    help="Folder of lines from constants, for O3 and N2O where --lines has none.",
)
@click.option("--cross-sections", type=click.Path(), help="Folder of measured cross sections (xs/*.gz, crs_*.dat.gz).")
@click.option(
    "--wavenumber",
    "ranges",
    required=True,
    multiple=True,
    callback=_ranges,
    help="Wavenumber range LO:HI in cm-1; may be repeated.",
)
@click.option(
    "--points", default=16, show_default=True, type=click.IntRange(1, 64), help="Maximum number of points per interval."
)
@click.option("--tolerance", default=4e-4, show_default=True, help="Error below which fewer points are used.")
@click.option(
    "--width",
    type=float,
    help="Width of all intervals, cm-1, a multiple of 0.125, with reference spectra; default: 5 to 100.",
)
@click.option("--parts", type=click.Path(), help="Folder of finished intervals; default: OUT.parts.")
@click.option("--out", required=True, type=click.Path(), help="Table file to write.")
def build(
    lines: str,
    continua: str,
    lookups: str | None,
    lowtran: str | None,
    generated: str | None,
    cross_sections: str | None,
    ranges: list[tuple[float, float]],
    points: int,
    tolerance: float,
    width: float | None,
    parts: str | None,
    out: str,
) -> None:
    """Build an absorption table from line lists.

    Finished intervals are kept in a folder beside the table; the same command resumes an interrupted build, and several
    processes may share that folder. About 2 s an interval. Gases of --cross-sections are added at the points of
    finished intervals, which takes seconds.

    \b
    Example:
      mat lines build --lines hitran --continua mt_ckd --cross-sections xs --wavenumber 10:33400 --out absorption.h5
    """
    from skyshine.mat.spectroscopy.table import Settings, build
    from skyshine.mat.spectroscopy.widths import interval_edges

    total = len({low for pair in ranges for low, _ in interval_edges(*pair, width)})
    with progress(total, "intervals") as advance:
        digest = build(
            ranges,
            out,
            lines,
            continua,
            lookups=lookups,
            lowtran=lowtran,
            cross_sections=cross_sections,
            generated=generated,
            parts=parts,
            settings=Settings(tolerance=tolerance, max_points=points, width=width),
            progress=lambda *_: advance(1),
        )
    click.echo(f"{out}: {total} intervals, content {digest[:16]}")


@command.command()
@click.argument("file", required=False, type=click.Path())
@json_option
def info(file: str | None, as_json: bool) -> None:
    """Show coverage, gases, provenance and errors of an absorption table (default: the packaged one).

    \b
    Example:
      mat lines info --json
    """
    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable

    table = AbsorptionTable.open(file)
    about = describe(table)
    if as_json:
        emit_json(about)
        return
    click.echo(f"{about['file']}\n{about['data_name']}, version {about['data_version']}")
    click.echo(f"{about['intervals']} intervals, {about['points']} points")
    click.echo("coverage " + ", ".join(f"{low:g}-{high:g}" for low, high in about["coverage"]["values"]) + " cm-1")
    rms, largest = about["error"]["rms"]["value"], about["error"]["largest"]["value"]
    click.echo(
        f"error of an interval's transmittance on an unseen profile and paths: rms {rms:.2g}, largest {largest:.2g}"
    )
    for part in about["regions"]:
        low, high = part["range"]["values"]
        click.echo(
            f"  {low:g}-{high:g} cm-1: intervals of {part['width']['value']:g} cm-1 with"
            f" {part['points_per_interval']:.1f} points, rms {part['rms']['value']:.2g}, largest"
            f" {part['largest']['value']:.2g}"
        )
    for name, gas in about["gases"].items():
        click.echo(f"{name}: rms error alone {gas['rms_error']['value']:.2g}")
        ranges: dict[str, list[str]] = {}
        for low, high, text in gas["provenance"]:
            ranges.setdefault(text, []).append(f"{low:g}-{high:g}")
        for text in sorted(set(ranges) - {"negligible"}):
            click.echo(f"  {text}:\n    {', '.join(ranges[text])}")
        for text in gas["terms"]:
            click.echo(f"  terms: {text}")


def describe(table: AbsorptionTable) -> dict[str, Any]:
    """Content of an absorption table as plain values."""
    import numpy as np

    gases = {}
    for name in table.gases:
        error = table.gas_error(name)
        rms = float(np.sqrt(np.mean(error[error > 0] ** 2))) if np.any(error > 0) else 0.0
        gases[name] = {
            "rms_error": quantity(rms, "1"),
            "provenance": table.provenance(name),
            "terms": table.terms(name),
        }
    return {
        "file": str(table.path),
        "data_version": table.version,
        "data_name": table.name,
        "coverage": quantity(table.coverage, "cm-1"),
        "intervals": len(table.interval_edges),
        "points": table.size,
        "error": {
            "rms": quantity(float(np.sqrt(np.mean(table.error[:, 0] ** 2))), "1"),
            "largest": quantity(float(table.error[:, 1].max()), "1"),
        },
        "regions": _regions(table),
        "gases": gases,
    }


def _regions(table: AbsorptionTable) -> list[dict[str, Any]]:
    """Points and errors of successive intervals of one width."""
    import numpy as np

    low, high = table.interval_edges.T
    starts = np.flatnonzero(np.append(True, np.abs(np.diff(high - low)) > 1e-3))
    parts = []
    for start, stop in zip(starts, np.append(starts[1:], low.size), strict=True):
        inside = slice(start, stop)
        parts.append(
            {
                "range": quantity([low[start], high[stop - 1]], "cm-1"),
                "width": quantity(high[start] - low[start], "cm-1"),
                "points_per_interval": float(table.count[inside].mean()),
                "rms": quantity(float(np.sqrt(np.mean(table.error[inside, 0] ** 2))), "1"),
                "largest": quantity(float(table.error[inside, 1].max()), "1"),
            }
        )
    return parts
