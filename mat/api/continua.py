"""What the choice of the water vapour continuum changes along a line of sight."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.mat.api.spectrum import Spectrum, spectrum
from skyshine.mat.atmosphere.gases.absorption import (
    available_water_continua,
    default_water_continuum,
    packaged_water_continuum,
)
from skyshine.mat.job.load import load_job
from skyshine.mat.radiometry.blackbody import SpectralResponse, brightness_temperature, planck_wavenumber
from skyshine.mat.scene.bands import response_of
from skyshine.schemas.errors import InputError

BACKGROUND = 300.0  # K


@dataclass(frozen=True)
class ContinuumEffect:
    """A line of sight with one water vapour continuum, over all of its spectral range.

    Attributes
    ----------
    name : str
        Name of the continuum.
    transmittance : float
        Mean over wavenumber.
    temperature : float
        Apparent temperature of the line of sight, and of the black background where it does not lead into space [K].
    difference : float
        Apparent temperature less that with the default continuum [K].
    """

    name: str
    transmittance: float
    temperature: float
    difference: float


def compare_continua(*, background: float = BACKGROUND, **arguments: Any) -> list[ContinuumEffect]:
    """The same line of sight with every water vapour continuum of the package, the default first.

    Parameters
    ----------
    background : float
        Temperature of the black body at the end of the range [K].
    **arguments
        Those of `skyshine.mat.spectrum`, without `water_continuum`; with `job` and no limits those of its only band.

    Raises
    ------
    InputError
        As `skyshine.mat.spectrum`, or a job without limits has several bands.
    """
    if arguments.get("job") is not None and arguments.get("wavenumber") is None and arguments.get("wavelength") is None:
        arguments["wavenumber"] = _limits_of_band(arguments["job"])
    effects: list[ContinuumEffect] = []
    names = dict.fromkeys([default_water_continuum(), *available_water_continua(packaged_water_continuum())])
    for name in names:
        line = spectrum(**{**arguments, "water_continuum": name})
        if line.coords:
            raise InputError(f"found several values of {', '.join(line.coords)}; allowed: a single line of sight")
        temperature = _apparent_temperature(line, background)
        reference = effects[0].temperature if effects else temperature
        effects.append(ContinuumEffect(name, float(line.transmittance.mean()), temperature, temperature - reference))
    return effects


def _limits_of_band(job: Any) -> tuple[float, float]:
    """Limits of the only band of a job, cm^-1."""
    loaded = load_job(job)
    bands = loaded.trimmed.bands
    if len(bands) != 1:
        raise InputError(
            f"found {len(bands)} bands; allowed: one band, or limits beside the job; give wavenumber or wavelength",
            file=loaded.file,
        )
    return response_of(bands[0]).wavenumber_range


def _apparent_temperature(line: Spectrum, background: float) -> float:
    """Brightness temperature of a line of sight over its bins [K]."""
    width = float(np.median(np.diff(line.wavenumber))) if line.wavenumber.size > 1 else 5.0
    behind = np.zeros(line.wavenumber.size)
    if not np.isinf(line.range):
        behind = line.transmittance * planck_wavenumber(line.wavenumber, background)
    radiance = float(np.sum(behind + line.path_thermal + line.path_scattered)) * width
    low, high = line.wavenumber[0] - width / 2, line.wavenumber[-1] + width / 2
    return float(brightness_temperature(SpectralResponse.rectangular(1e4 / high, 1e4 / low), radiance))
