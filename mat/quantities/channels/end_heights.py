"""Lowering of the ends of paths by refraction, and its effect on the direct beam there.

The sphere of `coordinates.RayCoordinates` bends every path by as much as the one that grazes the ground. Paths that
leave the air are bent less: their ends are higher, by kilometres at ranges of hundreds. Near sunrise that is the
difference between light and shadow. So the end is counted from that of a straight line over the real Earth, from which
refraction takes a share of the range that is bounded: the angle by which the path is bent.
"""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.grid import lines_of_sight
from skyshine.schemas.arrays import Floats

_NEAR_KM = 1e-5  # up to which paths are straight
_ABOVE_RISE = (0.05, 0.2, 0.4, 0.7, 1.2, 2.0)  # degree, of a source that has just risen for the end of the path


def end_rise(rays: RayCoordinates, root: float, elevation: float, path: LineOfSight) -> Floats:
    """Height of the end of each range (X,) of a path above that of a straight line, over the range: below 0.

    Parameters
    ----------
    root : float
        Cube root of the observer's height [km^(1/3)].
    elevation : float
        Elevation of the line at the observer, degree.
    """
    ranges = (path.length + path.beyond) / 1e3
    higher = path.surface_altitude / 1e3 - rays.ground_km - rays.straight_height(ranges, root, elevation)
    away = ranges > _NEAR_KM
    rise: Floats = np.where(away, higher, 0.0) / np.where(away, ranges, 1.0)
    return rise


def largest_change_of_beam(
    atmosphere: BandAtmosphere,
    rays: RayCoordinates,
    irradiance: Floats,
    source_elevation: tuple[float, float],
    lines: tuple[Floats, Floats, Floats],
) -> float:
    """What ends on the sphere of the coordinates instead of the real ones change at most of direct irradiance over pi
    at the longest ranges of sample lines, as the paths let it through [W m^-2 sr^-1].

    Parameters
    ----------
    atmosphere : BandAtmosphere
        Prepared.
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
    source_elevation : pair of float
        Lowest and highest, degree.
    lines : arrays
        Altitude [km] and elevation [degree], (n,), and ranges [km], (n, R), of the lines.
    """
    altitude, elevation, ranges = lines
    air, light = atmosphere.air, atmosphere.band.radiance_weight * irradiance / np.pi
    low, high = np.radians(source_elevation)
    largest = 0.0
    for row, path in enumerate(lines_of_sight(air, ranges, altitude, elevation)):
        inside = np.flatnonzero(path.valid)
        if not inside.size:
            continue
        end = inside[-1]
        on_sphere = float(rays.locate(ranges[row, end], altitude[row], elevation[row]).end_height)
        heights = np.array([path.surface_altitude[end], air.state.surface_altitude + on_sphere * 1e3])
        rise = air.source_rays.rise_at(heights[:1])[0]
        beam = direct_transmittance(air.source_paths, heights, np.clip(rise + np.radians(_ABOVE_RISE), low, high))
        change = (beam[1] - beam[0]) @ (light * np.exp(-path.depth[end]))
        largest = max(largest, float(np.abs(change).max()))
    return largest
