"""What an average over the band costs in the light that surfaces emit, and the bands where a job corrects it."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.job.extra_tables import WEIGHTED_TRANSMITTANCE
from skyshine.mat.job.model import Job
from skyshine.mat.quantities.emission import emission_weights, lines_of_sight
from skyshine.mat.quantities.formulas import mean_transmittance
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST, kelvin_per_radiance, reference_radiance
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of

WORTH_CORRECTING = 0.2  # K, rms over the paths below
_RANGES = np.array([0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])  # km, level, at the ground
_KELVIN = 300.0


def averaging_error(job: Job, band: int) -> float:
    """Error of the flat band mean of transmittance in the light of a black body at 300 K, rms over level paths.

    Parameters
    ----------
    job : Job
        The air is that of its first state; the paths, 20 m to 10 km at the ground, end where its range axis does.
    band : int
        Counted from 1.

    Returns
    -------
    float
        K at the black body, equation (6) against (5); 0 for bands that end below 2.5 um, where no temperature stands
        for a radiance.

    Examples
    --------
    >>> from skyshine.mat.api.examples import starter_files
    >>> from skyshine.mat.job.load import load_job
    >>> job = load_job(next(file for file in starter_files() if file.name == "job.yaml")).requested
    >>> [round(averaging_error(job, band), 1) for band in (1, 2)]
    [0.9, 0.1]
    """
    response = response_of(job.bands[band - 1])
    if response.upper < SHORTEST:
        return 0.0
    points = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
    air = SpectralAir.of(atmospheric_state(job.site, job.states[0]), points.points, points.gases, points.weight)
    ranges = _RANGES[max(job.atmosphere_grid.range_km[-1], _RANGES[0]) >= _RANGES]
    (path,) = lines_of_sight(air, ranges[None], np.array([job.site.altitude_km]), np.zeros(1))
    black = np.zeros((1, points.weight.size))
    _, flat = mean_transmittance(path.depth, points.weight[None] / points.weight.sum())
    _, weighted = mean_transmittance(path.depth, emission_weights(points, black, _KELVIN))
    error = (weighted - flat) * reference_radiance(response) * kelvin_per_radiance(response)
    return float(np.sqrt(np.mean(error**2)))


def weighted_transmittance_bands(job: Job) -> frozenset[int]:
    """Bands, counted from 1, whose states get the transmittance of emitted light: those that the job's `extra_tables`
    ask for, or without that key those where the band mean errs by more than `WORTH_CORRECTING` and the tables of the
    air are not in channels, which hold it.
    """
    if job.extra_tables is not None:
        return frozenset(job.needed_bands if WEIGHTED_TRANSMITTANCE in job.extra_tables else ())
    if job.atmosphere_grid.in_channels:
        return frozenset()
    return frozenset(band for band in job.needed_bands if averaging_error(job, band) > WORTH_CORRECTING)
