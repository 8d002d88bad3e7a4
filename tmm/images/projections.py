"""Coordinates of maps from longitude and latitude, and back: geographic systems, UTM and Web Mercator, in closed form.

Transverse Mercator is Krueger's series to the fourth order in the third flattening, as Karney 2011 ("Transverse
Mercator with an accuracy of a few nanometers", Journal of Geodesy 85:475-485) gives it. ETRS89 and NAD83 count as WGS
84, as EPSG's transformations 1149 and 1188 have it, with accuracies of 1 m and 4 m.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError

WGS84 = (6378137.0, 1 / 298.257223563)  # semi-major axis in metres, and flattening
_UTM_SCALE, _UTM_EAST, _UTM_SOUTH = 0.9996, 500_000.0, 10_000_000.0
_NEWTON_ROUNDS = 5  # of the geographic from the conformal latitude: four reach the rounding of float64
_GEOGRAPHIC = {"4326", "4258", "4269"}  # WGS 84, ETRS89, NAD83
_WEB_MERCATOR = "3857"
_ZONES = {  # EPSG codes of UTM zones: what stands before the number of the zone, its hemisphere, first and last zone
    "326": ("north", 1, 60),
    "327": ("south", 1, 60),
    "258": ("north", 28, 38),
    "269": ("north", 1, 23),
}

Coordinates = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]


class Projection(Protocol):
    """A map's coordinates."""

    def to_map(self, longitude: npt.NDArray[Any], latitude: npt.NDArray[Any]) -> Coordinates:
        """Coordinates X, Y of the map at degrees."""

    def to_degrees(self, x: npt.NDArray[Any], y: npt.NDArray[Any]) -> Coordinates:
        """Longitude and latitude in degrees at coordinates of the map."""


class Geographic:
    """A map in degrees."""

    def to_map(self, longitude: npt.NDArray[Any], latitude: npt.NDArray[Any]) -> Coordinates:
        """The degrees themselves; see `Projection`."""
        return longitude, latitude

    def to_degrees(self, x: npt.NDArray[Any], y: npt.NDArray[Any]) -> Coordinates:
        """The degrees themselves; see `Projection`."""
        return x, y


class WebMercator:
    """Spherical Mercator of WGS 84's degrees (EPSG method 1024)."""

    def to_map(self, longitude: npt.NDArray[Any], latitude: npt.NDArray[Any]) -> Coordinates:
        """See `Projection`."""
        return WGS84[0] * np.radians(longitude), WGS84[0] * np.arcsinh(np.tan(np.radians(latitude)))

    def to_degrees(self, x: npt.NDArray[Any], y: npt.NDArray[Any]) -> Coordinates:
        """See `Projection`."""
        return np.degrees(x / WGS84[0]), np.degrees(np.arctan(np.sinh(y / WGS84[0])))


@dataclass(frozen=True)
class TransverseMercator:
    """Transverse Mercator of an ellipsoid.

    Attributes
    ----------
    meridian : float
        Central meridian in degrees.
    scale : float
        On the central meridian.
    east, north : float
        False easting, and false northing at the equator, in metres.
    ellipsoid : tuple of float
        Semi-major axis in metres, and flattening.
    """

    meridian: float
    scale: float
    east: float
    north: float
    ellipsoid: tuple[float, float] = WGS84

    def to_map(self, longitude: npt.NDArray[Any], latitude: npt.NDArray[Any]) -> Coordinates:
        """See `Projection`."""
        turn = np.radians(longitude - self.meridian)
        conformal = _conformal_tangent(np.tan(np.radians(latitude)), self._eccentricity)
        xi = np.arctan2(conformal, np.cos(turn))
        eta = np.arcsinh(np.sin(turn) / np.hypot(conformal, np.cos(turn)))
        sums = xi + 1j * eta
        sums = sums + sum(a * np.sin(2 * k * sums) for k, a in enumerate(self._series(_FORWARD), 1))
        size = self.scale * self._radius
        return self.east + size * sums.imag, self.north + size * sums.real

    def to_degrees(self, x: npt.NDArray[Any], y: npt.NDArray[Any]) -> Coordinates:
        """See `Projection`."""
        size = self.scale * self._radius
        sums = (y - self.north) / size + 1j * (x - self.east) / size
        sums = sums - sum(b * np.sin(2 * k * sums) for k, b in enumerate(self._series(_BACKWARD), 1))
        turn = np.arctan2(np.sinh(sums.imag), np.cos(sums.real))
        conformal = np.sin(sums.real) / np.hypot(np.sinh(sums.imag), np.cos(sums.real))
        tangent = _geographic_tangent(conformal, self._eccentricity)
        return self.meridian + np.degrees(turn), np.degrees(np.arctan(tangent))

    @property
    def _eccentricity(self) -> float:
        return float(np.sqrt(self.ellipsoid[1] * (2 - self.ellipsoid[1])))

    @property
    def _third_flattening(self) -> float:
        return self.ellipsoid[1] / (2 - self.ellipsoid[1])

    @property
    def _radius(self) -> float:
        """Of the circle whose circumference is that of a meridian."""
        n = self._third_flattening
        return self.ellipsoid[0] / (1 + n) * (1 + n**2 / 4 + n**4 / 64)

    def _series(self, rows: tuple[tuple[float, ...], ...]) -> list[float]:
        n = self._third_flattening
        return [sum(c * n**k for k, c in enumerate(row, first)) for first, row in enumerate(rows, 1)]


