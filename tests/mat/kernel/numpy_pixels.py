"""Equation (1) for pixels in numpy: by which the tests judge the library in C (`pixels.c`).

The tables are read in numpy too; a pixel is as `skyshine.mat.runtime.pixel` takes it, on ground that is stated with it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy_air import SHORTEST_KM, NumpyAir
from numpy_response import NumpySurface

from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.radiometry.lobe import specular_lobe
from skyshine.mat.runtime.pixel import Faces, PixelRadiance, View
from skyshine.mat.runtime.shade import SHADED_SKY, air_temperature, shaded_temperature
from skyshine.mat.runtime.walls import beside_walls
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS
from skyshine.mat.tables.band import BandSpectra, BandTable
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError


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
        the table of temperatures has no response to it.
    """
    surface, air = NumpySurface.of(surface), NumpyAir.of(air)
    faces = _on_ground(surface, air, faces)
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
    ambient = _ambient(surface, band, air, faces, view)
    # Inside the integral over the band: (5), (18), (26) and (33).
    spectra = band.spectra(material=codes, temperature=temperature)
    direct = air.value_by_wavelength("direct_radiance", **view.lines.lit)
    depth = air.value_by_wavelength("optical_depth", **view.lines.path)
    through = through_by_wavelength(depth, np.asarray(view.lines.range, float), np.asarray(view.range, float))
    emitted, sky, beam = emitted_share(spectra, through), reflected(spectra, ambient), reflected(spectra, direct)
    sunlit = np.where(incidence > 0, transmittance, 0.0)
    sunlit = sunlit if faces.lit_share is None else sunlit * faces.lit_share
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


def _on_ground(surface: TemperatureTable, air: AtmosphereTable, faces: Faces) -> Faces:
    """Faces with the temperature of their ground: of the material that they or the file name, at their times."""
    if faces.ground_temperature is not None or "ground_material" not in air.attributes:
        return faces
    return replace(faces, ground_temperature=_ground_temperature(surface, air, faces), ground_material=None)


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
        lit_share=1 - shade if faces.lit_share is None else (1 - shade) * faces.lit_share,
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
    if faces.sky_view is None:
        return light
    wall = faces.wall_temperature
    if wall is None:
        wall = air_temperature(surface, faces.altitude, faces.time)

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
    walled = beside_walls(light, level, glow(wall), glow(ground), faces.sky_view, upward)
    # The sky hidden by a wall may be brighter than all that the face sees, where its own side of the sky is dark.
    return np.maximum(walled, 0.0)


def _ground_temperature(surface: TemperatureTable, air: AtmosphereTable, faces: Faces) -> Floats:
    """Temperature (n,) of the ground around the faces [K]."""
    if faces.ground_temperature is not None:
        return faces.ground_temperature
    if faces.ground_material is None:
        return air.ground_temperature(surface, time=faces.time)
    return surface.temperature(material=faces.ground_material, altitude=faces.altitude, time=faces.time)


def emitted_share(spectra: BandSpectra, transmittance: Floats) -> Floats:
    """What surfaces emit and paths let through, over the radiance of a black body (7): the integral (5).

    Parameters
    ----------
    spectra : BandSpectra
        Of (..., M) materials at their temperatures.
    transmittance : (..., B) array
        By wavelength.
    """
    share: Floats = np.sum((1.0 - spectra.reflectance) * spectra.emission * transmittance[..., None, :], axis=-1)
    return share


def reflected(spectra: BandSpectra, light: Floats) -> Floats:
    """Light by wavelength (..., B) that (..., M) materials reflect: the integrals (18) and (26) without geometry."""
    radiance: Floats = np.maximum(np.sum(spectra.reflectance * light[..., None, :], axis=-1), 0.0)
    return radiance


def through_by_wavelength(depth: Floats, centre_range: Floats, pixel_range: Floats) -> Floats:
    """Transmittance by wavelength (n, B) over the range of pixels (n,) [km], from the optical depth (n, B) over that of
    their centres (n,): as (8) and (9) do with one beta*.
    """
    stretch = pixel_range / np.maximum(centre_range, SHORTEST_KM)
    through: Floats = np.exp(-depth * np.where(pixel_range == centre_range, 1.0, stretch)[..., None])
    return through
