"""GDAL, by rasterio: what it says of an image file is returned or raised, and never written to the terminal."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError

WGS84 = "EPSG:4326"
Coordinates = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


@contextmanager
def quiet() -> Iterator[None]:
    """Keep rasterio's warnings and messages to itself."""
    logger = logging.getLogger("rasterio")
    level = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.setLevel(level)


def open_dataset(path: Path) -> Any:
    """The file as a `rasterio.DatasetReader`; None where GDAL does not read it."""
    import rasterio

    with quiet():
        try:
            return rasterio.open(path)
        except (rasterio.errors.RasterioError, ValueError, TypeError):
            return None


def find_system(name: str, file: Path) -> Any:
    """The coordinate system of a name such as ``EPSG:32633``, or of its text in WKT.

    Raises InputError: PROJ does not know it, or it is of no place on the Earth.
    """
    from rasterio.crs import CRS
    from rasterio.errors import CRSError

    with quiet():
        try:
            system = CRS.from_user_input(name) if name else None
        except CRSError:
            system = None
    if system is None or not (system.is_geographic or system.is_projected):
        raise InputError(
            f"lies on a map in '{name[:80] or 'no coordinate system'}'; allowed: a system that PROJ knows, such as "
            "EPSG:4326 or EPSG:32633; reproject the image",
            file=file,
        )
    return system


def transformed(source: Any, target: Any, x: npt.NDArray[Any], y: npt.NDArray[Any]) -> Coordinates:
    """Coordinates of one system in another, by PROJ; longitude and easting come first.

    >>> x, y = transformed("EPSG:4326", "EPSG:32633", np.array([15.0]), np.array([0.0]))
    >>> round(x[0]), round(y[0])
    (500000, 0)
    """
    from rasterio.warp import transform

    with quiet():
        east, north = transform(source, target, np.ravel(x).tolist(), np.ravel(y).tolist())
    return np.reshape(east, np.shape(x)), np.reshape(north, np.shape(y))
