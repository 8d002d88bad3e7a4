"""GeoTIFF: codes and confidence on the map that the image lay on."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.exchange.files import write_json
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.rasters import write_tiff

LAYOUT: dict[str, Any] = {"tiled": True, "blockxsize": 256, "blockysize": 256, "compress": "deflate"}


def write_geotiff(
    folder: str | os.PathLike[str], image: MaterialImage, path: str | os.PathLike[str], level: int
) -> list[Path]:
    """Write ``NAME.code.tif`` (uint16, 0 no data) with ``NAME.code.json``, and of the first level
    ``NAME.confidence.tif`` (float32, 0 to 1, NaN where there is no material); where the database has it,
    ``NAME.shade.tif`` (uint8, 255 in the shade).
    Raises InputError: the image had no place on a map, or a file cannot be written.

    image : MaterialImage; the level of the database that is written.
    path : path; the database, which has the place on the map and the confidence.
    """
    with open_tmm(path) as file:
        attributes, size = file.attributes, (file.height, file.width)
        confidence = file.array("levels/0/confidence") if level == 0 and file.has("levels/0/confidence") else None
        shade = file.array(f"levels/{level}/shade") if file.has_shade else None
    if "geo_affine" not in attributes:
        raise InputError(
            "has no place on a map; classify an image with GeoTIFF tags or a world file, or use --to png", file=path
        )
    a, b, c, d, e, f = (float(value) for value in attributes["geo_affine"])
    across, down = size[1] / image.width, size[0] / image.height
    affine = (a * across, b * down, c, d * across, e * down, f)
    georeference = affine, str(attributes["geo_crs"])
    names = {str(code): name for code, name in image.materials.items()}
    paths = [Path(folder) / f"{image.name}.code.tif", Path(folder) / f"{image.name}.code.json"]
    write_tiff(paths[0], image.level.code, georeference, names, nodata=0, **LAYOUT)
    materials = {str(code): {"code": code, "name": name} for code, name in image.materials.items()}
    write_json(paths[1], {"image": paths[0].name, "no_material": 0, "materials": materials})
    if confidence is not None:
        confidence_plane = np.where(image.level.code > 0, confidence, np.nan).astype(np.float32)
        paths.append(Path(folder) / f"{image.name}.confidence.tif")
        write_tiff(paths[-1], confidence_plane, georeference, nodata=float("nan"), **LAYOUT)
    if shade is not None:
        paths.append(Path(folder) / f"{image.name}.shade.tif")
        write_tiff(paths[-1], shade, georeference, **LAYOUT)
    return paths
