"""Season of the ground under a state's surfaces: as the job writes it, of a weather file's year, or of the latitude."""

from __future__ import annotations

import datetime
from typing import Annotated, Literal

import numpy as np
import pydantic
from pydantic import Field

from skyshine.mat.atmosphere.state.climate import COLDEST_DAY, profile_weights
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.job.fields import Celsius
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.ground_year import YEAR, GroundSeason, annual_harmonic
from skyshine.mat.surface.weather import LAPSE_RATE
from skyshine.schemas.documents import StrictModel

_ANY_YEAR = 2001  # any year of 365 days


class GroundYear(StrictModel):
    """Annual wave of the temperature at the surface of the ground, at the altitude of the weather."""

    mean_c: Celsius = Field(description="Mean temperature of the year.")
    amplitude_c: Annotated[float, Field(ge=0, le=60)] = Field(
        description="Half of what the warmest day exceeds the coldest by."
    )
    coldest_day: Annotated[float, Field(ge=1, lt=YEAR + 1)] | None = Field(
        None, description="Day of the year; by default 15 January in the north, half a year later in the south."
    )

    def at_latitude(self, latitude_deg: float) -> GroundYear:
        """The same with its coldest day, by default that of the hemisphere."""
        if self.coldest_day is not None:
            return self
        return self.model_copy(update={"coldest_day": COLDEST_DAY + (0.0 if latitude_deg >= 0 else YEAR / 2)})

    @property
    def text(self) -> str:
        """Its numbers in words; a loaded job has its coldest day."""
        return f"mean {self.mean_c:g} C, amplitude {self.amplitude_c:g} K, coldest on day {self.coldest_day:g}"

    def on(self, date: datetime.date) -> GroundSeason:
        """The wave on a date; a loaded job has its coldest day."""
        assert self.coldest_day is not None
        since = (date.timetuple().tm_yday - self.coldest_day) % YEAR
        return GroundSeason(self.mean_c + ZERO_CELSIUS, self.amplitude_c, since)


Ground = Annotated[
    Annotated[GroundYear, pydantic.Tag("year")]
    | Annotated[Literal["air", "file", "epw", "latitude"], pydantic.Tag("word")],
    pydantic.Discriminator(lambda value: "word" if isinstance(value, str) else "year"),
]


def ground_of_latitude(latitude_deg: float, altitude_km: float) -> GroundYear:
    """The year of the standard profiles at a latitude, cooler with altitude as the air.

    Examples
    --------
    >>> year = ground_of_latitude(45.0, 0.0)
    >>> round(year.mean_c), round(year.amplitude_c), round(year.coldest_day)
    (10, 11, 15)
    """
    days = np.arange(1.0, 366.0)
    new_year = datetime.date(_ANY_YEAR, 1, 1)
    celsius = np.array([_sea_level_air(latitude_deg, new_year + datetime.timedelta(days=int(day) - 1)) for day in days])
    mean, amplitude, coldest = annual_harmonic(days, celsius)
    lapse = LAPSE_RATE * 1e3 * altitude_km
    return GroundYear(mean_c=round(mean - lapse, 1), amplitude_c=round(amplitude, 1), coldest_day=round(coldest, 1))


def _sea_level_air(latitude_deg: float, date: datetime.date) -> float:
    """Air temperature of the standard profiles at sea level [Celsius]."""
    weights = profile_weights(latitude_deg, date)
    return sum(w * float(load_profile(name).temperature[0]) for name, w in weights.items()) - ZERO_CELSIUS
