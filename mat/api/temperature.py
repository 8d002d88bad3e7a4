"""One surface through the day, or under a measured record, with every flux."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.mat.job.fields import clock_interval
from skyshine.mat.job.leaf_area import open_stands, refuse_no_soil
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.job.surface import Operation
from skyshine.mat.scene.moisture import job_library, open_library, wet_grey
from skyshine.mat.scene.surface import surface_inputs, surface_materials
from skyshine.mat.surface.column import ColumnResult, from_record, from_scene
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solver import DAY
from skyshine.mat.surface.surroundings import WALL_EMISSIVITY, Surroundings
from skyshine.mat.surface.weather import DRY, Wetting
from skyshine.mat.surface.weather_readings import read_record
from skyshine.mat.surface.wet_skin import FilmSkin, film_capacity
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.result import CLOCK, Panel, Result
from skyshine.materials.files import MOST_LEAVES, load_thermal
from skyshine.materials.library import MaterialLibrary, load_library
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray

# Before a record: half a metre of concrete remembers a day to hundredths of a kelvin after a week.
SPIN_UP_DAYS = 7


class SurfaceTemperature(Result, ColumnResult):
    """Temperature and fluxes of a surface; the fields are those of `ColumnResult`, arrays (N,) over time."""

    def to_xarray(self) -> xarray.Dataset:
        """Temperature and fluxes as an `xarray.Dataset` over time: hours of the local clock, or UTC of a record."""
        local = self.time_units == "h"
        time = (
            np.array(self.time) if local else np.array([str(t).removesuffix("Z") for t in self.time], "datetime64[ns]")
        )
        variables: dict[str, tuple[tuple[str, ...], str, Any]] = {"temperature": (("time",), "K", self.temperature)}
        if self.depth_temperature is not None:
            variables["temperature_at_depth"] = (("time",), "K", self.depth_temperature)
        for name in ("leaf_temperature", "soil_temperature"):
            if getattr(self, name) is not None:
                variables[name] = (("time",), "K", getattr(self, name))
        if self.film is not None:
            variables["film"] = (("time",), "kg m^-2", self.film)
        variables |= {name: (("time",), "W m^-2", values) for name, values in self.fluxes.items()}
        attributes = {
            "residual": self.residual,
            "energy_closure": self.energy_closure,
            "bound_excess": self.bound_excess,
            "method": self.method,
        }
        over_time = dataset({"time": ("h" if local else "UTC", time)}, variables, attributes)
        if not local:
            del over_time["time"].attrs["units"]  # a date needs none, and xarray writes its own
        return over_time

    def _panels(self) -> list[Panel]:
        time, label = (
            (np.asarray(self.time, float), CLOCK)
            if self.time_units == "h"
            else (np.array([str(t).removesuffix("Z") for t in self.time], "datetime64[s]"), "UTC")
        )
        kelvin = {"surface": self.temperature}
        for name, values in (("at depth", self.depth_temperature), ("leaves", self.leaf_temperature)):
            kelvin |= {} if values is None else {name: values}
        kelvin |= {} if self.soil_temperature is None else {"soil": self.soil_temperature}
        fluxes = {name.replace("_", " "): values for name, values in self.fluxes.items()}
        return [
            Panel(time, label, "temperature, K", kelvin),
            Panel(time, label, "flux, W m$^{-2}$", fluxes),
        ]

    def __repr__(self) -> str:
        low, high = np.argmin(self.temperature), np.argmax(self.temperature)
        extremes = [f"{self.temperature[i]:.2f} K at {self._clock(int(i))}" for i in (low, high)]
        return f"<SurfaceTemperature {len(self.time)} times, {extremes[0]} to {extremes[1]}; {self.method}>"

    def _clock(self, index: int) -> str:
        time = self.time[index]
        return time if isinstance(time, str) else f"{time:05.2f} h"


def temperature(
    material: str | os.PathLike[str],
    *,
    job: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    state: int = 1,
    altitude: float | None = None,
    forcing: str | os.PathLike[str] | None = None,
    slope: float = 0.0,
    azimuth: float = 180.0,
    latitude: float | None = None,
    longitude: float | None = None,
    ground_albedo: float = 0.2,
    depth: float | None = None,
    shade: str | Sequence[str] = (),
    sky_view: float = 1.0,
    facing: float | None = None,
    facing_emissivity: float = WALL_EMISSIVITY,
    absorptance: float | None = None,
    emissivity: float | None = None,
    leaf_area_index: float | str | None = None,
) -> SurfaceTemperature:
    """Temperature and every flux of one surface through the day.

    Parameters
    ----------
    material : str or path
        Material of the library, or a YAML file of the layout of ``materials/ht``.
    job : path or mapping
        Sun, sky, weather and surroundings of its state; or `forcing`.
    state : int
        Number of the state of the job, counted from 1.
    altitude : float, optional
        Altitude of the surface [km], by default the site's; with `forcing` for a record without pressure, by default 0.
    forcing : path
        CSV of measured radiation and weather; or `job`. Its first day also serves for the days before it, and one day
        or less repeats; `notes` of the result list the defaults used for missing columns.
    slope, azimuth : float
        Slope of the surface [degree], 0 for one that faces up, and azimuth of its normal from north eastward [degree].
    latitude, longitude : float, optional
        [degree]; place the Sun for a slope, shade, a wall, or direct and diffuse light under `forcing`.
    ground_albedo : float
        Albedo of the surrounding ground, with `forcing`.
    depth : float, optional
        Below the skin [m], at which the temperature is wanted too.
    shade : str or sequence of str
        Hours such as ``"10:00-14:00"`` in which no light comes from the direction of the Sun, over midnight where the
        first is later; local clock with `job`, UTC with `forcing`.
    sky_view : float
        Open share of the sky above the surface, as far as the job leaves it open, 0 to 1; the rest is a wall, which
        reflects no sunlight.
    facing : float, optional
        Temperature of that wall [K]; by default that of the air.
    facing_emissivity : float
        Emissivity of the facing wall, 0 to 1.
    absorptance, emissivity : float, optional
        Optical values that replace the library's; required with a material file.
    leaf_area_index : float or "library", optional
        Leaf area index of a canopy with gaps through which soil is visible [m^2 m^-2], as the key of a job; by default
        the library's value. A record without latitude and longitude takes all light in the gaps as uniform; with a
        depth or without air the canopy is closed. `leaf_temperature` and `soil_temperature` of the result are those of
        the two.

    Returns
    -------
    SurfaceTemperature

    Raises
    ------
    InputError
        Both or neither of `job` and `forcing`, an unknown material, or a value outside its limits.

    Examples
    --------
    >>> import skyshine.mat
    >>> day = skyshine.mat.temperature("concrete", job=skyshine.mat.example("starter"), slope=30)
    >>> day.temperature.size
    192
    >>> bool(day.temperature.max() - day.temperature.min() > 10)
    True
    >>> shaded = skyshine.mat.temperature(
    ...     "concrete", job=skyshine.mat.example("starter"), slope=30, shade="10:00-14:00"
    ... )
    >>> bool((day.temperature - shaded.temperature).max() > 5)
    True
    """
    if (job is None) == (forcing is None):
        raise InputError("found both or neither of job and forcing; allowed: one of them")
    optical = {"solar_absorptance": absorptance, "thermal_emissivity": emissivity}
    surroundings = _surroundings(shade, sky_view, facing, facing_emissivity)
    if job is not None:
        model, (sun_path, weather, sky) = surface_inputs(job, state)
        if leaf_area_index is not None and model.leaf_area_index is not None:
            raise InputError("found leaf_area_index, which the job has too; allowed: in one of them; remove it here")
        if leaf_area_index is not None:
            gaps = _checked_gaps(material, leaf_area_index, job_materials(model.own_materials))
            model = model.model_copy(update={"leaf_area_index": gaps})
        library = job_library(model)
        if depth is not None and model.leaf_area_index is None:
            library = library.changed(
                lambda material_of_library: (
                    material_of_library if material_of_library.opened is None else material_of_library.opened.leaves
                )
            )
        surface = surface_material(material, model.operated, optical, library, weather.wetting)
        metres = sun_path.altitude if altitude is None else 1e3 * altitude
        column = from_scene(surface, sun_path, weather, sky, metres, slope, azimuth, depth, surroundings)
    else:
        assert forcing is not None
        record = read_record(forcing, 1e3 * (altitude or 0.0))
        library = load_library()
        if leaf_area_index is not None:
            library = open_library(library, tuple(_checked_gaps(material, leaf_area_index, library).items()))
        elif depth is None and np.any(record.values["pressure"]):
            library = open_library(library, "library")
        surface = surface_material(material, {}, optical, library, record.wetting)
        needs_sun = leaf_area_index or slope or surroundings is not None or "sw_down" not in record.values
        has_path = surface.canopy is not None and latitude is not None
        sun = _sun_at(latitude, longitude) if needs_sun or has_path else None
        spin_up = SPIN_UP_DAYS if record.period > DAY + 0.5 * record.step else 0
        column = from_record(surface, record, slope, azimuth, sun, ground_albedo, depth, surroundings, spin_up)
        column = replace(column, notes=(*column.notes, _before(record.period, spin_up)))
    return SurfaceTemperature(**{field.name: getattr(column, field.name) for field in fields(column)})


def _before(period: float, spin_up: int) -> str:
    """Weather assumed for the days before a record."""
    if spin_up:
        return f"no days before: the first day, {spin_up} times, is repeated for them (spin-up)"
    return f"no days before: the record, {period / 3600:g} h, repeats"


def _checked_gaps(
    material: str | os.PathLike[str], leaf_area_index: float | str, library: MaterialLibrary
) -> dict[str, float | str]:
    """The leaf area index of a material, as a job has it."""
    name = os.fspath(material)
    stands = [entry.name for entry in library if entry.stand is not None]
    try:
        open_stands({name: leaf_area_index}, stands)
        refuse_no_soil(library[name], library)
        number = isinstance(leaf_area_index, int | float) and 0 <= leaf_area_index <= MOST_LEAVES
        if leaf_area_index != "library" and not number:
            raise ValueError(f"found {leaf_area_index}; allowed: 0 to {MOST_LEAVES:g} m2/m2, or library")
    except ValueError as error:
        raise InputError(f"leaf_area_index: {error}") from None
    return {name: leaf_area_index}


def _surroundings(
    shade: str | Sequence[str], sky_view: float, facing: float | None, facing_emissivity: float
) -> Surroundings | None:
    """Shade and wall; None where there is neither."""
    try:
        hours = tuple(clock_interval(text) for text in ([shade] if isinstance(shade, str) else shade))
    except ValueError as error:
        raise InputError(f"shade: {error}") from None
    surroundings = Surroundings(hours, sky_view, facing, facing_emissivity)
    return surroundings if hours or sky_view < 1 else None


def surface_material(
    name: str | os.PathLike[str],
    operated: Mapping[str, Operation],
    optical_values: Mapping[str, float | None],
    library: MaterialLibrary | None = None,
    wetting: Wetting = DRY,
) -> SurfaceMaterial:
    """A material of the library, in operation or not, or of a file; given optical values replace the library's."""
    text = os.fspath(name)
    optical: dict[str, Any] = {key: value for key, value in optical_values.items() if value is not None}
    if text.endswith((".yaml", ".yml")) or Path(text).is_file():
        missing = [key for key in optical_values if key not in optical]
        if missing:
            name = missing[0].rpartition("_")[2]
            raise InputError(f"a material file contains no {name}; give {name}", file=text)
        thermal, surface, *_ = load_thermal(text)
        result = SurfaceMaterial(text, thermal, surface, **optical)
        capacity = film_capacity(surface, None) if wetting.rain else 0.0
        wet = optical if surface.canopy else wet_grey(optical)
        return replace(result, film=FilmSkin(**wet, capacity=capacity) if capacity else None)
    (result,) = surface_materials([(library or load_library())[text]], operated, wetting)
    return _with_optics(result, optical)


