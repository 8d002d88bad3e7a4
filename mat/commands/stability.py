"""``mat bench stability``: random extreme cases for a given time."""

from collections.abc import Iterable
from pathlib import Path

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.quantity import quantity


@click.command()
@click.option(
    "--seconds", type=click.FloatRange(0.0, 1e6), default=60.0, show_default=True, help="Duration of the run."
)
@click.option(
    "--seed",
    type=click.IntRange(0),
    default=1,
    show_default=True,
    help="Seed of the cases; case k depends only on seed and k.",
)
@click.option("--case", "case", metavar="PART:K", help="Number of one case to run again, as a report states it.")
@click.option(
    "--drawn",
    type=click.Path(file_okay=False),
    help="Folder for the drawn jobs, as YAML for 'mat build'.",
)
@json_option
def stability(seconds: float, seed: int, case: str | None, drawn: str | None, as_json: bool) -> None:
    """Run extreme and stiff cases of surface, air, whole jobs, bands, tables and textures, at random for a given time.

    The parts share the time evenly, whatever a case of each costs. Reports the worst residual and violation of a bound,
    and the slowest case; anything not finite or out of bounds fails, with the options that run the case again.

    \b
    Examples:
      mat bench stability --seconds 60 --seed 3
      mat bench stability --seed 3 --case job:12 --drawn jobs
    """
    from skyshine.mat.bench import stability as suite

    if case is None:
        trials = suite.run(seconds, seed)
        numbers = range(trials["job"].cases)
    else:
        name, _, text = case.partition(":")
        if not (text.isascii() and text.isdecimal()):
            raise InputError(f"found --case '{case}'; allowed: PART:K, such as job:12")
        trials = {name: suite.replay(name, int(text), seed)}
        numbers = range(int(text), int(text) + (name == "job"))
    if drawn is not None:
        _write_jobs(Path(drawn), seed, numbers)
    if as_json:
        emit_json(
            {
                name: {
                    "cases": trial.cases,
                    "failures": trial.failures,
                    "worst": {
                        measure: value if value < float("inf") else None for measure, value in trial.largest.items()
                    },
                    "time": quantity(trial.seconds, "s"),
                    "slowest": quantity(trial.slowest, "s"),
                    "slowest_case": trial.slowest_case,
                }
                for name, trial in trials.items()
            }
        )
    else:
        for name, trial in trials.items():
            click.echo(
                f"{name}: {trial.cases} cases in {trial.seconds:.0f} s,"
                f" slowest {trial.slowest:.2g} s ({trial.slowest_case})"
            )
            echo_table(("worst", "value"), [(measure, f"{value:.3g}") for measure, value in trial.largest.items()])
    failures = [failure for trial in trials.values() for failure in trial.failures]
    if failures:
        raise CheckFailed(f"{len(failures)} cases failed, the first: {failures[0]}")


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
