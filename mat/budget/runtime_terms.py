"""The radiance that a runtime computes, and the spectral integrals that it approximates; n views of M materials."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.budget.views import Views
from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.quantities.results import AtmosphericQuantities, SpectralLines
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.lobe import lobe_integral, specular_lobe
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class AtmosphereReadings:
    """Atmospheric quantities that a runtime reads for n views, (n, 1) each but for the last.

    Attributes
    ----------
    transmittance
    path_radiance_ratio, ambient, direct
        W m^-2 sr^-1.
    emitted : (n, M) array or None
        Transmittance of the light that the materials emit; None before the materials are known.
    """

    transmittance: Floats
    path_radiance_ratio: Floats
    ambient: Floats
    direct: Floats
    emitted: Floats | None = None

    @classmethod
    def of(cls, q: AtmosphericQuantities) -> AtmosphereReadings:
        """Terms from quantities at n points."""
        return cls(*(a[:, None] for a in (q.transmittance, q.path_radiance_ratio, q.ambient, q.direct)))

    @classmethod
    def integrated(cls, lines: SpectralLines, band: BandPoints) -> AtmosphereReadings:
        """Terms from spectral lines of sight: the definitions (8), (10), (20) and (36)."""
        tau = lines.transmittance @ band.weight / band.weight.sum()
        absorbed = np.maximum((1 - lines.transmittance) @ band.weight / band.weight.sum(), np.finfo(float).tiny)
        weight = lines.transmittance * band.radiance_weight / (np.pi * np.maximum(tau, np.finfo(float).tiny)[:, None])
        ambient, direct = (np.sum(weight * part, axis=1) for part in (lines.sky_irradiance, lines.direct_irradiance))
        return cls(*(a[:, None] for a in (tau, lines.path_radiance / absorbed, ambient, direct)))

    def with_transmittance(self, transmittance: Floats) -> AtmosphereReadings:
        """With another transmittance (n, 1); that of emitted light changes in the same ratio."""
        emitted = self.emitted
        if emitted is not None:
            emitted = emitted * (transmittance / np.maximum(self.transmittance, np.finfo(float).tiny))
        return replace(self, transmittance=transmittance, emitted=emitted)

    def at_range(self, centre_range: Floats, pixel_range: Floats) -> AtmosphereReadings:
        """With transmittance over `pixel_range` from that of the centre pixel over `centre_range`: (8) and (9)."""

        def extrapolated(transmittance: Floats) -> Floats:
            tau = np.maximum(transmittance, np.finfo(float).tiny)
            beta = BETA_FACTOR * centre_range[:, None] / np.maximum(-np.log(tau), 1e-12)
            through: Floats = np.exp(-BETA_FACTOR * pixel_range[:, None] / beta)
            return through

        emitted = None if self.emitted is None else extrapolated(self.emitted)
        return replace(self, transmittance=extrapolated(self.transmittance), emitted=emitted)


@dataclass(frozen=True, eq=False)
class ReflectedLight:
    """Light that M materials reflect inside the integral over the band, over the product of their mean reflectance and
    the band's light: (n, M) each.
    """

    ambient: Floats
    direct: Floats

    @classmethod
    def integrated(cls, lines: SpectralLines, band: BandPoints, reflectance: Floats, mean: Floats) -> ReflectedLight:
        """Terms from spectral lines of sight and reflectances (M, P), whose means over the band are (M,)."""
        weight = lines.transmittance * band.radiance_weight

        def of(light: Floats) -> Floats:
            return ratio((weight * light) @ reflectance.T, mean * np.sum(weight * light, axis=1)[:, None])

        return cls(of(lines.sky_irradiance), of(lines.direct_irradiance))


def ratio(part: Floats, total: Floats) -> Floats:
    """part / whole; 1 where there is no light."""
    quotient: Floats = np.where(total > 0, part / np.where(total > 0, total, 1.0), 1.0)
    return quotient


@dataclass(frozen=True, eq=False)
class Emission:
    """What n surfaces of M materials emit.

    Attributes
    ----------
    blackbody : (n, M) array
        (7) at their temperatures, W m^-2 sr^-1.
    reflectance : (M,) or (n, M) array
        Reflectance of equation (6).
    """

    blackbody: Floats
    reflectance: Floats


@dataclass(frozen=True, eq=False)
class Finish:
    """Band means of the materials' reflection.

    Attributes
    ----------
    reflectance, specular_fraction : (M,) arrays
    shininess : (M,) array
    normalisation : (M,) or (n, M) array
        N_s, one for all source angles or of each view.
    """

    reflectance: Floats
    specular_fraction: Floats
    shininess: Floats
    normalisation: Floats


def incidence(views: Views, normal: Floats) -> Floats:
    """Cosine of the angle between normals and source, (n, 1); 0 where the source is behind the surface."""
    cosine: Floats = np.maximum(np.sum(normal * views.to_source, axis=1), 0.0)[:, None]
    return cosine


def reflection(views: Views, normal: Floats, finish: Finish) -> Floats:
    """Radiance over (direct * reflectance * transmittance) of diffuse and specular reflection, (n, M).

    Equations (34) and (35).
    """
    cosine = incidence(views, normal)
    lobe = specular_lobe(finish.shininess, views.to_source[:, None], views.to_observer[:, None], normal[:, None])
    specular = np.where(cosine > 0, lobe * finish.normalisation, 0.0)
    return cosine * (1 - finish.specular_fraction) + specular * finish.specular_fraction


def runtime_radiance(
    readings: AtmosphereReadings,
    emission: Emission,
    bounce: Floats,
    finish: Finish,
    light: ReflectedLight | None = None,
) -> Floats:
    """Equation (1) with (6), (11), (19), (34) and (35): W m^-2 sr^-1, (n, M).

    Parameters
    ----------
    bounce : (n, M) array
        Reflection terms from `reflection`.
    light : ReflectedLight, optional
        Light by wavelength, if the runtime reflects it so.
    """
    tau, rho = readings.transmittance, finish.reflectance
    through = tau if readings.emitted is None else readings.emitted
    emitted = emission.blackbody * (1 - emission.reflectance) * through
    ambient, direct = readings.ambient, readings.direct
    if light is not None:
        ambient, direct = ambient * light.ambient, direct * light.direct
    reflected = (ambient + direct * bounce) * rho * tau
    radiance: Floats = emitted + reflected + readings.path_radiance_ratio * (1 - tau)
    return radiance


def spectral_radiance(
    lines: SpectralLines,
    band: BandPoints,
    temperature: Floats,
    reflectance: Floats,
    bounce: Floats,
) -> Floats:
    """The accurate forms (5), (18), (26), (33) and the path radiance: W m^-2 sr^-1, (n, M).

    Parameters
    ----------
    temperature : (n, M) array
        K.
    reflectance : (M, P) array
        Reflectance at the points.
    bounce : (n, M) array
        Reflection terms from `reflection`.
    """
    weight = lines.transmittance * band.radiance_weight / np.pi
    sky, direct = ((weight * part) @ reflectance.T for part in (lines.sky_irradiance, lines.direct_irradiance))
    thermal = spectral_thermal(lines.transmittance, band, temperature, reflectance)
    return thermal + sky + direct * bounce + lines.path_radiance[:, None]


def spectral_thermal(transmittance: Floats, band: BandPoints, temperature: Floats, reflectance: Floats) -> Floats:
    """Equation (5), (n, M), from transmittances (n, P); the other arguments as for `spectral_radiance`."""
    thermal = np.empty(temperature.shape)
    for number, kelvin in enumerate(temperature.T):
        emitted = planck_wavenumber(band.wavenumber, kelvin[:, None])
        thermal[:, number] = (transmittance * emitted) @ (band.radiance_weight * (1 - reflectance[number]))
    return thermal


def emitted_transmittance(band: BandPoints, reflectance: Floats, lines: SpectralLines, temperature: Floats) -> Floats:
    """Transmittance (n, M) of what the materials emit: equation (5) over what leaves the surfaces; arguments as for
    `spectral_radiance`.
    """
    through, everything = (
        spectral_thermal(transmittance, band, temperature, reflectance)
        for transmittance in (lines.transmittance, np.ones_like(lines.transmittance))
    )
    return ratio(through, everything)


def exact_normalisation(shininess: Floats, views: Views, normal: Floats) -> Floats:
    """N_s of each lobe at the very angle of incidence, (43), (n, M); grazing light counts as from 89.9 degrees."""
    cosine = np.maximum(incidence(views, normal)[:, 0], np.cos(np.radians(89.9)))
    angle = np.degrees(np.arccos(np.minimum(cosine, 1.0)))
    columns = {value: 2 * np.pi * cosine / lobe_integral(value, angle) for value in np.unique(shininess)}
    return np.stack([columns[value] for value in shininess], axis=1)
