"""Reading one material's files: `ht/NAME.yaml`, `ref/NAME.csv` and `spec/NAME.yaml`."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Generic, Literal, TypeVar

import numpy as np
from pydantic import Field, StringConstraints, model_validator

from skyshine.materials.records import Back, Layer, SpectralRange, SurfaceProperties, ThermalStack
from skyshine.schemas.documents import StrictModel, load_model
from skyshine.schemas.errors import InputError, nearest

Value = TypeVar("Value")
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]

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
Roughness = Annotated[float, Field(ge=1e-7, le=10.0)]
Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Resistance = Annotated[float, Field(ge=0.0, le=1e5)]
LobeWidth = Annotated[float, Field(ge=0.1, le=180.0)]

RANGE_KINDS = ("measured", "modelled", "fresnel", "proxy", "constant", "held", "interpolated")
COLUMNS = ("wavelength_um", "reflectance")
COLUMNS_TRANSMITTING = (*COLUMNS, "absorptance")


class Sourced(StrictModel, Generic[Value]):
    """A value and where it comes from."""

    value: Value
    source: Text


class LayerFile(StrictModel):
    """A layer, every number with its source; m, W m^-1 K^-1, kg m^-3, J kg^-1 K^-1."""

    thickness: Sourced[Thickness]
    conductivity: Sourced[Conductivity]
    density: Sourced[Density]
    heat_capacity: Sourced[HeatCapacity]

    def layer(self) -> Layer:
        return Layer(**{name: getattr(self, name).value for name in type(self).model_fields})


# What each kind of back must say and nothing else.
BACK_VALUES = {
    "adiabatic": (),
    "fixed": ("temperature",),
    "convective": ("temperature", "coefficient"),
    "heated": ("heat_flux",),
}


class BackFile(StrictModel):
    """The back boundary; K, W m^-2 K^-1 and W m^-2. Values by hour are those of the local clock hours 0 to 23."""

    kind: Sourced[Literal["adiabatic", "fixed", "convective", "heated"]]
    temperature: Sourced[Kelvin | KelvinByHour | Literal["daily_mean_air"]] | None = None
    coefficient: Sourced[Coefficient] | None = None
    heat_flux: Sourced[HeatFlux | HeatFluxByHour] | None = None

    @model_validator(mode="after")
    def _complete(self):
        refuse_incomplete_back(
            self, self.kind.value, {name: name for name in ("temperature", "coefficient", "heat_flux")}
        )
        return self

    def back(self) -> Back:
        kelvin = by_hour(self.temperature.value) if self.temperature else None
        return Back(
            kind=self.kind.value,
            temperature=None if kelvin == "daily_mean_air" else kelvin,
            coefficient=self.coefficient.value if self.coefficient else None,
            heat_flux=by_hour(self.heat_flux.value) if self.heat_flux else None,
        )


def by_hour(value):
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
        given = getattr(model, key) is not None
        if given != (name in BACK_VALUES[kind]):
            raise ValueError(
                f"a back of kind '{kind}' {'takes no' if given else 'needs a'} '{key}'; "
                f"{'remove' if given else 'add'} it or change the kind"
            )


class SurfaceFile(StrictModel):
    """Surface properties; m, 1, s m^-1."""

    roughness_length: Sourced[Roughness]
    wetness: Sourced[Fraction]
    surface_resistance: Sourced[Resistance]
    canopy: Sourced[bool]
    snow: Sourced[bool]

    def properties(self) -> SurfaceProperties:
        return SurfaceProperties(**{name: getattr(self, name).value for name in type(self).model_fields})


class ThermalFile(StrictModel):
    """`ht/NAME.yaml`."""

    skin: LayerFile
    layers: Annotated[list[LayerFile], Field(min_length=2, max_length=2)]
    back: BackFile
    surface: SurfaceFile

    def stack(self) -> ThermalStack:
        first, second = self.layers
        return ThermalStack(self.skin.layer(), (first.layer(), second.layer()), self.back.back())


class SpecularFile(StrictModel):
    """`spec/NAME.yaml`; fraction of 1, degrees."""

    specular_fraction: Sourced[Fraction]
    lobe_fwhm: Sourced[LobeWidth]


def load_thermal(file: str | os.PathLike) -> tuple[ThermalStack, SurfaceProperties, dict[str, str]]:
    """Stack, surface properties and the source of each of their fields, from `ht/NAME.yaml`."""
    content = load_model(file, ThermalFile)
    return content.stack(), content.surface.properties(), _sources(content)


def load_specular(file: str | os.PathLike) -> tuple[float, float, dict[str, str]]:
    """Specular fraction, lobe width [degree] and their sources, from `spec/NAME.yaml`."""
    content = load_model(file, SpecularFile)
    return content.specular_fraction.value, content.lobe_fwhm.value, _sources(content)


def _sources(model: StrictModel, prefix: str = "") -> dict[str, str]:
    """Source texts below a model by dotted field name; layers count from 1."""
    found = {}
    for name in type(model).model_fields:
        value = getattr(model, name)
        entries = [(name, value)] if not isinstance(value, list) else list(_numbered(name, value))
        for key, entry in entries:
            if isinstance(entry, Sourced):
                found[prefix + key] = entry.source
            elif isinstance(entry, StrictModel):
                found.update(_sources(entry, f"{prefix}{key}."))
    return found


def _numbered(name, values):
    return ((f"{name}.{number}", value) for number, value in enumerate(values, 1))


@dataclass(frozen=True, eq=False)
class SpectrumFile:
    """`ref/NAME.csv`: columns, stretches and the comment header."""

    wavelength: np.ndarray
    reflectance: np.ndarray
    absorptance: np.ndarray
    transmits: bool
    ranges: tuple[SpectralRange, ...]
    header: str


def load_spectrum(file: str | os.PathLike) -> SpectrumFile:
    """A reflectance spectrum with its comment header, from `ref/NAME.csv`.

    Raises
    ------
    InputError
        The file is missing, a row is not numbers, wavelengths do not increase, a value is outside 0 to 1,
        or a `# range:` line cannot be read.
    """
    file = Path(file)
    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=file) from None
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start}); save it as UTF-8", file=file) from None
    comments = [(number, text[1:].strip()) for number, text in enumerate(lines, 1) if text.startswith("#")]
    rows = [(number, text) for number, text in enumerate(lines, 1) if text.strip() and not text.startswith("#")]
    columns = _columns(file, rows)
    table, numbers = _table(file, rows[1:], columns)
    _check(file, table, numbers, columns)
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


def _columns(file, rows):
    allowed = f"'{','.join(COLUMNS)}' or '{','.join(COLUMNS_TRANSMITTING)}'"
    if not rows:
        raise InputError(f"holds no spectrum; add the line {allowed} and rows below it", file=file)
    number, text = rows[0]
    columns = tuple(part.strip() for part in text.split(","))
    if columns not in (COLUMNS, COLUMNS_TRANSMITTING):
        raise InputError(
            f"found the column names '{text.strip()[:60]}'; allowed: {allowed}", file=file, line=number, column=1
        )
    return columns


def _table(file, rows, columns):
    values, numbers = [], []
    for number, text in rows:
        parts = text.split(",")
        try:
            row = [float(part) for part in parts]
        except ValueError:
            row = []
        if len(row) != len(columns) or not np.all(np.isfinite(row)):
            raise InputError(
                f"found '{text.strip()[:60]}'; allowed: {len(columns)} numbers, {', '.join(columns)}",
                file=file,
                line=number,
                column=1,
            )
        values.append(row)
        numbers.append(number)
    if len(values) < 2:
        raise InputError(f"found {len(values)} rows of numbers; allowed: at least 2", file=file)
    return np.array(values), numbers


def _check(file, table, numbers, columns):
    rising = np.diff(table[:, 0], prepend=0.0) > 0.0
    for row in np.flatnonzero(~rising)[:1]:
        raise InputError(
            f"wavelength_um: found {table[row, 0]:g} after {table[row - 1, 0] if row else 0:g}; allowed: increasing "
            "values above 0; sort the rows",
            file=file,
            line=numbers[row],
            column=1,
        )
    for position, name in enumerate(columns[1:], 1):
        wrong = (table[:, position] < 0.0) | (table[:, position] > 1.0)
        for row in np.flatnonzero(wrong)[:1]:
            raise InputError(
                f"{name}: found {table[row, position]:g}; allowed: 0 to 1; divide by 100 if the table is in percent",
                file=file,
                line=numbers[row],
                column=1,
            )
    if len(columns) == 3:
        for row in np.flatnonzero(table[:, 1] + table[:, 2] > 1.0 + 1e-6)[:1]:
            raise InputError(
                f"found reflectance + absorptance = {table[row, 1] + table[row, 2]:g}; allowed: at most 1",
                file=file,
                line=numbers[row],
                column=1,
            )


def _range(file, number, text):
    span, _, note = text.partition(";")
    try:
        lower, upper, kind = span.split()
        lower, upper = float(lower), float(upper)
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
