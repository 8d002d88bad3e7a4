"""The nodes and sources of a job that its query limits read."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from math import prod
from typing import Any

import numpy as np

from skyshine.mat.job.fields import Span
from skyshine.mat.job.model import Job
from skyshine.mat.job.query_limits import QueryLimits
from skyshine.mat.job.site import local_times_utc

# The source is elsewhere in the sky at the far end of a line of sight, and in another second: degree beyond its own
# elevations.
SOURCE_MARGIN = 5.0
STEP_H = 1 / 12  # between the times at which the sources are placed
_LINE_AXES = ("range_km", "altitude_km", "elevation_deg")


def limited_axes(job: Job, limits: QueryLimits) -> Iterator[tuple[str, str, str, list[float], Span]]:
    """Axes with a limit: its key in `needs`, grid and name of the axis, the nodes of the job, the limit."""
    atmosphere, surface = job.atmosphere_grid, job.surface_grid
    for key, grid, name, nodes in (
        ("range_km", "atmosphere_grid", "range_km", atmosphere.range_km),
        ("observer_altitude_km", "atmosphere_grid", "altitude_km", job.observer_altitudes_km),
        ("elevation_deg", "atmosphere_grid", "elevation_deg", atmosphere.elevation_deg),
        ("source_elevation_deg", "atmosphere_grid", "source_elevation_deg", atmosphere.source_elevation_deg),
        ("source_azimuth_deg", "atmosphere_grid", "source_azimuth_deg", atmosphere.source_azimuth_deg),
        ("surface_altitude_km", "surface_grid", "altitude_km", job.surface_altitudes_km),
        ("slope_deg", "surface_grid", "slope_deg", surface.slope_deg),
    ):
        limit = getattr(limits, key)
        if limit is not None:
            yield key, grid, name, nodes, limit


def trimmed(job: Job) -> Job:
    """The job with the nodes and sources that its query limits read; the same job where it has none."""
    limits = job.query_limits
    if limits is None:
        return job
    changes: dict[str, dict[str, Any]] = {"atmosphere_grid": {}, "surface_grid": {}}
    # Tables on written axes keep their nodes; between the ends of other axes a tolerance places nodes anew.
    cut = {
        "atmosphere_grid": around if job.atmosphere_grid.writes_tables else between,
        "surface_grid": around if job.surface_grid.tolerance is None else between,
    }
    for _, grid, name, nodes, limit in limited_axes(job, limits):
        changes[grid][name] = cut[grid](nodes, *limit)
    if limits.faces_deg is not None:
        slopes, azimuths = limits.face_axes_deg
        if any(state.ground_material is not None for state in job.states):
            slopes = sorted({0.0, *slopes})  # the ground around faces is level, and read too
        changes["surface_grid"] |= {"slope_deg": slopes, "azimuth_deg": azimuths}
    sources = job.sources if limits.sources is None else limits.sources
    if limits.hours is not None:
        heights = source_elevations(job, limits.hours)
        lowest = job.atmosphere_grid.source_elevation_deg[0]
        if limits.sources is None:
            sources = [source for source in job.sources if heights[source][1] >= lowest] or job.sources[:1]
        spans = [heights[source] for source in sources]
        air = changes["atmosphere_grid"]
        nodes = air.get("source_elevation_deg", job.atmosphere_grid.source_elevation_deg)
        air["source_elevation_deg"] = cut["atmosphere_grid"](
            nodes, min(low for low, _ in spans), max(high for _, high in spans)
        )
    update: dict[str, Any] = {"sources": sources}
    for name, changed in changes.items():
        grid = getattr(job, name)
        update[name] = grid.model_copy(update=changed)
        update[name].model_fields_set.intersection_update(grid.model_fields_set)  # what is trimmed is not written
    return job.model_copy(update=update)


def read_share(requested: Job, trimmed: Job) -> float:
    """Share of the cells of range, altitude and elevation of the observer that are left of a job's."""
    all_axes, axes = requested.sampled_axes(), trimmed.sampled_axes()
    cells = [(max(1, len(axes[name]) - 1), max(1, len(all_axes[name]) - 1)) for name in _LINE_AXES]
    return prod(min(1.0, remaining / total) for remaining, total in cells)


def around(nodes: list[float], low: float, high: float) -> list[float]:
    """The nodes between two values, with the next beyond each; what lies beyond the ends has the end."""
    start = max(0, min(bisect_right(nodes, low) - 1, len(nodes) - 1))
    stop = max(0, min(bisect_left(nodes, high), len(nodes) - 1))
    return nodes[start : stop + 1]


def between(nodes: list[float], low: float, high: float) -> list[float]:
    """The nodes between two values and these themselves; what lies beyond the ends has the end."""
    low, high = (min(max(value, nodes[0]), nodes[-1]) for value in (low, high))
    return sorted({low, *(node for node in nodes if low < node < high), high})


def hours_around(times: list[float], hours: Span | None) -> list[float]:
    """Times of day between two of the clock, the first and the last, with the next beyond each; all of them where that
    is nearly all.

    Those after midnight follow as 24 and more, so that they ascend.
    """
    if hours is None:
        return times
    start, stop = hours
    turns = [time + turn for turn in (-24.0, 0.0, 24.0, 48.0) for time in times]
    stop += 24.0 if stop < start else 0.0
    nearby = turns[bisect_right(turns, start) - 1 : bisect_left(turns, stop) + 1]
    if len(nearby) >= len(times):
        return times
    return [time + 24.0 for time in nearby] if nearby[0] < 0 else nearby


def source_elevations(job: Job, hours_asked: Span) -> dict[str, Span]:
    """Lowest and highest elevation [degree] of each source between two hours of the local clock, over the dates of all
    states, with a margin.
    """
    from skyshine.mat.atmosphere.sources.ephemeris import position

    start, stop = hours_asked
    hours = np.append(
        np.arange(start, stop + (24.0 if stop < start else 0.0), STEP_H), stop + (24.0 if stop < start else 0.0)
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
