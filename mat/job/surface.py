"""The part of a job that surface temperatures are computed from: weather and grid."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
import pydantic
from pydantic import Field

from skyshine.mat.job.fields import (
    Celsius,
    Fraction,
    TimeOfDay,
    Tolerance,
    ascending,
    axis,
    by_hour,
    clock_text,
    tolerance_parts,
)
from skyshine.mat.job.ground import Ground, GroundYear
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.weather_readings import MOST_MOISTURE
from skyshine.materials.files import by_hour as values_by_hour
from skyshine.materials.files import refuse_incomplete_back
from skyshine.materials.records import Back, Material
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import nearest

# Default nodes of the temperature table, and the number of its times: with them 99 % of reads of all library materials
# in the Atacama in November err by 0.53 K or less, those of a single material by 0.5 K in the middle and 1.15 K at
# most, of a black roof membrane.
SURFACE_HEIGHTS_KM = (0, 0.75, 1.5, 2.25, 3)
_AZIMUTHS, _SLOPES, _TIMES = 30, 21, 40


# Days before the date: conduction through half a metre of soil has a day's memory, of a metre a week's.
LONGEST_HISTORY = 30
LONGEST_GAP_H = 3.0  # that linear interpolation between hourly values may bridge
# What a table by hour may give instead of one value for the day.
HOURLY_QUANTITIES = ("relative_humidity_percent", "wind_speed_m_s", "cloud_fraction")

# Measured light on the ground; direct and diffuse go together.
SUNLIGHT = ("direct_normal_w_m2", "diffuse_w_m2")
RADIATION = (*SUNLIGHT, "longwave_down_w_m2")
TOTAL = "global_horizontal_w_m2"  # in the place of both
RainKey = Literal["file", "none"]
WATER = ("rain_mm_h", "soil_moisture_m3_m3")  # on and in the ground

Percent = Annotated[float, Field(ge=0, le=100)]
Irradiance = Annotated[float, Field(ge=0, le=1500)]
Longwave = Annotated[float, Field(ge=20, le=800)]
Speed = Annotated[float, Field(ge=0, le=60)]
Pressure = Annotated[float, Field(ge=200, le=1100)]
# Heights of masts: above the roughness of open ground, below the depth of the surface layer.
MastHeight = Annotated[float, Field(ge=0.1, le=200)]


class HourlyWeather(StrictModel):
    """Air near the ground at times of the day, linear between them; every list is as long as ``time``."""

    time: Annotated[list[TimeOfDay], Field(min_length=8, max_length=1440), pydantic.AfterValidator(ascending)] = Field(
        description="Local clock, ascending within a day."
    )
    air_temperature_c: list[Celsius] = Field(description="Temperature of the air near the ground.")
    relative_humidity_percent: list[Percent] | None = Field(
        None, description="Relative humidity; by default that of the day's weather."
    )
    wind_speed_m_s: list[Speed] | None = Field(None, description="Wind speed; by default that of the day's weather.")
    cloud_fraction: list[Fraction] | None = Field(
        None, description="Share of the sky that clouds cover; by default that of the day's weather."
    )
    pressure_hpa: list[Pressure] | None = Field(
        None, description="Air pressure; by default that of the state's profile."
    )
    direct_normal_w_m2: list[Irradiance] | None = Field(
        None,
        description=(
            "Direct sunlight normal to it, means over the time since the entry before; for radiation: measured."
        ),
    )
    diffuse_w_m2: list[Irradiance] | None = Field(None, description="Sky sunlight on a level surface, likewise.")
    global_horizontal_w_m2: list[Irradiance] | None = Field(
        None,
        description=(
            "Sunlight on a level surface, likewise; in place of direct_normal and diffuse, into which it is parted."
        ),
    )
    longwave_down_w_m2: list[Longwave] | None = Field(
        None, description="Thermal radiation of the sky on a level surface, likewise; by default that of the state."
    )
    altitude_km: float | None = Field(
        None, ge=-0.5, le=9, description="Altitude of the measurements of the air; by default the altitude of the site."
    )
    wind_height_m: MastHeight | None = Field(
        None, description="Height of the anemometer; by default that of the weather."
    )
    air_height_m: MastHeight | None = Field(
        None, description="Height of the thermometer; by default that of the weather."
    )

    # Excluded from dumps: only temperature tables depend on them, and their identity states them.
    rain_mm_h: list[Annotated[float, Field(ge=0, le=2000)]] | None = Field(
        None,
        exclude=True,
        description=(
            "Means over the time since the entry before. Where it is given, if only zeros, rain and dew leave a film of"
            " water on surfaces, which darkens them and evaporates."
        ),
    )
    soil_moisture_m3_m3: list[Annotated[float, Field(ge=0, le=MOST_MOISTURE)]] | None = Field(
        None,
        exclude=True,
        description=(
            "Moisture of the upper soil: absorptance, emissivity and evaporation follow it by the hour, "
            "conductivity and heat capacity its mean; soil_moisture of the job still says what the bands "
            "see. Capped at a soil's porosity."
        ),
    )

    @pydantic.model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.direct_normal_w_m2 is None) != (self.diffuse_w_m2 is None):
            raise ValueError(f"found one of {' and '.join(SUNLIGHT)}; allowed: both or neither; give the other too")
        if self.direct_normal_w_m2 is not None and self.global_horizontal_w_m2 is not None:
            raise ValueError(f"found {SUNLIGHT[0]} and {TOTAL}; allowed: one of them; remove the total")
        for name in ("air_temperature_c", *HOURLY_QUANTITIES, "pressure_hpa", *RADIATION, TOTAL, *WATER):
            values = getattr(self, name)
            if values is not None and len(values) != len(self.time):
                raise ValueError(
                    f"found {len(values)} values of {name}; allowed: {len(self.time)}, one for each time; add or remove"
                    " some"
                )
        gaps = [(after - before) % 24 for before, after in zip(self.time, [*self.time[1:], self.time[0]], strict=True)]
        if max(gaps) > LONGEST_GAP_H:
            where = gaps.index(max(gaps))
            raise ValueError(
                f"found a gap of {gaps[where]:g} h after {clock_text(self.time[where])}; allowed: {LONGEST_GAP_H:g} h, "
                "also over midnight; add times"
            )
        return self


class Weather(StrictModel):
    """Air near the ground through the day: one temperature, the lowest and highest, a table by hour, or a file."""

    air_temperature_c: (
        Annotated[
            Annotated[Celsius, pydantic.Tag("constant")] | Annotated[tuple[Celsius, Celsius], pydantic.Tag("extremes")],
            pydantic.Discriminator(lambda value: "extremes" if isinstance(value, list | tuple) else "constant"),
        ]
        | None
    ) = Field(None, description="All day, or the lowest and highest of the day, at the altitude of the site.")
    hourly: HourlyWeather | None = Field(
        None, description="Measured or forecast values by time of day, in place of the day's."
    )
    file: str | None = Field(
        None,
        min_length=1,
        description=(
            "EPW, TMY3 (the day and month of the site's date), or CSV by time of day; relative to the job file. "
            "Keys beside it replace its values."
        ),
    )
    history_days: int = Field(
        0,
        ge=0,
        le=LONGEST_HISTORY,
        description=(
            "Days of the file before the date whose weather the ground remembers; 0: the day repeats. A CSV file needs"
            " dates then (ISO 8601 with a zone)."
        ),
    )
    days_before: list[HourlyWeather] = Field(
        [],
        max_length=LONGEST_HISTORY,
        description="Days before the date that the ground remembers, oldest first; only with `hourly`.",
    )
    relative_humidity_percent: Percent = Field(50.0, description="Daily mean; the vapour is constant.")
    wind_speed_m_s: Speed = Field(2.0, description="Mean over the day, at `wind_height_m`.")
    wind_height_m: MastHeight = Field(
        10.0, description="Height of the anemometer above open ground; 10 m in EPW, TMY3 and synoptic reports."
    )
    air_height_m: MastHeight = Field(
        2.0, description="Height of thermometer and hygrometer; 2 m in EPW, TMY3 and reports."
    )
    cloud_fraction: Fraction = Field(0.0, description="Share of the sky that clouds cover.")
    # Excluded from dumps as the water of a table is.
    snow_age_days: float | None = Field(
        None,
        ge=0,
        le=400,
        exclude=True,
        description="Time since snow fell: the albedo of snow falls from that of its material to that of old snow.",
    )
    rain: RainKey | None = Field(
        None,
        exclude=True,
        description=(
            "Rain of the weather file: read (file) or not (none). By default that of a CSV file's column is read, and"
            " that of EPW and TMY3 on days on which some falls, for their depths are often missing; `mat check` says"
            " what falls."
        ),
    )
    ground: Ground | None = Field(
        None,
        exclude=True,
        description=(
            "Deep temperature under stacks of ground by the season: as written, or by the air of the whole year in the"
            " weather file (file; default with EPW and TMY3), the header of EPW (epw), the latitude (coarse: standard"
            " profiles). With air (default elsewhere) the mean air of the day and of the days before."
        ),
    )
    ground_albedo: Fraction = Field(0.2, description="Share of sunlight that the ground around surfaces reflects.")
    radiation: Literal["computed", "measured"] | None = Field(
        None,
        description=(
            "Sunlight and sky longwave on the ground: computed from the state, or measured, as the file or the table by"
            " hour has them (in CSV direct_normal and diffuse, or sw_down, and lw_down); by default measured where"
            " sunlight is there. Measured light is of the weather, not of the state's air."
        ),
    )

    @pydantic.model_validator(mode="after")
    def _has_its_history(self) -> Self:
        if self.history_days and self.file is None:
            raise ValueError(
                f"found history_days: {self.history_days} without a file; allowed: with a file; give one, or"
                " days_before beside hourly"
            )
        if self.days_before and self.hourly is None:
            raise ValueError(
                "found days_before without hourly; allowed: with hourly; give it, or history_days of a file"
            )
        for number, day in enumerate(self.days_before, 1):
            names = ("air_temperature_c", *HOURLY_QUANTITIES, "pressure_hpa", *RADIATION, TOTAL, *WATER, "altitude_km")
            for name in names:
                if (getattr(day, name) is None) != (getattr(self.hourly, name) is None):
                    raise ValueError(
                        f"found {name} in one of hourly and day {number} of days_before; allowed: the same quantities"
                        " on all days; give it in both or neither"
                    )
        return self

    @pydantic.model_validator(mode="after")
    def _has_its_rain(self) -> Self:
        if self.rain is not None and self.file is None:
            raise ValueError(
                f"found rain: {self.rain} without a file; allowed: with a file; give one, or rain_mm_h in hourly"
            )
        return self

    @pydantic.model_validator(mode="after")
    def _has_its_ground(self) -> Self:
        if self.ground in ("file", "epw") and self.file is None:
            raise ValueError(
                f"found ground: {self.ground} without a file; allowed: with a file; give one, or latitude, or mean_c"
                " and amplitude_c"
            )
        return self

    @pydantic.model_validator(mode="after")
    def _measured_or_not(self) -> Self:
        has = [name for name in (*RADIATION, TOTAL) if getattr(self.hourly, name, None) is not None]
        if has and self.radiation == "computed":
            raise ValueError(
                f"found {has[0]} by hour and radiation: computed; allowed: radiation: measured; give it, or remove"
                f" {has[0]}"
            )
        if has and not self.measured:
            raise ValueError(
                f"found {has[0]} by hour without sunlight; allowed: with {' and '.join(SUNLIGHT)}, or {TOTAL}; give it"
            )
        if self.radiation == "measured" and self.file is None and not {SUNLIGHT[0], TOTAL} & {*has}:
            raise ValueError(
                f"found radiation: measured without {' and '.join(SUNLIGHT)}, or {TOTAL}; allowed: with a file or a"
                " table by hour that has them; give one, or remove radiation"
            )
        return self

    @pydantic.model_validator(mode="after")
    def _one_kind(self) -> Self:
        kinds = [name for name in ("air_temperature_c", "hourly", "file") if getattr(self, name) is not None]
        if len(kinds) != 1:
            raise ValueError(
                f"found {' and '.join(kinds) if kinds else 'no air temperature'}; "
                "allowed: one of air_temperature_c, hourly and file; give one of them"
            )
        if self.hourly is not None:
            for name in HOURLY_QUANTITIES:
                if getattr(self.hourly, name) is not None and name in self.model_fields_set:
                    raise ValueError(f"found {name} both by hour and for the day; allowed: once; remove one")
        return self

    @pydantic.model_validator(mode="after")
    def _ordered(self) -> Self:
        if isinstance(self.air_temperature_c, tuple):
            low, high = self.air_temperature_c
            if low > high:
                raise ValueError(f"found air_temperature_c [{low:g}, {high:g}]; allowed: [lowest, highest]; swap them")
        return self

    @property
    def measured(self) -> bool:
        """Whether its light is measured."""
        has_sunlight = any(getattr(self.hourly, name, None) is not None for name in (SUNLIGHT[0], TOTAL))
        return self.radiation == "measured" or (self.radiation is None and has_sunlight)

    def without_light(self) -> Self:
        """The same without the light of its tables, which is computed."""
        dark = dict.fromkeys((*RADIATION, TOTAL))
        before = [day.model_copy(update=dark) for day in self.days_before]
        hourly = None if self.hourly is None else self.hourly.model_copy(update=dark)
        return self.model_copy(update={"hourly": hourly, "days_before": before})

    @property
    def water(self) -> dict[str, Any]:
        """What it says of water on and in the ground and of snow, as plain data; empty where it says nothing."""
        days = [day for day in (*self.days_before, self.hourly) if day is not None]
        columns = {name: [getattr(day, name) for day in days] for name in WATER}
        columns = {name: values for name, values in columns.items() if values and values[-1] is not None}
        return columns | ({} if self.snow_age_days is None else {"snow_age_days": self.snow_age_days})

    @property
    def ground_year(self) -> GroundYear | None:
        """Yearly temperatures of the ground below; a loaded job has no other."""
        return self.ground if isinstance(self.ground, GroundYear) else None

    @property
    def heights_m(self) -> tuple[float, float]:
        """Of anemometer and thermometer [m]: as written here, else those of the table by hour, else the defaults."""
        heights = ((name, getattr(self.hourly, name, None)) for name in ("wind_height_m", "air_height_m"))
        wind, air = (getattr(self, k) if v is None or k in self.model_fields_set else v for k, v in heights)
        return wind, air

    @property
    def mean_air_temperature_c(self) -> float:
        """Mean of the day, of the two extremes where only those are given."""
        if self.hourly is not None:
            return float(
                np.mean(np.interp(np.arange(0, 24, 0.25), self.hourly.time, self.hourly.air_temperature_c, period=24))
            )
        return float(np.mean(np.asarray(self.air_temperature_c, float)))


# Temperature of a thing that is heated from inside: an exhaust pipe at most, liquid nitrogen at least.
OperatedCelsius = Annotated[float, Field(ge=-200, le=1500)]
OperatedHeat = Annotated[float, Field(ge=-1e4, le=1e4)]


class Operation(StrictModel):
    """Back boundary of a material in operation, in place of the library's."""

    kind: Literal["fixed", "convective", "open", "cavity", "heated"] = Field(
        description=(
            "A temperature, air of a temperature with a transfer coefficient, the outdoor air, enclosed air that"
            " floats, or a heat flux outwards."
        )
    )
    temperature_c: Annotated[float | list[float], by_hour(OperatedCelsius)] | None = Field(
        None,
        description="Temperature of the fixed back, or of the air behind a convective one; one for the day "
        "or one for each hour.",
    )
    coefficient_w_m2_k: float | None = Field(
        None, gt=0, le=1e5, description="Coefficient of the transfer between the back and the air behind."
    )
    exchange_w_m2_k: float | None = Field(
        None,
        gt=0,
        le=1e5,
        description="Heat exchange of a cavity's air with the outdoor air, by ventilation and other faces, "
        "for each m2 of this face.",
    )
    capacity_j_m2_k: float | None = Field(
        None,
        ge=0,
        le=1e7,
        description="Heat capacity of a cavity's air and of what is in it, for each m2 of this face.",
    )
    heat_flux_w_m2: Annotated[float | list[float], by_hour(OperatedHeat)] | None = Field(
        None,
        description="Heat flux from the back into the material, or into a cavity; one for the day or one for "
        "each hour.",
    )

    @pydantic.model_validator(mode="after")
    def _complete(self) -> Self:
        keys = {
            "temperature": "temperature_c",
            "coefficient": "coefficient_w_m2_k",
            "heat_flux": "heat_flux_w_m2",
            "exchange": "exchange_w_m2_k",
            "capacity": "capacity_j_m2_k",
        }
        refuse_incomplete_back(self, self.kind, keys)
        return self

    @classmethod
    def of_back(cls, back: Back) -> dict[str, Any]:
        """The keys of a job that describe a back boundary of the library."""
        kelvin = back.temperature
        celsius = [temperature - ZERO_CELSIUS for temperature in kelvin] if isinstance(kelvin, tuple) else kelvin
        flux = back.heat_flux
        keys = {
            "temperature_c": celsius - ZERO_CELSIUS if isinstance(celsius, float) else celsius,
            "coefficient_w_m2_k": back.coefficient,
            "exchange_w_m2_k": back.exchange,
            "capacity_j_m2_k": back.capacity,
            "heat_flux_w_m2": list(flux) if isinstance(flux, tuple) else flux,
        }
        return {"kind": back.kind} | {key: value for key, value in keys.items() if value is not None}

    @property
    def back(self) -> Back:
        """The back boundary in SI units."""
        celsius = self.temperature_c
        kelvin = None if celsius is None else at_kelvin(celsius)
        return Back(
            self.kind,
            kelvin,
            self.coefficient_w_m2_k,
            values_by_hour(self.heat_flux_w_m2),
            self.exchange_w_m2_k,
            self.capacity_j_m2_k,
        )


