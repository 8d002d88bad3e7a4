"""Positions of the Sun and the Moon, by the package astronomy-engine (VSOP87 and NOVAS, within one arc minute)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.solar import ASTRONOMICAL_UNIT
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import InputError

SOURCES = ("sun", "moon")
J2000 = np.datetime64("2000-01-01T12:00:00", "us")
MICROSECONDS_PER_DAY = 86_400e6  # 24 h of 3600 s


@dataclass(frozen=True)
class SourcePosition:
    """Topocentric, geometric position (no refraction); every array has the shape (T,) of the times.

    Attributes
    ----------
    elevation : array
        Above the horizon, negative below it, degree.
    azimuth : array
        Azimuth from north eastward, 0 to 360 degree.
    distance : array
        Distance from the observer, m.
    phase_angle : array
        Angle Sun - source - observer, degree: 0 full, 180 new; 0 for the Sun itself.
    waxing : array of bool
        Whether the Moon is before full; False for the Sun.
    sun_distance : array
        Distance of the light source from the Sun, au: for the Moon, its distance from the Sun; for the Sun, the
        observer's.
    """

    elevation: Floats
    azimuth: Floats
    distance: Floats
    phase_angle: Floats
    waxing: Booleans
    sun_distance: Floats


def position(
    source: str, times: npt.ArrayLike, latitude: float, longitude: float, height: float = 0.0
) -> SourcePosition:
    """Position of the Sun or the Moon for an observer on the Earth.

    Parameters
    ----------
    source : str
        ``"sun"`` or ``"moon"``.
    times : (T,) array of datetime64
        UTC.
    latitude, longitude : float
        Geodetic, north and east positive, degree.
    height : float
        Above sea level, m.

    Raises
    ------
    InputError
        For another source, a time that is not a time, or an impossible place.
    """
    import astronomy  # slow to import

    if source not in SOURCES:
        raise InputError(f"no source '{source}'; allowed: {', '.join(SOURCES)}")
    if not (abs(latitude) <= 90 and abs(longitude) <= 360 and np.isfinite(height)):
        raise InputError(
            f"no place at latitude {latitude}, longitude {longitude}, height {height}: degrees, degrees and metres"
        )
    observer = astronomy.Observer(latitude, longitude, height)
    moments = [astronomy.Time(days) for days in _days_since_j2000(times)]
    rows = np.array([_row(astronomy, source, moment, observer) for moment in moments]).reshape(-1, 6)
    elevation, azimuth, distance, phase_angle, waxing, sun_distance = rows.T
    return SourcePosition(elevation, azimuth, distance, phase_angle, waxing.astype(bool), sun_distance)


def _row(astronomy: Any, source: str, moment: Any, observer: Any) -> tuple[float, float, float, float, bool, float]:
    """The six numbers of a `SourcePosition` at one moment."""
    body = astronomy.Body.Sun if source == "sun" else astronomy.Body.Moon
    equator = astronomy.Equator(body, moment, observer, ofdate=True, aberration=True)
    horizon = astronomy.Horizon(moment, observer, equator.ra, equator.dec, astronomy.Refraction.Airless)
    direction = horizon.altitude, horizon.azimuth, equator.dist * ASTRONOMICAL_UNIT
    if source == "sun":
        return *direction, 0.0, False, equator.dist
    sun = astronomy.Equator(astronomy.Body.Sun, moment, observer, ofdate=True, aberration=True)
    to_observer = -_vector(equator)
    to_sun = _vector(sun) + to_observer
    # From the cross product as well: the cosine alone loses the phase near full and new Moon.
    phase = np.degrees(np.arctan2(np.linalg.norm(np.cross(to_observer, to_sun)), to_observer @ to_sun))
    return *direction, float(phase), astronomy.MoonPhase(moment) < 180, float(np.linalg.norm(to_sun))


def _vector(equatorial: Any) -> Floats:
    return np.array([equatorial.vec.x, equatorial.vec.y, equatorial.vec.z])


def _days_since_j2000(times: npt.ArrayLike) -> Floats:
    moments = np.atleast_1d(np.asarray(times))
    if moments.dtype.kind != "M" or np.any(np.isnat(moments)):
        raise InputError("times must be numpy datetime64 values in UTC, none of them NaT")
    days: Floats = (moments.astype("datetime64[us]") - J2000).astype(float) / MICROSECONDS_PER_DAY
    return days
