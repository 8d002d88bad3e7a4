"""Properties of a spectral band: blackbody radiance, reflectance and specular lobes of materials."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.response_table import parse_response
from skyshine.mat.scene.moisture import open_library
from skyshine.mat.scene.sources import solar_spectrum
from skyshine.mat.tables.band import BandTable, band_group
from skyshine.mat.tables.files import BAND
from skyshine.materials.library import load_library
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.errors import InputError


def band(
    wavelength: tuple[float, float] | None = None,
    *,
    response: str | os.PathLike[str] | None = None,
    materials: Sequence[str] | None = None,
) -> BandTable:
    """Blackbody radiance, reflectance and specular lobes of a band: the same table as a ``.band`` file.

    Parameters
    ----------
    wavelength : (low, high), optional
        Edges [um] of a rectangular response; or `response`.
    response : path, optional
        CSV of wavelength[um] or wavenumber[cm-1], and response; or `wavelength`.
    materials : sequence of str, optional
        Materials of the library; by default all.

    Returns
    -------
    BandTable

    Raises
    ------
    InputError
        Both or neither of `wavelength` and `response`, edges that do not rise, or an unknown material.

    Examples
    --------
    >>> import skyshine.mat
    >>> thermal = skyshine.mat.band((8, 12), materials=["concrete", "aluminium_polished"])
    >>> print(f"{float(thermal.blackbody_radiance(300.0)):.2f} W m^-2 sr^-1")
    38.50 W m^-2 sr^-1
    >>> bool(thermal.value("reflectance", material="aluminium_polished") > 0.8)
    True
    """
    if (wavelength is None) == (response is None):
        raise InputError("found both or neither of wavelength and response; allowed: one of them")
    if wavelength is not None:
        low, high = wavelength
        if not 0 < low < high:
            raise InputError(f"found the edges {low:g} and {high:g} um; allowed: 0 < low < high")
        sensor, name = SpectralResponse.rectangular(low, high), f"{low:g}-{high:g} um"
    else:
        assert response is not None
        name = os.fspath(response)
        sensor = parse_response(read_text(name), name)
    library = open_library(load_library(), "library")  # stands of leaves as jobs have them
    chosen = list(library) if materials is None else [library[material] for material in materials]
    group = band_group(sensor, sorted(chosen, key=lambda material: material.code), solar_spectrum())
    return BandTable(
        Path(name), BAND.name, group, {"title": BAND.title, "data_version": f"materials {library.version}"}
    )
