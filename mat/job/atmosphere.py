"""The part of a job that the atmosphere is computed from: state, bands, grid."""

from __future__ import annotations

import datetime
from typing import Annotated, Any, Literal, Self

import pydantic
from pydantic import Field

from skyshine.mat.atmosphere.particles.aerosol_column import (
    BOUNDARY_MODELS,
    LARGEST_OPTICAL_DEPTH,
    SEASONS,
    STRATOSPHERES,
)
from skyshine.mat.atmosphere.particles.angstrom import EXPONENTS
from skyshine.mat.atmosphere.particles.windblown import DEFAULT_AIR_MASS
from skyshine.mat.atmosphere.state.gas_amounts import CARBON_DIOXIDE_PPM
from skyshine.mat.atmosphere.state.profiles import GASES, PROFILES
from skyshine.mat.atmosphere.state.sea_air import COLDEST_SEA, WARMEST_SEA
from skyshine.mat.atmosphere.state.state import MOST_AIRGLOW
from skyshine.mat.job.aerosols import MOST_LAYERS, AerosolLayer
from skyshine.mat.job.clouds import Cloud, Rain
from skyshine.mat.job.default_nodes import ELEVATIONS_DEG, RANGES_KM, SOURCE_AZIMUTHS_DEG, SOURCE_ELEVATIONS_DEG
from skyshine.mat.job.fields import Fraction, TimeOfDay, Tolerance, ascending, axis, one_of
from skyshine.mat.job.files import JobFile
from skyshine.mat.job.presets import presets, with_preset
from skyshine.mat.job.series import Series
from skyshine.mat.job.soundings import StateSounding
from skyshine.mat.job.surface import Weather
from skyshine.mat.job.surroundings import StateSurroundings
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import nearest
from skyshine.tmm.job.materials import MaterialName

Edges = tuple[float, float]
DEFAULT_TOLERANCE = "0.5 K"
AUTO = "auto"  # a profile blended by the site's latitude and the date
TYPICAL = "typical"  # an optical depth by place and month


def _profile(value: Any) -> Any:
    """A name, `AUTO`, or the weights of a blend; a blend of one part is its name."""
    if isinstance(value, str):
        if value not in (*PROFILES, AUTO):
            raise ValueError(f"found '{value}'; {nearest(value, (*PROFILES, AUTO))}")
        return value
    if not isinstance(value, dict):
        raise ValueError(f"found {value!r}; allowed: {AUTO}, a standard profile, or weights of some of them by name")
    for name, weight in value.items():
        if name not in PROFILES:
            raise ValueError(f"found '{name}'; {nearest(str(name), PROFILES)}")
        if isinstance(weight, bool) or not isinstance(weight, int | float) or not 0 < weight <= 1:
            raise ValueError(f"found {weight!r} for {name}; allowed: a weight above 0, up to 1")
    if abs(sum(value.values()) - 1) > 1e-6:
        raise ValueError(f"found weights with the sum {sum(value.values()):g}; allowed: the sum 1")
    return next(iter(value)) if len(value) == 1 else value


_WEIGHTS = {
    "type": "object",
    "propertyNames": {"enum": list(PROFILES)},
    "additionalProperties": {"type": "number", "exclusiveMinimum": 0, "maximum": 1},
    "minProperties": 1,
}
ProfileChoice = Annotated[
    str | dict[str, float],
    pydantic.PlainValidator(_profile),
    pydantic.WithJsonSchema({"anyOf": [{"type": "string", "enum": [AUTO, *PROFILES]}, _WEIGHTS]}),
]


OpticalDepth = Annotated[
    Annotated[float, Field(ge=0, le=LARGEST_OPTICAL_DEPTH), pydantic.Tag("number")]
    | Annotated[Literal["typical"], pydantic.Tag("word")],
    pydantic.Discriminator(lambda value: "word" if isinstance(value, str) else "number"),
]


