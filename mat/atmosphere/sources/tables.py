"""The packaged tables of Sun, Moon and night sky: the one module of the folder that reads files."""

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
def night_sky_table() -> dict[str, Floats]:
    """Brightness of the night sky in broad bands, by column."""
    return read_csv(atmospheres.path("sources/night_sky.csv"))


@cache
def lunar_tables() -> tuple[dict[str, Floats], dict[str, Floats]]:
    """Coefficients of the disk-equivalent reflectance of the Moon, and its spectral shape, by column."""
    coefficients, shape = (
        read_csv(atmospheres.path(f"sources/lunar_{name}.csv")) for name in ("coefficients", "shape")
    )
    return coefficients, shape
