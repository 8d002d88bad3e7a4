"""``mat bench parts``: the ladder of every part of the tool."""

from __future__ import annotations

import time
from pathlib import Path

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress, write_measured


@click.command("parts")
@click.option("--out", type=click.Path(file_okay=False), help="Folder for bench.json and bench.png.")
@click.option("--quick", is_flag=True, help="Narrow bands and few materials: within three minutes on two cores.")
@json_option
def parts(quick: bool, out: str | None, as_json: bool) -> None:
    """Every part of the tool by itself: settings, their errors in its own unit and run times, and its default.

    \b
    Example:
      mat bench parts --quick --out bench
    """
    from skyshine.mat.bench import whole as bench

    chosen = bench.parts(quick)
    ladders, seconds = [], {}
    with progress(len(chosen), "measuring") as advance:
        for name, measure in chosen.items():
            begin = time.monotonic()
            ladders += measure()
            seconds[name] = time.monotonic() - begin
            advance(1)
    result = bench.describe(ladders, seconds)
    if out:
        write_measured(Path(out) / "bench.json", result, lambda picture: bench.plot(ladders, picture))
    if as_json:
        emit_json(result)
        return
    for ladder in ladders:
        best = ladder.pareto()
        click.echo(f"{ladder.name}: error is {ladder.units}, time for {ladder.work}; default because {ladder.why}")
        rows = [
            (
                rung.name,
                f"{rung.seconds:.3g}",
                f"{rung.error:.3g}",
                "yes" if rung in best else "",
                "default" if rung.default else "",
            )
            for rung in ladder.rungs
        ]
        echo_table(("setting", "seconds", "error", "best of its time", ""), rows)
    click.echo(", ".join(f"{name} {spent:.0f} s" for name, spent in seconds.items()))