class GasAmount(StrictModel):
    """How much of a gas there is; its profile is scaled."""

    scale: float | None = Field(None, ge=0, le=1000, description="Factor on the profile.")
    ppm: float | None = Field(None, ge=0, le=1e6, description="Parts per million at the ground.")
    column_mm: float | None = Field(None, ge=0, le=200, description="Water vapour above the ground, mm of water.")
    column_du: float | None = Field(None, ge=0, le=2000, description="Ozone above the ground, Dobson units.")

    @pydantic.model_validator(mode="after")
    def _one(self) -> Self:
        amounts = [name for name in type(self).model_fields if getattr(self, name) is not None]
        if len(amounts) != 1:
            raise ValueError(
                f"found {' and '.join(amounts) or 'no amount'}; allowed: one of {', '.join(type(self).model_fields)}"
            )
        return self


def _gas(name: str) -> str:
    if name not in GASES:
        raise ValueError(f"found '{name}'; {nearest(name, GASES)}")
    return name


GasName = Annotated[
    str, pydantic.AfterValidator(_gas), pydantic.WithJsonSchema({"type": "string", "enum": list(GASES)})
]


def _preset_brings_the_rest(schema: dict[str, Any]) -> None:
    """In the JSON Schema of a state, a preset supplies the keys that are required without one."""
    schema["properties"]["preset"] = {**schema["properties"]["preset"], "examples": list(presets())}
    schema["anyOf"] = [{"required": ["preset"]}, {"required": schema.pop("required")}]


NAME_PATTERN = "^[A-Za-z][A-Za-z0-9_-]{0,39}$"
StateName = Annotated[str, Field(pattern=NAME_PATTERN)]


