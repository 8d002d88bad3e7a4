"""The axes of the atmospheric tables of a job, and which part of its paths its scenes read."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS
from skyshine.mat.atmosphere.transfer.path_axes import PathScope
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.job.trim import read_share
from skyshine.mat.quantities.grid import PathGrid


def path_grid(job: Job) -> PathGrid:
    """Axes between whose ends the channels of a job are placed, and by whose cells random lines of sight are drawn."""
    return PathGrid(**{name: np.asarray(nodes, float) for name, nodes in job.sampled_axes().items()})


def table_grid(job: Job) -> PathGrid:
    """Axes of the tables of a job that writes all five."""
    return PathGrid(**{name: np.asarray(nodes, float) for name, nodes in job.atmosphere_axes().items()})


def path_scope(loaded: LoadedJob) -> PathScope:
    """The part of the paths of a job that is within its query limits, how high the surfaces at their ends lie, and how
    low the source is along them.
    """
    share, job = read_share(loaded.requested, loaded.trimmed), loaded.trimmed
    axes = job.atmosphere_axes()
    reach, steepest = 1e3 * axes["range_km"][-1], np.radians(max(axes["elevation_deg"][-1], 0.0))
    start = 1e3 * (axes["altitude_km"][-1] - job.site.altitude_km)
    return PathScope(
        share,
        float(start + reach * np.sin(steepest) + reach**2 / (2 * EARTH_RADIUS)),
        float(axes["source_elevation_deg"][0] - np.degrees(reach / EARTH_RADIUS)),
    )
