"""The materials of a job with the water that the job puts into their soil, and its snow on them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.job.by_material import value_for
from skyshine.mat.job.model import Job
from skyshine.mat.job.moisture import water_fraction
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.radiometry.reflectance import solar_absorptance, thermal_emissivity
from skyshine.mat.radiometry.water_film import film_reflectance, moist_reflectance
from skyshine.mat.scene.canopy import opened
from skyshine.mat.surface.soil_moisture import moist_stack, resistance
from skyshine.mat.surface.wet_skin import FilmSkin, MoistSkin, film_capacity
from skyshine.materials.library import MaterialLibrary, load_library
from skyshine.materials.records import Material
from skyshine.materials.water import water_index
from skyshine.schemas.arrays import Floats


def under_snow(material: Material, snow: Material, depth: float) -> Material:
    """A material below a layer of snow of a depth [m], which gives it its looks and melts.

    The skin and the layers of the material lie below the snow, over its own back; wind reaches it as it did.
    """
    top = snow.thermal.layers[0]
    below = material.thermal
    solids = (below.skin, *below.layers) if below.skin.thickness else below.layers
    return replace(
        material,
        thermal=replace(below, skin=snow.thermal.skin, layers=(replace(top, thickness=depth), *solids), light=()),
        surface=replace(snow.surface, exposure=material.surface.exposure),
        wavelength=snow.wavelength,
        reflectance=snow.reflectance,
        absorptance=snow.absorptance,
        transmits=snow.transmits,
        ranges=snow.ranges,
        specular_fraction=snow.specular_fraction,
        lobe_fwhm=snow.lobe_fwhm,
        soil=None,
    )


def job_library(job: Job) -> MaterialLibrary:
    """The material library as a job changes it: water in soils, gaps between leaves, and snow on things.

    Where a job has no `leaf_area_index`, stands have the library's own, unless it operates them.
    """
    library = job_materials(job.own_materials)
    if job.soil_moisture is not None:
        library = _moist_library(library, _hashable(job.soil_moisture))
    if job.leaf_area_index is not None:
        library = open_library(library, _hashable(job.leaf_area_index))
    else:
        library = open_library(library, "library", frozenset(job.operated))
    if job.snow_on:
        library = _snowed_library(library, tuple((n, c.snow, c.depth_m) for n, c in job.snow_on.items()))
    return library


@lru_cache(maxsize=4)
def _snowed_library(library: MaterialLibrary, covers: tuple[tuple[str, str, float], ...]) -> MaterialLibrary:
    """A library in which snow lies on some materials: their names, and material and depth [m] of the snow."""
    by_name = {name: (library[snow], depth) for name, snow, depth in covers}
    return library.changed(
        lambda material: under_snow(material, *by_name[material.name]) if material.name in by_name else material
    )


def _hashable(value: float | str | Mapping[str, Any]) -> Given:
    return tuple(value.items()) if isinstance(value, Mapping) else value


@lru_cache(maxsize=4)
def open_library(
    library: MaterialLibrary, leaf_area_index: Given, closed: frozenset[str] = frozenset()
) -> MaterialLibrary:
    """A library whose stands have the gaps that a job's `leaf_area_index` gives them; the soil below them stays.

    Parameters
    ----------
    leaf_area_index : float, str or tuple
        One value for all materials, or pairs of a name and a value.
    closed : frozenset of str
        Names of stands that stay closed.
    """
    requested = dict(leaf_area_index) if isinstance(leaf_area_index, tuple) else leaf_area_index

    def of(material: Material) -> Material:
        value = None if material.name in closed else value_for(requested, material.name)
        stand = material.stand
        if value is None or stand is None:
            return material
        return opened(material, _ground(library[stand.soil], stand.moisture), value)

    return library.changed(of)


def _ground(soil: Material, moisture: float | None) -> Material:
    """The soil of a stand with the stand's own moisture, unless a job has given it another."""
    untouched = load_library()[soil.name]
    if moisture is None or (soil.thermal, soil.surface) != (untouched.thermal, untouched.surface):
        return soil
    return moist(soil, moisture)


