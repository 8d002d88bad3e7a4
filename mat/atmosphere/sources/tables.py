"""The packaged tables of Sun and Moon: the one module of the folder that reads files."""

from __future__ import annotations

from functools import cache

from skyshine import atmospheres
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv


@cache
def solar_bins() -> tuple[Floats, Floats]:
    """Edges (N + 1,) [cm^-1] and mean irradiance (N,) [W m^-2 (cm^-1)^-1] of the bins of the solar spectrum."""
    table = read_csv(atmospheres.path("sources/solar.csv"))
    return table["wavenumber[cm-1]"], table["irradiance[W m-2 (cm-1)-1]"][:-1]


@cache
def lunar_tables() -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Coefficients of the disk-equivalent reflectance of the Moon, and its spectral shape, by column."""
    coefficients, shape = (
        read_csv(atmospheres.path(f"sources/lunar_{name}.csv")) for name in ("coefficients", "shape")
    )
    return coefficients, shape
