"""`mat materials new`: the files of a material of one's own."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands import completions
from skyshine.mat.commands.model_options import model_options
from skyshine.mat.job.own_materials import THERMAL, OwnMaterial, of_first_layer
from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.errors import InputError

UNITS = ["um", "nm", "angstrom", "m", "cm-1"]


@click.command(
    "new",
    epilog="Example: mat materials new hangar_roof --absorptance 0.32 --emissivity 0.87 --like paint_white_on_metal",
)
@click.argument("name")
@click.option(
    "--like",
    shell_complete=completions.materials,
    required=True,
    metavar="NAME",
    help="Base material for all unspecified properties.",
)
@model_options(OwnMaterial, {key: key for key in ("absorptance", "emissivity", *THERMAL)})
@click.option(
    "--spectrum",
    type=click.Path(path_type=Path),
    help="Spectrum file: ECOSTRESS, ASTER, USGS text, CSV or ENVI library.",
)
@click.option("--unit", type=click.Choice(UNITS), help="Unit of its first column, if the file does not state it.")
@click.option("--scale", type=click.Choice(["fraction", "percent"]), help="Scale of its values.")
@click.option("--quantity", type=click.Choice(["reflectance", "emissivity"]), help="Quantity of its values.")
@click.option("--wavelengths", type=click.Path(path_type=Path), help="File of the wavelengths of a USGS text file.")
@click.option("--record", help="Name of the spectrum in an ENVI library or a table of many.")
@click.option("--description", help="Description for the list of materials, one line.")
@click.option("--code", type=click.IntRange(1, 65535), help="Material code; by default the first free one from 1001.")
@click.option(
    "--out",
    type=click.Path(file_okay=False, path_type=Path),
    help="Folder of the material library to write into; by default MATERIALS_DATABASE.",
)
@json_option
def new(
    name: str,
    like: str,
    absorptance: float | None,
    emissivity: float | None,
    spectrum: Path | None,
    out: Path | None,
    description: str | None,
    code: int | None,
    as_json: bool,
    **options: object,
) -> None:
    """Write the files of a material NAME that is like one of the library but for the numbers or the spectrum given.

    Numbers are taken as they are; their source is "user". The spectrum applies in its own range, that of --like
    elsewhere. --absorptance scales it below 2.5 um. --emissivity is that of all wavelengths beyond, so of every band;
    with --spectrum, whose shape stays, it is the mean over radiation of 300 K.
    """
    from skyshine.mat.api.own_material import default_folder, new_material
    from skyshine.mat.scene.material_summary import material_summary
    from skyshine.materials.library import load_library
    from skyshine.materials.spectrum_files import Said, read_spectrum

    spectrum_options = Said(**{key: options[key] for key in ("unit", "scale", "quantity", "wavelengths", "record")})  # type: ignore[arg-type]
    if spectrum is None and spectrum_options != Said():
        raise InputError(
            "found --unit, --scale, --quantity, --wavelengths or --record without --spectrum; add the file"
        )
    read = read_spectrum(spectrum, spectrum_options) if spectrum else None
    thermal = {key: value for key in THERMAL if isinstance(value := options[key], float)}
    created = new_material(
        name,
        like=like,
        folder=out or default_folder(),
        absorptance=absorptance,
        emissivity=None if read else emissivity,
        thermal_emissivity=emissivity if read else None,
        spectrum=read,
        values=of_first_layer(thermal),
        description=description,
        code=code,
    )
    summary = material_summary(load_library(created.folder)[name])
    if as_json:
        files = [str(file) for file in created.files]
        emit_json({"name": name, "code": created.code, "files": files, "borrowed_um": created.borrowed, **summary})
        return
    if read:
        click.echo(f"read {read.read_as}: {read.wavelength[0]:g} to {read.wavelength[-1]:g} um")
        for lower, upper in created.borrowed:
            click.echo(f"{lower:g} to {upper:g} um from {like}")
    if emissivity is not None:
        where = "the mean over radiation of 300 K, the shape is that of the spectrum" if read else "beyond 2.5 um"
        click.echo(f"emissivity {emissivity:g}: {where}")
    numbers = ", ".join(f"{key.replace('_', ' ')} {value:.3f}" for key, value in summary.items())
    click.echo(f"{created.code}  {name}: {numbers}")
    for file in created.files:
        click.echo(f"  {file}")
    click.echo(f"use it with MATERIALS_DATABASE={created.folder.resolve()}")