# Coefficients of n^k, n^(k + 1), ... of the k-th term (Karney 2011, equations 35 and 36).
_FORWARD = (
    (1 / 2, -2 / 3, 5 / 16, 41 / 180),
    (13 / 48, -3 / 5, 557 / 1440),
    (61 / 240, -103 / 140),
    (49561 / 161280,),
)
_BACKWARD = (
    (1 / 2, -2 / 3, 37 / 96, -1 / 360),
    (1 / 48, 1 / 15, -437 / 1440),
    (17 / 480, -37 / 840),
    (4397 / 161280,),
)


def _conformal_tangent(tangent: npt.NDArray[Any], e: float) -> npt.NDArray[np.float64]:
    """Tangent of the conformal latitude of that of the geographic latitude (Karney 2011, equations 7 to 9)."""
    secant = np.hypot(1, tangent)
    sigma = np.sinh(e * np.arctanh(e * tangent / secant))
    conformal: npt.NDArray[np.float64] = tangent * np.hypot(1, sigma) - sigma * secant
    return conformal


def _geographic_tangent(conformal: npt.NDArray[Any], e: float) -> npt.NDArray[np.float64]:
    """Inverse of `_conformal_tangent`, by Newton's method (Karney 2011, equations 19 to 21)."""
    tangent = conformal / (1 - e**2)
    for _ in range(_NEWTON_ROUNDS):
        found = _conformal_tangent(tangent, e)
        slope = (1 + (1 - e**2) * tangent**2) / ((1 - e**2) * np.hypot(1, tangent))
        tangent = tangent + (conformal - found) / np.hypot(1, found) * slope
    return tangent


def find_projection(crs: str, path: Path) -> Projection:
    """The projection that a coordinate system's name, ``EPSG:code``, stands for.

    Raises
    ------
    InputError
        It is none of those that are known.
    """
    code = re.fullmatch(r"EPSG:([0-9]+)", crs)
    number = code[1] if code else ""
    if number in _GEOGRAPHIC:
        return Geographic()
    if number == _WEB_MERCATOR:
        return WebMercator()
    hemisphere, first, last = _ZONES.get(number[:3], ("", 1, 0))
    if len(number) == 5 and first <= int(number[3:]) <= last:
        north = _UTM_SOUTH if hemisphere == "south" else 0.0
        return TransverseMercator(6 * int(number[3:]) - 183, _UTM_SCALE, _UTM_EAST, north)
    raise InputError(
        f"lies on a map in '{crs or 'no coordinate system'}'; allowed: EPSG:4326, 4258, 4269, 3857 and UTM zones (32601"
        " to 32660, 32701 to 32760, 25828 to 25838, 26901 to 26923); project the image to one of them before it is"
        " classified, as 'gdalwarp -t_srs EPSG:4326' does",
        file=path,
    )
