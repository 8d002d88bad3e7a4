"""Programs that make the absorption data, in a checkout: ``python -m mat.maintain.lines generate|broadband``."""

from __future__ import annotations

import click

from skyshine.schemas.commands import emit_json, json_option, progress
from skyshine.schemas.quantity import quantity


@click.group()
def main() -> None:
    """Generate lines, choose the points of broadband fluxes."""


@main.command()
@click.option("--out", required=True, type=click.Path(), help="The folder to write; it is made where it is missing.")
def generate(out: str) -> None:
    """Compute lines of ozone and nitrous oxide from published constants and band strengths.

    Writes HITRAN records and a table of their bands and sources. About a minute.

    \b
    Example:
      python -m mat.maintain.lines generate --out generated
    """
    from pathlib import Path

    from mat.maintain.lines.rotors.records import write_all

    for path in write_all(Path(out)):
        click.echo(path)


@main.command()
@click.option("--table", type=click.Path(), help="Absorption table to choose from; default: the packaged one.")
@click.option(
    "--points",
    default=96,
    show_default=True,
    type=click.IntRange(1, 512),
    help="Most points for each set.",
)
@click.option(
    "--tolerance",
    default=0.0125,
    show_default=True,
    help="Rms error of fluxes, W m-2 and percent, at which fewer points do.",
)
@click.option("--out", required=True, type=click.Path(), help="The file to write.")
@json_option
def broadband(table: str | None, points: int, tolerance: float, out: str, as_json: bool) -> None:
    """Choose the points for broadband longwave and shortwave fluxes from an absorption table.

    \b
    Example:
      python -m mat.maintain.lines broadband --out broadband.h5
    """
    from mat.maintain.lines.broadband import build
    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable

    with progress(6, "stages") as advance:
        result = build(
            out, AbsorptionTable.open(table), tolerance=tolerance, max_points=points, progress=lambda: advance(1)
        )
    if as_json:
        errors = {
            name: {key: quantity(value, "W m-2") for key, value in error.items()}
            for name, error in result["errors"].items()
        }
        emit_json({"file": str(out), "points": result["points"], "errors": errors})
        return
    click.echo(f"{out}: " + ", ".join(f"{count} points {name}" for name, count in result["points"].items()))
    for name, error in result["errors"].items():
        click.echo(
            f"  {name}: rms {error['rms']:.2g}, largest {error['max']:.2g} W m-2 on states not used in the choice"
        )


if __name__ == "__main__":
    main()
