"""Where and when a scene is: the place and date that place Sun and Moon."""

from __future__ import annotations

from datetime import date
from typing import Annotated

import numpy as np
from pydantic import Field

from skyshine.schemas.documents import StrictModel

_EARTH_RADIUS = 6371.0  # km, of the sphere of the Earth's volume


class Site(StrictModel):
    """Where and when: what places Sun and Moon."""

    latitude_deg: float = Field(ge=-90, le=90, description="Latitude; north is positive.")
    longitude_deg: float = Field(ge=-180, le=180, description="Longitude; east is positive.")
    date: Annotated[date, Field(description="Local day of the scene.")]
    utc_offset_h: float = Field(ge=-12, le=14, description="Local clock time minus UTC.")
    altitude_km: float = Field(0.0, ge=-0.5, le=5.9, description="Altitude of the ground below the scene.")


def local_times_utc(site: Site, hours: np.ndarray) -> np.ndarray:
    """UTC times of local clock hours on the day of the site.

    Parameters
    ----------
    hours : (n,) float
        Local clock, in hours.

    Returns
    -------
    (n,) datetime64[s]
    """
    seconds = np.round((np.asarray(hours, float) - site.utc_offset_h) * 3600).astype("timedelta64[s]")
    return np.datetime64(site.date.isoformat(), "s") + seconds


def great_circle(latitude: float, longitude: float, other_latitude: float, other_longitude: float) -> float:
    """Distance of two places on a sphere [km]; latitudes and longitudes in degree.

    Examples
    --------
    >>> round(great_circle(0, 0, 0, 90))  # a quarter of the equator
    10008
    """
    a, b, difference = np.radians([latitude, other_latitude, other_longitude - longitude])
    haversine = np.sin((b - a) / 2) ** 2 + np.cos(a) * np.cos(b) * np.sin(difference / 2) ** 2
    return float(2 * _EARTH_RADIUS * np.arcsin(np.sqrt(min(haversine, 1.0))))
