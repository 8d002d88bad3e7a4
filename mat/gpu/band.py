"""A ``.band`` database as textures: black-body radiance and the materials."""

from __future__ import annotations

import numpy as np

from skyshine.mat.gpu.air import source_of
from skyshine.mat.gpu.container import GpuFile, rows_of_four, texture
from skyshine.mat.tables.band import BandTable
from skyshine.schemas.errors import InputError

_MATERIAL = ("specular_fraction", "shininess", "normalisation", "reflectance")


def export_band(band: BandTable) -> GpuFile:
    """Single precision throughout: half floats would err by 0.02 K in black-body radiance, and the tables are small.

    Raises
    ------
    InputError
        The temperatures of the black body are not equally spaced.
    """
    temperature = np.asarray(band.root.axes["temperature"].values, float)
    step = float(temperature[1] - temperature[0])
    if not np.allclose(np.diff(temperature), step, rtol=1e-6):
        raise InputError("has black-body temperatures of unequal steps; build the file again", file=band.path)
    radiance = np.asarray(band.root.variables["blackbody_radiance"].data, float)
    materials = np.stack([np.asarray(band.root.variables[name].data, float) for name in _MATERIAL], axis=-1)
    textures = {
        "blackbody": texture("R32F", rows_of_four(radiance), "band radiance of a black body, W m^-2 sr^-1"),
        "materials": texture("RGBA32F", materials[:, None, :], ", ".join(_MATERIAL)),
    }
    numbers = {
        "first_temperature": float(temperature[0]),
        "temperature_step": step,
        "temperatures": int(temperature.size),
        "material": [int(code) for code in band.root.axes["material"].values],
        "material_name": list(band.materials),
    }
    return GpuFile("band", source_of(band.path.name, band.attributes), textures, numbers)
