"""The axes of the atmospheric tables of a job."""

from __future__ import annotations

import numpy as np

from skyshine.mat.job.model import Job
from skyshine.mat.quantities.grid import PathGrid


def path_grid(job: Job) -> PathGrid:
    """Axes of the atmospheric tables of a job."""
    axes = job.atmosphere_grid
    return PathGrid(
        *(
            np.asarray(nodes, float)
            for nodes in (
                axes.range_km,
                job.observer_altitudes_km,
                axes.elevation_deg,
                axes.source_elevation_deg,
                axes.source_azimuth_deg,
            )
        )
    )
