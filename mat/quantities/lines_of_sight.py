"""Lines of sight, and the direction of a source beside them, for all readers of atmospheric quantities."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class LinesOfSight:
    """Lines of sight of any shape, each from an observer over a range; the source is None where none matters.

    Attributes
    ----------
    range, altitude : (...) array
        km; the length of the line, and the observer above sea level.
    elevation : (...) array
        Elevation of the line above the horizontal at the observer, degree.
    source_elevation, source_azimuth : (...) array, optional
        Elevation and azimuth of the source, degree; azimuth relative to that of the line.

    Examples
    --------
    >>> import numpy as np
    >>> lines = LinesOfSight(np.array([1.0, 2.0]), np.array([0.5, 0.5]), np.array([-30.0, -15.0]))
    >>> {name: values.tolist() for name, values in lines.path.items()}
    {'range': [1.0, 2.0], 'altitude': [0.5, 0.5], 'elevation': [-30.0, -15.0]}
    """

    range: Floats
    altitude: Floats
    elevation: Floats
    source_elevation: Floats | None = None
    source_azimuth: Floats | None = None

    @property
    def path(self) -> dict[str, Any]:
        """Values by the names of the axes of transmittance."""
        return {"range": self.range, "altitude": self.altitude, "elevation": self.elevation}

    @property
    def lit(self) -> dict[str, Any]:
        """Values by the names of the axes of light on surfaces."""
        return self.path | {"source_elevation": self.source_elevation}

    @property
    def whole(self) -> dict[str, Any]:
        """Values by the names of the axes of path radiance."""
        return self.lit | {"source_azimuth": self.source_azimuth}

    @property
    def place(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Range, altitude, elevation, source elevation and azimuth, as `BandAtmosphere` computes quantities there."""
        assert self.source_elevation is not None and self.source_azimuth is not None  # lines with a source
        return self.range, self.altitude, self.elevation, self.source_elevation, self.source_azimuth

    def take(self, index: Any) -> Self:
        """Some of them; parts (n, ...) are indexed along their first axis."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        return replace(self, **{name: part[index] for name, part in parts.items() if part is not None})


def direction(elevation: npt.ArrayLike, azimuth: npt.ArrayLike) -> Floats:
    """Unit vectors (..., 3) to east, north and up of directions in degree."""
    up, turn = np.radians(np.asarray(elevation, float)), np.radians(np.asarray(azimuth, float))
    return np.stack([np.cos(up) * np.sin(turn), np.cos(up) * np.cos(turn), np.sin(up) + 0.0 * turn], axis=-1)


def slope_and_azimuth(normal: Floats) -> tuple[Floats, Floats]:
    """Slope from the zenith and azimuth from north eastward (...,) of unit vectors (..., 3) [degree]."""
    level = np.hypot(normal[..., 0], normal[..., 1])
    slope = np.degrees(np.arctan2(level, normal[..., 2]))
    azimuth = np.mod(np.degrees(np.arctan2(normal[..., 0], normal[..., 1])), 360.0)
    return slope, np.where(level > 1e-12, azimuth, 0.0)
