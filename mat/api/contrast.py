"""Contrast of one material against another through the day."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from skyshine.mat.job.fields import clock_interval
from skyshine.mat.render.contrast import Contrast, Face, Sight
from skyshine.mat.render.contrast import contrast as contrast_of_faces
from skyshine.mat.render.contrast_picture import draw_contrast
from skyshine.schemas.errors import InputError

__all__ = ["Contrast", "contrast", "draw_contrast"]


def contrast(
    folder: str | os.PathLike[str],
    material: str,
    background: str,
    *,
    band: str | None = None,
    state: int = 1,
    source: Literal["sun", "moon"] | str = "sun",
    range: float = 1.0,
    elevation: float = -45.0,
    heading: float = 0.0,
    altitude: float | None = None,
    slope: float = 0.0,
    azimuth: float = 180.0,
    shade: Sequence[str] = (),
) -> list[Contrast]:
    """Contrast of a face of one material against level ground of another, in each band.

    Parameters
    ----------
    folder : path
        Folder of a finished build.
    material, background : str
    band : str, optional
        One band by its name; by default all.
    state : int
        Counted from 1.
    source : {'sun', 'moon'}
    range : float
        Distance from the observer [km].
    elevation, heading : float
        Elevation and azimuth of the line of sight at the observer [degree].
    altitude : float, optional
        Altitude of the surfaces [km]; by default the lowest of the tables.
    slope, azimuth : float
        Slope and azimuth of the material's surface [degree].
    shade : sequence of str
        Intervals such as 10:00-14:00 in which no light comes to the material's face from the direction of the Sun.

    Raises
    ------
    InputError
        A database, a material or a place is missing, or a face is turned away from the observer.

    Examples
    --------
    >>> import skyshine.mat
    >>> job = {
    ...     "skyshine": 1,
    ...     "name": "road and lawn",
    ...     "site": {"latitude_deg": 45, "longitude_deg": 9, "date": "2026-06-21", "utc_offset_h": 1},
    ...     "states": [{"profile": "midlatitude_summer", "weather": {"air_temperature_c": [15, 29]}}],
    ...     "bands": [{"wavelength_um": [10, 10.2]}],
    ...     "sources": ["sun"],
    ...     "materials": ["asphalt_road", "grass_green"],
    ...     "atmosphere_grid": {
    ...         "tolerance": "5 K",
    ...         "range_km": [0.1, 1, 2],
    ...         "altitude_km": [0.1, 2],
    ...         "elevation_deg": [-90, -45, 0],
    ...         "source_elevation_deg": [-10, 0, 30, 75],
    ...         "source_azimuth_deg": [0, 90, 180],
    ...     },
    ...     "surface_grid": {"altitude_km": [0], "azimuth_deg": [0], "slope_deg": [0]},
    ...     "output": {"pictures": False},
    ... }
    >>> built = skyshine.mat.build(job, out="lawn", jobs=1)
    >>> (day,) = skyshine.mat.contrast("lawn", "asphalt_road", "grass_green")
    >>> bool(day.contrast.max() > 10)
    True
    """
    try:
        intervals = tuple(clock_interval(text) for text in shade)
    except ValueError as error:
        raise InputError(f"shade: {error}") from None
    face = Face(material, slope, azimuth, intervals)
    sight = Sight(range, elevation, heading, altitude)
    return contrast_of_faces(Path(folder), face, Face(background), sight, band=band, state=state, source=source)
