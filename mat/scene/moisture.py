"""The materials of a job with the water that the job puts into their soil."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
import numpy.typing as npt

from skyshine.mat.job.model import Job
from skyshine.mat.job.moisture import moisture_of, water_fraction
from skyshine.mat.radiometry.water_film import moist_reflectance
from skyshine.mat.surface.soil_moisture import evaporating_share, moist_stack, resistance
from skyshine.materials.library import MaterialLibrary, load_library
from skyshine.materials.records import Material
from skyshine.materials.water import water_index
from skyshine.schemas.arrays import Floats


def job_library(job: Job) -> MaterialLibrary:
    """The material library as a job changes it; without `soil_moisture` the library itself."""
    if job.soil_moisture is None:
        return load_library()
    given = job.soil_moisture
    return _moist_library(load_library(), tuple(given.items()) if isinstance(given, dict) else given)


Given = float | str | tuple[tuple[str, float | str], ...]


@lru_cache(maxsize=4)
def _moist_library(library: MaterialLibrary, given: Given) -> MaterialLibrary:
    return library.changed(partial(_of_job, dict(given) if isinstance(given, tuple) else given))


def _of_job(given: float | str | dict[str, float | str], material: Material) -> Material:
    value = moisture_of(given, material.name)
    if material.soil is None or value is None:
        return material
    try:
        return moist(material, water_fraction(value, material.name, material.soil))
    except ValueError:  # refused when the job was loaded, if one of its tables could have it
        return material


def moist(material: Material, moisture: float) -> Material:
    """A material that has soil, with a volume fraction of water in it, up to its porosity."""
    if material.soil is None:
        return material
    moisture = min(moisture, material.soil.porosity)
    reflectance = moist_reflectance(material.reflectance, material.wavelength, water_at(material.wavelength), moisture)
    surface = replace(
        material.surface,
        wetness=float(evaporating_share(moisture)),
        surface_resistance=float(resistance(moisture)),
    )
    return replace(
        material,
        thermal=moist_stack(material.thermal, material.soil, moisture),
        surface=surface,
        reflectance=reflectance,
        absorptance=1.0 - reflectance,
    )


def water_at(wavelength: Floats) -> npt.NDArray[np.complex128]:
    """Refractive index of water at wavelengths [um]: n linear, k exponential between those of the table."""
    known, index = water_index()
    n, k = np.interp(wavelength, known, index.real), np.interp(wavelength, known, np.log(index.imag))
    whole: npt.NDArray[np.complex128] = n + 1j * np.exp(k)
    return whole
