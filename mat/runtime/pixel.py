"""The radiance of pixels from the databases: equation (1) of DSTO-TN-0193, as the example runtimes compute it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.radiometry.lobe import specular_lobe
from skyshine.mat.runtime.by_wavelength import check_same_band, emitted_share, reflected
from skyshine.mat.runtime.by_wavelength import transmittance as transmittance_of
from skyshine.mat.runtime.shade import SHADED_SKY, air_temperature, shaded_temperature
from skyshine.mat.runtime.walls import beside_walls
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError


@dataclass(frozen=True, eq=False)
class View:
    """Where n pixels are seen from, and how they are lit.

    Attributes
    ----------
    lines : LinesOfSight
        Lines (n,) on which the atmospheric tables are read: those of the pixels, or of the centre of their frame.
    range : (n,) array
        From the observer to the point of the pixel [km].
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
        lines : LinesOfSight
        heading : (n,) array
            Of the lines, from north eastward [degree].
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
        Of the materials, as `skyshine.tmm.TmmFile.mixture` gives them; 0 where unused.
    shares : (n, M) array
        Of the materials; they sum to 1.
    altitude : array
        [km]
    azimuth, slope : array
        [degree]
    time : array
        Local clock [h].
    temperature : (n, M) array, optional
        [K], in place of that of the table: in the shade, say, from `TemperatureTable.temperature`.
    ground_material : array of int or str, optional
        Code or name of the ground around, for the sky of tilted faces.
    ground_temperature : array, optional
        [K], in place of that of the material: of the ground that the file names, `AtmosphereTable.ground_temperature`.
    lit : array, optional
        Share of the direct light of Sun or Moon that reaches the face; by default all.
    sky_view, wall_temperature : array, optional
        Open share of the sky above the face, and the temperature of the wall that hides the rest [K]; without them the
        whole sky is open.
    shade : array, optional
        Share of the face that lies in the shade all day, as `skyshine.tmm.TmmFile.shade` gives it; by default none. No
        direct light falls there, and no more of the sky is open than `shaded_sky`; what hides it has the temperature
        of the air, where `wall_temperature` is not given.
    shaded_sky : array, optional
        Open share of the sky above the part in the shade; by default .5, as in a scene of `mat render`.
    shaded_temperature : (n, M) array, optional
        Of the materials in the shade [K], in place of those by the response of the table; any where `shade` is 0.
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
    lit: Floats | None = None
    sky_view: Floats | None = None
    wall_temperature: Floats | None = None
    shade: Floats | None = None
    shaded_sky: Floats | None = None
    shaded_temperature: Floats | None = None

    def on_ground_of(self, air: AtmosphereTable, surface: TemperatureTable) -> Faces:
        """The faces with the temperature at their times of the ground that an atmosphere file names, if it names one;
        without it the light of the ground is that of the one temperature that the file states.
        """
        if "ground_material" not in air.attributes:
            return self
        hours, place = np.unique(self.time, return_inverse=True)
        return replace(self, ground_temperature=air.ground_temperature(surface, time=hours)[place])


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
    surface : TemperatureTable
    band : BandTable
    air : AtmosphereTable
        Of the same band and state: that of the Sun or of the Moon.
    faces : Faces
    view : View

    Raises
    ------
    InputError
        A pixel without material, a material that a table lacks, a value outside an axis, or a face in the shade and
        the table of temperatures holds no response to it.
    """
    if faces.shade is not None and np.any(faces.shade != 0):
        faces = _with_shade(surface, faces, faces.shade)
    used = faces.shares > 0
    if np.any(used & (faces.codes == 0)) or not np.all(used.any(axis=-1)):
        raise InputError("found a pixel without material; allowed: codes of the tables; leave such pixels out")
    # Unused places read as the first material, with no share.
    codes = np.where(used, faces.codes, np.take_along_axis(faces.codes, used.argmax(axis=-1)[:, None], axis=-1))
    temperature = faces.temperature if faces.temperature is not None else _sunlit(surface, faces, codes)
    fraction, shininess, normalisation = (
        band.value(name, material=codes) for name in ("specular_fraction", "shininess", "normalisation")
    )
    beta = air.value("beta_star", **view.lines.path)
    transmittance = air.transmittance(range=view.range, beta_star=beta)
    normal, to_source, to_observer = (_unit(each) for each in (view.normal, view.to_source, view.to_observer))
    incidence = np.maximum(np.sum(normal * to_source, axis=-1), 0.0)
    blackbody = band.blackbody_radiance(temperature)
    check_same_band(air, band)
    ambient = _ambient(surface, band, air, faces, view)
    # Inside the integral over the band: (5), (18), (26) and (33).
    spectra = band.spectra(material=codes, temperature=temperature)
    direct = air.value_by_wavelength("direct_radiance", **view.lines.lit)
    depth = air.value_by_wavelength("optical_depth", **view.lines.path)
    through = transmittance_of(depth, np.asarray(view.lines.range, float), np.asarray(view.range, float))
    emitted, sky, beam = emitted_share(spectra, through), reflected(spectra, ambient), reflected(spectra, direct)
    sunlit = np.where(incidence > 0, transmittance, 0.0)
    sunlit = sunlit if faces.lit is None else sunlit * faces.lit
    shape = specular_lobe(shininess, to_source[:, None], to_observer[:, None], normal[:, None])

    def over_materials(values: Floats) -> Floats:
        total: Floats = np.sum(faces.shares * values, axis=-1)
        return total

    return PixelRadiance(
        over_materials(temperature),
        over_materials(blackbody),
        transmittance,
        over_materials(blackbody * emitted),
        _path(air, view, beta),
        over_materials(sky) * transmittance,
        over_materials(beam * (1 - fraction)) * incidence * sunlit,
        over_materials(beam * shape * fraction * normalisation) * sunlit,
    )


def sky_radiance(air: AtmosphereTable, view: View) -> Floats:
    """Radiance (n,) of lines of sight that end in the air: equation (11) alone [W m^-2 sr^-1].

    Raises
    ------
    InputError
        A value outside an axis.
    """
    return _path(air, view, air.value("beta_star", **view.lines.path))


def pixel_value(radiance: npt.ArrayLike, *, bits: int, gain: float, buffer_gain: float, offset: float) -> Integers:
    """Pixel values of radiances in W m^-2 sr^-1, equation (44), rounded to the nearest integer.

    The nearest integer to x - 1/2, halves upwards, is the floor of x.

    Parameters
    ----------
    radiance : array_like
    bits : int
        N.
    gain, buffer_gain, offset : float
        G [W m^-2 sr^-1], BG and DC.
    """
    share = np.clip(np.asarray(radiance, float) / gain, 0.0, 1.0)
    level = np.clip(np.floor(2**bits * buffer_gain * (share - offset)), 0, 2**bits - 1)
    return np.asarray(level, np.int64)


def _sunlit(surface: TemperatureTable, faces: Faces, codes: Integers) -> Floats:
    """Temperatures (n, M) of materials in full sun under the whole sky [K]."""
    return surface.temperature(
        material=codes,
        altitude=faces.altitude[:, None],
        azimuth=faces.azimuth[:, None],
        slope=faces.slope[:, None],
        time=faces.time[:, None],
    )


def _with_shade(surface: TemperatureTable, faces: Faces, shade: Floats) -> Faces:
    """Faces of twice as many materials: as they were, and once more in the shade all day."""
    if not np.all((shade >= 0) & (shade <= 1)):
        raise InputError("found a share in the shade beyond 0 to 1; allowed: what a texture's `shade` gives")
    own = np.ones(shade.shape) if faces.sky_view is None else faces.sky_view
    under = np.minimum(own, SHADED_SKY if faces.shaded_sky is None else faces.shaded_sky)
    dark = (faces.shares > 0) & (faces.codes > 0) & (shade > 0)[:, None]
    codes = np.where(faces.shares > 0, faces.codes, faces.codes[:, :1])
    kelvin = faces.temperature if faces.temperature is not None else _sunlit(surface, faces, codes)
    cool = faces.shaded_temperature
    if cool is None:
        row, part = np.nonzero(dark)
        where = {name: getattr(faces, name)[row] for name in ("altitude", "azimuth", "slope")}
        cool, time = np.zeros(dark.shape), faces.time[row, None]
        cool[row, part] = shaded_temperature(surface, codes[row, part], under[row], **where, time=time)[:, 0]
    view, wall = own - shade * (own - under), faces.wall_temperature
    if wall is None and np.any(view < 1):
        wall = air_temperature(surface, faces.altitude, faces.time)
    return replace(
        faces,
        codes=np.concatenate([faces.codes, faces.codes], axis=1),
        shares=np.concatenate([faces.shares * (1 - shade[:, None]), faces.shares * shade[:, None]], axis=1),
        temperature=np.concatenate([kelvin, np.where(dark, cool, kelvin)], axis=1),
        lit=1 - shade if faces.lit is None else (1 - shade) * faces.lit,
        sky_view=view,
        wall_temperature=wall,
        shade=None,
    )


def _unit(vectors: Floats) -> Floats:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    if not np.all(np.isfinite(length) & (length > 0)):
        raise InputError("found a direction without length; allowed: three finite numbers that are not all 0")
    return np.asarray(vectors / length)


def _path(air: AtmosphereTable, view: View, beta: Floats) -> Floats:
    """Path radiance (n,), equation (11)."""
    ratio = air.value("path_radiance_ratio", **view.lines.whole)
    path: Floats = ratio * -np.expm1(-BETA_FACTOR * view.range / beta)
    return path


def _ambient(surface: TemperatureTable, band: BandTable, air: AtmosphereTable, faces: Faces, view: View) -> Floats:
    """L_ambient of the faces by wavelength (n, B); of level ones where the file or the view says no more."""
    place = view.lines.lit
    if view.source_heading is None or AMBIENT_HARMONICS not in air.quantities:
        light = air.value_by_wavelength("ambient_radiance", **place)
    else:
        given: dict[str, Any] = {}
        if faces.ground_material is not None or faces.ground_temperature is not None:
            given = {"ground_temperature": _ground_temperature(surface, air, faces), "band": band}
        turn = faces.azimuth - view.source_heading
        light = air.ambient_radiance(slope=faces.slope, azimuth=turn, by_wavelength=True, **given, **place)
    if faces.sky_view is None or faces.wall_temperature is None:
        return light

    def glow(kelvin: Floats) -> Floats:
        """Light of black bodies beside the faces, as `light`."""
        share = band.spectra(material=next(iter(band.materials)), temperature=kelvin).emission
        depth = air.value_by_wavelength("optical_depth", **view.lines.path)
        beta = air.value("beta_star", **view.lines.path)
        tau = air.transmittance(range=view.lines.range, beta_star=beta)[:, None]
        weight = np.divide(np.exp(-depth), tau, out=np.zeros_like(depth), where=tau > 0)
        return np.asarray(band.blackbody_radiance(kelvin)[:, None] * share * weight)

    level, ground = air.value_by_wavelength("ambient_radiance", **place), _ground_temperature(surface, air, faces)
    upward = np.cos(np.radians(faces.slope))
    walled = beside_walls(light, level, glow(faces.wall_temperature), glow(ground), faces.sky_view, upward)
    # The sky hidden by a wall may be brighter than all that the face sees, where its own side of the sky is dark.
    return np.maximum(walled, 0.0)


def _ground_temperature(surface: TemperatureTable, air: AtmosphereTable, faces: Faces) -> Floats:
    """Temperature (n,) of the ground around the faces [K]."""
    if faces.ground_temperature is not None:
        return faces.ground_temperature
    if faces.ground_material is None:
        return air.ground_temperature(surface, time=faces.time)
    return surface.temperature(material=faces.ground_material, altitude=faces.altitude, time=faces.time)
