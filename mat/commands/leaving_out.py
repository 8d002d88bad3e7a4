"""``mat bench leaving-out``: what a job leaves out, measured against the whole."""

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.quantity import quantity


@click.command("leaving-out")
@click.argument("job", type=click.Path())
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Of the places that are read.")
@json_option
def leaving_out(job, seed, as_json):
    """Build JOB as it is and whole, and compare: processor time, bytes, and every answer within what it needs.

    \b
    Example:
      mat bench leaving-out demo/job.yaml
    """
    import os
    import tempfile
    from pathlib import Path

    from skyshine.mat.bench.leaving_out import compare
    from skyshine.mat.job.load import load_job

    loaded = load_job(job)
    os.environ["SKYSHINE_CACHE"] = ""  # or the second build would find what the first has compiled
    with tempfile.TemporaryDirectory() as folder:
        found = compare(loaded, Path(folder), seed)
    if as_json:
        emit_json(
            {
                "differences": {
                    name: {"largest": value, "bound": bound} for name, (value, bound) in found.differences.items()
                },
                **{
                    name: {"time": quantity(cost.seconds, "s"), "size": quantity(cost.size, "byte")}
                    for name, cost in (("as_it_is", found.kept), ("whole", found.whole))
                },
            }
        )
    else:
        rows = [
            (name, f"{cost.seconds:.2f}", f"{cost.size / 1e6:.2f}")
            for name, cost in (("as it is", found.kept), ("whole", found.whole))
        ]
        echo_table(("build", "processor seconds", "MB"), rows)
        echo_table(
            ("largest difference", "found", "bound"),
            [(n, f"{a:.2g}", f"{b:g}") for n, (a, b) in found.differences.items()],
        )
    beyond = [name for name, (value, bound) in found.differences.items() if not value <= bound]
    if beyond:
        raise CheckFailed(f"answers differ by more than stated: {', '.join(beyond)}")
