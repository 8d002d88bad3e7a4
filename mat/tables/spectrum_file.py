"""The `spectrum` file: means over spectral bins along one line of sight, in HDF5 or CSV."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.tables.files import SPECTRUM
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file
from skyshine.schemas.paths import StrPath
from skyshine.schemas.whole_files import write_whole

Columns = Mapping[str, tuple[str, npt.NDArray[np.float64]]]  # units and values (B,) by name, wavenumber first

RADIANCE = "W m^-2 sr^-1 (cm^-1)^-1"
IRRADIANCE = "W m^-2 (cm^-1)^-1"
LONG_NAMES = {
    "wavenumber": "middle of the bin",
    "wavelength": "of the middle of the bin",
    "transmittance": "transmittance of the line of sight",
    "transmittance_rayleigh": "transmittance of scattering by molecules alone",
    "transmittance_aerosol": "transmittance of particles alone",
    "path_thermal": "radiance that the air of the line of sight emits and scatters of emitted light",
    "path_scattered": "radiance of the source's light that the air of the line of sight scatters",
    "sky_irradiance": "diffuse irradiance of a level surface at the end of the line of sight",
    "night_sky": "radiance of airglow and starlight behind the air of a line of sight into space",
    "direct_irradiance": "irradiance by the source, normal to the beam, at the end of the line of sight",
}


def write_spectrum(path: StrPath, columns: Columns, attributes: Mapping[str, Any], data_version: str, job: str) -> str:
    """Write the columns of a spectrum as HDF5.

    Parameters
    ----------
    columns : mapping
        Units and values (B,) by name; wavenumber becomes the axis.
    attributes : mapping of str to str or float
        Attributes of the whole file.
    data_version : str
        Version of the data that the spectrum was computed from.
    job : str
        What was computed, as YAML.

    Returns
    -------
    str
        The digest of the content.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    units, wavenumber = columns["wavenumber"]
    variables = {
        name: Variable(("wavenumber",), values, unit, _long_name(name))
        for name, (unit, values) in columns.items()
        if name != "wavenumber"
    }
    variables["wavelength"] = Variable(("wavenumber",), 1e4 / wavenumber, "um", LONG_NAMES["wavelength"])
    root = Group({"wavenumber": Axis(wavenumber, units, LONG_NAMES["wavenumber"])}, variables, {}, dict(attributes))
    header = Header(SPECTRUM.name, data_version, job, SPECTRUM.title)
    return write_file(path, root, header)


def csv_lines(columns: Columns, attributes: Mapping[str, Any] | None = None) -> Iterable[str]:
    """Lines of a CSV file: attributes as comments, names with units, values."""
    for name, value in (attributes or {}).items():
        yield from (f"# {name}: {line}" for line in str(value).splitlines())
    yield ",".join(f"{name}[{unit}]" for name, (unit, _) in columns.items())
    for row in zip(*(values for _, values in columns.values()), strict=True):
        yield ",".join(f"{value:.8g}" for value in row)


def write_spectrum_csv(path: StrPath, columns: Columns, attributes: Mapping[str, Any]) -> None:
    """Write the columns of a spectrum as CSV, its attributes as comments.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    write_whole(Path(path), "\n".join(csv_lines(columns, attributes)) + "\n")


def _long_name(name: str) -> str:
    return LONG_NAMES.get(name, f"transmittance of {name.removeprefix('transmittance_')} alone")
