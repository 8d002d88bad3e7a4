"""``mat bench stability``: random extreme cases for a given time."""

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.quantity import quantity


@click.command()
@click.option(
    "--seconds", type=click.FloatRange(0.0, 1e6), default=60.0, show_default=True, help="How long to draw cases."
)
@click.option(
    "--seed", type=click.IntRange(0), default=1, show_default=True, help="Case k is drawn from seed and k alone."
)
@json_option
def stability(seconds: float, seed: int, as_json: bool) -> None:
    """Extreme and stiff cases of surface, air, sky, bands, lobes, tables and textures, at random for a given time.

    Reports the worst residual and violation of a bound, and the slowest case; anything not finite or out of bounds
    fails.

    \b
    Example:
      mat bench stability --seconds 60 --seed 3
    """
    from skyshine.mat.bench import stability as suite

    trials = suite.run(seconds, seed)
    if as_json:
        emit_json(
            {
                name: {
                    "cases": trial.cases,
                    "failures": trial.failures,
                    "worst": {
                        measure: value if value < float("inf") else None for measure, value in trial.worst.items()
                    },
                    "slowest": quantity(trial.slowest, "s"),
                    "slowest_case": trial.slowest_case,
                }
                for name, trial in trials.items()
            }
        )
    else:
        for name, trial in trials.items():
            click.echo(f"{name}: {trial.cases} cases, slowest {trial.slowest:.2g} s ({trial.slowest_case})")
            echo_table(("worst", "value"), [(measure, f"{value:.3g}") for measure, value in trial.worst.items()])
    failures = [failure for trial in trials.values() for failure in trial.failures]
    if failures:
        raise CheckFailed(f"{len(failures)} cases failed, the first: {failures[0]}")
