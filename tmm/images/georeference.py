"""Where a texture lies on the ground: GeoTIFF tags (OGC 19-008r4) or a world file beside the image."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number

_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_PIXEL_IS_POINT = 2  # GTRasterTypeGeoKey: the tie point is the centre of the texel, not its corner
_USER_DEFINED = 32767

# What tifffile raises of files that it cannot read; its own error is a ValueError.
TIFF_ERRORS = (struct.error, ValueError, TypeError, IndexError, KeyError, OverflowError, ZeroDivisionError)

Affine = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class GeoReference:
    """An affine map from pixel to ground coordinates.

    Attributes
    ----------
    affine : tuple of 6 float
        a, b, c, d, e, f of X = a x + b y + c, Y = d x + e y + f, with x and y in texels from the top left corner.
    crs : str
        ``EPSG:code``, or the citation of the file; empty where it names none, as world files do.
    """

    affine: Affine
    crs: str


def read_georeference(image: Path) -> GeoReference | None:
    """The georeference of an image; its own tags come before a world file. None where there is neither.

    Raises
    ------
    InputError
        A world file does not hold six numbers, or maps everything to a line; or GeoTIFF tags are damaged.
    """
    return (_geotiff(image) if is_tiff(image) else None) or _world(image)


def is_tiff(image: Path) -> bool:
    """Whether a file begins as a TIFF or BigTIFF."""
    with open(image, "rb") as file:
        return file.read(4) in _TIFF


def _geotiff(image: Path) -> GeoReference | None:
    import tifffile

    try:
        with tifffile.TiffFile(image) as file:
            tags = getattr(file.pages[0], "geotiff_tags", None) or {}
    except TIFF_ERRORS:
        return None  # OpenImageIO reads images whose tags tifffile does not
    try:
        affine = _affine(tags)
        return None if affine is None else GeoReference(_six(affine), _crs(tags))
    except (ValueError, TypeError):
        raise InputError("has GeoTIFF tags that cannot be read; fix or remove them", file=image) from None


def _affine(tags: dict[str, Any]) -> list[float] | None:
    """The map that GeoTIFF tags give; None where they give none."""
    matrix, scale, tie = (tags.get(key) for key in ("ModelTransformation", "ModelPixelScale", "ModelTiepoint"))
    if matrix is not None:
        m = np.asarray(matrix, float).reshape(4, 4)
        affine = [m[0, 0], m[0, 1], m[0, 3], m[1, 0], m[1, 1], m[1, 3]]
    elif scale is not None and tie is not None:
        (column, row, _, x, y, _), (across, down) = np.ravel(tie)[:6].astype(float), np.ravel(scale)[:2].astype(float)
        affine = [across, 0.0, x - column * across, 0.0, -down, y + row * down]
    else:
        return None
    if not np.isfinite(affine).all():
        raise ValueError("not finite")
    return _from_centre(affine) if int(tags.get("GTRasterTypeGeoKey", 1)) == _PIXEL_IS_POINT else affine


def _crs(tags: dict[str, Any]) -> str:
    for key in ("ProjectedCSTypeGeoKey", "GeographicTypeGeoKey"):
        code = int(tags.get(key, 0))
        if 0 < code < _USER_DEFINED:
            return f"EPSG:{code}"
    return str(tags.get("GTCitationGeoKey") or tags.get("PCSCitationGeoKey") or "").strip("| ")


def _world(image: Path) -> GeoReference | None:
    """World files are named by the first and last letter of the image's ending with a w, or .wld."""
    ending = image.suffix[1:]
    endings = [ending[0] + ending[-1] + "w", ending + "w", "wld"] if ending else ["wld"]
    places = [image.with_suffix("." + form) for name in endings for form in (name, name.upper())]
    place = next((place for place in places if place.is_file()), None)
    if place is None:
        return None
    try:
        a, d, b, e, c, f = (plain_number(word) for word in place.read_text(encoding="utf-8").split())
    except (ValueError, OSError):
        raise InputError("is no world file: it must hold six numbers; fix or remove it", file=place) from None
    if not (np.isfinite([a, b, c, d, e, f]).all() and a * e - b * d):
        raise InputError("maps the image to a line; fix its first four numbers or remove it", file=place)
    return GeoReference(_six(_from_centre([a, b, c, d, e, f])), "")


def _six(affine: list[float]) -> Affine:
    a, b, c, d, e, f = (float(value) for value in affine)
    return a, b, c, d, e, f


def _from_centre(affine: list[float]) -> list[float]:
    """The map whose origin is the corner of the first texel, of one whose origin is its centre."""
    a, b, c, d, e, f = affine
    return [a, b, c - (a + b) / 2, d, e, f - (d + e) / 2]
