"""Error against run time of the direct computation of atmospheric quantities.

python tests/bench/atmosphere.py --quick
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from atmosphere_ladder import AtmosphereBench


@click.command()
@click.option(
    "--out", type=click.Path(file_okay=False), help="Folder for atmosphere-bench.json and atmosphere-bench.png."
)
@click.option("--quick", is_flag=True, help="One narrow band instead of 3-5 and 8-12 um.")
@json_option
def atmosphere(out: str | None, quick: bool, as_json: bool) -> None:
    """Error against run time of atmospheric quantities, by spectral points, directions of the sky, layers and streams.

    \b
    Example:
      python tests/bench/atmosphere.py --quick
    """
    import atmosphere_ladder as bench
    import ladders

    bands = bench.QUICK_BANDS if quick else bench.BANDS
    with progress(4 * len(bands), "measuring") as advance:
        measured = [bench.bench_band(name, limits, advance=advance) for name, limits in bands.items()]
    result = {"atmosphere": bench.PROFILE, "bands": {band.band: describe(band) for band in measured}}
    if out:
        ladders.write_measured(
            Path(out) / "atmosphere-bench.json", result, lambda picture: bench.plot(measured, picture)
        )
    if as_json:
        emit_json(result)
        return
    for band in measured:
        _print(band)


def describe(bench: AtmosphereBench) -> dict[str, Any]:
    """Ladders of a band as plain values."""
    return {
        "points": bench.points,
        "total_points": bench.total_points,
        "ladders": {
            name: [
                {
                    "name": rung.name,
                    "time": quantity(rung.seconds, "s"),
                    "errors_rms": {kind: quantity(error, "1") for kind, error in rung.errors.items()},
                }
                for rung in rungs
            ]
            for name, rungs in bench.ladders.items()
        },
    }


def _print(bench: AtmosphereBench) -> None:
    click.echo(f"{bench.band}: {bench.points} of {bench.total_points} points")
    for name, rungs in bench.ladders.items():
        header = [name, "time s", *(f"{kind} rms %" for kind in rungs[0].errors)]
        echo_table(
            header, [[r.name, f"{r.seconds:.3g}", *(f"{100 * e:.2g}" for e in r.errors.values())] for r in rungs]
        )


if __name__ == "__main__":
    atmosphere()
