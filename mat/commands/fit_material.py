"""`mat materials fit`: parameters of a material from a measured record."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.model_options import model_options
from skyshine.mat.job.own_materials import OwnMaterial
from skyshine.schemas.commands import echo_table, emit_json, json_option, progress
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    from skyshine.mat.api.fit_material import MaterialFit


@click.command(
    "fit",
    epilog="Example: mat materials fit --record roof.csv --material roof_membrane_black --free albedo,conductivity",
)
@click.option(
    "--record", required=True, type=click.Path(), metavar="CSV", help="Weather and measured skin temperature."
)
@click.option(
    "--material",
    shell_complete=completions.materials_or_files,
    required=True,
    metavar="NAME|FILE",
    help="Material with the start values and all fixed parameters.",
)
@click.option("--free", required=True, metavar="NAME,NAME...", help="Parameters to fit; see below.")
@click.option(
    "--held-out",
    default="0.25",
    show_default=True,
    metavar="SHARE|alternate",
    help="Share of the days, at the end, held out from the fit; or every second day.",
)
@click.option(
    "--spin-up",
    type=click.FloatRange(0),
    default=1.0,
    show_default=True,
    help="Initial days that the fit ignores (spin-up).",
)
@click.option("--name", metavar="NAME", help="Name of a new material to write with the fitted values.")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the material library to write into; by default MATERIALS_DATABASE.",
)
@model_options(OwnMaterial, {"absorptance": "absorptance", "emissivity": "emissivity"})
@json_option
def fit(
    record: str,
    material: str,
    free: str,
    held_out: str,
    spin_up: float,
    name: str | None,
    out: Path | None,
    absorptance: float | None,
    emissivity: float | None,
    as_json: bool,
) -> None:
    """Fit parameters of a material to a measured time series of its skin temperature.

    The record is a CSV as `mat temperature --forcing` takes it, of a level surface at equal steps over two days or
    more, with a column surface_temperature (K, or [C]), or lw_up (W/m2) from which it follows with the emissivity.
    Empty cells there do not count. Days are counted from the first reading.

    Parameters: albedo, emissivity, conductivity, heat_capacity, thickness (of the first layer), roughness_length,
    wetness, surface_resistance, back_temperature. Each has bounds. All intervals contain the truth with 99 %
    probability; parameters that the record does not determine are named.
    """
    from skyshine.mat.api.fit_material import fit_material
    from skyshine.mat.surface.fit import SEARCHES

    with progress(SEARCHES, "searching") as advance:
        result = fit_material(
            record,
            material,
            [parameter.strip() for parameter in free.split(",") if parameter.strip()],
            held_out=_share(held_out),
            spin_up=spin_up,
            absorptance=absorptance,
            emissivity=emissivity,
            name=name,
            out=out,
            advance=advance,
        )
    emit_json(result.to_dict()) if as_json else _print(result)


def _share(text: str) -> float | str:
    from skyshine.mat.surface.fit import ALTERNATE

    try:
        return text if text == ALTERNATE else float(text)
    except ValueError:
        raise InputError(f"--held-out: found '{text}'; allowed: 0 to less than 1, or '{ALTERNATE}'") from None


def _print(result: MaterialFit) -> None:
    click.echo(
        f"{result.material}: {int(result.fitted.sum())} readings, equivalent to "
        f"{result.effective_readings:.0f} independent ones"
    )
    rows = []
    for entry in result.parameters:
        units = "" if entry.units == "1" else entry.units
        numbers = (entry.start, entry.value, entry.standard_error, entry.low, entry.high, *entry.bounds)
        rows.append([entry.name, *(f"{number:.4g}" for number in numbers), units])
    echo_table(["parameter", "start", "fit", "std error", "99 % from", "to", "bound", "bound", "units"], rows)
    if len(result.parameters) > 1:
        names = [entry.name for entry in result.parameters]
        pairs = zip(names, result.correlation, strict=True)
        echo_table(["correlation", *names], [[name, *(f"{value:+.2f}" for value in row)] for name, row in pairs])
    rows = [
        [entry.part, entry.prediction, entry.hours, f"{entry.bias:+.2f}", f"{entry.rms:.2f}", str(entry.count)]
        for entry in result.errors
    ]
    echo_table(["days", "prediction", "hours", "bias K", "rms K", "readings"], rows)
    for note in result.notes:
        click.echo(note)
    if result.written:
        click.echo(f"{result.written.code}  {result.written.name}")
        for file in result.written.files:
            click.echo(f"  {file}")
        click.echo(f"use it with MATERIALS_DATABASE={result.written.folder.resolve()}")
