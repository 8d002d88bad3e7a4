"""The angle that a source's light is turned by into a line of sight, as a coordinate in place of the source's azimuth.

Light that particles scatter depends on this angle most of all, within a few degrees of the source steeply. A table by
azimuth needs close nodes of both elevations and of azimuth to follow it; a table by scattering angle follows it on one
axis.
"""

from __future__ import annotations

import numpy as np

_LEVEL = 1e-9  # product of cosines below which line or source stands in the zenith or nadir, and azimuth means nothing


def scattering_angle(elevation, source_elevation, source_azimuth):
    """Angle [degree] between line of sight and source, 0 to 180; the azimuth is relative to the line of sight;
    arguments in degree.
    """
    line, source = np.radians(elevation), np.radians(source_elevation)
    half = (
        np.sin((line - source) / 2) ** 2 + np.cos(line) * np.cos(source) * np.sin(np.radians(source_azimuth) / 2) ** 2
    )
    return 2 * np.degrees(np.arcsin(np.sqrt(np.clip(half, 0.0, 1.0))))


def azimuth_at(elevation, source_elevation, angle):
    """The azimuth at which light is scattered by an angle, and what no azimuth makes up for; all in rad.

    Parameters
    ----------
    elevation, source_elevation, angle : arrays
        Of the line of sight, the source, and between the two.

    Returns
    -------
    azimuth, rest : arrays
        Azimuth 0 to pi. The rest is 0 where line and source can stand so; it is the smallest turn that is left where
        they cannot.
    """
    elevation, source_elevation, angle = np.broadcast_arrays(elevation, source_elevation, angle)
    rise, level = np.sin(elevation) * np.sin(source_elevation), np.cos(elevation) * np.cos(source_elevation)
    turning = level > _LEVEL
    azimuth = np.arccos(
        np.where(turning, np.clip((np.cos(angle) - rise) / np.where(turning, level, 1.0), -1.0, 1.0), 1.0)
    )
    return azimuth, angle - np.radians(scattering_angle(*np.degrees([elevation, source_elevation, azimuth])))
