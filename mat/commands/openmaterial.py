"""``mat export --to openmaterial``: materials as files of ASAM OpenMATERIAL 3D."""

from __future__ import annotations

from pathlib import Path

import click

from skyshine.mat.commands import completions


@click.command(epilog="Example: mat export concrete asphalt_road --to openmaterial --out exchange")
@click.argument("names", nargs=-1, shell_complete=completions.materials)
@click.option("--out", required=True, type=click.Path(file_okay=False, path_type=Path), help="Output folder.")
def command(names: tuple[str, ...], out: Path) -> None:
    """Write the materials NAMES, by default all, as files of ASAM OpenMATERIAL 3D.

    NAME.xomp has emissivity, density, heat layers and the specular lobe, NAME_brdf.xompt the diffuse reflectance by
    wavelength, materials.xomm maps the names to the files.
    """
    from skyshine.mat.exchange.openmaterial import write_openmaterial
    from skyshine.materials.library import load_library

    for path in write_openmaterial(load_library(), names, out):
        click.echo(path)
