"""Where a texture lies on the ground: what GDAL reads of a TIFF, or a world file beside the image."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.plain_numbers import plain_number
from skyshine.tmm.images.gdal import open_dataset, quiet

_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")

Affine = tuple[float, float, float, float, float, float]


@dataclass(frozen=True)
class GeoReference:
    """An affine map from pixel to ground coordinates.

    affine : tuple of 6 float
        a, b, c, d, e, f of X = a x + b y + c, Y = d x + e y + f, with x and y in texels from the top left corner.
    crs : str; ``EPSG:code``, or the system as WKT; empty where the file names none, as world files do.
    """

    affine: Affine
    crs: str


def read_georeference(image: Path) -> GeoReference | None:
    """The georeference of an image; its own tags come before a world file. None where there is neither.

    Raises InputError: a world file does not contain six numbers, or maps everything to a line; or tags do.
    """
    return (_stored(image) if is_tiff(image) else None) or _world(image)


def is_tiff(image: Path) -> bool:
    """Whether a file begins as a TIFF or BigTIFF."""
    with open(image, "rb") as file:
        return file.read(4) in _TIFF


def _stored(image: Path) -> GeoReference | None:
    dataset = open_dataset(image)
    if dataset is None:
        return None
    with quiet(), dataset:
        transform, system = dataset.transform, dataset.crs
    affine = tuple(transform)[:6]
    if transform.is_identity:
        return None
    if not np.isfinite(affine).all() or transform.determinant == 0:
        raise InputError("has GeoTIFF tags that cannot be read; fix or remove them", file=image)
    code = None if system is None else system.to_epsg()
    name = f"EPSG:{code}" if code else "" if system is None else system.to_wkt()
    return GeoReference(_six(list(affine)), name)


def _world(image: Path) -> GeoReference | None:
    """World files are named by the first and last letter of the image's ending with a w, or .wld."""
    ending = image.suffix[1:]
    endings = [ending[0] + ending[-1] + "w", ending + "w", "wld"] if ending else ["wld"]
    candidates = [image.with_suffix("." + form) for name in endings for form in (name, name.upper())]
    world_file = next((world_file for world_file in candidates if world_file.is_file()), None)
    if world_file is None:
        return None
    try:
        a, d, b, e, c, f = (plain_number(word) for word in world_file.read_text(encoding="utf-8").split())
    except (ValueError, OSError):
        raise InputError("is no world file: it must contain six numbers; fix or remove it", file=world_file) from None
    if not (np.isfinite([a, b, c, d, e, f]).all() and a * e - b * d):
        raise InputError("maps the image to a line; fix its first four numbers or remove it", file=world_file)
    return GeoReference(_six(_from_centre([a, b, c, d, e, f])), "")


def _six(affine: list[float]) -> Affine:
    a, b, c, d, e, f = (float(value) for value in affine)
    return a, b, c, d, e, f


def _from_centre(affine: list[float]) -> list[float]:
    """The map whose origin is the corner of the first texel, of one whose origin is its centre."""
    a, b, c, d, e, f = affine
    return [a, b, c - (a + b) / 2, d, e, f - (d + e) / 2]
