"""The scattering angle of a source's light into a line of sight, a coordinate in place of the source's azimuth.

Light that particles scatter depends on this angle most of all, within a few degrees of the source steeply. A table by
azimuth needs close nodes of both elevations and of azimuth to follow it; a table by scattering angle follows it on one
axis.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats

_LEVEL = 1e-9  # product of cosines below which line or source is at the zenith or nadir: azimuth is undefined there


def scattering_angle(
    elevation: npt.ArrayLike, source_elevation: npt.ArrayLike, source_azimuth: npt.ArrayLike
) -> Floats:
    """Angle [degree] between line of sight and source, 0 to 180.

    Parameters
    ----------
    elevation, source_elevation : array_like
        Elevations of the line of sight and of the source [degree].
    source_azimuth : array_like
        Azimuth of the source from that of the line of sight [degree].

    Returns
    -------
    ndarray
        Of the arguments' common shape.

    References
    ----------
    The haversine formula, which keeps its digits for small angles.
    """
    line, source = np.radians(elevation), np.radians(source_elevation)
    half = (
        np.sin((line - source) / 2) ** 2 + np.cos(line) * np.cos(source) * np.sin(np.radians(source_azimuth) / 2) ** 2
    )
    angle: Floats = 2 * np.degrees(np.arcsin(np.sqrt(np.clip(half, 0.0, 1.0))))
    return angle


def azimuth_at(
    elevation: npt.ArrayLike, source_elevation: npt.ArrayLike, angle: npt.ArrayLike
) -> tuple[Floats, Floats]:
    """The azimuth of a source at which its light is scattered by an angle.

    Parameters
    ----------
    elevation, source_elevation, angle : array_like
        Elevations of the line of sight and the source, and the angle between the two [rad].

    Returns
    -------
    azimuth, excess : ndarrays
        Azimuth, 0 to pi, and the part of the angle that no azimuth gives [rad]: 0 wherever the two elevations allow
        the angle, otherwise the (signed) distance to the nearest angle they allow.
    """
    elevation, source_elevation, angle = np.broadcast_arrays(elevation, source_elevation, angle)
    rise, level = np.sin(elevation) * np.sin(source_elevation), np.cos(elevation) * np.cos(source_elevation)
    turning = level > _LEVEL
    azimuth = np.arccos(
        np.where(turning, np.clip((np.cos(angle) - rise) / np.where(turning, level, 1.0), -1.0, 1.0), 1.0)
    )
    return azimuth, angle - np.radians(scattering_angle(*np.degrees([elevation, source_elevation, azimuth])))
