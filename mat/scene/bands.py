"""Spectral responses of the bands of a job, and the band model that it asks for."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable, default_water_continuum
from skyshine.mat.job.atmosphere import Band
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.response_table import parse_response


def response_of(band: Band) -> SpectralResponse:
    """The sensor response of a job's band.

    Raises
    ------
    InputError
        At the place in a response table that is wrong.
    """
    if band.response is not None:
        return parse_response(band.response.text, band.response.path)
    if band.wavenumber_cm is not None:
        low, high = band.wavenumber_cm
        return SpectralResponse.rectangular(1e4 / high, 1e4 / low)
    assert band.wavelength_um is not None  # a band has one of the three
    return SpectralResponse.rectangular(*band.wavelength_um)


def absorption_table(water_continuum: str | None = None) -> AbsorptionTable:
    """The packaged band model with a water vapour continuum, by default that of jobs, opened once a process."""
    return _packaged().with_continuum(water_continuum or default_water_continuum())


@lru_cache(maxsize=1)
def _packaged() -> AbsorptionTable:
    return AbsorptionTable.open()


def all_points(response: SpectralResponse, water_continuum: str) -> BandPoints:
    """All points of a band, which states share."""
    return _all_points(response.wavelength.tobytes(), response.response.tobytes(), water_continuum)


@lru_cache(maxsize=4)  # tables of 7 MB in 8-12 um, 23 MB in 3-5 um
def _all_points(wavelength: bytes, values: bytes, water_continuum: str) -> BandPoints:
    from skyshine.mat.atmosphere.band.response_points import points_of_band  # which a check does without

    response = SpectralResponse(np.frombuffer(wavelength), np.frombuffer(values))
    return points_of_band(absorption_table(water_continuum), response)