def _with_optics(material: SurfaceMaterial, optical: Mapping[str, float]) -> SurfaceMaterial:
    """A material with the values that are given, dry and wet; of an open stand leaves and soil alike."""
    film, canopy = material.film, material.canopy
    if film is not None:
        as_dry = film.solar_absorptance == material.solar_absorptance  # leaves and glass
        film = replace(film, **(optical if as_dry else wet_grey(optical)))
    if canopy is not None:
        leaves, soil = (_with_optics(part, optical) for part in (canopy.leaves, canopy.soil))
        canopy = replace(canopy, leaves=leaves, soil=soil)
    return replace(material.with_optics(**optical), film=film, canopy=canopy)


def _sun_at(
    latitude: float | None, longitude: float | None
) -> Callable[[npt.NDArray[np.datetime64]], tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]:
    """Elevation and azimuth of the Sun [degree] at UTC times of a place."""
    if latitude is None or longitude is None:
        raise InputError(
            "a slope, shade, a wall, gaps of leaves, or direct and diffuse light of a record needs the Sun; give"
            " latitude and longitude"
        )

    def sun(times: npt.NDArray[np.datetime64]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        solar_position = position("sun", times.astype("datetime64[s]"), latitude, longitude, 0.0)
        return solar_position.elevation, solar_position.azimuth

    return sun
