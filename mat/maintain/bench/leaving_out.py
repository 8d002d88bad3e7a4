"""``python -m mat.maintain.bench.leaving_out``: the omissions of a job, measured against a build without them."""

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.quantity import quantity


@click.command()
@click.argument("job", type=click.Path())
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Of the places that are read.")
@json_option
def leaving_out(job: str, seed: int, as_json: bool) -> None:
    """Build JOB with and without its omissions, and compare processor time, bytes and values read inside its limits.

    Of atmospheres 98 % of the reads count: both files keep their tolerance in 99 %.

    \b
    Example:
      python -m mat.maintain.bench.leaving_out demo/job.yaml
    """
    import os
    import tempfile
    from pathlib import Path

    from mat.maintain.bench.omissions import compare
    from skyshine.mat.job.load import load_job

    loaded = load_job(job)
    loaded.refuse_without_bands()
    os.environ["SKYSHINE_CACHE"] = ""  # without a cache, or the second build would use the bands of the first
    with tempfile.TemporaryDirectory() as folder:
        comparison = compare(loaded, Path(folder), seed)
    if as_json:
        emit_json(
            {
                "differences": {
                    name: {"largest": value, "bound": bound} for name, (value, bound) in comparison.differences.items()
                },
                **{
                    name: {"time": quantity(cost.seconds, "s"), "size": quantity(cost.size, "byte")}
                    for name, cost in (("as_it_is", comparison.trimmed), ("whole", comparison.full))
                },
            }
        )
    else:
        rows = [
            (name, f"{cost.seconds:.2f}", f"{cost.size / 1e6:.2f}")
            for name, cost in (("as it is", comparison.trimmed), ("whole", comparison.full))
        ]
        echo_table(("build", "processor seconds", "MB"), rows)
        echo_table(
            ("difference", "found", "bound"),
            [(n, f"{a:.2g}", f"{b:g}") for n, (a, b) in comparison.differences.items()],
        )
    exceeded = [name for name, (value, bound) in comparison.differences.items() if not value <= bound]
    if exceeded:
        raise CheckFailed(f"answers differ by more than stated: {', '.join(exceeded)}")


if __name__ == "__main__":
    leaving_out()
