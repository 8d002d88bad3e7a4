"""How shadows fall in an image: the Sun's direction, by a job's angles or time and by the image's place on a map."""

from __future__ import annotations

from datetime import UTC
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.schemas.errors import InputError
from skyshine.tmm.features.cast_shade import REACH, Fall
from skyshine.tmm.images.gdal import WGS84, find_system, transformed
from skyshine.tmm.images.georeference import GeoReference, read_georeference
from skyshine.tmm.job.shade import Shade

_WALK = 100.0  # m, over which a direction on the ground is taken to the map
_TALLEST = 50.0  # m: chosen; trees and houses of fifteen storeys
_SHORTEST = 16  # texels: a reach below loses shadows to an elevation that is a little off


def shadow_fall(shade: Shade, image: Path) -> Fall:
    """Direction and longest length of shadows in an image.

    Raises InputError: a time is given, and the image has no place on a map that is known, or the Sun was not up.

    shade : Shade
    image : Path

    Examples
    --------
    >>> shadow_fall(Shade(sun_azimuth_deg=180), Path("up_is_north.png"))  # doctest: +SKIP
    Fall(x=0.0, y=-1.0, reach=128, azimuth=180.0)
    """
    georeference = read_georeference(image)
    elevation: float | None
    if shade.time is not None:
        if georeference is None:
            raise InputError(
                "has no place on a map, which 'shade.time' needs; give it GeoTIFF tags, or say 'sun_azimuth_deg'",
                file=image,
            )
        elevation, azimuth = _sun(shade, georeference, image)
    else:
        elevation, azimuth = shade.sun_elevation_deg, float(shade.sun_azimuth_deg or 0.0)
    if georeference is None:
        return _fall(np.array([np.sin(np.radians(azimuth)), -np.cos(np.radians(azimuth))]), REACH, azimuth)
    linear = np.array(georeference.affine).reshape(2, 3)[:, :2]
    try:
        system = find_system(georeference.crs, image)
    except InputError:
        if shade.time is not None:
            raise
        towards = np.array([np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))])  # the map's north is up on it
        return _fall(np.linalg.solve(linear, towards), REACH, azimuth)
    texels = np.linalg.solve(linear, _walk(system, georeference, azimuth))
    reach = REACH
    if elevation is not None:
        longest = _TALLEST / np.tan(np.radians(elevation)) * np.hypot(*texels) / _WALK
        reach = int(np.clip(np.ceil(longest), _SHORTEST, REACH))
    return _fall(texels, reach, azimuth)


def _fall(towards: npt.NDArray[np.float64], reach: int, azimuth: float) -> Fall:
    """Shadows fall away from the Sun, which is in this direction of the image."""
    x, y = -towards / np.hypot(*towards)
    return Fall(float(x), float(y), reach, azimuth)


def _sun(shade: Shade, georeference: GeoReference, image: Path) -> tuple[float, float]:
    """Elevation and azimuth of the Sun over the image's corner, in degrees."""
    assert shade.time is not None
    longitude, latitude = _degrees(find_system(georeference.crs, image), georeference)
    moment = np.datetime64(shade.time.astimezone(UTC).replace(tzinfo=None))
    sun = position("sun", [moment], latitude, longitude)
    elevation, azimuth = float(sun.elevation[0]), float(sun.azimuth[0])
    if elevation <= 0:
        raise InputError(
            f"lies at latitude {latitude:.2f}, longitude {longitude:.2f}, where the Sun was {-elevation:.1f} degrees "
            f"below the horizon at {shade.time.isoformat()}; allowed: a time of day; correct 'shade.time' or its zone",
            file=image,
        )
    return elevation, azimuth


def _degrees(system: Any, georeference: GeoReference) -> tuple[float, float]:
    """Longitude and latitude of the image's corner."""
    x, y = np.array([georeference.affine[2]]), np.array([georeference.affine[5]])
    longitude, latitude = transformed(system, WGS84, x, y)
    return float(longitude[0]), float(latitude[0])


def _walk(system: Any, georeference: GeoReference, azimuth: float) -> npt.NDArray[np.float64]:
    """Coordinates of the map that a walk towards an azimuth crosses, from the image's corner."""
    longitude, latitude = _degrees(system, georeference)
    north, east = (_WALK * np.cos(np.radians(azimuth)), _WALK * np.sin(np.radians(azimuth)))
    local = f"+proj=aeqd +datum=WGS84 +lat_0={latitude!r} +lon_0={longitude!r}"  # metres about the corner
    x, y = transformed(local, system, np.array([0.0, east]), np.array([0.0, north]))
    return np.array([x[1] - x[0], y[1] - y[0]])
