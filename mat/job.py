"""The YAML job: what a scene needs, as typed models with defaults, limits and units.

Units stand in the key names here, at the edge; everything behind this module is in SI.
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import pydantic
import yaml
from pydantic import Field

from skyshine.mat.atmosphere.profiles import PROFILES
from skyshine.materials.library import MaterialLibrary, load_library
from skyshine.schemas.documents import Document, StrictModel, parse_model, read_yaml
from skyshine.schemas.errors import nearest
from skyshine.tmm.job import MaterialName, TextureJob, check_distinct_names

JOB_FORMAT = 1

_CLOCK = re.compile(r"^([0-9]{1,2}):([0-5][0-9])(?::([0-5][0-9]))?$")


def _hours(value: object) -> float:
    match = _CLOCK.match(value) if isinstance(value, str) else None
    if match is None:
        raise ValueError(f"found {value!r}; allowed: a time of day such as 08:30; write hours:minutes")
    hours = int(match[1]) + int(match[2]) / 60 + int(match[3] or 0) / 3600
    if hours >= 24:
        raise ValueError(f"found {value!r}; allowed: 00:00 to 23:59; the day is periodic, so 24:00 is 00:00")
    return hours


def clock_text(hours: float) -> str:
    """A time of day as it is written in a job, such as 08:30."""
    seconds = round(hours * 3600)
    text = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}"
    return text + (f":{seconds % 60:02d}" if seconds % 60 else "")


def _ascending(values: list[float]) -> list[float]:
    for before, after in zip(values, values[1:]):
        if not after > before:
            raise ValueError(f"found {after:g} after {before:g}; allowed: strictly ascending values; sort them")
    return values


def _profile(name: str) -> str:
    if name not in PROFILES:
        raise ValueError(f"found '{name}'; {nearest(name, PROFILES)}")
    return name


def _axis(low: float, high: float) -> object:
    number = Annotated[float, Field(ge=low, le=high)]
    return Annotated[list[number], Field(min_length=1, max_length=512), pydantic.AfterValidator(_ascending)]


TimeOfDay = Annotated[
    float,
    pydantic.BeforeValidator(_hours),
    pydantic.PlainSerializer(clock_text, return_type=str),
    pydantic.WithJsonSchema({"type": "string", "pattern": _CLOCK.pattern}),
]
Fraction = Annotated[float, Field(ge=0, le=1)]
Celsius = Annotated[float, Field(ge=-120, le=80)]
ProfileName = Annotated[
    str, pydantic.AfterValidator(_profile), pydantic.WithJsonSchema({"type": "string", "enum": list(PROFILES)})
]

MaterialChoice = Annotated[
    Annotated[Literal["used", "all"], pydantic.Tag("word")]
    | Annotated[list[MaterialName], Field(min_length=1), pydantic.Tag("names")],
    pydantic.Discriminator(lambda value: "names" if isinstance(value, list) else "word"),
]


class Site(StrictModel):
    """Where and when: what places Sun and Moon."""

    latitude_deg: float = Field(ge=-90, le=90)
    longitude_deg: float = Field(ge=-180, le=180, description="East is positive.")
    date: date
    utc_offset_h: float = Field(ge=-12, le=14, description="Local clock time minus UTC.")
    altitude_km: float = Field(0.0, ge=-0.5, le=5.9, description="Altitude of the ground below the scene.")


class Weather(StrictModel):
    """Air near the ground through the day, at the altitude of the site."""

    air_temperature_c: tuple[Celsius, Celsius] = Field(description="Lowest and highest of the day.")
    relative_humidity_percent: float = Field(50.0, ge=0, le=100, description="Daily mean; the vapour is constant.")
    wind_speed_m_s: float = Field(2.0, ge=0, le=60)
    cloud_fraction: Fraction = 0.0
    ground_albedo: Fraction = 0.2

    @pydantic.model_validator(mode="after")
    def _ordered(self):
        low, high = self.air_temperature_c
        if low > high:
            raise ValueError(f"found air_temperature_c [{low:g}, {high:g}]; allowed: [lowest, highest]; swap them")
        return self


class State(StrictModel):
    """One atmospheric state: profile, aerosol, weather."""

    profile: ProfileName
    humidity_scale: float = Field(1.0, ge=0, le=10, description="Factor on the profile's water vapour.")
    co2_ppm: float = Field(420.0, ge=0, le=5000)
    aerosol: Literal["rural", "none"] = "rural"
    visibility_km: float = Field(23.0, ge=0.1, le=300)
    surface_albedo: Fraction = Field(0.1, description="Of the ground below the paths, in the sensor bands.")
    weather: Weather


class Band(StrictModel):
    """One spectral band of the sensor."""

    wavelength_um: tuple[float, float] = Field(description="Lower and upper edge; the response is 1 between them.")

    @pydantic.model_validator(mode="after")
    def _ordered(self):
        low, high = self.wavelength_um
        if not 0 < low < high:
            raise ValueError(f"found wavelength_um [{low:g}, {high:g}]; allowed: 0 < lower < upper; swap or mend them")
        return self


OBSERVER_HEIGHTS_KM = (0.002, 0.05, 0.2, 0.5, 1, 2, 3, 5, 8, 12, 20, 40)
SURFACE_HEIGHTS_KM = (0, 0.25, 0.5, 0.75, 1, 1.5, 2, 3)


class AtmosphereGrid(StrictModel):
    """Nodes of the atmospheric tables."""

    range_km: _axis(0, 100_000) = [
        0.001, 0.1, 0.2, 0.35, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 28, 40, 60, 90, 130, 200, 300, 1000,
    ]  # fmt: skip
    altitude_km: _axis(-0.5, 100_000) | None = Field(
        None, description="Of the observer above sea level; by default from 2 m to 40 km above the site's ground."
    )
    elevation_deg: _axis(-90, 90) = [
        -90, -60, -40, -30, -20, -15, -10, -7, -5, -3, -2, -1, 0, 1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 90,
    ]  # fmt: skip
    source_elevation_deg: _axis(-90, 90) = [-10, -5, -2, 0, 2, 5, 10, 20, 30, 45, 60, 75, 90]
    source_azimuth_deg: _axis(0, 180) = [0, 5, 10, 20, 30, 45, 60, 75, 90, 110, 130, 155, 180]


class SurfaceGrid(StrictModel):
    """Nodes of the temperature table."""

    altitude_km: _axis(-0.5, 9) | None = Field(
        None, description="Of the surface above sea level; by default from the site's ground to 3 km above it."
    )
    azimuth_deg: _axis(0, 359.999) = [15.0 * i for i in range(24)]
    slope_deg: _axis(0, 180) = [0, 10, 20, 30, 45, 60, 75, 90, 135, 180]
    time: Annotated[list[TimeOfDay], Field(min_length=1, max_length=512), pydantic.AfterValidator(_ascending)] = Field(
        [f"{i // 2:02d}:{i % 2 * 30:02d}" for i in range(48)], validate_default=True
    )


class Accuracy(StrictModel):
    """How closely the tables are to be computed and measured."""

    spectral_tolerance: float = Field(1e-3, ge=1e-4, le=0.05, description="Relative, of a compiled band.")
    solver_steps: Literal[48, 96, 192, 288] = 96
    seed: int = Field(1, ge=0, le=2**31 - 1, description="Of the random points at which table errors are measured.")


class Output(StrictModel):
    """Where the files go."""

    folder: str = Field("built", min_length=1, description="Relative to the job file.")
    pictures: bool = True


class Job(StrictModel):
    """A whole job."""

    skyshine: Literal[1] = Field(description="Version of the job format.")
    name: str = Field(min_length=1, max_length=80)
    site: Site
    states: list[State] = Field(min_length=1, max_length=99)
    bands: list[Band] = Field(min_length=1, max_length=99)
    sources: list[Literal["sun", "moon"]] = Field(["sun", "moon"], min_length=1, max_length=2)
    textures: Annotated[tuple[TextureJob, ...], Field(max_length=10_000)] = ()
    materials: MaterialChoice = Field(
        "used", description="Those the textures use, all of the library, or names."
    )
    atmosphere_grid: AtmosphereGrid = AtmosphereGrid()
    surface_grid: SurfaceGrid = SurfaceGrid()
    accuracy: Accuracy = Accuracy()
    output: Output = Output()

    @property
    def observer_altitudes_km(self) -> list[float]:
        """Altitudes of the atmospheric tables."""
        return self.atmosphere_grid.altitude_km or [round(self.site.altitude_km + h, 9) for h in OBSERVER_HEIGHTS_KM]

    @property
    def surface_altitudes_km(self) -> list[float]:
        """Altitudes of the temperature table."""
        return self.surface_grid.altitude_km or [round(self.site.altitude_km + h, 9) for h in SURFACE_HEIGHTS_KM]

    @pydantic.model_validator(mode="after")
    def _above_ground(self):
        for name, altitudes in (("atmosphere", self.observer_altitudes_km), ("surface", self.surface_altitudes_km)):
            if altitudes[0] < self.site.altitude_km:
                raise ValueError(
                    f"found {altitudes[0]:g} in {name}_grid.altitude_km; allowed: at least the site's altitude_km, "
                    f"{self.site.altitude_km:g}; raise it, or lower the site"
                )
        return self

    @pydantic.model_validator(mode="after")
    def _consistent(self):
        if self.materials == "used" and not self.textures:
            raise ValueError(
                "found 'materials: used' without textures; allowed: used with textures, all, or a list of names; "
                "name the materials"
            )
        check_distinct_names(self.textures)
        if len(set(self.sources)) != len(self.sources):
            raise ValueError("found a source twice; allowed: sun and moon once each; remove one")
        return self


@dataclass(frozen=True)
class LoadedJob:
    """A job with the file it came from."""

    job: Job
    document: Document

    @property
    def file(self) -> Path:
        return self.document.file

    @property
    def folder(self) -> Path:
        """Folder against which the job's paths are read."""
        return self.document.file.resolve().parent


def load_job(file: str | os.PathLike, library: MaterialLibrary | None = None) -> LoadedJob:
    """Read, check and type a job.

    Parameters
    ----------
    library : MaterialLibrary, optional
        Whose materials the job may name; by default the packaged one with the user's.

    Raises
    ------
    InputError
        With file:line:column of the first thing that does not fit.
    """
    document = read_yaml(file)
    names = (library or load_library()).names
    return LoadedJob(parse_model(document, Job, {"materials": names}), document)


def local_times_utc(site: Site, hours: np.ndarray) -> np.ndarray:
    """UTC times of local clock hours on the day of the site.

    Parameters
    ----------
    hours : (n,) float
        Local clock, in hours.

    Returns
    -------
    (n,) datetime64[s]
    """
    seconds = np.round((np.asarray(hours, float) - site.utc_offset_h) * 3600).astype("timedelta64[s]")
    return np.datetime64(site.date.isoformat(), "s") + seconds


def resolved_text(content: dict) -> str:
    """YAML text of a resolved job or a part of it, the same for the same content."""
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=10_000)
