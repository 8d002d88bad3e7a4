"""The radiance that a runtime computes, and the spectral integrals that it stands for; n views of M materials."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.budget.views import Views
from skyshine.mat.quantities.formulas import BETA_FACTOR
from skyshine.mat.quantities.results import AtmosphericQuantities, SpectralLines
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.lobe import lobe_integral, specular_lobe


@dataclass(frozen=True, eq=False)
class Readings:
    """What a runtime reads of the atmosphere for n views, (n, 1) each.

    Attributes
    ----------
    transmittance
    path_radiance_ratio, ambient, direct
        W m^-2 sr^-1.
    """

    transmittance: np.ndarray
    path_radiance_ratio: np.ndarray
    ambient: np.ndarray
    direct: np.ndarray

    @classmethod
    def of(cls, q: AtmosphericQuantities) -> Readings:
        """From quantities at n points."""
        return cls(*(a[:, None] for a in (q.transmittance, q.path_radiance_ratio, q.ambient, q.direct)))

    @classmethod
    def integrated(cls, lines: SpectralLines, band: BandPoints) -> Readings:
        """From spectral lines of sight: the definitions (8), (10), (20) and (36)."""
        tau = lines.transmittance @ band.weight / band.weight.sum()
        absorbed = np.maximum((1 - lines.transmittance) @ band.weight / band.weight.sum(), np.finfo(float).tiny)
        weight = lines.transmittance * band.radiance_weight / (np.pi * np.maximum(tau, np.finfo(float).tiny)[:, None])
        ambient, direct = (np.sum(weight * part, axis=1) for part in (lines.sky_irradiance, lines.direct_irradiance))
        return cls(*(a[:, None] for a in (tau, lines.path_radiance / absorbed, ambient, direct)))

    def at_range(self, centre_range, own_range) -> np.ndarray:
        """Transmittance over `own_range` from that of the centre pixel over `centre_range`: (8) and (9)."""
        tau = np.maximum(self.transmittance[:, 0], np.finfo(float).tiny)
        beta = BETA_FACTOR * centre_range / np.maximum(-np.log(tau), 1e-12)
        return np.exp(-BETA_FACTOR * own_range / beta)[:, None]


@dataclass(frozen=True, eq=False)
class Finish:
    """What reflects: (M,) or (n, M) arrays.

    Attributes
    ----------
    reflectance, specular_fraction : (M,) arrays
    shininess : (M,) array
    normalisation : (M,) or (n, M) array
        N_s, one for all source angles or of each view.
    """

    reflectance: np.ndarray
    specular_fraction: np.ndarray
    shininess: np.ndarray
    normalisation: np.ndarray


def incidence(views: Views, normal: np.ndarray) -> np.ndarray:
    """Cosine of the angle between normals and source, (n, 1), 0 where it stands behind."""
    return np.maximum(np.sum(normal * views.to_source, axis=1), 0.0)[:, None]


def reflection(views: Views, normal: np.ndarray, finish: Finish) -> np.ndarray:
    """Radiance over (direct * reflectance * transmittance) of diffuse and specular reflection, (34) and (35), (n,
    M).
    """
    cosine = incidence(views, normal)
    lobe = specular_lobe(finish.shininess, views.to_source[:, None], views.to_observer[:, None], normal[:, None])
    specular = np.where(cosine > 0, lobe * finish.normalisation, 0.0)
    return cosine * (1 - finish.specular_fraction) + specular * finish.specular_fraction


def runtime_radiance(readings: Readings, blackbody: np.ndarray, bounce: np.ndarray, finish: Finish) -> np.ndarray:
    """Equation (1) with (6), (11), (19), (34) and (35): W m^-2 sr^-1, (n, M).

    Parameters
    ----------
    readings : Readings
    blackbody : (n, M) array
        (7) at the surface's temperature.
    bounce : (n, M) array
        From `reflection`.
    """
    tau, rho = readings.transmittance, finish.reflectance
    seen = blackbody * (1 - rho) + (readings.ambient + readings.direct * bounce) * rho
    return seen * tau + readings.path_radiance_ratio * (1 - tau)


def spectral_radiance(
    lines: SpectralLines,
    band: BandPoints,
    temperature: np.ndarray,
    reflectance: np.ndarray,
    bounce: np.ndarray,
    thermal_transmittance: np.ndarray | None = None,
) -> np.ndarray:
    """The accurate forms (5), (18), (26), (33) and the path radiance: W m^-2 sr^-1, (n, M).

    Parameters
    ----------
    lines : SpectralLines
    band : BandPoints
    temperature : (n, M) array
        K.
    reflectance : (M, P) array
        At the points.
    bounce : (n, M) array
        From `reflection`.
    thermal_transmittance : (n, P) array, optional
        In place of that of the lines, in (5) alone.
    """
    through = lines.transmittance if thermal_transmittance is None else thermal_transmittance
    weight = lines.transmittance * band.radiance_weight / np.pi
    sky, direct = ((weight * part) @ reflectance.T for part in (lines.sky_irradiance, lines.direct_irradiance))
    return (
        spectral_thermal(through, band, temperature, reflectance) + sky + direct * bounce + lines.path_radiance[:, None]
    )


def spectral_thermal(
    transmittance: np.ndarray, band: BandPoints, temperature: np.ndarray, reflectance: np.ndarray
) -> np.ndarray:
    """Equation (5), (n, M), from transmittances (n, P); the rest as `spectral_radiance`."""
    thermal = np.empty(temperature.shape)
    for number, kelvin in enumerate(temperature.T):
        emitted = planck_wavenumber(band.wavenumber, kelvin[:, None])
        thermal[:, number] = (transmittance * emitted) @ (band.radiance_weight * (1 - reflectance[number]))
    return thermal


def exact_normalisation(shininess: np.ndarray, views: Views, normal: np.ndarray) -> np.ndarray:
    """N_s of each lobe at the very angle of incidence, (43), (n, M); grazing light counts as from 89.9 degrees."""
    cosine = np.maximum(incidence(views, normal)[:, 0], np.cos(np.radians(89.9)))
    angle = np.degrees(np.arccos(np.minimum(cosine, 1.0)))
    columns = {value: 2 * np.pi * cosine / lobe_integral(value, angle) for value in np.unique(shininess)}
    return np.stack([columns[value] for value in shininess], axis=1)
