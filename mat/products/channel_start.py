"""Nodes of tables in channels from which placing starts."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from skyshine.mat.quantities.channels.nodes import ChannelNodes, NodeCounts
from skyshine.mat.quantities.grid import PathGrid

FEWEST = 0.5  # share of `NodeCounts` from which placing starts where the tolerance is coarse
# Limits of observers whose heights are limited: the fewest from which placing starts, and the span of the cube roots of
# heights [km^(1/3)], 0 to 40 km, over which all of `NodeCounts` are spread.
_FEWEST_HEIGHTS, _HEIGHT_SPAN = 3, 3.42


def channel_nodes(base: PathGrid, ground_km: float, counts: NodeCounts) -> ChannelNodes:
    """So many nodes between the ends of a job's axes, over a ground; fewer over few heights of observers."""
    lowest, highest = (max(float(altitude) - ground_km, 0.0) for altitude in base.altitude_km[[0, -1]])
    lowest_elevation, highest_elevation = base.source_elevation_deg[[0, -1]]
    span = float(np.cbrt(highest) - np.cbrt(lowest))
    limit = max(_FEWEST_HEIGHTS, math.ceil(counts.height * span / _HEIGHT_SPAN))
    counts = replace(counts, height=min(counts.height, limit))
    return ChannelNodes.of(counts, (lowest, highest), (float(lowest_elevation), float(highest_elevation)))