def named_operation(material: Material, operation: str) -> dict[str, Any]:
    """Keys of the `Operation` that a material has under a name.

    Raises
    ------
    ValueError
        It has none of this name.
    """
    if not material.operated:
        raise ValueError(f"found '{operation}'; allowed: a mapping with kind, for {material.name} has none by name")
    if operation not in material.operated:
        raise ValueError(f"found '{operation}'; {nearest(operation, material.operated)}")
    return Operation.of_back(material.operated[operation])


def at_kelvin(celsius: float | list[float]) -> float | tuple[float, ...]:
    """[K] of one or 24 temperatures in degrees Celsius."""
    return tuple(value + ZERO_CELSIUS for value in celsius) if isinstance(celsius, list) else celsius + ZERO_CELSIUS


class SurfaceGrid(StrictModel):
    """Nodes of the temperature table."""

    altitude_km: Annotated[list[float], axis(-0.5, 9)] | None = Field(
        None,
        description="Altitude of the surface above sea level; by default from the site's ground to 3 km above it.",
    )
    azimuth_deg: Annotated[list[float], axis(0, 359.999)] = Field(
        [360.0 / _AZIMUTHS * i for i in range(_AZIMUTHS)],
        description="Azimuth of the surface normal, clockwise from north.",
    )
    slope_deg: Annotated[list[float], axis(0, 180)] = Field(
        [180.0 / (_SLOPES - 1) * i for i in range(_SLOPES)],
        description="Slope of a face: 0 is level and looks up, 90 a wall, 180 looks down.",
    )
    time: Annotated[list[TimeOfDay], Field(min_length=1, max_length=512), pydantic.AfterValidator(ascending)] | None = (
        Field(
            None,
            description=(
                f"By default {_TIMES}, placed for each state where the temperatures of its materials bend: at sunrise"
                " and sunset, and when sunlight comes to tilted faces and leaves them."
            ),
        )
    )
    tolerance: Tolerance | None = Field(
        None,
        description=(
            "Interpolation error in K; it places the nodes, between the ends of the axes, where the error "
            "is; 99 % of all reads are within it, all but two in ten thousand within three times. By default "
            "the job's accuracy, unless the job writes azimuths, slopes or times; a default of 0.5 K is held "
            "as far as most_nodes allows, and the file states its error."
        ),
    )
    most_nodes: int = Field(
        40_000_000,
        ge=16,
        le=200_000_000,
        description="Largest number of nodes of a table whose nodes a tolerance places.",
    )

    @property
    def times(self) -> list[float]:
        """Times of the day [h]: those that are written, or as many, equally spaced, as are placed by default."""
        return self.time or [24.0 / _TIMES * i for i in range(_TIMES)]

    @pydantic.field_validator("tolerance")
    @classmethod
    def _in_kelvin(cls, value: str | None) -> str | None:
        if value is not None and tolerance_parts(value)[1] != "K":
            raise ValueError(f"found '{value}'; allowed: kelvin, such as 0.1 K, for temperatures; write it so")
        return value
