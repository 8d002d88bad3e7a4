"""The radiance of pixels from the databases: equation (1) of DSTO-TN-0193, as the example runtimes compute it."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.mat.tables.kernel_tables import kernel_tables, messages
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

_OPTIONAL = (
    "temperature", "ground_temperature", "lit_share", "sky_view", "wall_temperature", "shade", "shaded_sky",
    "shaded_temperature",
)  # fmt: skip
_BY_MATERIAL = ("material", "share", "temperature", "shaded_temperature")
_DIRECTIONS = ("normal", "to_source", "to_observer")
_LINE = ("range", "altitude", "elevation", "source_elevation", "source_azimuth")


@dataclass(frozen=True, eq=False)
class View:
    """Lines of sight and illumination of n pixels.

    Attributes
    ----------
    lines : LinesOfSight
        Lines (n,) on which the atmospheric tables are read: those of the pixels, or of the centre of their frame, which
        is one line, (1,), or n times the same.
    range : (n,) array
        Distance from the observer to the point of the pixel [km].
    normal, to_source, to_observer : (n, 3) array
        Directions from the points, of any length.
    source_heading : (n,) array, optional
        Azimuth of Sun or Moon from north eastward [degree]; without it the sky of level faces is taken.
    """

    lines: LinesOfSight
    range: Floats
    normal: Floats
    to_source: Floats
    to_observer: Floats
    source_heading: Floats | None = None

    @classmethod
    def of(cls, lines: LinesOfSight, heading: npt.ArrayLike, normal: Floats, *, nearest: float = 0.0) -> View:
        """Pixels at the ends of their own lines of sight.

        Parameters
        ----------
        heading : (n,) array
            Azimuth of the lines of sight, clockwise from north [degree].
        normal : (n, 3) array
            East, north and up.
        nearest : float
            Shortest range of the tables [km]: those of nearer pixels are read there.
        """
        *_, source_elevation, source_azimuth = lines.place
        azimuth = np.asarray(heading, float) + source_azimuth
        to_source, to_observer = direction(source_elevation, azimuth), -direction(lines.elevation, heading)
        read = replace(lines, range=np.maximum(lines.range, nearest))
        return cls(read, lines.range, normal, to_source, to_observer, azimuth)


@dataclass(frozen=True, eq=False)
class Faces:
    """The surfaces of n pixels, each of up to M materials; angles and times of the shape (n,).

    Attributes
    ----------
    codes : (n, M) int array
        Codes of the materials, as `skyshine.tmm.TmmFile.mixture` gives them; 0 where unused.
    shares : (n, M) array
        Area fractions of the materials; they sum to 1.
    altitude : array
        [km]
    azimuth, slope : array
        [degree]
    time : array
        Local clock [h].
    temperature : (n, M) array, optional
        [K], in place of that of the table: in the shade, say, from `TemperatureTable.temperature`.
    ground_material : array of int or str, optional
        Code or name of the ground around, for the sky of tilted faces and beside walls; by default the one that the
        atmosphere file names, level and at the lowest altitude, at the pixel's time. Where it names none, the
        temperature that it states.
    ground_temperature : array, optional
        [K], in place of that of the material.
    lit_share : array, optional
        Share of the direct light of Sun or Moon that reaches the face; by default all.
    sky_view : array, optional
        Open share of the sky above the face; by default the whole.
    wall_temperature : array, optional
        Temperature of the wall that hides the rest of the sky [K]; by default that of the air.
    shade : array, optional
        Share of the face that lies in the shade all day, as `skyshine.tmm.TmmFile.shade` gives it; by default none. No
        direct light falls there, and no more of the sky is open than `shaded_sky`.
    shaded_sky : array, optional
        Open share of the sky above the part in the shade; by default 0.5, as in a scene of `mat render`.
    shaded_temperature : (n, M) array, optional
        Temperatures of the materials in the shade [K], instead of the table's response; ignored where `shade` is 0.
    """

    codes: Integers
    shares: Floats
    altitude: Floats
    azimuth: Floats
    slope: Floats
    time: Floats
    temperature: Floats | None = None
    ground_material: npt.NDArray[Any] | None = None
    ground_temperature: Floats | None = None
    lit_share: Floats | None = None
    sky_view: Floats | None = None
    wall_temperature: Floats | None = None
    shade: Floats | None = None
    shaded_sky: Floats | None = None
    shaded_temperature: Floats | None = None


@dataclass(frozen=True, eq=False)
class PixelRadiance:
    """Terms of the radiance of n pixels, in W m^-2 sr^-1 where nothing else is said.

    Attributes
    ----------
    temperature, blackbody_radiance : (n,) array
        Means over the materials [K], and by equation (7).
    transmittance : (n,) array
        Equation (9).
    thermal, path, skyshine, diffuse, specular : (n,) array
        Equations (6), (11), (19), (34) and (35).
    """

    temperature: Floats
    blackbody_radiance: Floats
    transmittance: Floats
    thermal: Floats
    path: Floats
    skyshine: Floats
    diffuse: Floats
    specular: Floats

    @property
    def radiance(self) -> Floats:
        """The sum of all terms, equation (1)."""
        return self.thermal + self.path + self.skyshine + self.diffuse + self.specular


def pixel_radiance(
    surface: TemperatureTable, band: BandTable, air: AtmosphereTable, faces: Faces, view: View
) -> PixelRadiance:
    """Radiance of pixels: of the materials of each by their shares, behind the air.

    Parameters
    ----------
    air : AtmosphereTable
        Table of the same band and state, for the Sun or the Moon.

    Raises
    ------
    InputError
        A pixel without material, a material that a table lacks, a value outside an axis, or a face in the shade and
        the table of temperatures has no response to it.
    """
    _refuse_unknown(faces)
    count, materials = faces.codes.shape
    inputs: dict[str, npt.NDArray[Any]] = {
        "material": faces.codes,
        "share": faces.shares,
        "surface_altitude": faces.altitude,
        "surface_azimuth": faces.azimuth,
        "surface_slope": faces.slope,
        "range": view.range,
        "normal": view.normal,
        "to_source": view.to_source,
        "to_observer": view.to_observer,
    }
    optional = {name: getattr(faces, name) for name in _OPTIONAL}
    if faces.ground_material is not None:
        optional["ground_material"] = np.broadcast_to(surface.material_codes(faces.ground_material), count)
    inputs |= {name: values for name, values in optional.items() if values is not None}
    inputs["time"] = faces.time
    wide = dict.fromkeys(_BY_MATERIAL, (count, materials)) | dict.fromkeys(_DIRECTIONS, (count, 3))
    # The library sees no lengths: arrays of another shape end here.
    inputs = {name: np.broadcast_to(values, wide.get(name, (count,))) for name, values in inputs.items()}
    with messages():
        lines, of_lines = _lines(view, count)
        terms = kernel_tables(surface, band, air).pixels(count, materials, lines, {**inputs, **of_lines})
    return PixelRadiance(**{field.name: terms[field.name] for field in fields(PixelRadiance)})


def _lines(view: View, count: int) -> tuple[int, dict[str, Floats]]:
    """How many lines of sight there are, 1 where all are the same, and their values."""
    names = [f"line_{name}" if name == "range" else name for name in _LINE]
    parts = dict(zip(names, (np.asarray(part, float) for part in view.lines.place), strict=True))
    if view.source_heading is not None:
        parts["source_heading"] = np.asarray(view.source_heading, float)
    if count and all(np.all(part == part.flat[0]) for part in parts.values()):
        return 1, {name: part.ravel()[:1] for name, part in parts.items()}
    return count, {name: np.broadcast_to(part, count) for name, part in parts.items()}


def _refuse_unknown(faces: Faces) -> None:
    """Refuse temperatures that are not numbers, for which the library would take those of the tables."""
    present = faces.shares > 0
    shaded = present if faces.shade is None else present & (faces.shade > 0)[:, None]
    for kelvin, read in ((faces.temperature, present), (faces.shaded_temperature, shaded)):
        if kelvin is not None and not np.all(np.isfinite(kelvin) | ~read):
            raise InputError("temperature: found a value that is not finite; allowed: finite numbers")
    for values in (faces.wall_temperature, faces.ground_temperature):
        if values is not None and not np.all(np.isfinite(values)):
            raise InputError("temperature: found a value that is not finite; allowed: finite numbers")


def sky_radiance(air: AtmosphereTable, view: View) -> Floats:
    """Radiance (n,) of lines of sight that end in the air: equation (11) alone [W m^-2 sr^-1].

    Raises
    ------
    InputError
        A value outside an axis.
    """
    beta = air.value("beta_star", **view.lines.path)
    ratio = air.value("path_radiance_ratio", **view.lines.whole)
    radiance: Floats = ratio * -np.expm1(-BETA_FACTOR * view.range / beta)
    return radiance


def pixel_value(radiance: npt.ArrayLike, *, bits: int, gain: float, buffer_gain: float, offset: float) -> Integers:
    """Pixel values of radiances in W m^-2 sr^-1, equation (44), rounded to the nearest integer.

    The nearest integer to x - 1/2, halves upwards, is the floor of x.

    Parameters
    ----------
    bits : int
        N.
    gain, buffer_gain, offset : float
        G [W m^-2 sr^-1], BG and DC.
    """
    share = np.clip(np.asarray(radiance, float) / gain, 0.0, 1.0)
    level = np.clip(np.floor(2**bits * buffer_gain * (share - offset)), 0, 2**bits - 1)
    return np.asarray(level, np.int64)
