"""The keys of a state that describe its air, for what is computed without a job."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from pydantic.fields import FieldInfo

from skyshine.mat.atmosphere.soundings.files import read_levels
from skyshine.mat.job.atmosphere import AUTO, TYPICAL, State
from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import Weather
from skyshine.schemas.documents import mapping_document, parse_model
from skyshine.schemas.errors import InputError, nearest

WIND = "wind_speed_m_s"  # wind of the weather; the others are keys of the state itself
KEYS = (
    "preset",
    "profile",
    "sounding",
    "humidity_scale",
    "co2_ppm",
    "gases",
    "aerosol",
    "visibility_km",
    "aerosol_table",
    "aerosol_optical_depth",
    "angstrom_exponent",
    "aerosol_layers",
    "air_mass",
    "stratosphere",
    "season",
    "clouds",
    "rain",
    "night_sky",
    "sea_temperature_c",
    "surface_albedo",
    WIND,
)
PROFILE, PROFILE_ABOVE = "midlatitude_summer", "us_standard"  # profiles of air without a place; above a sounding
_PLACE = Site(latitude_deg=0.0, longitude_deg=0.0, date=datetime.date(2000, 1, 1), utc_offset_h=0.0)
_ANY_C = 15.0  # temperature of a weather whose temperature nothing reads


@cache
def key_fields() -> dict[str, FieldInfo]:
    """The field of the job's models behind each of `KEYS`."""
    return {key: (Weather if key == WIND else State).model_fields[key] for key in KEYS}


def described_state(air: Mapping[str, Any]) -> tuple[Site, State]:
    """The state of some of `KEYS` at sea level, or at the bottom of its sounding.

    Profile and, above a sounding, its continuation are `PROFILE` and `PROFILE_ABOVE` by default; all else is as in a
    job. Paths of files are relative to the working directory.

    Raises
    ------
    InputError
        A key is unknown, a value does not fit, or it needs the place or date of a job.

    Examples
    --------
    >>> described_state({"aerosol": "urban", "visibility_km": 5})[1].profile
    'midlatitude_summer'
    """
    for key in air:
        if key not in KEYS:
            raise InputError(f"found the key '{key}' of air; {nearest(key, KEYS)}")
    keys = {key: value for key, value in air.items() if key != WIND}
    weather = {} if keys.get("preset") else {"air_temperature_c": _ANY_C}
    weather |= {WIND: air[WIND]} if WIND in air else {}
    try:
        document = mapping_document({"air": "profile", "weather": weather, **keys}, ".")
        state = parse_model(document, State, {"folder": None})
    except InputError as error:
        raise InputError(error.message) from None  # the place of a document that nobody wrote says nothing
    if air.get("profile") == AUTO or state.aerosol_optical_depth == TYPICAL:
        raise InputError(f"found {AUTO} or {TYPICAL}, which need a place and a date; allowed: in a job; give the job")
    if state.profile == AUTO:
        state = state.model_copy(update={"profile": PROFILE if state.sounding is None else PROFILE_ABOVE})
    if state.sounding is None:
        return _PLACE, state
    if state.sounding.choice.time is not None:
        raise InputError("found a time of the sounding, which needs a place and a date; allowed: in a job")
    levels = read_levels(state.sounding.path)
    state = state.model_copy(update={"sounding": replace(state.sounding, levels=levels)})
    return _PLACE.model_copy(update={"altitude_km": float(levels.altitude[0]) / 1e3}), state