class State(StrictModel):
    """One atmospheric state: profile, gases, aerosol, cloud, rain, weather."""

    model_config = pydantic.ConfigDict(json_schema_extra=_preset_brings_the_rest)

    name: StateName | None = Field(
        None,
        description=(
            "Name in its files, their pictures and the catalogue, by which open_catalog finds them; by default the"
            " preset's or profile's name. A series shares it."
        ),
    )
    preset: str | None = Field(
        None, description="A ready state (mat info --preset); keys beside it take the place of its own."
    )

    series: Series | None = Field(None, description="Makes a state for each day of a span or row of a table.")
    profile: ProfileChoice = Field(
        AUTO,
        description=(
            "Standard profile, or weights of several; above a sounding, it continues that to space. In a job auto by"
            " default: blended by the site's latitude and the date."
        ),
    )
    sounding: StateSounding | None = Field(
        None,
        description=(
            "File of measured or modelled air: CSV, University of Wyoming (text or CSV), IGRA v2, netCDF on pressure"
            " levels, or an input of MODTRAN; with file, time and column if it contains several."
        ),
    )
    air: Literal["weather", "profile"] = Field(
        "weather",
        description=(
            "Source of the air near the ground, in paths and sky: temperature, humidity and pressure of the weather, or"
            " those of profile and sounding. By default that of the weather, with a sounding that of the sounding."
            " humidity_scale and an amount of H2O in gases keep their water vapour."
        ),
    )
    air_times: (
        Annotated[list[TimeOfDay], Field(min_length=1, max_length=96), pydantic.AfterValidator(ascending)] | None
    ) = Field(
        None,
        description=(
            "Makes a state for each time of the day, whose paths have the air of that time; by default they have the"
            " day's mean. Surface temperatures follow the whole day in each."
        ),
    )
    sea_temperature_c: float | None = Field(
        None,
        ge=COLDEST_SEA - ZERO_CELSIUS,
        le=WARMEST_SEA - ZERO_CELSIUS,
        description=(
            "Temperature of the surface of a sea below the paths. To 50 m above it air temperature and humidity are"
            " those of bulk theory (COARE 3.5) by the weather's wind and the lowest air, rays bend in them, and a"
            " maritime aerosol has large drops of spray by wind and height. water_sea and water_coastal have this"
            " temperature all day where neither operated nor temperatures_c names them."
        ),
    )
    humidity_scale: float = Field(1.0, ge=0, le=10, description="Factor on the profile's water vapour.")
    co2_ppm: float = Field(
        CARBON_DIOXIDE_PPM,
        ge=0,
        le=5000,
        description="Carbon dioxide, parts per million.",
    )
    gases: dict[GasName, GasAmount] = Field({}, description="Amounts of gases, by formula.")
    aerosol: Annotated[str, one_of((*BOUNDARY_MODELS, "none"))] = Field(
        "rural", description="Aerosol model of the lowest 2 km."
    )
    visibility_km: float | None = Field(
        None, ge=0.1, le=300, description="Visibility at the ground; by default that of the aerosol."
    )
    aerosol_table: JobFile | None = Field(
        None,
        description=(
            "CSV of wavelength[um], extinction, single_scattering_albedo and asymmetry of the lowest 2 km, in place of"
            " those of the aerosol, which then gives the amount by height."
        ),
    )
    aerosol_optical_depth: OpticalDepth | None = Field(
        None,
        description=(
            "Vertical optical depth of all aerosol from the ground to space at 0.55 um, in place of "
            "visibility_km; the profile has the shape of the aerosol's own visibility. typical: that of the "
            "place and month, from a climatology of the Linke turbidity (error about 0.1; clear days have less)."
        ),
    )
    angstrom_exponent: float | None = Field(
        None,
        ge=EXPONENTS[0],
        le=EXPONENTS[1],
        description=(
            "Slope of the aerosol's extinction against wavelength up to 1.64 um, where the spectrum of the aerosol"
            " follows; by default that of the aerosol."
        ),
    )
    aerosol_layers: list[AerosolLayer] = Field(
        [],
        max_length=MOST_LAYERS,
        description="Layers added to the aerosol, whose optical depth and Angstrom exponent they do not change.",
    )
    air_mass: int = Field(
        DEFAULT_AIR_MASS,
        ge=1,
        le=10,
        description="Air mass character of navy_maritime: 1 open ocean to 10 continental.",
    )
    stratosphere: Annotated[str, one_of(tuple(STRATOSPHERES))] = Field(
        "background", description="Volcanic loading, and age of its particles."
    )
    season: Annotated[str, one_of(SEASONS)] | None = Field(
        None, description="Season of the aerosol profiles; by default that of the profile, or of most of its blend."
    )
    clouds: list[Cloud] = Field(
        [],
        max_length=8,
        description="Clouds over the whole sky, for paths and surfaces alike, in place of the weather's "
        "cloud_fraction.",
    )
    rain: Rain | None = Field(None, description="Rain from the ground to a height; by default none.")
    night_sky: float = Field(
        0.0,
        ge=0,
        le=MOST_AIRGLOW,
        description=(
            "Airglow over its mean, with starlight and zodiacal light, in the ambient light of level faces below 2.5"
            " um; 0 for none of them. Paths do not scatter it."
        ),
    )
    surface_albedo: Fraction = Field(0.1, description="Albedo of the ground below the paths, in the sensor bands.")
    ground_material: MaterialName | None = Field(
        None,
        description=(
            "Material of the ground around tilted faces and below the paths: its temperature by hour, "
            "emissivity and albedo in the heat balance and in the bands, where scattered light and heat see "
            "its reflectance by wavelength; weather.ground_albedo and surface_albedo, where written, replace "
            "it. The same ground is everywhere: adjacency is not modelled. Its table of temperatures is "
            "built too. By default the level material with the largest share of finished textures, else the "
            "first level one of a list of materials; where neither says one, the ground has the temperature "
            "of the air, the day's mean in ambient light."
        ),
    )
    # Excluded from dumps: only temperature tables depend on it, and their identity states it.
    surroundings: StateSurroundings | None = Field(
        None, exclude=True, description="Walls around all surfaces; by default an open plain."
    )
    date: datetime.date | None = Field(None, description="Date of this state; by default the date of the site.")
    weather: Weather = Field(description="Weather of the day, which drives the surface temperatures.")

    _aerosol_origin: str | None = pydantic.PrivateAttr(None)
    _ground_origin: str | None = pydantic.PrivateAttr(None)
    _one_of_many: bool = pydantic.PrivateAttr(False)

    @property
    def aerosol_origin(self) -> str | None:
        """Where the optical depth comes from, if not from the job."""
        return self._aerosol_origin

    @property
    def optical_depth(self) -> float | None:
        """That of the aerosol, where it is given; a loaded job has no `TYPICAL`."""
        depth = self.aerosol_optical_depth
        return depth if isinstance(depth, float) else None

    def with_optical_depth(self, depth: float, origin: str) -> State:
        """The state with a number for `TYPICAL`, and in words where it comes from."""
        state = self.model_copy(update={"aerosol_optical_depth": depth})
        state._aerosol_origin = origin
        return state

    @property
    def ground_origin(self) -> str | None:
        """Why the state has its ground, if not by the job's own word."""
        return self._ground_origin

    def with_ground(self, material: str, origin: str) -> State:
        """The state with a ground that the job does not write, and in words where it comes from."""
        state = self.model_copy(update={"ground_material": material})
        state._ground_origin = origin
        return state

    @property
    def profile_weights(self) -> dict[str, float]:
        """Weights of the standard profiles; a loaded job has no `AUTO`."""
        return {self.profile: 1.0} if isinstance(self.profile, str) else self.profile

    def as_one_of_many(self) -> Self:
        """The state as a member of a series whose weather differs, or of one of several sites."""
        member = self.model_copy()
        member._one_of_many = True
        return member

    @property
    def is_one_of_many(self) -> bool:
        """Whether points and nodes are those of the state's cell of air, whatever other states the job has."""
        return self._one_of_many

    @property
    def has_water_amount(self) -> bool:
        """Whether the job states how much water vapour is in the air, in place of the weather's humidity."""
        return self.humidity_scale != 1.0 or "H2O" in self.gases

    @property
    def air_time(self) -> float | None:
        """Local clock hour of the air of paths; None is the day's mean. A loaded job has one at most."""
        return None if self.air_times is None else self.air_times[0]

    @property
    def surrounding_materials(self) -> tuple[str, ...]:
        """Materials of the ground and of the walls, where the state names them."""
        wall = None if self.surroundings is None else self.surroundings.wall.material
        return tuple(name for name in (self.ground_material, wall) if name is not None)

    @pydantic.model_validator(mode="before")
    @classmethod
    def _from_preset(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        state = with_preset(data)
        return {"air": "profile", **state} if state.get("sounding") is not None else state

    @pydantic.model_validator(mode="after")
    def _air_of_a_time(self) -> Self:
        if self.air_times is not None and self.air == "profile":
            raise ValueError(
                "found air_times and the air of the profile, which has no times; allowed: with air: weather; give it,"
                " or remove air_times"
            )
        return self

    @pydantic.model_validator(mode="after")
    def _amounts(self) -> Self:
        for gas, amount in self.gases.items():
            for unit, owner in (("column_mm", "H2O"), ("column_du", "O3")):
                if getattr(amount, unit) is not None and gas != owner:
                    raise ValueError(f"found {unit} of {gas}; allowed: {unit} of {owner}; give a scale or ppm")
        for key, gas in (("humidity_scale", "H2O"), ("co2_ppm", "CO2")):
            if (
                gas in self.gases
                and key in self.model_fields_set
                and getattr(self, key) != type(self).model_fields[key].default
            ):
                raise ValueError(f"found {key} and gases.{gas}; allowed: one of them; remove the other")
        return self

    @pydantic.model_validator(mode="after")
    def _one_amount_of_aerosol(self) -> Self:
        depth = self.aerosol_optical_depth
        text = depth if isinstance(depth, str | None) else f"{depth:g}"
        if depth is not None and self.visibility_km is not None:
            raise ValueError(
                f"found visibility_km {self.visibility_km:g} and aerosol_optical_depth {text};"
                " allowed: one of them; remove the other"
            )
        if self.aerosol == "none" and self.aerosol_table is not None:
            raise ValueError(
                "found aerosol none and aerosol_table; allowed: the table with an aerosol, which gives the amount by"
                " height; name one, or remove the table"
            )
        if self.aerosol == "none" and depth:
            raise ValueError(
                f"found aerosol none and aerosol_optical_depth {text}; allowed: an aerosol"
                " with an optical depth; name one, or remove it"
            )
        return self

    @pydantic.model_validator(mode="after")
    def _one_cloud(self) -> Self:
        if self.clouds and self.weather.cloud_fraction > 0:
            raise ValueError(
                "found clouds and weather.cloud_fraction; allowed: layers, which paths see too, or a fraction for"
                " surfaces; remove one"
            )
        return self


class Band(StrictModel):
    """One spectral band of the sensor: a rectangle, or a table of the response."""

    name: str | None = Field(
        None,
        pattern=NAME_PATTERN,
        description="Name in files, pictures, the catalogue and needs.bands; by default b01, b02 ... by order.",
    )
    wavelength_um: Edges | None = Field(None, description="Lower and upper edge; the response is 1 between them.")
    wavenumber_cm: Edges | None = Field(None, description="Lower and upper edge, cm-1; the response is 1 between them.")
    response: JobFile | None = Field(
        None,
        description=(
            "Table of wavelength (um, nm) or wavenumber (cm-1), and response to energy, between commas, semicolons,"
            " tabs or blanks; a column named QE or quantum_efficiency counts photons and is multiplied by wavelength."
        ),
    )

    @pydantic.model_validator(mode="after")
    def _one(self) -> Self:
        ranges = [name for name in type(self).model_fields if name != "name"]
        stated = [name for name in ranges if getattr(self, name) is not None]
        if len(stated) != 1:
            raise ValueError(f"found {' and '.join(stated) or 'no range'}; allowed: one of {', '.join(ranges)}")
        for name in stated:
            edges = getattr(self, name)
            if name != "response" and not 0 < edges[0] < edges[1]:
                raise ValueError(
                    f"found {name} [{edges[0]:g}, {edges[1]:g}]; allowed: 0 < lower < upper; swap or fix them"
                )
        return self


AXES = ("range_km", "altitude_km", "elevation_deg", "source_elevation_deg", "source_azimuth_deg")


class AtmosphereGrid(StrictModel):
    """Axes of the atmospheric tables and the error of the channels between their ends."""

    range_km: Annotated[list[float], axis(0, 100_000)] = Field(
        [*RANGES_KM],
        description=(
            "Distance from the observer along the line of sight. The ends of each axis are what the file is "
            "for. A job that writes all five axes gets the tables of beta*, path, ambient and direct "
            "radiance on exactly these nodes too, in the group grid of the file, with errors of their own."
        ),
    )
    altitude_km: Annotated[list[float], axis(-0.5, 100_000)] | None = Field(
        None,
        description=(
            "Altitude of the observer above sea level; by default from 2 m to 40 km above the site's "
            "ground. From 100 km on the file serves observers at any height in space."
        ),
    )
    elevation_deg: Annotated[list[float], axis(-90, 90)] = Field(
        [*ELEVATIONS_DEG],
        description="Elevation of the line of sight at the observer; -90 looks straight down.",
    )
    tolerance: Tolerance = Field(
        DEFAULT_TOLERANCE,
        description=(
            "Error that the channels leave at most in 99 % of all reads, in all but one or two in ten thousand within"
            " three times, in kelvin, percent or radiance of a scene at 300 K (in kelvin and percent a surface reflects"
            " 0.3 of sky and source, in radiance all). In bands that end before 2.5 um percent are of the light that"
            " such a surface reflects of the source outside the atmosphere, and 3 % count as 1 K. By default the"
            " job's accuracy. A default of 0.5 K is held as far as most_nodes allows; a written one is held, or the"
            " build ends; mat check says where that is to be expected."
        ),
    )
    most_nodes: int = Field(
        20_000_000,
        ge=32,
        le=200_000_000,
        description="Largest number of nodes of all fields of the channels that a tolerance places.",
    )

    source_elevation_deg: Annotated[list[float], axis(-90, 90)] = Field(
        [*SOURCE_ELEVATIONS_DEG], description="Elevation of Sun or Moon above the horizon."
    )
    source_azimuth_deg: Annotated[list[float], axis(0, 180)] = Field(
        [*SOURCE_AZIMUTHS_DEG],
        description="Azimuth of Sun or Moon relative to that of the line of sight; light is the same on both sides.",
    )

    @property
    def writes_tables(self) -> bool:
        """Whether the job writes all five axes, so that its files contain tables on them."""
        return all(name in self.model_fields_set and getattr(self, name) is not None for name in AXES)