Given = float | str | tuple[tuple[str, float | str], ...]


@lru_cache(maxsize=4)
def _moist_library(library: MaterialLibrary, soil_moisture: Given) -> MaterialLibrary:
    return library.changed(partial(_of_job, dict(soil_moisture) if isinstance(soil_moisture, tuple) else soil_moisture))


def _of_job(soil_moisture: float | str | dict[str, float | str], material: Material) -> Material:
    value = value_for(soil_moisture, material.name)
    if material.soil is None or value is None:
        return material
    try:
        return moist(material, water_fraction(value, material.name, material.soil))
    except ValueError:  # refused when the job was loaded, if one of its tables could have it
        return material


def moist(material: Material, moisture: float, frost: float = 0.0) -> Material:
    """A material that has soil, with a volume fraction of water in it, up to its porosity: ice in kelvins of frost."""
    if material.soil is None:
        return material
    moisture = min(moisture, material.soil.porosity)
    reflectance = moist_reflectance(material.reflectance, material.wavelength, water_at(material.wavelength), moisture)
    surface = replace(
        material.surface,
        wetness=1.0,
        surface_resistance=float(resistance(material.soil.texture, moisture)),
    )
    return replace(
        material,
        thermal=moist_stack(material.thermal, material.soil, moisture, frost),
        moisture=moisture,
        dry=material.dry or material,
        surface=surface,
        reflectance=reflectance,
        absorptance=1.0 - reflectance,
    )


# Volume fractions between which absorptance and emissivity of a soil are linear: within 0.001 of the law.
_MOISTURES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8)
_FILM = 3e-4  # m: of the optical properties of a film of rain; chosen: between those of a wall and of a road


@lru_cache(maxsize=512)
def optics(material: Material) -> tuple[float, float]:
    """Solar absorptance at the ground and thermal emissivity."""
    return float(solar_absorptance(material, *ground_sunlight())), float(thermal_emissivity(material))


def moist_skin(dry: Material) -> MoistSkin | None:
    """Absorptance and emissivity of a material by soil moisture; None without soil."""
    if dry.soil is None:
        return None
    inside = tuple(moisture for moisture in _MOISTURES if moisture < dry.soil.porosity)
    moistures = (*inside, dry.soil.porosity)
    absorptances, emissivities = zip(*(optics(moist(dry, moisture)) for moisture in moistures), strict=True)
    return MoistSkin(dry.soil.texture, moistures, absorptances, emissivities)


def film_skin(material: Material) -> FilmSkin | None:
    """A material under a film of water; None where none shows. Leaves and glass keep their absorptance."""
    capacity = film_capacity(material.surface, material.soil)
    if not capacity:
        return None
    if material.transmits or material.surface.canopy:
        return FilmSkin(*optics(material), capacity)
    wet = film_reflectance(material.reflectance, material.wavelength, water_at(material.wavelength), _FILM)
    return FilmSkin(*optics(replace(material, reflectance=wet, absorptance=1.0 - wet)), capacity)


# um at which a surface without a spectrum is evaluated for its whole range: chosen, where sunlight and thermal
# radiation are strongest.
_GREY = {"solar_absorptance": 0.55, "thermal_emissivity": 10.0}


def wet_grey(dry_optics: Mapping[str, float]) -> dict[str, float]:
    """Solar absorptance and thermal emissivity, those that are given, of a grey surface under clear water."""
    wet = {}
    for name, dry in dry_optics.items():
        micron = np.array([_GREY[name]])
        wet[name] = 1.0 - float(film_reflectance([1.0 - dry], micron, water_at(micron), _FILM)[0])
    return wet


def water_at(wavelength: Floats) -> npt.NDArray[np.complex128]:
    """Refractive index of water at wavelengths [um]: n linear, k exponential between those of the table."""
    tabulated, index = water_index()
    n, k = np.interp(wavelength, tabulated, index.real), np.interp(wavelength, tabulated, np.log(index.imag))
    refractive_index: npt.NDArray[np.complex128] = n + 1j * np.exp(k)
    return refractive_index
