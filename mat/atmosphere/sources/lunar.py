"""Lunar spectral irradiance: reflected sunlight and the Moon's own thermal emission.

Reflected: disk-equivalent reflectance in the form of Kieffer and Stone 2005 (doi:10.1086/430185), with their
coefficients at 32 wavelengths from 0.35 to 2.38 um smoothed over wavelength against the spectral shape of 95 % Apollo
16 soil and 5 % breccia, and raised to the level of LIME (Toledano et al. 2024, doi:10.5194/acp-24-3649-2024), 0 to 9 %
higher. Beyond 2.55 um reflectance goes with 1 - emissivity (Kirchhoff).

Thermal: see `lunar_thermal`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.lunar_thermal import disk_emission
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.sources.tables import lunar_tables
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

MOON_RADIUS = 1_737_400.0  # m, mean (IAU Working Group 2015)
# Degree: the phase scales of the ROLO model 311g (Kieffer and Stone 2005, table 5), and the end of its fit.
P1, P2, P3, P4 = 4.06054, 12.8802, -30.5858, 16.7498
LARGEST_FITTED_PHASE = 97.0
# Spectral emissivity: near 1 at the Christiansen feature at 8 um (Salisbury et al. 1995), 0.95 beyond 10 um (Vasavada
# et al. 2012), falling to the lower end of the 0.6 to 1.0 that disk-integrated measurements from 3.7 to 15 um give
# (Mueller et al. 2020, EPSC2020-586) where sunlight is still reflected well; linear between these. Good to about 0.1
# below 6 um, 0.03 above.
EMISSIVITY_WAVELENGTH = np.array([2.55, 3.75, 8.0, 10.0])  # um
EMISSIVITY = np.array([0.65, 0.65, 0.99, 0.95])


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
        Distance of the Moon from the observer, m.
    sun_distance : float
        Distance of the Moon from the Sun, au.
    waxing : bool, optional
        Whether the Moon is before full: the sides of the Moon differ by up to some percent. Without it, the (geometric)
        mean of both.
    width : (P,) array or float, optional
        cm^-1, over which sunlight is averaged, see `solar_irradiance`.

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
        thermal=thermal_emissivity(1e4 / wavenumber) * area * disk_emission(wavenumber, phase_angle, sun_distance),
    )


def disk_reflectance(wavelength: npt.ArrayLike, phase_angle: float, waxing: bool | None = None) -> Floats:
    """Disk-equivalent reflectance A of the Moon at mean libration.

    The irradiance at the observer is A * (solid angle of the Moon / pi) * (solar irradiance at the Moon). The fit is of
    1.55 to 97 degrees. Below, its opposition surge goes on: from 4 degrees to 0 it brightens by 1.38 at 0.555 um,
    and Clementine saw more than 1.4 (Buratti, Hillier and Wang 1996, doi:10.1006/icar.1996.0225). Beyond, the Moon has
    its colours of 97 degrees and the brightness of Krisciunas and Schaefer 1991 (doi:10.1086/132921).

    Parameters
    ----------
    wavelength : (P,) array
        um.
    phase_angle : float
        Degree.
    waxing : bool, optional
        Phase direction, as in `lunar_irradiance`.

    Returns
    -------
    (P,) array
    """
    coefficients, shape = lunar_tables()
    wavelength = np.asarray(wavelength, dtype=float)
    at = {name: np.interp(wavelength, coefficients["wavelength[um]"], values) for name, values in coefficients.items()}
    degrees = min(phase_angle, LARGEST_FITTED_PHASE)
    radians = np.radians(degrees)
    logarithm = at["a0"] + at["a1"] * radians + at["a2"] * radians**2 + at["a3"] * radians**3
    if waxing is not None:
        # Selenographic longitude of the Sun at mean libration: east, positive, before full Moon.
        longitude = radians if waxing else -radians
        logarithm += at["b1"] * longitude + at["b2"] * longitude**3 + at["b3"] * longitude**5
    logarithm += at["d1"] * np.exp(-degrees / P1) + at["d2"] * np.exp(-degrees / P2)
    logarithm += at["d3"] * np.cos((degrees - P3) / P4)
    fainter = _magnitude(phase_angle) - _magnitude(degrees)
    reflectance: Floats = np.exp(logarithm) * _shape(shape, wavelength) * 10 ** (-0.4 * fainter)
    return reflectance


def thermal_emissivity(wavelength: npt.ArrayLike) -> Floats:
    """Emissivity of the lunar surface against wavelength [um]."""
    emissivity: Floats = np.interp(np.asarray(wavelength, dtype=float), EMISSIVITY_WAVELENGTH, EMISSIVITY)
    return emissivity


def _shape(shape: dict[str, Floats], wavelength: Floats) -> Floats:
    """Reflectance of the samples; beyond their spectra, one minus the emissivity, scaled to join."""
    beyond = (1 - thermal_emissivity(wavelength)) / (1 - EMISSIVITY[0])
    reflectance: Floats = np.interp(wavelength, shape["wavelength[um]"], shape["reflectance"]) * beyond
    return reflectance


def _magnitude(phase_angle: float) -> float:
    """Of the Moon, relative to the full Moon (Krisciunas and Schaefer 1991, equation 9, after Allen 1976); degree."""
    return 0.026 * phase_angle + 4e-9 * phase_angle**4
