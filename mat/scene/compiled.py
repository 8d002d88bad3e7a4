"""The compiled band of a state: from the cache, or chosen now."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.band.cache import Origin, cached_compile_band
from skyshine.mat.atmosphere.band.compile import CompiledBand
from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.sources import source_irradiance, usual_irradiance

MAX_POINTS = 64


def compiled_band(loaded: LoadedJob, state: AtmosphericState, everything: BandPoints) -> tuple[CompiledBand, Origin]:
    """All points of a band reduced for a state on its day, as the job asks, and whether they come from the cache."""
    job, whole = loaded.trimmed, loaded.requested
    on_the_day, at_one_au = (
        np.stack([light(whole, source, everything.wavenumber, everything.width) for source in whole.sources])
        for light in (source_irradiance, usual_irradiance)
    )
    return cached_compile_band(
        absorption_table(job.water_continuum),
        state,
        everything,
        path_grid(whole),
        on_the_day,
        at_one_au,
        tolerance=job.accuracy.spectral_tolerance,
        max_points=MAX_POINTS,
        seed=job.accuracy.seed,
    )
