"""Reading one material's files: `ht/NAME.yaml`, `ref/NAME.csv` and `spec/NAME.yaml`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Generic, Literal, NamedTuple, Self, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import Field, GetJsonSchemaHandler, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from skyshine.materials.records import (
    Back,
    Layer,
    PenetratingLight,
    Soil,
    SpectralRange,
    Stand,
    SurfaceProperties,
    ThermalStack,
)
from skyshine.schemas.csv_table import CsvTable, data_lines, parse_table, read_text
from skyshine.schemas.documents import StrictModel, Text, load_model
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.paths import StrPath
from skyshine.schemas.plain_numbers import plain_number

Value = TypeVar("Value")

# Limits wide enough for every solid, liquid and foil, narrow enough to catch a value in other units.
Thickness = Annotated[float, Field(ge=1e-6, le=100.0)]
Conductivity = Annotated[float, Field(ge=1e-3, le=5000.0)]
Density = Annotated[float, Field(ge=0.1, le=25000.0)]
HeatCapacity = Annotated[float, Field(ge=50.0, le=20000.0)]
Kelvin = Annotated[float, Field(ge=50.0, le=2000.0)]
KelvinByHour = Annotated[list[Kelvin], Field(min_length=24, max_length=24)]
# A square metre that gives out as much as a kitchen range at most, or takes as much from what cools behind it.
HeatFlux = Annotated[float, Field(ge=-1e4, le=1e4)]
HeatFluxByHour = Annotated[list[HeatFlux], Field(min_length=24, max_length=24)]
Coefficient = Annotated[float, Field(gt=0.0, le=1e5)]
AirCapacity = Annotated[float, Field(ge=0.0, le=1e7)]  # up to two metres of water behind a square metre
Roughness = Annotated[float, Field(ge=1e-7, le=10.0)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Resistance = Annotated[float, Field(ge=0.0, le=1e5)]
MOST_LEAVES = 20.0  # m2/m2: more than any stand that was measured (Asner et al. 2003: 18 at most)
OperationName = Annotated[str, Field(pattern="^[a-z][a-z0-9_]*$")]
LobeWidth = Annotated[float, Field(ge=0.1, le=180.0)]

RANGE_KINDS = ("measured", "modelled", "fresnel", "proxy", "constant", "held", "interpolated")
USER = "user"  # the source of what a user gives as a plain number
COLUMNS = ("wavelength_um", "reflectance")
COLUMNS_TRANSMITTING = (*COLUMNS, "absorptance")


class Sourced(StrictModel, Generic[Value]):
    """A value and where it comes from."""

    value: Value = Field(description="The value itself, in the unit of its key.")
    source: Text = Field(description="Source of the value: a reference of mat.yaml in brackets and the place in it.")

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        sourced = handler(core)
        return {"anyOf": [sourced, handler.resolve_ref_schema(sourced)["properties"]["value"]]}

    @model_validator(mode="before")
    @classmethod
    def _of_the_user(cls, content: Any) -> Any:
        """A plain number has no source entry: whoever writes one is its source."""
        return {"value": content, "source": USER} if isinstance(content, int | float | str | list) else content


class LayerFile(StrictModel):
    """A layer, every number with its source; m, W m^-1 K^-1, kg m^-3, J kg^-1 K^-1."""

    thickness: Sourced[Thickness] = Field(description="Thickness, m.")
    conductivity: Sourced[Conductivity] = Field(
        description="Thermal conductivity, W m^-1 K^-1; without effect in a skin, which has no resistance."
    )
    density: Sourced[Density] = Field(description="Density, kg m^-3.")
    heat_capacity: Sourced[HeatCapacity] = Field(description="Specific heat, J kg^-1 K^-1.")

    def layer(self) -> Layer:
        return Layer(**{name: getattr(self, name).value for name in type(self).model_fields})


# What each kind of back must say and nothing else.
BACK_VALUES = {
    "adiabatic": (),
    "fixed": ("temperature",),
    "convective": ("temperature", "coefficient"),
    "open": ("coefficient",),
    "cavity": ("coefficient", "exchange", "capacity"),
    "heated": ("heat_flux",),
}
# What it may say too.
BACK_CHOICES = {"cavity": ("heat_flux",)}
BackKind = Literal["adiabatic", "fixed", "convective", "open", "cavity", "heated"]


class BackFile(StrictModel):
    """The back boundary; K, W m^-2 K^-1, J m^-2 K^-1, W m^-2. Values by hour are those of the clock hours 0 to 23."""

    kind: Sourced[BackKind] = Field(
        description=(
            "No flux (adiabatic), a temperature (fixed), a coefficient to air of a temperature (convective), to the"
            " outdoor air of the hour (open) or to enclosed air that floats (cavity), or heat from inside (heated)."
        )
    )
    temperature: Sourced[Kelvin | KelvinByHour | Literal["daily_mean_air"]] | None = Field(
        None, description="K, one or by hour, or the day's mean air temperature; of fixed and convective, no default."
    )
    coefficient: Sourced[Coefficient] | None = Field(
        None,
        description="Coefficient of heat transfer to the air behind, W m^-2 K^-1; of convective, open and "
        "cavity, no default.",
    )
    heat_flux: Sourced[HeatFlux | HeatFluxByHour] | None = Field(
        None, description="Into the stack from behind, or into the cavity (by default none), W m^-2, one or by hour."
    )
    exchange: Sourced[Coefficient] | None = Field(
        None,
        description=(
            "Heat exchange of enclosed with outdoor air, by ventilation and through its other faces, W m^-2 "
            "K^-1 of this face; of cavity, no default."
        ),
    )
    capacity: Sourced[AirCapacity] | None = Field(
        None,
        description="Heat capacity of the enclosed air and what is in it, J m^-2 K^-1 of this face; of "
        "cavity, no default.",
    )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        names = ("temperature", "coefficient", "heat_flux", "exchange", "capacity")
        refuse_incomplete_back(self, self.kind.value, {name: name for name in names})
        return self

    def back(self) -> Back:
        kelvin = by_hour(self.temperature.value) if self.temperature else None
        return Back(
            kind=self.kind.value,
            temperature=None if kelvin == "daily_mean_air" else kelvin,
            coefficient=self.coefficient.value if self.coefficient else None,
            heat_flux=by_hour(self.heat_flux.value) if self.heat_flux else None,
            exchange=self.exchange.value if self.exchange else None,
            capacity=self.capacity.value if self.capacity else None,
        )


def by_hour(value: Any) -> Any:
    """A value as a record keeps it: lists become tuples, so that equal materials are found."""
    return tuple(value) if isinstance(value, list) else value


def refuse_incomplete_back(model: StrictModel, kind: str, keys: dict[str, str]) -> None:
    """ValueError where a model of a back lacks a value that its kind needs, or has one that it does not take.

    Parameters
    ----------
    keys : dict of str to str
        The model's own key for each value of `BACK_VALUES`.
    """
    for name, key in keys.items():
        is_stated = getattr(model, key) is not None
        if is_stated != (name in BACK_VALUES[kind]) and name not in BACK_CHOICES.get(kind, ()):
            raise ValueError(
                f"a back of kind '{kind}' {'takes no' if is_stated else 'needs a'} '{key}'; "
                f"{'remove' if is_stated else 'add'} it or change the kind"
            )


class SurfaceFile(StrictModel):
    """Surface properties; m, 1, s m^-1.

    A file of before `exposure` has none: a stack on a back of kind `fixed`, which is ground, is a field then, any other
    a plate.
    """

    roughness_length: Sourced[Roughness] = Field(
        description="Roughness length of momentum, m; without effect on a plate."
    )
    wetness: Sourced[Fraction] = Field(description="Share of the surface that evaporates, 0 to 1.")
    surface_resistance: Sourced[Resistance] = Field(
        description="Resistance to evaporation, s m^-1; of a canopy the least, in full light and humid air "
        "of 25 Celsius."
    )
    canopy: Sourced[bool] = Field(description="Whether the skin is leaves, whose stomata open with light.")
    snow: Sourced[bool] = Field(description="Whether it is snow or ice, whose temperature ends at the melting point.")
    exposure: Sourced[Literal["field", "plate", "roof", "wall"]] | None = Field(
        None,
        description=(
            "Exposure to wind: endless ground or canopy (field), an object on open ground (plate), roof or "
            "wall of a building; by default field on a fixed back, else plate."
        ),
    )

    delivered: Sourced[Fraction] | None = Field(
        None, description="Share of sunlight that leaves as electric power at 25 Celsius, 0 to 1; by default none."
    )
    delivered_per_kelvin: Sourced[Annotated[float, Field(ge=-0.01, le=0.0)]] | None = Field(
        None, description="Change of that share with temperature, over itself, K^-1; by default none."
    )

    def properties(self, back: str) -> SurfaceProperties:
        """Properties of a stack on a kind of back."""
        values = {
            name: getattr(self, name).value for name in type(self).model_fields if getattr(self, name) is not None
        }
        return SurfaceProperties(**{"exposure": "field" if back == "fixed" else "plate"} | values)


class SoilFile(StrictModel):
    """Pores of a material that is dry in the library and answers to soil moisture; 1, W m^-1 K^-1."""

    texture: Sourced[Literal["gravel", "sand", "sandy_loam", "loam", "silt", "clay", "organic"]] = Field(
        description="Class of grains by which conductivity and evaporation follow moisture."
    )
    porosity: Sourced[Annotated[float, Field(ge=0.05, le=0.95)]] = Field(
        description="Share of the volume between the grains, 0.05 to 0.95: the largest water content."
    )
    solid_conductivity: Sourced[Conductivity] = Field(description="Conductivity of the grains themselves, W m^-1 K^-1.")
    layers: Sourced[Literal[1, 2]] = Field(description="Number of layers below the skin are of this soil.")

    def soil(self) -> Soil:
        return Soil(**{name: getattr(self, name).value for name in type(self).model_fields})


class StandFile(StrictModel):
    """Plants whose leaves the skin is, for jobs that look through their gaps; 1."""

    leaf_area_index: Sourced[Annotated[float, Field(gt=0.0, le=MOST_LEAVES)]] = Field(
        description="Area of one side of the leaves over that of the ground, up to 20."
    )
    soil: Sourced[Text] = Field(description="Name of the material below the leaves.")
    moisture: Sourced[Annotated[float, Field(ge=0.0, le=0.95)]] | None = Field(
        None, description="Water in that soil, m3/m3, where a job has no soil_moisture for it; by default as it is."
    )
    clumping: Sourced[Annotated[float, Field(ge=0.1, le=1.0)]] | None = Field(
        None,
        description="Clumping factor of the leaf area where leaves grow in clumps, 0.1 to 1; by default 1, at random.",
    )

    def stand(self) -> Stand:
        values = {
            name: getattr(self, name).value for name in type(self).model_fields if getattr(self, name) is not None
        }
        return Stand(**values)


class PenetratingLightFile(StrictModel):
    """Sunlight that layers let in; 1, m^-1."""

    share: Sourced[Annotated[float, Field(gt=0.0, le=1.0)]] = Field(
        description="Share of all sunlight that the material absorbs, 0 to 1."
    )
    extinction: Sourced[Annotated[float, Field(ge=0.05, le=1000.0)]] = Field(
        description="Coefficient of its absorption within the layers, m^-1."
    )


class ThermalFile(StrictModel):
    """`ht/NAME.yaml`."""

    skin: LayerFile = Field(
        description="Stores heat at the temperature of the surface: paint, leaves, millimetres of soil."
    )
    layers: Annotated[list[LayerFile], Field(min_length=2, max_length=2)] = Field(
        description="Two layers that conduct, from the skin inwards."
    )
    back: BackFile = Field(description="Boundary below the second layer.")
    surface: SurfaceFile = Field(description="Exchange of heat and water between surface and air.")
    soil: SoilFile | None = Field(
        default=None,
        description="Pores of the soil, if it responds to soil moisture; without them moisture changes nothing.",
    )
    stand: StandFile | None = Field(default=None, description="Canopy: leaf area index and the soil below it.")
    light: Annotated[list[PenetratingLightFile], Field(max_length=3)] = Field(
        default=[],
        description="Sunlight that layers let in (ice), by exponential laws; the rest stays at the surface.",
    )
    operated: dict[OperationName, BackFile] = Field(
        default={},
        description="Backs in operation by name (idling, driving), one of which a job's operated may choose.",
    )

    @model_validator(mode="after")
    def _whole(self) -> Self:
        total = sum(part.share.value for part in self.light)
        if total > 1 + 1e-9:
            raise ValueError(f"found shares of light with a sum of {total:g}; allowed: 1 at most; lower one")
        if self.stand is not None and not self.surface.canopy.value:
            raise ValueError("found a stand of a surface without leaves; allowed: with surface.canopy true; remove it")
        return self

    def stack(self) -> ThermalStack:
        outer, second = self.layers
        light = tuple(PenetratingLight(part.share.value, part.extinction.value) for part in self.light)
        return ThermalStack(self.skin.layer(), (outer.layer(), second.layer()), self.back.back(), light)


class SpecularFile(StrictModel):
    """`spec/NAME.yaml`; fraction of 1, degrees."""

    specular_fraction: Sourced[Fraction] = Field(description="Share of the reflected light in the lobe, 0 to 1.")
    lobe_fwhm: Sourced[LobeWidth] = Field(description="Full width of the lobe at half its maximum, degree.")


class ThermalContent(NamedTuple):
    """`ht/NAME.yaml` as records, with the source of each of their fields."""

    stack: ThermalStack
    surface: SurfaceProperties
    soil: Soil | None
    stand: Stand | None
    operated: dict[str, Back]
    sources: dict[str, str]


def load_thermal(file: StrPath) -> ThermalContent:
    """Stack, surface, soil, stand of leaves, backs in operation and the sources of all: `ht/NAME.yaml`."""
    content = load_model(file, ThermalFile)
    return ThermalContent(
        content.stack(),
        content.surface.properties(content.back.kind.value),
        None if content.soil is None else content.soil.soil(),
        None if content.stand is None else content.stand.stand(),
        {name: part.back() for name, part in content.operated.items()},
        _sources(content),
    )


def load_specular(file: StrPath) -> tuple[float, float, dict[str, str]]:
    """Specular fraction, lobe width [degree] and their sources, from `spec/NAME.yaml`."""
    content = load_model(file, SpecularFile)
    return content.specular_fraction.value, content.lobe_fwhm.value, _sources(content)


def _sources(model: StrictModel, prefix: str = "") -> dict[str, str]:
    """Source texts below a model by dotted field name; layers count from 1."""
    texts: dict[str, str] = {}
    for name in type(model).model_fields:
        value = getattr(model, name)
        entries = list(_entries(name, value))
        for key, entry in entries:
            if isinstance(entry, Sourced):
                texts[prefix + key] = entry.source
            elif isinstance(entry, StrictModel):
                texts.update(_sources(entry, f"{prefix}{key}."))
    return texts


def _entries(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Dotted names of what is below a field: members of lists by number, those of mappings by key."""
    if isinstance(value, list):
        return ((f"{name}.{number}", item) for number, item in enumerate(value, 1))
    if isinstance(value, dict):
        return ((f"{name}.{key}", item) for key, item in value.items())
    return iter([(name, value)])


