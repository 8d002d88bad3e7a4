"""The table builder: atmospheric quantities and surface temperatures for infrared scene runtimes.

`build` and `check` take a job as `mat build` and `mat check` do; `open` reads a database as a `TemperatureTable`,
`AtmosphereTable` or `BandTable`, and with ``grid=True`` the tables on a job's five axes as a `GridTable`;
`open_catalog` finds one by date, band or source; `spectrum`, `temperature` and `band` compute one thing without a job's
tables; `report` measures how wrong built tables are; `fit_material` finds a material's parameters from a measured
record; `Scene` draws pictures from built tables, `Frame` does so from
the buffers of another renderer, and `contrast` compares two materials through the day; `example` names
a packaged job; `query` interpolates one table, with its stated error; `export` writes other formats, `lut` a look-up
table for ISOFIT; `needs` limits a job to what a scene reads. Results are small objects, which notebooks show; those
of numbers have `to_xarray`, and `plot` where they are lines.

Examples
--------
>>> import skyshine.mat
>>> window = skyshine.mat.spectrum(wavelength=(8, 12), range=1, elevation=0)
>>> print(window)
<Spectrum 832.5 to 1247.5 cm^-1, 84 bins, 1 km; mean transmittance 0.7300>
>>> skyshine.mat.check(skyshine.mat.example("ship")).materials[:2]
['glass_window', 'steel_bare']
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skyshine.mat.api.band import band
    from skyshine.mat.api.build import build
    from skyshine.mat.api.check import check
    from skyshine.mat.api.contrast import contrast
    from skyshine.mat.api.examples import example
    from skyshine.mat.api.export import export
    from skyshine.mat.api.fit_material import fit_material
    from skyshine.mat.api.fluxes import fluxes
    from skyshine.mat.api.frame import Frame
    from skyshine.mat.api.needs import needs
    from skyshine.mat.api.query import query
    from skyshine.mat.api.report import report
    from skyshine.mat.api.scene import Scene
    from skyshine.mat.api.spectrum import spectrum
    from skyshine.mat.api.temperature import temperature
    from skyshine.mat.exchange.isofit import Lut
    from skyshine.mat.exchange.isofit import write_lut as lut
    from skyshine.mat.tables.atmosphere_table import AtmosphereTable
    from skyshine.mat.tables.atmq import GridTable
    from skyshine.mat.tables.band import BandTable
    from skyshine.mat.tables.catalog import open_catalog
    from skyshine.mat.tables.htt import TemperatureTable
    from skyshine.mat.tables.loader import open_table as open

_HOMES = {
    "AtmosphereTable": ("tables.atmosphere_table", "AtmosphereTable"),
    "BandTable": ("tables.band", "BandTable"),
    "Frame": ("api.frame", "Frame"),
    "GridTable": ("tables.atmq", "GridTable"),
    "Lut": ("exchange.isofit", "Lut"),
    "Scene": ("api.scene", "Scene"),
    "TemperatureTable": ("tables.htt", "TemperatureTable"),
    "band": ("api.band", "band"),
    "build": ("api.build", "build"),
    "check": ("api.check", "check"),
    "contrast": ("api.contrast", "contrast"),
    "example": ("api.examples", "example"),
    "export": ("api.export", "export"),
    "fit_material": ("api.fit_material", "fit_material"),
    "fluxes": ("api.fluxes", "fluxes"),
    "lut": ("exchange.isofit", "write_lut"),
    "needs": ("api.needs", "needs"),
    "open": ("tables.loader", "open_table"),
    "open_catalog": ("tables.catalog", "open_catalog"),
    "query": ("api.query", "query"),
    "report": ("api.report", "report"),
    "spectrum": ("api.spectrum", "spectrum"),
    "temperature": ("api.temperature", "temperature"),
}

__all__ = [
    "AtmosphereTable",
    "BandTable",
    "Frame",
    "GridTable",
    "Lut",
    "Scene",
    "TemperatureTable",
    "band",
    "build",
    "check",
    "contrast",
    "example",
    "export",
    "fit_material",
    "fluxes",
    "lut",
    "needs",
    "open",
    "open_catalog",
    "query",
    "report",
    "spectrum",
    "temperature",
]


def __getattr__(name: str) -> Any:
    # Loaded when asked for, so that `mat --help` and a runtime that only opens tables do not wait for the physics.
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, attribute = _HOMES[name]
    return getattr(importlib.import_module(f"{__name__}.{module}"), attribute)


def __dir__() -> list[str]:
    return sorted(__all__)
