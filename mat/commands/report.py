"""``mat report``: the error budget of a built database."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import short


@click.command(epilog="Example: mat report demo/job.yaml --out report.html")
@click.argument("job", metavar="JOB|DIR", type=click.Path())
@click.option(
    "--built", type=click.Path(file_okay=False), help="Folder of the databases; by default the one that the job names."
)
@click.option(
    "--out", type=click.Path(dir_okay=False), help="HTML page to write; its numbers are written beside it as JSON."
)
@click.option(
    "--scenes",
    type=click.IntRange(1, 10_000),
    default=40,
    show_default=True,
    help="Number of random views of each set of tables.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Seed of the random views.")
@click.option("--band", metavar="NAME", help="Name of one band, b01 if the job gives no name; by default all bands.")
@json_option
def command(
    job: str, built: str | None, out: str | None, scenes: int, seed: int, band: str | None, as_json: bool
) -> None:
    """Measure the error budget of the databases of JOB, or of the folder DIR that contains a job.yaml.

    Random scenes, some of them in a shadow or beside a wall, go through the runtime's equations with the tables, and
    through the accurate spectral integrals with temperatures solved for each face; each source of error is switched on
    alone, then all together.
    """
    from skyshine.mat.api.report import report, step_count

    file = _job_file(job)
    with progress(step_count(file, band), "measuring") as advance:
        measured = report(file, built=built, scenes=scenes, seed=seed, band=band, advance=advance)
    if out:
        measured.write_html(out)
    if as_json:
        emit_json(measured.numbers)
    else:
        _print(measured.numbers)


def _job_file(text: str) -> Path:
    path = Path(text)
    if path.suffix == ".h5":
        raise InputError(
            "is a database; name the job that it was built with, or the folder that contains its job.yaml", file=path
        )
    if not path.is_dir():
        return path
    for folder in (path, path.parent):
        if (folder / "job.yaml").is_file():
            return folder / "job.yaml"
    raise InputError(
        "contains no job.yaml; name the job's file, and --built for another folder of databases", file=path
    )


def _print(report: dict[str, Any]) -> None:
    from skyshine.mat.budget.summary import by_size

    for budget in report["budgets"]:
        low, high = budget["wavelength"]["values"]
        click.echo(f"state {budget['state']}, {low:g} to {high:g} um, {budget['source']}: {budget['views']} views")
        rows = [
            (
                error["what"],
                *(short(error["temperature"][key]["value"]) for key in ("rms", "p99", "maximum")),
                *(short(error["radiance"][key]["value"]) for key in ("rms", "p99", "maximum")),
            )
            for error in (budget["errors"][name] for name in by_size(budget["errors"]))
        ]
        echo_table(("source of error", "rms K", "p99 K", "max K", "rms W m^-2 sr^-1", "p99", "max"), rows)
        click.echo(budget["dominant"])
    for note in report["notes"]:
        click.echo(note)
    click.echo(report["headline"])
