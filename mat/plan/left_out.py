"""What a job leaves out of its tables, with the bound of the change and how to restore it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.job.trim import hours_around, read_share
from skyshine.materials.library import MaterialLibrary

PLACED_BOUND = "within that of the table: as many times are placed between the hours as would be equally spaced"
ANEW_BOUND = "twice {} in 99 % of the reads: nodes are placed anew, with the same tolerance as those of the whole job"


@dataclass(frozen=True)
class LeftOut:
    """Something that the job does not need.

    Attributes
    ----------
    bound : str
        What leaving it out changes at most.
    restore : str
        The key that brings it back.
    """

    what: str
    why: str
    bound: str
    restore: str


def temperature_times(job: Job) -> list[float]:
    return hours_around(job.surface_grid.times, None if job.query_limits is None else job.query_limits.hours)


def tables_left_out(loaded: LoadedJob, library: MaterialLibrary, materials: tuple[str, ...]) -> list[LeftOut]:
    job, omissions = loaded.trimmed, []
    unused = set(library.names) - set(materials)
    if unused and job.materials == "used":
        omissions.append(
            LeftOut(f"{len(unused)} of {len(library)} materials", "no texture uses them", "none", "materials: all")
        )
    level = int(np.sum(np.isin(job.surface_grid.slope_deg, (0.0, 180.0))))
    if level and len(job.surface_grid.azimuth_deg) > 1:
        spared = level * (len(job.surface_grid.azimuth_deg) - 1)
        total = len(job.surface_grid.slope_deg) * len(job.surface_grid.azimuth_deg)
        omissions.append(
            LeftOut(
                f"{spared} of {total} orientations",
                "level surfaces face no azimuth: solved once and copied",
                "none",
                "nothing to restore: the table contains them",
            )
        )
    if not job.ambient_harmonics:
        omissions.append(
            LeftOut("harmonics of ambient light", "all faces are level", "none", "a slope above 0 in surface_grid")
        )
    omissions += _not_needed(loaded)
    for source, kind in (("sun", "atmq"), ("moon", "lunar_atmq")):
        if source not in loaded.requested.sources:
            omissions.append(
                LeftOut(f"{kind} tables", f"sources does not name the {source}", "none", f"sources: [{source}]")
            )
    return omissions


def _not_needed(loaded: LoadedJob) -> list[LeftOut]:
    """Nodes and sources that nothing within the job's needs reads."""
    job, requested, needs = loaded.trimmed, loaded.requested, loaded.trimmed.query_limits
    if needs is None:
        return []
    wide = "a wider needs.{0}, or none"
    all_axes, air = requested.atmosphere_axes(), job.atmosphere_axes()
    tolerance = job.surface_grid.tolerance
    times_bound = "none" if requested.surface_grid.time else PLACED_BOUND
    faces_bound = "none at these faces; others are not known"
    air_bound, surface_bound = ANEW_BOUND.format(job.atmosphere_grid.tolerance), "none"
    if tolerance is not None:
        surface_bound = times_bound = ANEW_BOUND.format(tolerance)
    source_key = "hours" if needs.source_elevation_deg is None else "source_elevation_deg"
    axes = [
        ("ranges", "range_km", "range_km", air_bound),
        ("observer altitudes", "altitude_km", "observer_altitude_km", air_bound),
        ("elevations", "elevation_deg", "elevation_deg", air_bound),
        ("source elevations", "source_elevation_deg", source_key, air_bound),
        ("source azimuths", "source_azimuth_deg", "source_azimuth_deg", air_bound),
    ]
    cases = [(name, key, all_axes[axis], air[axis], bound) for name, axis, key, bound in axes]
    cases += [
        (
            "surface altitudes",
            "surface_altitude_km",
            requested.surface_altitudes_km,
            job.surface_altitudes_km,
            surface_bound,
        ),
        ("times of day", "hours", requested.surface_grid.times, temperature_times(job), times_bound),
    ]
    slopes, kept_slopes = requested.surface_grid.slope_deg, job.surface_grid.slope_deg
    if needs.faces_deg is None:
        cases.append(("slopes", "slope_deg", slopes, kept_slopes, surface_bound))
    omissions = [
        LeftOut(
            f"{len(nodes) - len(nodes_used)} of {len(nodes)} {name}",
            f"no read within needs.{key} touches them",
            bound,
            wide.format(key),
        )
        for name, key, nodes, nodes_used, bound in cases
        if len(nodes_used) < len(nodes)
    ]
    if needs.faces_deg is not None:
        omissions.append(
            LeftOut(
                f"all but {len(kept_slopes)} slopes and {len(job.surface_grid.azimuth_deg)} azimuths",
                "needs.faces_deg names no others",
                faces_bound,
                "needs.slope_deg, or neither",
            )
        )
    share = read_share(requested, job)
    if share < 1:
        omissions.append(
            LeftOut(
                "spectral points for other paths",
                f"{share:.2g} of the cells of range, altitude and elevation are read; points are chosen, and errors"
                " measured, there",
                f"{job.accuracy.spectral_tolerance:g} of a value, rms, as in all other paths",
                "needs without range_km, observer_altitude_km and elevation_deg",
            )
        )
    if needs.materials is not None:
        omissions.append(
            LeftOut(
                "all other materials",
                "needs.materials does not name them",
                "none; reads of others are refused",
                "more names in needs.materials, or none",
            )
        )
    if not needs.shade:
        omissions.append(
            LeftOut("response to shade and other heat", "needs.shade is false", "none", "needs.shade: true")
        )
    omissions += [
        LeftOut(
            f"all files of the band {name}", "needs.bands does not name it", "none", f"{name} in needs.bands, or none"
        )
        for number, name in enumerate(job.band_names, 1)
        if number not in job.needed_bands
    ]
    omissions += [
        LeftOut(
            f"tables of the {source}",
            "it is below all their elevations in the hours needed"
            if needs.sources is None
            else "needs.sources does not name it",
            "none",
            wide.format("hours") if needs.sources is None else f"{source} in needs.sources, or none",
        )
        for source in requested.sources
        if source not in job.sources
    ]
    return omissions
