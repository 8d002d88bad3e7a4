"""The axes of the atmospheric tables of a job."""

from __future__ import annotations

import numpy as np

from skyshine.mat.job.model import Job
from skyshine.mat.quantities.grid import PathGrid, ScatteringGrid


def path_grid(job: Job, quantity: str | None = None) -> PathGrid:
    """Axes of the atmospheric tables of a job, or of one quantity where no tolerance places its nodes.

    Path radiance stands by scattering angle where the job does not write the azimuths.
    """
    axes = {name: np.asarray(nodes, float) for name, nodes in job.atmosphere_axes(quantity).items()}
    by_angle = quantity == "path_radiance_ratio" and "source_azimuth_deg" not in job.atmosphere_grid.written
    return (ScatteringGrid if by_angle else PathGrid)(**axes)
