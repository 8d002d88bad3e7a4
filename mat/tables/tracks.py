"""Positions of Sun and Moon through a day and the night after it, in a ``.htt`` database."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.tables.axes import AxisRule, table_axis
from skyshine.mat.tables.interpolation import interpolate
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Variable

TRACK_TIME = "track_time"
TRACK_END_H, TRACK_STEP_H = 36.0, 1 / 12  # h: the day and the night after it, every 5 minutes
SOURCES = ("sun", "moon")
# Elevation of the Sun's centre at sunrise and sunset [degree]: radius 0.267 and refraction 0.567 below the horizon.
SUNRISE_ELEVATION = -0.833
_ABOVE = "above the horizon, without refraction"
_DESCRIBED = {
    "sun_elevation": ("degree", f"elevation of the centre of the Sun {_ABOVE}"),
    "sun_azimuth": ("degree", "azimuth of the Sun, from north eastward; without jumps, to be taken modulo 360"),
    "sun_distance": ("au", "distance of the Sun from the observer"),
    "moon_elevation": ("degree", f"elevation of the centre of the Moon {_ABOVE}"),
    "moon_azimuth": ("degree", "azimuth of the Moon, from north eastward; without jumps, to be taken modulo 360"),
    "moon_distance": ("km", "distance of the Moon from the observer"),
    "moon_phase_angle": ("degree", "angle Sun - Moon - observer: 0 full, 180 new"),
    "moon_illuminated_fraction": ("1", "illuminated share of the disc of the Moon"),
}


@dataclass(frozen=True, eq=False)
class SourceTrack:
    """Positions of a source at given times.

    Attributes
    ----------
    elevation, azimuth : ndarray
        Geometric; from north eastward, 0 to 360 [degree].
    distance : ndarray
        Distance from the observer: of the Sun [au], of the Moon [km].
    phase_angle : ndarray
        Angle Sun - Moon - observer, 0 for the Sun [degree].
    illuminated_fraction : ndarray
        Illuminated fraction of the disc.
    """

    elevation: Floats
    azimuth: Floats
    distance: Floats
    phase_angle: Floats
    illuminated_fraction: Floats


def track_hours() -> Floats:
    """Local clock hours of the tracks, from midnight over the night after the day."""
    hours: Floats = np.arange(float(round(TRACK_END_H / TRACK_STEP_H) + 1)) * TRACK_STEP_H
    return hours


def track_fields(tracks: Mapping[str, Floats]) -> tuple[dict[str, Axis], dict[str, Variable]]:
    """Axis and arrays of the tracks.

    Parameters
    ----------
    tracks : mapping of str to ndarray
        Elevation, azimuth and distance of ``sun`` and ``moon`` as ``sun_elevation`` and so on, and
        ``moon_phase_angle``, at `track_hours`, in the units of the file.
    """
    fraction = np.cos(np.radians(tracks["moon_phase_angle"]) / 2) ** 2
    arrays = {**tracks, "moon_illuminated_fraction": fraction}
    axes = {TRACK_TIME: table_axis(track_hours(), "h", "local clock time, beyond 24 on the next day")}
    return axes, {
        name: Variable((TRACK_TIME,), arrays[name].astype(np.float32), *described)
        for name, described in _DESCRIBED.items()
    }


def source_track(root: Group, source: str, time: npt.ArrayLike) -> SourceTrack:
    """Read the track of the Sun or the Moon.

    Parameters
    ----------
    root : Group
        Root group of a ``.htt`` database.
    source : {'sun', 'moon'}
    time : array_like
        Local clock [h], 0 to 36.

    Raises
    ------
    InputError
        Another source, a time beyond the track, or a file without tracks.
    """
    if source not in SOURCES:
        raise InputError(f"found the source '{source}'; allowed: {', '.join(SOURCES)}")
    if TRACK_TIME not in root.axes or any(name not in root.variables for name in _DESCRIBED):
        raise InputError("the file contains no tracks of Sun and Moon; build it again")
    rule = AxisRule.of(TRACK_TIME, root.axes[TRACK_TIME])

    def at(name: str) -> Floats:
        return interpolate(np.asarray(root.variables[name].data), [rule], {TRACK_TIME: np.asarray(time, float)})

    elevation, azimuth, distance = (at(f"{source}_{name}") for name in ("elevation", "azimuth", "distance"))
    if source == "sun":
        phase, fraction = np.zeros_like(elevation), np.ones_like(elevation)
    else:
        phase, fraction = at("moon_phase_angle"), at("moon_illuminated_fraction")
    return SourceTrack(elevation, np.mod(azimuth, 360.0), distance, phase, fraction)
