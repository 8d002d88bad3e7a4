"""The axes of the atmospheric tables of a job."""

from __future__ import annotations

import numpy as np

from skyshine.mat.job.model import Job
from skyshine.mat.quantities.grid import PathGrid


def path_grid(job: Job, quantity: str | None = None) -> PathGrid:
    """Axes of the atmospheric tables of a job, or of one quantity where no tolerance places its nodes."""
    return PathGrid(**{name: np.asarray(nodes, float) for name, nodes in job.atmosphere_axes(quantity).items()})
