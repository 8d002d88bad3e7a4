"""The distant sources of one line of sight: their directions, and the scattering angles of their light into it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Rays, scattering_cosine, source_cosine
from skyshine.mat.radiometry.scattering_angle import azimuth_at
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class LineSources:
    """S sources of one line of sight.

    Attributes
    ----------
    elevation, azimuth : (S,) arrays
        Geometric, at the observer, rad; azimuth from that of the line of sight.
    excess : (S,) array
        Part of the scattering angle that no azimuth gives, as in `scattering_angle.azimuth_at`, rad.
    """

    elevation: Floats
    azimuth: Floats
    excess: Floats

    @classmethod
    def at(cls, elevation: Floats, azimuth: Floats) -> LineSources:
        """Sources by elevation and azimuth (S,) [rad]."""
        return cls(elevation, azimuth, np.zeros(elevation.shape))

    @classmethod
    def at_angle(cls, line_elevation: float, elevation: Floats, angle: Floats) -> LineSources:
        """Sources by elevation and scattering angle (S,), of a line of sight at an elevation [rad]."""
        return cls(elevation, *azimuth_at(line_elevation, elevation, angle))

    @classmethod
    def of_axes(cls, elevation: Floats, azimuth: Floats) -> LineSources:
        """All pairs of an elevation (SE,) and an azimuth (SA,) [rad], S = SE * SA."""
        return cls.at(np.repeat(elevation, azimuth.size), np.tile(azimuth, elevation.size))

    def to_source(self, rays: Rays) -> Floats:
        """Cosine of the sources' zenith angle at the segment ends of one ray, (K+1, S)."""
        cosine: Floats = source_cosine(rays, self.elevation, self.azimuth)[0]
        return cosine

    def deflection(self, rays: Rays) -> Floats:
        """Cosine of the scattering angle at the segment ends of one ray, (K+1, S)."""
        return self._with_excess(scattering_cosine(rays, self.elevation, self.azimuth)[0])

    def local_deflection(self, line_elevation: float) -> Floats:
        """Cosine of the scattering angle (S,) at the observer of a line of sight at an elevation [rad]."""
        direction = np.pi / 2 - line_elevation
        return self._with_excess(
            np.sin(self.elevation) * np.cos(direction)
            + np.cos(self.elevation) * np.cos(self.azimuth) * np.sin(direction)
        )

    def _with_excess(self, cosine: Floats) -> Floats:
        """Cosines (..., S) of scattering angles with the excess added."""
        if not np.any(self.excess):
            return cosine
        cosine_with_excess: Floats = np.cos(np.clip(np.arccos(np.clip(cosine, -1.0, 1.0)) + self.excess, 0.0, np.pi))
        return cosine_with_excess
