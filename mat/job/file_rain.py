"""Rain of a typical or measured year, EPW or TMY3: depths that fell in the hours before a reading, as rates by hour."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.job.typical_years import RAIN_DEPTH, RAIN_HOURS, YearFile
from skyshine.schemas.arrays import Floats

_LONGEST = 24  # hours over which a depth may have been gathered


def hourly_rain(year: YearFile, hours: Sequence[int]) -> Floats:
    """Rain in the hour that ends at each reading [mm h^-1]; NaN where the file tells none.

    Parameters
    ----------
    hours : sequence of int
        Numbers of readings.

    Notes
    -----
    A depth is with the hours over which it was gathered, which end at its reading (EnergyPlus, Auxiliary Programs,
    "Liquid Precipitation Depth" and "Quantity"; Wilcox and Marion 2008, table 1-3), one where they are missing. What a
    depth of several hours has beyond those that readings among them tell falls evenly in the others, whose readings
    tell none or 0: files write 0 for hours that nobody read.

    Raises
    ------
    InputError
        With file:line:column of what is no depth.
    """
    longest = _LONGEST * year.per_hour
    low, high = min(hours), min(max(hours) + longest, len(year.readings))
    low = max(low - longest, 0)
    span = range(low, high)
    depth, gathered = (year.values(name, span) for name in (RAIN_DEPTH, RAIN_HOURS))
    readings = np.where(np.isfinite(gathered), gathered * year.per_hour, 1.0)
    spans = np.clip(readings, 1.0, longest).round().astype(int)
    rain = np.where(spans == 1, depth, np.nan)
    for end in np.flatnonzero((spans > 1) & np.isfinite(depth)):
        part = np.arange(max(end - spans[end] + 1, 0), end + 1)
        known_rain = np.nan_to_num(rain[part])
        silent = part[known_rain <= 0]
        if silent.size:
            rain[silent] = max(depth[end] - known_rain.sum(), 0.0) / silent.size
    chosen: Floats = rain[np.asarray(hours) - low] * year.per_hour
    return chosen
