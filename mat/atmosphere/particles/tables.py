"""The packaged tables of aerosol, cloud and rain: the one module of the folder that reads files."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine import atmospheres
from skyshine.mat.atmosphere.particles.moments import log_linear_mean
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.hdf5 import open_database, sound

# Column name with its unit in brackets to values; numbers, but for the names of models and types of cloud.
Columns = dict[str, npt.NDArray[Any]]
PHASE_FILETYPE = "phase_functions"
_RESOLVED = 0.05  # error of the mean of a phase function whose angles resolve it


@dataclass(frozen=True, eq=False)
class PhaseTable:
    """Phase functions of one kind of particle.

    Attributes
    ----------
    node : (E,) array
        Effective radius [um] of droplets, rate [mm/h] of rain, humidity [percent] of aerosol; one node of fog.
    wavelength : (W,) array
        um.
    angle : (A,) array
        Degree.
    phase : (A, E, W) array
        Mean over the sphere 1.
    moments : (M, E, W) array
        Legendre moments; the first is 1.
    """

    node: Floats
    wavelength: Floats
    angle: Floats
    phase: Floats
    moments: Floats


@dataclass(frozen=True, eq=False)
class ScatteringTable(PhaseTable):
    """All of the scattering by one aerosol or component, whose nodes are relative humidities [percent].

    Attributes
    ----------
    extinction, absorption : (E, W) arrays
        um^2 a particle.
    """

    extinction: Floats
    absorption: Floats


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
def phase_table(kind: str) -> PhaseTable:
    """Phase functions of droplets of "water", "fog_advection" or "fog_radiation", or of drops of "rain"."""
    return PhaseTable(**_phase_group("cloud/phase.h5", kind, ()))


@cache
def scattering_table(kind: str) -> ScatteringTable:
    """Scattering by "rural", "urban", "maritime" or "tropospheric" aerosol, or by a component "opac_NAME"."""
    return ScatteringTable(**_phase_group("aerosol/phase.h5", kind, ("extinction", "absorption")))


def _phase_group(name: str, kind: str, more: tuple[str, ...]) -> dict[str, Floats]:
    path = atmospheres.path(name)
    with open_database(path, PHASE_FILETYPE) as file, sound(path):
        group = file[kind]
        columns = {
            name: np.asarray(group[name][:], float)
            for name in ("node", "wavelength", "angle", "phase", "moments", *more)
        }
    phase = np.moveaxis(columns["phase"], -1, 0)
    mean = log_linear_mean(np.radians(columns["angle"]), phase)
    # Peaks narrower than the angles leave light out, which the moments have: all else is the error of the angles.
    columns["phase"] = np.where(np.abs(mean - 1) < _RESOLVED, phase / mean, phase)
    columns["moments"] = np.moveaxis(columns["moments"], -1, 0)
    return columns


@cache
def _columns(name: str) -> Columns:
    columns: Columns = read_csv(atmospheres.path(name))
    for values in columns.values():
        values.flags.writeable = False  # shared by all that ask for the table
    return columns
