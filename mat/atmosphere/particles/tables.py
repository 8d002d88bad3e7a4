"""The packaged tables of aerosol, cloud and rain: the one module of the folder that reads files."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy.typing as npt

from skyshine import atmospheres
from skyshine.schemas.csv_table import read_csv

# Column name with its unit in brackets to values; numbers, but for the names of models and types of cloud.
Columns = dict[str, npt.NDArray[Any]]


def aerosol_table(model: str) -> Columns:
    """Extinction, absorption and asymmetry of an aerosol model by humidity and wavelength."""
    return _columns(f"aerosol/{model}.csv")


def phase_function_tables() -> tuple[Columns, Columns]:
    """Aerosol phase functions by angle, and which of them belongs to a model, humidity and wavelength."""
    return _columns("aerosol/phase_functions.csv"), _columns("aerosol/phase_index.csv")


def desert_table() -> Columns:
    """Extinction, absorption and asymmetry of the desert aerosol by wind speed and wavelength."""
    return _columns("aerosol/desert.csv")


def navy_maritime_table() -> Columns:
    """Extinction and absorption of the parts of the Navy maritime aerosol by humidity and wavelength."""
    return _columns("aerosol/navy_maritime.csv")


def vertical_table() -> Columns:
    """Aerosol extinction at 0.55 um by altitude, for each season and visibility."""
    return _columns("aerosol/vertical.csv")


def stratosphere_table() -> Columns:
    """Aerosol extinction at 0.55 um by altitude of a stratosphere laden by volcanoes."""
    return _columns("aerosol/stratosphere.csv")


def cloud_table(phase: str) -> Columns:
    """Extinction, absorption and asymmetry of water or ice cloud by effective radius and wavelength."""
    return _columns(f"cloud/{phase}.csv")


def cloud_types_table() -> Columns:
    """The clouds of LOWTRAN7 by name: phase, base, top, extinction and effective radius."""
    return _columns("cloud/types.csv")


def rain_table() -> Columns:
    """Extinction, absorption and asymmetry of rain by rate and wavelength."""
    return _columns("cloud/rain.csv")


@cache
def _columns(name: str) -> Columns:
    columns: Columns = read_csv(atmospheres.path(name))
    for values in columns.values():
        values.flags.writeable = False  # shared by all that ask for the table
    return columns
