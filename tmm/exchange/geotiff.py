"""GeoTIFF (OGC 19-008r4): codes and confidence on the map that the image lay on."""

from __future__ import annotations

import io
import os
import re
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.database.reader import open_tmm
from skyshine.tmm.exchange.files import write_bytes, write_json
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.images.georeference import Affine

TILE = 256
# Tags: where a texel lies, what the coordinates are; GDAL's own for no data and for names.
_SCALE, _TIE, _MATRIX, _KEYS, _TEXTS, _METADATA, _NO_DATA = 33550, 33922, 34264, 34735, 34737, 42112, 42113
# Keys of the directory in _KEYS.
_MODEL_TYPE, _RASTER_TYPE, _CITATION, _GEOGRAPHIC, _PROJECTED = 1024, 1025, 1026, 2048, 3072
_PIXEL_IS_AREA, _USER_DEFINED = 1, 32767

Tag = tuple[int, str, int, Any, bool]


def write_geotiff(
    folder: str | os.PathLike[str], image: MaterialImage, path: str | os.PathLike[str], level: int
) -> list[Path]:
    """Write ``NAME.code.tif`` (uint16, 0 no data) with ``NAME.code.json``, and of the first level
    ``NAME.confidence.tif`` (float32, 0 to 1, NaN where there is no material); where the database has it,
    ``NAME.shade.tif`` (uint8, 255 in the shade).

    Parameters
    ----------
    image : MaterialImage
        The level of the database that is written.
    path : path
        The database, which has the place on the map and the confidence.

    Raises
    ------
    InputError
        The image had no place on a map, or a file cannot be written.
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
    tags = _place(affine, str(attributes["geo_crs"]), image.height, image.width)
    names = "".join(f'<Item name="{code}" sample="0">{escape(name)}</Item>' for code, name in image.materials.items())
    metadata = f"<GDALMetadata>{names}</GDALMetadata>"
    paths = [Path(folder) / f"{image.name}.code.tif", Path(folder) / f"{image.name}.code.json"]
    _write(paths[0], image.level.code, [*tags, _text(_METADATA, metadata), _text(_NO_DATA, "0")])
    materials = {str(code): {"code": code, "name": name} for code, name in image.materials.items()}
    write_json(paths[1], {"image": paths[0].name, "no_material": 0, "materials": materials})
    if confidence is not None:
        known = np.where(image.level.code > 0, confidence, np.nan).astype(np.float32)
        paths.append(Path(folder) / f"{image.name}.confidence.tif")
        _write(paths[-1], known, [*tags, _text(_NO_DATA, "nan")])
    if shade is not None:
        paths.append(Path(folder) / f"{image.name}.shade.tif")
        _write(paths[-1], shade, tags)
    return paths


def _write(path: Path, values: npt.NDArray[Any], tags: list[Tag]) -> None:
    import tifffile

    content = io.BytesIO()
    tifffile.imwrite(
        content,
        values,
        photometric="minisblack",
        tile=(TILE, TILE),
        compression="zlib",
        metadata=None,
        software=False,
        extratags=tags,
    )
    write_bytes(path, content.getvalue())


def _text(tag: int, text: str) -> Tag:
    return tag, "s", 0, text, True


def _place(affine: Affine, crs: str, height: int, width: int) -> list[Tag]:
    """Tags of an affine map from texels to the coordinates of a system."""
    a, b, c, d, e, f = affine
    if b == d == 0 and a > 0 > e:
        place: list[Tag] = [(_SCALE, "d", 3, (a, -e, 0.0), True), (_TIE, "d", 6, (0.0, 0.0, 0.0, c, f, 0.0), True)]
    else:
        place = [(_MATRIX, "d", 16, (a, b, 0.0, c, d, e, 0.0, f, *[0.0] * 4, 0.0, 0.0, 0.0, 1.0), True)]
    keys, text = {_RASTER_TYPE: (0, 1, _PIXEL_IS_AREA)}, ""
    code = re.fullmatch(r"EPSG:([0-9]+)", crs)
    if code:
        geographic = _in_degrees(affine, height, width)
        keys[_MODEL_TYPE] = (0, 1, 2 if geographic else 1)
        keys[_GEOGRAPHIC if geographic else _PROJECTED] = (0, 1, int(code[1]))
    elif crs:
        text = crs.encode("ascii", "replace").decode() + "|"
        keys[_MODEL_TYPE] = (0, 1, _USER_DEFINED)
        keys[_CITATION] = (_TEXTS, len(text), 0)
    directory = [1, 1, 0, len(keys), *(number for key in sorted(keys) for number in (key, *keys[key]))]
    place.append((_KEYS, "H", len(directory), tuple(directory), True))
    return [*place, _text(_TEXTS, text)] if text else place


def _in_degrees(affine: Affine, height: int, width: int) -> bool:
    """Whether all corners can be longitudes and latitudes: numbers of systems do not tell which are geographic."""
    a, b, c, d, e, f = affine
    corners = [(x, y) for x in (0, width) for y in (0, height)]
    return all(abs(a * x + b * y + c) <= 360 and abs(d * x + e * y + f) <= 90 for x, y in corners)
