"""What a job leaves out of the physics of its atmospheric tables, with bounds."""

from __future__ import annotations

import itertools
from typing import Any

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.bounds import Scattering
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.plan.left_out import LeftOut
from skyshine.mat.scene.assessed_points import assessed_points
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import MAX_POINTS
from skyshine.mat.scene.ground import band_albedo, over_ground
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.scene.omission import Omission
from skyshine.mat.scene.sources import irradiance_of_sources
from skyshine.mat.tables.files import state_label


def physics_left_out(loaded: LoadedJob) -> list[LeftOut]:
    """Points and scattered light that bands of states do not need, with about what each changes.

    States of the same air are represented by the first of them, except for their light. Bounds are those at some
    hundred points of a band; a build takes the bounds at the points of its tables, which differ little. More than
    `STATES` states are represented by `STATES` of them.
    """
    job, library = loaded.trimmed, job_library(loaded.trimmed)
    bands, left_out = {}, []
    faint: dict[str, list[tuple[float, float, str]]] = {}
    by_case: dict[tuple[Any, ...], Scattering] = {}
    looked_at = _spread(len(job.states))
    for number in job.needed_bands:
        response = response_of(job.bands[number - 1])
        bands[number] = response, assessed_points(response, job.water_continuum)
        left_out += _points(job, absorption_table().count_between(*response.wavenumber_range), number)
    for number, band in itertools.product(looked_at, bands):
        state = job.states[number - 1]
        response, everything = bands[band]
        key = band, air_key(state), band_albedo(state, response, library)
        table = f"{state_label(number, len(job.states))}b{band:02d}"
        air = over_ground(atmospheric_state(job.site, state), state, response, library)
        irradiance = irradiance_of_sources(job.on_date_of_state(number), everything)
        if key not in by_case:
            by_case[key] = Scattering.of(SpectralAir.of(air, everything.points, everything.gases, everything.weight))
        light = by_case[key].radiance(irradiance, everything.radiance_weight)
        omission = Omission.of(job, job.sources, air, response, light)
        for source, change in omission.scattered.items():
            what = f"scattered light of the {source}"
            faint.setdefault(what, []).append((change, change * omission.radiance, table))
    part = f" ({len(looked_at)} of {len(job.states):,} states looked at)" if len(looked_at) < len(job.states) else ""
    return left_out + [_faint(what, cases, part) for what, cases in faint.items()]


STATES = 6  # assessed of a job with more states
_RESTORE_SPECTRUM = "a smaller accuracy.spectral_tolerance"


def _points(job: Job, count: int, band: int) -> list[LeftOut]:
    """Spectral points of a band, which has so many."""
    bound = f"about {job.accuracy.spectral_tolerance:g} of a value, rms; the file states the measured error"
    what = f"all but {MAX_POINTS} or fewer of {count:,} spectral points in b{band:02d}"
    return [LeftOut(what, "a few represent all", bound, _RESTORE_SPECTRUM)] if count > MAX_POINTS else []


def _spread(states: int) -> list[int]:
    """Numbers of states, evenly spread over those of a job, counted from 1: a check of thousands takes seconds."""
    return sorted({round(1 + k * (states - 1) / (STATES - 1)) for k in range(STATES)})


def _faint(what: str, cases: list[tuple[float, float, str]], part: str) -> LeftOut:
    """Light that can be omitted at some places."""
    kelvin, radiance, _ = max(cases)
    tables = [table for *_, table in cases]
    more = f" and {len(tables) - 3} more" if len(tables) > 3 else ""
    return LeftOut(
        f"{what} in {', '.join(tables[:3])}{more}{part}",
        "too faint to be seen",
        f"about {kelvin:.1e} K or {radiance:.1e} W m^-2 sr^-1 of what is seen",
        "a smaller accuracy.negligible_k; 0 leaves nothing out",
    )
