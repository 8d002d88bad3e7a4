"""``tmm import``: materials of a CDB as a texture database."""

import click

from skyshine.schemas.commands import emit_json, json_option
from skyshine.schemas.quantity import quantity


@click.command(
    epilog=(
        "Example: tmm import cdb/Tiles/N12/E044/005_RMTexture/L00/U0/N12E044_D005_S001_T001_L00_U0_R0.tif --out build"
    )
)
@click.argument("file", type=click.Path())
@click.option("--out", type=click.Path(), required=True, help="Output folder of the database.")
@click.option(
    "--map", "map_file", type=click.Path(), help="Map of base materials to ours, instead of the packaged one."
)
@click.option(
    "--table",
    type=click.Path(),
    help="Composite Material Table of an index image outside a CDB, or of a tile whose table is elsewhere.",
)
@json_option
def command(file: str, out: str, map_file: str | None, table: str | None, as_json: bool) -> None:
    """Write the materials of FILE as a texture database (.tmm.h5) with all mip levels.

    FILE is the first layer of raster materials in a CDB (datasets 005 and 504), in its place there, or (--table)
    any image of indices into a Composite Material Table. Composites become mixtures of up to three materials. An image
    whose colours or indices name materials by themselves is a job with a `palette`.
    """
    from skyshine.materials.library import load_library
    from skyshine.tmm.database.usage import read_usage
    from skyshine.tmm.exchange.imported import import_texture

    path = import_texture(file, out, load_library(), map_file, table)
    usage = read_usage(path)
    if as_json:
        emit_json({"file": str(path), "usage": {name: quantity(share, "1") for name, share in usage.items()}})
        return
    click.echo(f"{path}:")
    for name, share in sorted(usage.items(), key=lambda item: -item[1]):
        click.echo(f"  {100 * share:6.2f} %  {name}")
