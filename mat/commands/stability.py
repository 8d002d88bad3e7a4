"""``mat bench stability``: random extreme cases for a given time."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import CheckFailed, InputError

_TIMES = ("time", "slowest")  # keys of a kind


@click.command()
@click.option(
    "--seconds", type=click.FloatRange(0.0, 1e6), default=60.0, show_default=True, help="Processor time of the run."
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of the cases; case k depends only on seed and k.",
)
@click.option(
    "--case", "case", metavar="KIND:K", help="Kind and number of one case to run again, as a report states them."
)
@click.option(
    "--drawn",
    type=click.Path(file_okay=False),
    help="Folder for the drawn jobs, as YAML for 'mat build'.",
)
@json_option
def stability(seconds: float, seed: int, case: str | None, drawn: str | None, as_json: bool) -> None:
    """Run extreme and stiff cases of surface, air, whole jobs, bands, tables and textures, at random for a given time.

    One case of each kind runs, then five of each, the cheapest kinds first; then the kinds share the time evenly.
    Prints value, limit and margin of the worst case of each kind and measure, the worst first, with the line that runs
    it again; --json lists every case. Anything not finite or beyond its limit fails.

    \b
    Examples:
      mat bench stability --seconds 60 --seed 3
      mat bench stability --seed 3 --case job:12 --drawn jobs
    """
    from skyshine.mat.bench import stability as suite

    if case is None:
        cases = suite.run(seconds, seed)
        numbers = [item.number for item in cases if item.kind == "job"]
    else:
        kind, _, text = case.partition(":")
        if not (text.isascii() and text.isdecimal()):
            raise InputError(f"found --case '{case}'; allowed: KIND:K, such as job:12")
        cases = [suite.replay(kind, int(text), seed)]
        numbers = [int(text)] if kind == "job" else []
    if drawn is not None:
        _write_jobs(Path(drawn), seed, numbers)
    result = suite.described(cases, seed)
    if as_json:
        emit_json(result)
    else:
        _print(result)
    failures = [failure for item in cases for failure in item.failures]
    if failures:
        raise CheckFailed(f"{len(failures)} cases failed, the first: {failures[0]}")


def _print(result: dict[str, Any]) -> None:
    """The worst case of each kind and measure, the worst first; then how many cases of each kind ran."""
    rows = [
        (
            item["kind"],
            item["measure"],
            "not finite" if item["value"] is None else f"{item['value']:.3g}",
            f"{item['limit']:.3g}",
            "" if item["margin"] is None else f"{item['margin']:.3g}",
            item["again"],
        )
        for item in result["worst"]
    ]
    echo_table(("kind", "measure", "value", "limit", "margin", "run again"), rows)
    kinds = [
        (kind, str(of_kind["cases"]), str(of_kind["refused"]), *(f"{of_kind[key]['value']:.2g}" for key in _TIMES))
        for kind, of_kind in result["kinds"].items()
    ]
    echo_table(("kind", "cases", "rightly refused", "processor s", "slowest"), kinds)


def _write_jobs(folder: Path, seed: int, numbers: Iterable[int]) -> None:
    """Write the jobs of these cases, each drawn again from its seed and number."""
    import numpy as np
    import yaml

    from skyshine.mat.bench.extreme_jobs import random_job

    try:
        folder.mkdir(parents=True, exist_ok=True)
        for number in numbers:
            job = random_job(np.random.default_rng([seed, number]))
            text = yaml.safe_dump(job, sort_keys=False)
            (folder / f"job-{seed}-{number}.yaml").write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror}; name another place", file=folder) from None
