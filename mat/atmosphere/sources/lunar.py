"""Lunar spectral irradiance: reflected sunlight and the Moon's own thermal emission.

Reflected: disk-equivalent reflectance in the form of Kieffer and Stone 2005 (doi:10.1086/430185) with the LIME
coefficients of Toledano et al. 2024 (doi:10.5194/acp-24-3649-2024) at six wavelengths from 0.44 to 1.64 um; between and
beyond them the spectral shape of 95 % Apollo 16 soil and 5 % breccia to 2.55 um, then 1 - emissivity (Kirchhoff).

Thermal: each point of the sphere in equilibrium with the sunlight on it, T = T_subsolar cos^(1/4)(incidence), over a
night side of 100 K, emitting diffusely (Vasavada et al. 2012, doi:10.1029/2011JE003987). Roughness is left out: near
full Moon it would brighten, at large phase darken the disk by several percent.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.sources.tables import lunar_tables
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

MOON_RADIUS = 1_737_400.0  # m, mean (IAU Working Group 2015)
# LIME was fitted from 2 to 90 degrees, but its opposition surge is steep: from 5 to 2 degrees it brightens by 1.48 at
# 0.555 um, the model of Miller and Turner 2009 by 1.08. Held from 4 degrees it stays within 13 % of the latter down to
# full Moon.
SMALLEST_PHASE = 4.0
SOLAR_CONSTANT = 1361.0  # W m^-2 at 1 au (Kopp and Lean 2011)
SOLAR_ALBEDO = 0.12  # of the mean lunar surface (Vasavada et al. 2012)
BROADBAND_EMISSIVITY = 0.95  # (Vasavada et al. 2012)
NIGHT_TEMPERATURE = 100.0  # K (Vasavada et al. 2012: 95 to 110 K at low latitudes)
# Spectral emissivity: near 1 at the Christiansen feature at 8 um (Salisbury et al. 1995), 0.95 beyond 10 um (Vasavada
# et al. 2012), falling to the lower end of the 0.6 to 1.0 that disk-integrated measurements from 3.7 to 15 um give
# (Mueller et al. 2020, EPSC2020-586) where sunlight is still reflected well; linear between these. Good to about 0.1
# below 6 um, 0.03 above.
EMISSIVITY_WAVELENGTH = np.array([2.55, 3.75, 8.0, 10.0])  # um
EMISSIVITY = np.array([0.65, 0.65, 0.99, 0.95])
# Gauss points of the disk integral across latitude, the sunlit and the dark part of longitude: right to 1e-6.
LATITUDES, DAY_LONGITUDES, NIGHT_LONGITUDES = 16, 16, 6


@dataclass(frozen=True)
class LunarIrradiance:
    """Irradiance by the whole disk at normal incidence, W m^-2 (cm^-1)^-1, shape (P,).

    Attributes
    ----------
    reflected : array
        Sunlight reflected by the Moon.
    thermal : array
        The Moon's own emission.
    """

    reflected: Floats
    thermal: Floats

    @property
    def total(self) -> Floats:
        """Sum of both."""
        return self.reflected + self.thermal


def lunar_irradiance(
    wavenumber: npt.ArrayLike,
    phase_angle: float,
    moon_distance: float,
    sun_distance: float,
    waxing: bool | None = None,
    width: npt.ArrayLike | None = None,
) -> LunarIrradiance:
    """Irradiance of the Moon outside the atmosphere.

    Parameters
    ----------
    wavenumber : (P,) array
        cm^-1, 10 to 83,500.
    phase_angle : float
        Angle Sun - Moon - observer, 0 (full) to 180 (new), degree.
    moon_distance : float
        From the observer, m.
    sun_distance : float
        From the Moon to the Sun, au.
    waxing : bool, optional
        Whether the Moon is before full: the sides of the Moon differ by up to some percent. Without it, the (geometric)
        mean of both.
    width : (P,) array or float, optional
        cm^-1, over which sunlight is averaged, see `solar_irradiance`.

    Returns
    -------
    LunarIrradiance

    Raises
    ------
    InputError
        For a phase angle outside 0 to 180, a distance that is not positive (the Moon's must exceed its radius), or a
        wavenumber outside the solar table.
    """
    if not 0 <= phase_angle <= 180:
        raise InputError(f"lunar phase angle {phase_angle} is outside 0 to 180 degrees")
    if not MOON_RADIUS < moon_distance < np.inf:
        raise InputError(f"lunar distance {moon_distance} m must exceed the Moon's radius of {MOON_RADIUS:.0f} m")
    if not 0 < sun_distance < np.inf:
        raise InputError(f"distance {sun_distance} au of the Sun from the Moon must be positive")
    wavenumber = np.atleast_1d(np.asarray(wavenumber, dtype=float))
    sunlight = solar_irradiance(wavenumber, width) / sun_distance**2
    area = (MOON_RADIUS / moon_distance) ** 2  # solid angle of the disk over pi
    return LunarIrradiance(
        reflected=disk_reflectance(1e4 / wavenumber, phase_angle, waxing) * area * sunlight,
        thermal=thermal_emissivity(1e4 / wavenumber) * area * _disk_integral(wavenumber, phase_angle, sun_distance),
    )


def disk_reflectance(wavelength: npt.ArrayLike, phase_angle: float, waxing: bool | None = None) -> Floats:
    """Disk-equivalent reflectance A of the Moon at mean libration.

    The irradiance at the observer is A * (solid angle of the Moon / pi) * (solar irradiance at the Moon). Phase angles
    below `SMALLEST_PHASE` act as it. Beyond 90 degrees the fit is extrapolated: the crescent it gives is fainter than
    that of Miller and Turner 2009, by a fifth at 110 and a third at 130 degrees.

    Parameters
    ----------
    wavelength : (P,) array
        um.
    phase_angle : float
        Degree.
    waxing : bool, optional
        As in `lunar_irradiance`.

    Returns
    -------
    (P,) array
    """
    coefficients, shape = lunar_tables()
    wavelength = np.asarray(wavelength, dtype=float)
    degrees = max(phase_angle, SMALLEST_PHASE)
    radians = np.radians(degrees)
    logarithm = sum(coefficients[f"a{i}"] * radians**i for i in range(4))
    if waxing is not None:
        # Selenographic longitude of the Sun at mean libration: east, positive, before full Moon.
        longitude = radians if waxing else -radians
        logarithm += sum(coefficients[f"b{i}"] * longitude ** (2 * i - 1) for i in (1, 2, 3))
    logarithm += coefficients["d1"] * np.exp(-degrees / coefficients["p1"]) + coefficients["d2"] * np.exp(
        -degrees / coefficients["p2"]
    )
    logarithm += coefficients["d3"] * np.cos((degrees - coefficients["p3"]) / coefficients["p4"])
    nodes = coefficients["wavelength[um]"]
    scale = np.interp(wavelength, nodes, np.exp(logarithm) / _shape(shape, nodes))
    reflectance: Floats = scale * _shape(shape, wavelength)
    return reflectance


def thermal_emissivity(wavelength: npt.ArrayLike) -> Floats:
    """Emissivity of the lunar surface against wavelength [um]."""
    emissivity: Floats = np.interp(np.asarray(wavelength, dtype=float), EMISSIVITY_WAVELENGTH, EMISSIVITY)
    return emissivity


def subsolar_temperature(sun_distance: float) -> float:
    """Temperature of the surface under the Sun in equilibrium with it, K; the Sun's distance in au."""
    absorbed = (1 - SOLAR_ALBEDO) * SOLAR_CONSTANT / sun_distance**2
    return float((absorbed / (BROADBAND_EMISSIVITY * Stefan_Boltzmann)) ** 0.25)


def _shape(shape: dict[str, Floats], wavelength: Floats) -> Floats:
    """Reflectance of the samples; beyond their spectra, one minus the emissivity, scaled to join."""
    beyond = (1 - thermal_emissivity(wavelength)) / (1 - EMISSIVITY[0])
    reflectance: Floats = np.interp(wavelength, shape["wavelength[um]"], shape["reflectance"]) * beyond
    return reflectance


def _disk_integral(wavenumber: Floats, phase_angle: float, sun_distance: float) -> Floats:
    """Blackbody radiance times cosine over the visible hemisphere of a unit sphere, W m^-2 (cm^-1)^-1, shape (P,)."""
    cos_incidence, weight = _visible_hemisphere(float(phase_angle))
    fourth_power = subsolar_temperature(sun_distance) ** 4 * np.maximum(cos_incidence, 0) + NIGHT_TEMPERATURE**4
    integral: Floats = weight @ planck_wavenumber(wavenumber, fourth_power[:, None] ** 0.25)
    return integral


@lru_cache(maxsize=64)
def _visible_hemisphere(phase_angle: float) -> tuple[Floats, Floats]:
    """Cosine of the Sun's incidence and projected area, both (N,), of points on the half sphere that the observer sees.

    Photometric coordinates: the observer over longitude 0 of the equator, the Sun over longitude `phase_angle` of it.
    """
    latitude, latitude_weight = _gauss(-np.pi / 2, np.pi / 2, LATITUDES)
    phase = np.radians(phase_angle)
    terminator = phase - np.pi / 2
    longitude, longitude_weight = (
        np.concatenate(parts)
        for parts in zip(
            _gauss(-np.pi / 2, terminator, NIGHT_LONGITUDES), _gauss(terminator, np.pi / 2, DAY_LONGITUDES), strict=True
        )
    )
    cos_incidence = np.cos(latitude)[:, None] * np.cos(longitude - phase)
    weight = (np.cos(latitude) ** 2 * latitude_weight)[:, None] * (np.cos(longitude) * longitude_weight)
    return cos_incidence.ravel(), weight.ravel()


def _gauss(low: float, high: float, count: int) -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (high - low)
    return low + half * (nodes + 1), half * weights
