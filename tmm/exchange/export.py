"""From a texture database to the files of another format."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError
from skyshine.schemas.progress import Progress, silent
from skyshine.tmm.database.levels import level_sizes
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.exchange.cdb_materials import CdbMaterials, load_map
from skyshine.tmm.exchange.image import MaterialImage, read_levels

Form = Literal["png", "masks", "splat", "geotiff", "relit", "gltf", "dirsig", "cdb"]


@dataclass(frozen=True)
class CdbTarget:
    """Where materials go in a CDB: a tile, or a model texture whose finest level of detail is `lod`.

    Without either, what was imported from a CDB goes to where it came from, with its own indices and table; all else is
    cut into tiles by its place on the ground, the finest of level of detail `lod`.
    """

    tile: str | None = None
    model: str | None = None
    lod: int | None = None
    map_file: str | None = None


@dataclass(frozen=True)
class MeshTarget:
    """A glTF mesh that shows the texture's photograph, and which of its images that is; see `write_mesh`."""

    file: str
    photograph: str | None = None


def export(
    path: str | os.PathLike[str],
    form: Form,
    out: str | os.PathLike[str],
    library: MaterialLibrary,
    level: int | None = None,
    target: CdbTarget = CdbTarget(),
    mesh: MeshTarget | None = None,
    progress: Progress = silent,
) -> list[Path]:
    """Write a texture's materials in another format.

    Raises InputError: the file cannot be read, its materials do not fit the format, or a file cannot be written.

    Parameters
    ----------
    path : path
        A ``.tmm.h5``.
    form : {"png", "masks", "splat", "geotiff", "relit", "gltf", "dirsig", "cdb"}
    out : path
        Folder; of a CDB, its root.
    library : MaterialLibrary
        Material library, for the composite materials of a CDB.
    level : int, optional
        The mip level: by default the first; for a CDB tile that is named the one of the tile's size; a model texture
        and tiles that are cut have all.
    mesh : MeshTarget, optional
        Mesh of a glTF export that receives the feature IDs; without it they go into a quad.

    Returns
    -------
    list of Path
        The files written.
    """
    if mesh is not None and form != "gltf":
        raise InputError("--mesh goes with --to gltf alone; leave it out")
    if form == "cdb":
        return _export_cdb(path, Path(out), library, level, target, progress)
    if form == "relit":
        from skyshine.tmm.exchange.relit import write_relit

        if level:
            raise InputError("--level does not go with relit, which is the photograph; leave it out")
        return write_relit(out, path)
    from skyshine.tmm.exchange.dirsig import write_dirsig
    from skyshine.tmm.exchange.geotiff import write_geotiff
    from skyshine.tmm.exchange.gltf import write_gltf
    from skyshine.tmm.exchange.gltf_mesh import write_mesh
    from skyshine.tmm.exchange.indexed_png import write_png
    from skyshine.tmm.exchange.share_maps import write_masks, write_splat_maps

    image = read_levels(path, [level or 0])[0]
    if level:
        image = replace(image, name=f"{image.name}.{level}")
    writers: dict[Form, Callable[[Path, MaterialImage], list[Path]]] = {
        "png": write_png,
        "masks": write_masks,
        "splat": write_splat_maps,
        "geotiff": lambda folder, texture: write_geotiff(folder, texture, path, level or 0),
        "dirsig": write_dirsig,
        "gltf": lambda folder, texture: (
            write_gltf(folder, texture) if mesh is None else write_mesh(folder, texture, mesh.file, mesh.photograph)
        ),
    }
    return writers[form](Path(out), image)


def _export_cdb(
    path: str | os.PathLike[str],
    root: Path,
    library: MaterialLibrary,
    level: int | None,
    target: CdbTarget,
    progress: Progress,
) -> list[Path]:
    from skyshine.tmm.exchange.cdb import write_cdb
    from skyshine.tmm.exchange.cdb_bases import add_bases, bases_of, require_bases
    from skyshine.tmm.exchange.imported import kept_raster

    raster = kept_raster(path) if target == CdbTarget() and level is None else None
    materials = load_map(library, target.map_file)
    if raster is not None:
        composites = list(raster.table.values())
    else:
        composites = [materials.composite(name, 1) for name in _used_materials(path)]
    require_bases(root, composites)
    if raster is not None:
        paths = write_cdb(root, raster)
    else:
        paths = _export_materials(path, root, materials, level, target, progress)
    return [*paths, *add_bases(root, {*materials.recipes.bases, *bases_of(composites)})]


def _used_materials(path: str | os.PathLike[str]) -> list[str]:
    """The materials that some texel of a database has."""
    with open_tmm(path) as file:
        return [name for name, share in file.usage.items() if share > 0]


def _export_materials(
    path: str | os.PathLike[str],
    root: Path,
    materials: CdbMaterials,
    level: int | None,
    target: CdbTarget,
    progress: Progress,
) -> list[Path]:
    """Write composite materials of ours into a CDB."""
    from skyshine.tmm.exchange.cdb import from_image, write_cdb
    from skyshine.tmm.exchange.cdb_places import parse_tile
    from skyshine.tmm.exchange.cdb_tiles import cut_tiles

    if target.model is not None and target.tile is None:
        return _export_model(path, root, materials, level, target.model, target.lod)
    if target.tile is None:
        if level is not None:
            raise InputError("--level goes with --tile; tiles that are cut have all levels of detail; leave it out")
        return cut_tiles(Path(path), root, materials, target.lod, progress)
    if target.model is not None or target.lod is not None:
        raise InputError("--tile excludes these: it names the level of detail, and no model; remove --model and --lod")
    tile = parse_tile(target.tile)
    if level is None:
        sizes = _level_sizes(path)
        level = sizes.index((tile.side, tile.side)) if (tile.side, tile.side) in sizes else 0
    return write_cdb(root, from_image(read_levels(path, [level])[0], tile, materials))


def _export_model(
    path: str | os.PathLike[str], root: Path, materials: CdbMaterials, level: int | None, name: str, lod: int | None
) -> list[Path]:
    from skyshine.tmm.exchange.cdb import from_image, used_codes, write_cdb
    from skyshine.tmm.exchange.cdb_places import MIN_LOD, model_texture

    if lod is None:
        raise InputError("--model needs --lod, the level of detail of its finest texture; give it")
    if level is not None:
        raise InputError("--level does not go with --model, whose levels of detail are all mip levels; leave it out")
    model_texture(name, lod)
    images = read_levels(path, range(min(len(_level_sizes(path)), lod - MIN_LOD + 1)))
    codes = used_codes(images[0])  # one table serves all levels, and the coarser ones have no other materials
    rasters = [from_image(image, model_texture(name, lod - k), materials, codes) for k, image in enumerate(images)]
    return list(dict.fromkeys(file for raster in rasters for file in write_cdb(root, raster)))


def _level_sizes(path: str | os.PathLike[str]) -> list[tuple[int, int]]:
    with open_tmm(path) as file:
        return level_sizes(file.height, file.width)
