"""``mat report``: the error budget of a built database."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.errors import InputError


@click.command(epilog="Example: mat report demo/job.yaml --out report.html")
@click.argument("job", metavar="JOB|DIR", type=click.Path())
@click.option(
    "--built", type=click.Path(file_okay=False), help="Folder of the databases; by default the one that the job names."
)
@click.option("--out", type=click.Path(dir_okay=False), help="HTML page to write; its numbers go beside it as JSON.")
@click.option(
    "--scenes",
    type=click.IntRange(1, 10_000),
    default=40,
    show_default=True,
    help="Random views of each set of tables.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Of the random views.")
@click.option("--band", type=click.IntRange(1), default=None, help="One band, counted from 1; by default all.")
@json_option
def command(job, built, out, scenes, seed, band, as_json) -> None:
    """Measure the error budget of the databases of JOB, or of the folder DIR that holds a job.yaml.

    Random scenes go through the runtime's equations with the tables, and through the accurate spectral integrals; each
    source of error is switched on alone, then all together.
    """
    from skyshine.mat.job.load import load_job
    from skyshine.mat.report.budget import Prepared, error_budget
    from skyshine.mat.report.page import render
    from skyshine.mat.report.summary import describe_all
    from skyshine.materials.library import load_library

    loaded, library = load_job(_job_file(job)), load_library()
    folder = Path(built) if built else loaded.output_folder
    bands = loaded.trimmed.needed_bands
    if band is not None and band not in bands:
        raise InputError(f"found --band {band}; allowed: {', '.join(map(str, bands))}, the bands that the job builds")
    sets = list(product(range(1, len(loaded.trimmed.states) + 1), bands if band is None else [band]))
    budgets, notes = [], []
    with progress(len(sets) * len(loaded.trimmed.sources), "measuring") as advance:
        for state, number in sets:
            prepared = Prepared.of(loaded, state, number)
            for source in loaded.trimmed.sources:
                found = error_budget(prepared, folder, library, source=source, scenes=scenes, seed=seed)
                if found is None:
                    notes.append(
                        f"State {state}, band {number}: no view has the {source} above the horizon on the tables' axes."
                    )
                else:
                    budgets.append(found)
                advance(1)
    report = describe_all(budgets, notes, job=loaded.trimmed.name, seed=seed)
    if out:
        _write(Path(out), report, render(report, budgets))
    if as_json:
        emit_json(report)
    else:
        _print(report)


def _job_file(given: str) -> Path:
    path = Path(given)
    if path.suffix == ".h5":
        raise InputError(
            "is a database; name the job that it was built with, or the folder that holds its job.yaml", file=path
        )
    if not path.is_dir():
        return path
    for folder in (path, path.parent):
        if (folder / "job.yaml").is_file():
            return folder / "job.yaml"
    raise InputError("holds no job.yaml; name the job's file, and --built for another folder of databases", file=path)


def _write(page: Path, report: dict, text: str) -> None:
    import json

    try:
        page.parent.mkdir(parents=True, exist_ok=True)
        page.write_text(text, encoding="utf-8")
        page.with_suffix(".json").write_text(json.dumps(report, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another place", file=page) from None


def _print(report: dict) -> None:
    for budget in report["budgets"]:
        low, high = budget["wavelength"]["values"]
        click.echo(f"state {budget['state']}, {low:g} to {high:g} um, {budget['source']}: {budget['views']} views")
        rows = [
            (
                error["what"],
                *(_number(error["temperature"][key]["value"]) for key in ("rms", "p95", "maximum")),
                *(_number(error["radiance"][key]["value"]) for key in ("rms", "p95", "maximum")),
            )
            for error in budget["errors"].values()
        ]
        echo_table(("source of error", "rms K", "p95 K", "max K", "rms W m^-2 sr^-1", "p95", "max"), rows)
    for note in report["notes"]:
        click.echo(note)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
