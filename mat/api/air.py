"""The air of `spectrum` and `fluxes`: that of a job's state, or one described by the same keys."""

from __future__ import annotations

import functools
import inspect
import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.sources.lunar import lunar_irradiance
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.air import KEYS, PROFILE, described_state, key_fields
from skyshine.mat.job.load import LoadedJob, load_job
from skyshine.mat.job.model import Job
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.ground import over_ground
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.sources import source_irradiance
from skyshine.schemas.errors import InputError, nearest

MEAN_MOON_DISTANCE = 384_400e3  # m (Allen's Astrophysical Quantities, 4th edition, 2000)
# Degree. Full Moons pass beside the Earth's shadow: half of them have less, half more than 3.6.
FULL_MOON_PHASE = 4.0
Function = TypeVar("Function", bound=Callable[..., Any])


def with_air_keys(function: Function) -> Function:
    """Shows the keys of a job's air in the signature of a function that takes them as ``**air``."""
    signature = inspect.signature(function)
    parameters = [part for part in signature.parameters.values() if part.kind is not part.VAR_KEYWORD]
    names = {part.name for part in parameters}
    parameters += [
        inspect.Parameter(key, inspect.Parameter.KEYWORD_ONLY, default=PROFILE if key == "profile" else field.default)
        for key, field in key_fields().items()
        if key not in names
    ]

    @functools.wraps(function)
    def call(*positional: Any, **named: Any) -> Any:
        unknown = next((name for name in named if name not in names and name not in KEYS), None)
        if unknown is not None:
            raise InputError(f"found the argument '{unknown}'; {nearest(unknown, [*names, *KEYS])}")
        return function(*positional, **named)

    call.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    return call  # type: ignore[return-value]


def on_the_day(job: str | os.PathLike[str] | Mapping[str, Any], state: int, described: Mapping[str, Any]) -> LoadedJob:
    """A job on the date of a state; refused beside a description of the air."""
    if described:
        raise InputError(
            f"found job and {' and '.join(described)}; allowed: the air of a job's state, or one that is described"
            " here; remove one"
        )
    loaded = load_job(job)
    count = len(loaded.trimmed.states)
    if not 1 <= state <= count:
        raise InputError(f"found state {state}; allowed: 1 to {count}", file=loaded.file)
    return loaded.on_date_of_state(state)


def state_air(loaded: LoadedJob, state: int, low: float, high: float) -> AtmosphericState:
    """The air of a job's state over its ground, as that is between two wavenumbers [cm^-1]."""
    state_of_job = loaded.trimmed.states[state - 1]
    response = SpectralResponse.rectangular(1e4 / high, 1e4 / low)
    return over_ground(
        atmospheric_state(loaded.trimmed.site, state_of_job), state_of_job, response, job_library(loaded.trimmed)
    )


def described_air(air: Mapping[str, Any]) -> AtmosphericState:
    """The air of keys of a job's state, over a ground of its temperature.

    Raises
    ------
    InputError
        As `described_state`.
    """
    site, state = described_state(air)
    result = atmospheric_state(site, state)
    if state.sea_temperature_c is not None:
        return result
    return replace(result, surface_temperature=float(result.temperature[0]))


def source_on_the_day(source: str, points: SpectralPoints, job: Job | None) -> npt.NDArray[np.float64]:
    """Of the source outside the atmosphere, mean over each point's interval, W m^-2 (cm^-1)^-1; on the day of a job."""
    low, high = points.interval_edges[points.interval].T
    if job is not None and source in ("sun", "moon"):
        return source_irradiance(job, source, (low + high) / 2, high - low)
    if source == "sun":
        return solar_irradiance((low + high) / 2, high - low)
    if source == "moon":
        return lunar_irradiance((low + high) / 2, FULL_MOON_PHASE, MEAN_MOON_DISTANCE, 1.0, width=high - low).total
    if source == "none":
        return np.zeros(points.wavenumber.size)
    raise InputError(f"found the source {source!r}; allowed: 'sun', 'moon' or 'none'")