@dataclass(frozen=True, eq=False)
class SpectrumFile:
    """`ref/NAME.csv`: columns, stretches and the comment header."""

    wavelength: npt.NDArray[np.float64]
    reflectance: npt.NDArray[np.float64]
    absorptance: npt.NDArray[np.float64]
    transmits: bool
    ranges: tuple[SpectralRange, ...]
    header: str


def load_spectrum(file: StrPath) -> SpectrumFile:
    """A reflectance spectrum with its comment header, from `ref/NAME.csv`.

    Raises
    ------
    InputError
        The file is missing, a row is not numbers, wavelengths do not increase, a value is outside 0 to 1,
        or a `# range:` line cannot be read.
    """
    file = Path(file)
    text = read_text(file)
    comments = [(n, line[1:].strip()) for n, line in enumerate(text.splitlines(), 1) if line.startswith("#")]
    if not data_lines(text):
        raise InputError(f"contains no spectrum; add the line {_HEADERS} and rows below it", file=file)
    parsed = parse_table(text, file)
    _check(parsed)
    table, columns = parsed.values, parsed.names
    reflectance = table[:, 1]
    transmits = len(columns) == 3
    return SpectrumFile(
        wavelength=table[:, 0],
        reflectance=reflectance,
        absorptance=table[:, 2] if transmits else 1.0 - reflectance,
        transmits=transmits,
        ranges=tuple(
            _range(file, number, text.partition(":")[2]) for number, text in comments if text.startswith("range:")
        ),
        header="\n".join(text for _, text in comments if not text.startswith("range:")),
    )


