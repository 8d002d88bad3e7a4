"""The nodes and sources of a job that its query limits read."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import Any

import numpy as np

from skyshine.mat.job.fields import Span
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import local_times_utc

# The source stands elsewhere at the far end of a line of sight, and in another second: degree beyond its own
# elevations.
SOURCE_MARGIN = 5.0
STEP_H = 1 / 12  # between the times at which the sources are placed


def trimmed(job: Job) -> Job:
    """The job with the nodes and sources that its query limits read; the same job where it has none."""
    query_limits = job.query_limits
    if query_limits is None:
        return job
    air: dict[str, list[float]] = {}
    surface: dict[str, list[float]] = {}
    for grid, key, nodes, limits in (
        (air, "range_km", job.atmosphere_grid.range_km, query_limits.range_km),
        (air, "altitude_km", job.observer_altitudes_km, query_limits.observer_altitude_km),
        (air, "elevation_deg", job.atmosphere_grid.elevation_deg, query_limits.elevation_deg),
        (surface, "altitude_km", job.surface_altitudes_km, query_limits.surface_altitude_km),
        (surface, "slope_deg", job.surface_grid.slope_deg, query_limits.slope_deg),
    ):
        if limits is not None:
            grid[key] = around(nodes, *limits)
    sources = job.sources
    if query_limits.hours is not None:
        heights = source_elevations(job, query_limits.hours)
        lowest = job.atmosphere_grid.source_elevation_deg[0]
        sources = [source for source in job.sources if heights[source][1] >= lowest] or job.sources[:1]
        spans = [heights[source] for source in sources]
        air["source_elevation_deg"] = around(
            job.atmosphere_grid.source_elevation_deg, min(low for low, _ in spans), max(high for _, high in spans)
        )
    update: dict[str, Any] = {"sources": sources}
    for name, changes in (("atmosphere_grid", air), ("surface_grid", surface)):
        grid = getattr(job, name)
        update[name] = grid.model_copy(update=changes)
        update[name].model_fields_set.intersection_update(grid.model_fields_set)  # what is trimmed is not written
    return job.model_copy(update=update)


def around(nodes: list[float], low: float, high: float) -> list[float]:
    """The nodes between two values, with the next beyond each; what lies beyond the ends has the end."""
    first = max(0, min(bisect_right(nodes, low) - 1, len(nodes) - 1))
    last = max(0, min(bisect_left(nodes, high), len(nodes) - 1))
    return nodes[first : last + 1]


def hours_around(times: list[float], hours: Span | None) -> list[float]:
    """Times of day between two of the clock, the first and the last, with the next beyond each; all of them where that
    is nearly all.

    Those after midnight follow as 24 and more, so that they ascend.
    """
    if hours is None:
        return times
    first, last = hours
    turns = [time + turn for turn in (-24.0, 0.0, 24.0, 48.0) for time in times]
    last += 24.0 if last < first else 0.0
    kept = turns[bisect_right(turns, first) - 1 : bisect_left(turns, last) + 1]
    if len(kept) >= len(times):
        return times
    return [time + 24.0 for time in kept] if kept[0] < 0 else kept


def source_elevations(job: Job, hours_asked: Span) -> dict[str, Span]:
    """Lowest and highest elevation [degree] of each source between two hours of the local clock, over the dates of all
    states, with a margin.
    """
    from skyshine.mat.atmosphere.sources.ephemeris import position

    first, last = hours_asked
    hours = np.append(
        np.arange(first, last + (24.0 if last < first else 0.0), STEP_H), last + (24.0 if last < first else 0.0)
    )
    elevations: dict[str, Span] = {}
    for source in job.sources:
        heights = [
            position(
                source,
                local_times_utc(job.on_date_of_state(k).site, hours),
                job.site.latitude_deg,
                job.site.longitude_deg,
            ).elevation
            for k in range(1, len(job.states) + 1)
        ]
        elevations[source] = (float(np.min(heights)) - SOURCE_MARGIN, float(np.max(heights)) + SOURCE_MARGIN)
    return elevations
