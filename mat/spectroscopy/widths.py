"""Widths of the intervals of the band model, and their maximum numbers of points, by wavenumber."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


@dataclass(frozen=True)
class Region:
    """Intervals from `low` cm^-1 to the next region's: their width in cm^-1, a divisor of the region, and the largest
    number of points.
    """

    low: float
    width: float
    max_points: int


# 5 cm^-1 where sensors look at heat; wider where only broadband fluxes (below 330 cm^-1) or sunlight (beyond 5000
# cm^-1) matter and the lines thin out. H2O lines end at 25,711 cm^-1; beyond 28,000 cm^-1 absorption by ozone grows
# fast enough to need steps of 25.
REGIONS = (
    Region(10.0, 10.0, 12),
    Region(330.0, 5.0, 64),
    Region(5000.0, 20.0, 10),
    Region(9000.0, 50.0, 8),
    Region(17000.0, 100.0, 6),
    Region(28000.0, 25.0, 4),
)
HIGHEST = 33400.0  # cm^-1, the first edge beyond 0.3 um


def interval_edges(low: float, high: float, width: float | None = None) -> Floats:
    """Edges (I, 2) of the intervals that cover [low, high] cm^-1: those of `REGIONS`, or all of a width [cm^-1].

    Raises
    ------
    InputError
        The range is empty, or part of it lies outside 10 to 33,400 cm^-1.
    """
    if not 0 < low < high:
        raise InputError(f"wavenumbers {low:g}:{high:g} are no range; give LO:HI in cm^-1 with 0 < LO < HI")
    if low < REGIONS[0].low or high > HIGHEST:
        raise InputError(
            f"wavenumbers {low:g}:{high:g} are not within {REGIONS[0].low:g}:{HIGHEST:g} cm^-1; give a range inside"
        )
    if width is not None:
        count = round((high - low) / width)
        if not (width > 0 and count >= 1 and abs(count * width - (high - low)) < 1e-6):
            raise InputError(f"found the width {width:g} cm-1 for {low:g}:{high:g} cm-1; give a divisor of the range")
        lows = low + width * np.arange(count + 1)
        return np.stack([lows[:-1], lows[1:]], axis=1)
    ends = [*(region.low for region in REGIONS[1:]), HIGHEST]
    starts = np.concatenate([np.arange(r.low, end, r.width) for r, end in zip(REGIONS, ends, strict=True)])
    edges = np.stack([starts, np.append(starts[1:], HIGHEST)], axis=1)
    return np.asarray(edges[(edges[:, 1] > low) & (edges[:, 0] < high)])


def max_points(low: float) -> int:
    """Largest number of points of the interval that begins at `low` cm^-1."""
    return [region for region in REGIONS if region.low <= low][-1].max_points
