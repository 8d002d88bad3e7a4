"""Materials from elsewhere as a texture database."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Variable, write_file
from skyshine.tmm.database.layout import (
    CHUNK,
    composite_layout,
    level_layout,
    materials_layout,
    texture_header,
    usage_layout,
)
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Composites, Level, LevelStream, level_sizes
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.exchange.cdb import CdbRaster
from skyshine.tmm.exchange.cdb_materials import CdbMaterials
from skyshine.tmm.exchange.cdb_places import INDEX, is_placed, place_of
from skyshine.tmm.exchange.cdb_table import Composite, parse_table, table_text
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.job.model import Palette, TextureJob


def write_imported(
    image: MaterialImage,
    source: str | os.PathLike[str],
    colours: dict[str, str],
    path: str | os.PathLike[str],
    library_version: str,
    raster: CdbRaster | None = None,
) -> str:
    """Write an imported image as a database; returns the hash of its content.

    Confidence is 1 where there is a material, for nothing was classified, and 0 elsewhere.
    Raises InputError: the file cannot be written.

    source : path; the file it was read from, for the provenance.
    colours : dict of str to str
        Material by colour or grey level of that file: the palette of the job that is in the database.
    raster : CdbRaster, optional; kept, so that indices and composite materials can be written again as they came.
    """
    levels, mixtures = [image.level], Composites()
    levels += coarser_levels(image)
    for level in levels:
        mixtures.add(level)
    confidence = (image.level.code > 0).astype(np.float32)
    groups = {
        "materials": materials_layout(np.array(list(image.materials), np.uint16), tuple(image.materials.values())),
        "quality": Group(attributes={"tested_texels": 0, "seed_texels": 0}),
        "provenance": Group(attributes=_provenance(image, Path(source))),
        "levels": Group(groups={str(k): _filled(k, level, image, confidence) for k, level in enumerate(levels)}),
        "usage": _usage(image),
        "composites": composite_layout(*mixtures.mixtures()),
    }
    if raster is not None:
        groups["cdb"] = _cdb(raster, Path(path))
    job = TextureJob(image=Path(source).name, palette=Palette(colours=colours))
    return write_file(path, Group(groups=groups), texture_header(job, library_version))


def coarser_levels(image: MaterialImage) -> list[Level]:
    """The mip levels above a level of mixtures: in each texel, the mean share of every material over its part of the
    image.
    """
    stream = LevelStream(image.height, image.width, np.array(list(image.materials), np.uint16))
    levels: list[list[Level]] = [[] for _ in level_sizes(image.height, image.width)[1:]]
    for top in range(0, image.height, CHUNK):
        band = Level(*(part[top : top + CHUNK] for part in vars(image.level).values()))
        for number, _, part in stream.add_mixed(band):
            levels[number - 1].append(part)
    return [
        Level(*(np.concatenate(parts) for parts in zip(*(vars(part).values() for part in level), strict=True)))
        for level in levels
    ]


def _usage(image: MaterialImage) -> Group:
    level = image.level
    counts = np.bincount(level.mix_code.ravel(), level.mix_weight.ravel(), minlength=1 << 16) / WEIGHT_TOTAL
    classified = int(np.count_nonzero(level.code))
    share = counts[list(image.materials)] / max(classified, 1)
    return usage_layout(np.array(list(image.materials), np.uint16), share, level.code.size, classified, classified)


def _filled(k: int, level: Level, image: MaterialImage, confidence: npt.NDArray[Any]) -> Group:
    layout = level_layout(k, level.code.shape, image.height, image.width)
    data = {
        "code": level.code,
        "mix_code": level.mix_code,
        "mix_weight": level.mix_weight,
        "confidence": confidence,
    }
    variables = {name: replace(variable, data=data[name]) for name, variable in layout.variables.items()}
    return Group(layout.axes, variables)


def _provenance(image: MaterialImage, source: Path) -> dict[str, Any]:
    return {
        "texture": source.name,
        "texture_sha256": file_sha256(source),
        "width": image.width,
        "height": image.height,
        "pixel_type": "uint16",
        "encoding": "material codes",
        "distinct_colours": 0,
    }


def _cdb(raster: CdbRaster, path: Path) -> Group:
    layers, height, width = raster.index.shape
    axes = {
        "layer": Axis(np.arange(1, layers + 1, dtype=np.uint8), "1", "layer"),
        "y": Axis(np.arange(height) + 0.5, "1", "row of the texel's centre"),
        "x": Axis(np.arange(width) + 0.5, "1", "column of the texel's centre"),
    }
    dims, chunks = ("layer", "y", "x"), (1, CHUNK, CHUNK)
    lines = table_text(list(raster.table.values()), path).decode().splitlines()
    axes["line"] = Axis(np.arange(len(lines), dtype=np.int32), "1", "line of the table")
    return Group(
        axes,
        {
            "index": Variable(
                dims, raster.index.astype(np.uint32), "1", "index of the composite material", chunks=chunks
            ),
            "share": Variable(dims, raster.share, "1", "share of the composite material", chunks=chunks),
            "table": Variable(("line",), np.array(lines, dtype=object), "1", "Composite Material Table, XML"),
        },
        attributes={"raster": raster.location.raster(Path(), INDEX, 1).name},
    )


def kept_raster(path: str | os.PathLike[str]) -> CdbRaster | None:
    """The raster materials that a database was imported with; None where it came from elsewhere.

    Raises InputError: the database cannot be read.
    """
    with open_tmm(path) as file:
        if not file.has("cdb/index"):
            return None
        text = b"\n".join(file.array("cdb/table"))
        location = place_of(file.group_attributes("cdb")["raster"])
        return CdbRaster(location, file.array("cdb/index"), file.array("cdb/share"), parse_table(text, Path(path)))


def import_texture(
    path: str | os.PathLike[str],
    out: str | os.PathLike[str],
    library: MaterialLibrary,
    map_file: str | os.PathLike[str] | None = None,
    table: str | os.PathLike[str] | None = None,
) -> Path:
    """Read raster materials of a CDB, or an image of indices into its table, and write a database into a folder.

    Raises InputError: a file cannot be read, or a material has no counterpart.

    Parameters
    ----------
    map_file : path, optional
        Material map of a CDB; by default the packaged one.
    table : path, optional
        Composite Material Table that an image of indices goes with, which then may be anywhere; of a raster in a
        CDB, in place of its own.
    """
    from skyshine.tmm.exchange.cdb import read_cdb, to_image
    from skyshine.tmm.exchange.cdb_materials import load_map

    path, raster = Path(path), None
    if table is not None and not is_placed(path):
        image, colours = _with_table(path, Path(table), load_map(library, map_file))
    else:
        raster, materials = read_cdb(path, table), load_map(library, map_file)
        image, present = to_image(raster, materials), np.unique(raster.index).tolist()
        colours = _first_materials([k for k in present if k in raster.table], raster.table, materials)
    target = Path(out) / f"{image.name}.tmm.h5"
    write_imported(image, path, colours, target, library.version, raster)
    return target


def _with_table(path: Path, table_path: Path, materials: CdbMaterials) -> tuple[MaterialImage, dict[str, str]]:
    """An image of indices into a table, and the palette for its provenance."""
    from skyshine.tmm.exchange.cdb import indexed_image, indices_in
    from skyshine.tmm.exchange.cdb_table import read_table
    from skyshine.tmm.exchange.rasters import read_plane

    table, index = read_table(table_path), read_plane(path)
    if index.dtype.kind != "u":
        raise InputError("contains floats; allowed: unsigned integers, indices into the table", file=path)
    present = indices_in(index, table, path, table_path.name)
    layers, shares = index[np.newaxis], np.ones((1, *index.shape), np.float32)
    image = indexed_image(path.name.partition(".")[0], layers, shares, table, materials)
    return image, _first_materials(present, table, materials)


def _first_materials(present: list[int], table: dict[int, Composite], materials: CdbMaterials) -> dict[str, str]:
    """The material with the largest share in each composite, by index as a palette names it."""
    principal = {index: next(iter(materials.mixture(table[index]))) for index in present}
    return {str(index): materials.library.by_code(code).name for index, code in principal.items()}
