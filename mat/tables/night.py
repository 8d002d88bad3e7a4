"""Atmospheric tables while their source is below its lowest elevation: only the emission of the air remains.

Between the lowest node and the elevation `dark_below` at which twilight ends, the light of the source falls linearly to
0, if the node lies in deep twilight; from a higher node it would fall far too slowly, and such elevations are refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.mat.tables.axes import AxisRule
from skyshine.schemas.arrays import Booleans

# Elevations [degree] of the centre of the Sun at which astronomical and civil twilight end (Explanatory Supplement to
# the Astronomical Almanac, Seidelmann 1992, section 9.33).
ASTRONOMICAL_TWILIGHT, CIVIL_TWILIGHT = -18.0, -6.0
SOURCE_ELEVATION = "source_elevation"


def dark_elevation(highest_km: float) -> float:
    """Elevation [degree] of a source at and below which an observer up to an altitude [km] sees no light of it.

    Astronomical twilight has then ended at all points of the ground that the observer sees: their distance to the
    horizon, as an angle at the centre of the Earth, is added. No source is below the nadir.
    """
    radius = EARTH_RADIUS / 1e3
    horizon = np.degrees(np.arccos(radius / (radius + max(highest_km, 0.0))))
    return float(max(ASTRONOMICAL_TWILIGHT - horizon, -90.0))


@dataclass(frozen=True, eq=False)
class Night:
    """Which light of the source is read below its lowest elevation.

    Attributes
    ----------
    rule : AxisRule
        Axis of the source elevation.
    """

    rule: AxisRule

    @property
    def lowest(self) -> float:
        """The first node [degree]."""
        return float(self.rule.nodes[0])

    @property
    def dark_below(self) -> float:
        """The elevation at and below which there is no light of the source [degree]."""
        return self.rule.dark_below

    def lacks(self, elevation: npt.ArrayLike) -> Booleans:
        """Which elevations [degree] are in a twilight that the file does not have, for its lowest node is too high."""
        height = np.asarray(elevation, float)
        lacking: Booleans = (self.lowest > CIVIL_TWILIGHT) & (height < self.lowest) & (height > self.dark_below)
        return lacking
