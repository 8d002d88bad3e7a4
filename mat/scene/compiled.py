"""The compiled band of a state: from the cache, or chosen now, for similar states of the job together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from skyshine.mat.atmosphere.band.cache import Origin, cached_compile_band, points_for_airs
from skyshine.mat.atmosphere.band.compile import CompiledBand, SimilarAirs
from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.path_axes import PathScope
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.air_cells import airs_of_cell, shared_cell
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, all_points, response_of
from skyshine.mat.scene.grids import path_grid, path_scope
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.sources import source_irradiance, usual_irradiance
from skyshine.schemas.arrays import Floats

MAX_POINTS = 64


def compiled_band(
    loaded: LoadedJob, state_of_job: State, response: SpectralResponse, state: AtmosphericState, everything: BandPoints
) -> tuple[CompiledBand, Origin]:
    """All points of a band reduced for a state on its day, as the job asks, and where they come from.

    Parameters
    ----------
    loaded : LoadedJob
        Job on the date of the state.
    state : AtmosphericState
        Atmosphere of the state, over its ground.
    everything : BandPoints
        All points of the response.

    Returns
    -------
    compiled : CompiledBand
    origin : Origin
    """
    job = loaded.trimmed
    points = everything.wavenumber, everything.width
    on_the_day = np.stack([source_irradiance(job, source, *points) for source in job.sources])
    return cached_compile_band(
        absorption_table(job.water_continuum),
        state,
        everything,
        path_grid(job),
        on_the_day,
        _usual(job, everything),
        **_settings(loaded),
        similar=similar_airs(loaded.requested, state_of_job, response),
    )


@dataclass(frozen=True, eq=False)
class StateBand:
    """A state and a band of a job.

    Attributes
    ----------
    air : AtmosphericState
        Air over the state's ground.
    everything : BandPoints
        All points of the band.
    origin : Origin
        Where the compiled band comes from.
    """

    response: SpectralResponse
    air: AtmosphericState
    everything: BandPoints
    compiled: CompiledBand
    origin: Origin

    @classmethod
    def of(cls, loaded: LoadedJob, state: int, band: int) -> StateBand:
        """A state and a band, counted from 1, of a job on the date of the state."""
        job = loaded.trimmed
        state_of_job, response = job.states[state - 1], response_of(job.bands[band - 1])
        air = over_ground(atmospheric_state(job.site, state_of_job), state_of_job, response, job_library(job))
        everything = all_points(response, job.water_continuum)
        return cls(response, air, everything, *compiled_band(loaded, state_of_job, response, air, everything))


def band_of_airs(loaded: LoadedJob, airs: SimilarAirs, everything: BandPoints) -> BandPoints:
    """All points of a band reduced for similar airs; parameters as `compiled_band`."""
    job = loaded.trimmed
    table = absorption_table(job.water_continuum)
    return points_for_airs(table, airs, everything, path_grid(job), _usual(job, everything), **_settings(loaded)).band


class _Settings(TypedDict):
    tolerance: float
    max_points: int
    seed: int
    scope: PathScope


def _settings(loaded: LoadedJob) -> _Settings:
    """How points are chosen."""
    accuracy = loaded.trimmed.accuracy
    return _Settings(
        tolerance=accuracy.spectral_tolerance, max_points=MAX_POINTS, seed=accuracy.seed, scope=path_scope(loaded)
    )


def _usual(job: Job, everything: BandPoints) -> Floats:
    """Irradiance of the job's sources on no particular day, (B, P)."""
    return np.stack([usual_irradiance(source, everything.wavenumber, everything.width) for source in job.sources])


def similar_airs(requested: Job, state_of_job: State, response: SpectralResponse) -> SimilarAirs | None:
    """The airs for which the points of a state are chosen together with those of other states; None where it has its
    own.
    """
    cell = shared_cell(requested, state_of_job)
    return None if cell is None else airs_of_cell(requested.site, state_of_job, cell, response, job_library(requested))
