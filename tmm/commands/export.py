"""``tmm export``: a texture's materials in the formats of others."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import click

from skyshine.schemas.commands import emit_json, json_option, progress
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    from skyshine.tmm.exchange.export import Form

TMM = "tmm"  # our own format, made of the formats of others


@click.command(epilog="Example: tmm export build/yellowstone_road.tmm.h5 --to gltf --out exchange")
@click.argument("file", type=click.Path())
@click.option(
    "--to",
    "form",
    type=click.Choice(["png", "masks", "splat", "geotiff", "relit", "gltf", "dirsig", "cdb", TMM]),
    required=True,
    help="Format to write.",
)
@click.option("--out", type=click.Path(), required=True, help="Output folder; for a CDB, its root.")
@click.option(
    "--level",
    type=click.IntRange(min=0),
    help="Mip level to write; by default the first, or the one that fits the tile.",
)
@click.option(
    "--tile",
    help="CDB: tile that the texture covers, such as N12E044_L00_U0_R0; by default tiles are cut by its georeference.",
)
@click.option("--model", help="CDB: name of a geotypical model's texture; all mip levels are written.")
@click.option(
    "--lod", type=int, help="CDB: finest level of detail, -10 to 23, of the model texture or of the tiles that are cut."
)
@click.option(
    "--map",
    "map_file",
    type=click.Path(),
    help="CDB, tmm: map of materials to base materials, instead of the packaged one.",
)
@click.option(
    "--table",
    type=click.Path(),
    help="tmm: Composite Material Table of an index image outside a CDB, or of a tile whose table is elsewhere.",
)
@click.option(
    "--mesh", type=click.Path(), help="glTF: mesh with the photograph as texture; the feature IDs are written into it."
)
@click.option("--photograph", help="glTF: name or number of the mesh's image that is the photograph.")
@json_option
def command(
    file: str,
    form: str,
    out: str,
    level: int | None,
    tile: str | None,
    model: str | None,
    lod: int | None,
    map_file: str | None,
    table: str | None,
    mesh: str | None,
    photograph: str | None,
    as_json: bool,
) -> None:
    """Write the materials of FILE in another format.

    png: indexed PNG with a legend. masks: a grey PNG for each material (Unreal, Blender). splat: RGBA PNG of four
    materials each (Unity). geotiff: codes, confidence and shade on the map. relit: the photograph without its cast
    shade. gltf: a quad, or a mesh of your own (--mesh), with a feature ID texture and a property table. dirsig:
    material map and mixture map. cdb: raster materials with their composite material tables: tiles of all levels of
    detail cut by the place on the map, or one tile that the texture covers (005, 006), or a model's texture (504, 505).

    tmm: a texture database of ours with all mip levels, of a FILE from elsewhere: the first layer of raster materials
    in a CDB (datasets 005 and 504), in its place there, or (--table) any image of indices into a Composite Material
    Table. Composites become mixtures of up to three materials. An image whose colours or indices name materials by
    themselves is a job with a `palette`.
    """
    from skyshine.materials.library import load_library
    from skyshine.tmm.exchange.export import CdbTarget, MeshTarget, export
    from skyshine.tmm.exchange.imported import import_texture

    others = {"--level": level, "--tile": tile, "--model": model, "--lod": lod, "--mesh": mesh}
    for option, value in (others if form == TMM else {"--table": table}).items():
        if value is not None:
            raise InputError(f"found {option} with --to {form}; leave it out")

    target = CdbTarget(tile, model, lod, map_file)
    if photograph is not None and mesh is None:
        raise click.UsageError("--photograph names an image of a mesh; give --mesh")
    into = None if mesh is None else MeshTarget(mesh, photograph)
    if form == TMM:
        paths = [import_texture(file, out, load_library(), map_file, table)]
    else:
        paths = export(file, cast("Form", form), out, load_library(), level, target, into, progress)
    if as_json:
        emit_json({"file": file, "format": form, "written": [str(path) for path in paths]})
    else:
        click.echo("\n".join(map(str, paths)))