_HEADERS = f"'{','.join(COLUMNS)}' or '{','.join(COLUMNS_TRANSMITTING)}'"


def _check(table: CsvTable) -> None:
    if table.names not in (COLUMNS, COLUMNS_TRANSMITTING):
        raise table.error(-1, 0, f"found the column names '{','.join(table.names)[:60]}'; allowed: {_HEADERS}")
    values = table.values
    rising = np.diff(values[:, 0], prepend=0.0) > 0.0
    for row in np.flatnonzero(~rising)[:1]:
        before = values[row - 1, 0] if row else 0
        raise table.error(
            row,
            0,
            f"wavelength_um: found {values[row, 0]:g} after {before:g}; allowed: increasing values above 0; sort the"
            " rows",
        )
    for position, name in enumerate(table.names[1:], 1):
        wrong = (values[:, position] < 0.0) | (values[:, position] > 1.0)
        for row in np.flatnonzero(wrong)[:1]:
            raise table.error(
                row,
                position,
                f"{name}: found {values[row, position]:g}; allowed: 0 to 1; divide by 100 if the table is in percent",
            )
    if len(table.names) == 3:
        for row in np.flatnonzero(values[:, 1] + values[:, 2] > 1.0 + 1e-6)[:1]:
            total = values[row, 1] + values[row, 2]
            raise table.error(row, 1, f"found reflectance + absorptance = {total:g}; allowed: at most 1")


def _range(file: Path, number: int, text: str) -> SpectralRange:
    span, _, note = text.partition(";")
    try:
        start, stop, kind = span.split()
        lower, upper = plain_number(start), plain_number(stop)
    except ValueError:
        raise InputError(
            f"found 'range:{text[:60]}'; allowed: 'range: LOWER UPPER KIND; note' with wavelengths in um",
            file=file,
            line=number,
            column=1,
        ) from None
    if kind not in RANGE_KINDS or not 0.0 < lower <= upper:
        raise InputError(
            f"range: found '{span.strip()}'; {nearest(kind, RANGE_KINDS)}, over a lower and an upper wavelength in um",
            file=file,
            line=number,
            column=1,
        )
    return SpectralRange(lower, upper, kind, note.strip())
