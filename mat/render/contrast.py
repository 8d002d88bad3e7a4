"""Contrast of one material against another through the day, and the hours at which it vanishes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.render.databases import BandTables, SceneTables, held_hours, in_twilight, refused
from skyshine.mat.runtime.equivalent_temperature import equivalent_temperature
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.result import CLOCK, Panel, Result
from skyshine.mat.tables.tracks import SUNRISE_ELEVATION
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray

STEPS = 288  # steps of a day
AIR_QUANTITIES = "beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance"


@dataclass(frozen=True)
class Face:
    """A surface of one material.

    Attributes
    ----------
    slope, azimuth : float
        [degree]
    shade : tuple of (begin, end)
        Clock hours in which no light comes from the direction of the Sun; over midnight where `begin` is later.
    """

    material: str
    slope: float = 0.0
    azimuth: float = 0.0
    shade: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class Sight:
    """The line of sight to both faces.

    Attributes
    ----------
    range : float
        Distance of the faces from the observer [km].
    elevation : float
        Elevation of the line of sight at the observer [degree].
    heading : float
        Azimuth of the line of sight, from north eastward [degree].
    altitude : float or None
        Altitude of the surface [km]; None takes the lowest of the tables.
    """

    range: float = 1.0
    elevation: float = -45.0
    heading: float = 0.0
    altitude: float | None = None


@dataclass(frozen=True, eq=False, repr=False)
class Contrast(Result):
    """Apparent temperatures of two faces through the day.

    Attributes
    ----------
    hours : (T,) array
        Local clock; those that the tables contain, without a twilight that they lack.
    material, background : (T,) array
        Apparent temperature [K].
    crossovers : tuple of float
        Hours at which the contrast changes its sign.
    band : str
        Name of the band.
    wavelength : tuple of float
        Limits of the band [um].
    sight : Sight
    date : str
        Date of the day, as 2026-07-28.
    sun_up : tuple of (rise, set)
        Hours of sunrise and sunset; empty where the Sun does neither.
    stated_error : float
        Error of the contrast [K]: the 99th percentiles that the files state for both temperatures and the quantities
        of the air, and the largest error in the shade where there is shade, added as squares.
    """

    hours: Floats
    material: Floats
    background: Floats
    crossovers: tuple[float, ...]
    band: str
    wavelength: tuple[float, float]
    sight: Sight
    date: str
    sun_up: tuple[float, ...]
    stated_error: float

    @property
    def contrast(self) -> Floats:
        """Material minus background (T,) [K]."""
        return self.material - self.background

    def __repr__(self) -> str:
        low, high = float(np.min(self.contrast)), float(np.max(self.contrast))
        return (
            f"<Contrast {self.wavelength[0]:g} to {self.wavelength[1]:g} um, {self.date}: {low:+.2f} to {high:+.2f} K,"
            f" {len(self.crossovers)} crossovers, stated error {self.stated_error:.2g} K>"
        )

    def _panels(self) -> list[Panel]:
        apparent = {"material": self.material, "background": self.background}
        return [
            Panel(self.hours, CLOCK, "apparent temperature, K", apparent),
            Panel(self.hours, CLOCK, "contrast, K", {"contrast": self.contrast}),
        ]

    def to_xarray(self) -> xarray.Dataset:
        """Both apparent temperatures and the contrast as an `xarray.Dataset` over hours of the local clock."""
        values = {"material": self.material, "background": self.background, "contrast": self.contrast}
        return dataset(
            {"time": ("h", self.hours)},
            {name: (("time",), "K", array) for name, array in values.items()},
            {
                "band": self.band,
                "wavelength_um": list(self.wavelength),
                "date": self.date,
                "crossovers": np.array(self.crossovers),
                "stated_error_kelvin": self.stated_error,
            },
        )


def contrast(
    folder: Path, material: Face, background: Face, sight: Sight, *, band: str | None, state: int, source: str
) -> list[Contrast]:
    """Contrast in each band.

    Parameters
    ----------
    folder : Path
        Output folder of a finished build.
    material, background : Face
    sight : Sight
    band : str or None
        One band by its name; by default all.
    state : int
        Counted from 1.
    source : {'sun', 'moon'}

    Raises
    ------
    InputError
        A database, a material or a place is missing.
    """
    tables = SceneTables.of(folder, state=state, bands=None if band is None else [band], source=source, refuse=refused)
    day = np.arange(float(STEPS)) * (24.0 / STEPS)
    elevation = tables.surface.source_track(source, time=day).elevation
    tabulated = held_hours(tables.surface, day) & ~np.any(
        [in_twilight(read.air, elevation) for read in tables.bands], axis=0
    )
    hours = day[tabulated]
    codes = tables.codes({face.material: () for face in (material, background)})
    codes = np.resize(codes, 2)  # one code where both faces are of one material
    up = sun_hours(tables.surface)
    date = str(tables.surface.attributes["date"])
    results = []
    for read in tables.bands:
        target, behind = (
            equivalent_temperature(read.band, seen_radiance(tables, read, face, int(code), sight, hours, source=source))
            for face, code in zip((material, background), codes, strict=True)
        )
        crossovers = crossover_hours(hours, target - behind, step=24.0 / STEPS)
        lower, upper = (float(limit) for limit in read.air.attributes["wavelength_um"])
        error = stated_error(tables.surface, read.air, [int(code) for code in codes[:1][[bool(material.shade)]]])
        results.append(Contrast(hours, target, behind, crossovers, read.name, (lower, upper), sight, date, up, error))
    return results


def sun_hours(surface: TemperatureTable) -> tuple[float, ...]:
    """Hours of sunrise and sunset on the local clock; none where the Sun stays up or down."""
    minutes = np.arange(24 * 60)
    up = surface.source_track("sun", time=minutes / 60.0).elevation > SUNRISE_ELEVATION
    rise, set_ = (np.flatnonzero(up & ~np.roll(up, 1)), np.flatnonzero(~up & np.roll(up, 1)))
    return (float(rise[0]) / 60.0, float(set_[0]) / 60.0) if rise.size and set_.size else ()


def stated_error(surface: TemperatureTable, air: AtmosphereTable, shaded: Sequence[int]) -> float:
    """Error of a contrast [K] by the errors that the files state, added as squares; `shaded` has the codes of
    materials in the shade.
    """
    temperature = surface.error("temperature")["p99_kelvin"]
    parts = [temperature, temperature]
    parts += [air.error(name)["p99_kelvin"] for name in AIR_QUANTITIES]
    accuracy = surface.root.groups["accuracy"]
    if shaded and "shade_maximum" in accuracy.variables:
        rows = {int(code): row for row, code in enumerate(np.asarray(accuracy.axes["material"].values))}
        parts += [float(np.asarray(accuracy.variables["shade_maximum"].data)[rows[code]]) for code in shaded]
    return float(np.sqrt(np.nansum(np.square(parts))))


def seen_radiance(
    tables: SceneTables, read: BandTables, face: Face, code: int, sight: Sight, hours: Floats, *, source: str
) -> Floats:
    """Radiance (T,) of a face, through the air, at hours (T,) of the local clock [W m^-2 sr^-1].

    Parameters
    ----------
    read : BandTables
        One band of the tables.
    code : int
        Code of the face's material in the tables.
    hours : (T,) array
    source : {'sun', 'moon'}

    Raises
    ------
    InputError
        The face is turned away from the observer, or a value is outside an axis.
    """
    altitude = sight.altitude
    if altitude is None:
        altitude = float(tables.surface.root.axes["altitude"].values[0])
    sight_vector, normal = direction(sight.elevation, sight.heading), direction(90.0 - face.slope, face.azimuth)
    if normal @ sight_vector >= 0:
        raise InputError(
            f"the face of {face.material} is turned away from the observer; change its slope or azimuth, or the"
            " line of sight"
        )
    track = tables.surface.source_track(source, time=hours)
    observer = altitude - sight.range * float(np.sin(np.radians(sight.elevation)))
    highest = float(np.max(read.air.attributes.get("altitude_km", np.inf)))
    if observer > highest:
        raise InputError(
            f"{sight.range:g} km at an elevation of {sight.elevation:g} degree put the observer at {observer:.4g} km;"
            f" allowed: up to {highest:g} km; give a shorter range or another elevation"
        )
    nearest, count = float(read.air.rules("beta_star")[0].nodes[0]), hours.size
    lines = LinesOfSight(
        np.full(count, sight.range),
        np.full(count, observer),
        np.full(count, sight.elevation),
        track.elevation,
        track.azimuth - sight.heading,
    )
    view = View.of(lines, np.full(count, sight.heading), np.broadcast_to(normal, (count, 3)), nearest=nearest)
    faces = _faces(tables, face, code, altitude, hours)
    return pixel_radiance(tables.surface, read.band, read.air, faces, view).radiance


def crossover_hours(hours: Floats, contrast: Floats, *, step: float) -> tuple[float, ...]:
    """Hours at which a contrast (T,) changes its sign, linear between its ascending hours, over midnight too.

    A contrast that is 0 over some time changes its sign where it leaves 0. Between hours that are more than a step
    apart it is not known, and no change is reported.
    """
    hours, contrast = np.append(hours, hours[0] + 24.0), np.append(contrast, contrast[0])
    nonzero = np.flatnonzero(contrast)
    crossings = []
    for before, after in pairwise(nonzero):
        previous = after - 1
        if contrast[before] * contrast[after] < 0 and hours[after] - hours[previous] < 1.5 * step:
            share = contrast[previous] / (contrast[previous] - contrast[after])
            crossings.append(float(np.mod(hours[previous] + share * (hours[after] - hours[previous]), 24.0)))
    return tuple(sorted(crossings))


def _faces(tables: SceneTables, face: Face, code: int, altitude: float, hours: Floats) -> Faces:
    where: dict[str, Any] = {"material": code, "altitude": altitude, "azimuth": face.azimuth, "slope": face.slope}
    lit_share, change = np.ones(hours.size), None
    if face.shade:
        change = tables.surface.absorbed_change(**where, shade=face.shade)
        lit_share = np.asarray([not any(_within(hour, *interval) for interval in face.shade) for hour in hours], float)
    kelvin = tables.surface.temperature(**where, time=hours, absorbed_change=change)
    count = hours.size
    return Faces(
        codes=np.full((count, 1), code),
        shares=np.ones((count, 1)),
        altitude=np.full(count, altitude),
        azimuth=np.full(count, face.azimuth),
        slope=np.full(count, face.slope),
        time=hours,
        temperature=kelvin[:, None],
        lit_share=lit_share,
    )


def _within(hour: float, start: float, stop: float) -> bool:
    """Whether a clock hour lies in an interval, over midnight where the first is later."""
    return start <= hour < stop if start < stop else hour >= start or hour < stop
