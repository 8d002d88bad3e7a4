"""The axes of a table's lines of sight, as the transfer reads them from `quantities.grid.PathGrid`."""

from __future__ import annotations

from typing import Protocol

from skyshine.schemas.arrays import Floats


class PathAxes(Protocol):
    """Axes of the atmospheric tables, each a strictly increasing array."""

    @property
    def range_km(self) -> Floats:
        """Range (R,) [km]."""

    @property
    def altitude_km(self) -> Floats:
        """Altitude (A,) of the observer above sea level [km]."""

    @property
    def elevation_deg(self) -> Floats:
        """Elevation (E,) of the line of sight at the observer [degree]."""

    @property
    def source_elevation_deg(self) -> Floats:
        """Elevation (SE,) of the source [degree]."""

    @property
    def source_azimuth_deg(self) -> Floats:
        """Azimuth (SA,) of the source from that of the line of sight, or its scattering angle [degree]."""
