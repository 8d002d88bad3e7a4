"""Aerosol of LOWTRAN7: optical properties and phase functions.

Models of Shettle and Fenn 1979 (AFGL-TR-79-0214) as tabulated in LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177).
Extinction is relative to that at 0.55 um; the vertical profile (`aerosol_column`) carries the amount. Where sizes and
refractive indices are known, phase functions are those of Mie theory (`aerosol/phase.h5`, and `cloud/phase.h5` of the
two fogs); those of the stratosphere and of meteoric dust are LOWTRAN7's own tables (34 angles, 27 wavelengths from 0.2
to 40 um). Those of the first and last wavelength represent all beyond.
"""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.moments import MOMENTS, moment_weights
from skyshine.mat.atmosphere.particles.particles import AerosolOptics, between_wavelengths, linear_weights
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

MODELS: tuple[str, ...] = ("rural", "urban", "maritime", "tropospheric", "fog_advection", "fog_radiation")
MODELS += ("stratospheric_background", "volcanic_aged", "volcanic_fresh", "meteoric_dust")
FOGS = ("fog_advection", "fog_radiation")
OF_KNOWN_COMPONENTS = ("rural", "urban", "maritime", "tropospheric")
_FINE_ANGLES = 1801  # among which the moments of LOWTRAN7's functions take them as linear


@dataclass(frozen=True, eq=False)
class AerosolModel:
    """One aerosol model: tables against humidity (H nodes), wavelength (W nodes) and angle.

    Attributes
    ----------
    humidity : (H,) array
        Percent; one node for a model that does not depend on humidity.
    wavelength : (W,) array
        um.
    extinction, absorption, asymmetry : (H, W) arrays
    phase_angle : (A,) array
        Degree.
    phase_wavelength : (V,) array
        um.
    phase : (A, H, V) array
        Mean over the sphere 1.
    moments : (`MOMENTS`, H, V) array
        Legendre moments of the phase functions.
    fixed_humidity : float or None
        Percent; replaces the humidity of the air.
    """

    name: str
    humidity: Floats
    wavelength: Floats
    extinction: Floats
    absorption: Floats
    asymmetry: Floats
    phase_angle: Floats
    phase_wavelength: Floats
    phase: Floats
    moments: Floats
    fixed_humidity: float | None = None

    @staticmethod
    def load(name: str, fixed_humidity: float | None = None) -> AerosolModel:
        """Load a packaged model.

        Parameters
        ----------
        name : str
            One of `MODELS`.
        fixed_humidity : float, optional
            Percent; the model then ignores the humidity of the air.

        Raises
        ------
        InputError
            For an unknown name; the message contains the nearest one.
        """
        if name not in MODELS:
            nearest = get_close_matches(str(name), MODELS, n=1, cutoff=0.0)[0]
            raise InputError(f"no aerosol model '{name}'; did you mean '{nearest}'? Allowed: {', '.join(MODELS)}")
        return _load(name, fixed_humidity)

    def optics(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> AerosolOptics:
        """Extinction, single-scattering albedo and asymmetry.

        In humidity interpolation is LOWTRAN7's: the logarithm of the property is linear in log(100 - humidity), and
        humidity above 99 % acts as 99 %. Between wavelengths extinction and absorption follow power laws
        (`between_wavelengths`), where LOWTRAN7 is linear; asymmetry is linear.

        Parameters
        ----------
        wavenumber : (P,) array
            cm^-1, at most 50,000 (0.2 um).
        relative_humidity : (L,) array
            Percent.

        Raises
        ------
        InputError
            For a wavenumber outside the tables or a humidity that is negative or not a number.
        """
        wavelength = self._wavelength(wavenumber)
        humid = self._log_humidity_weights(relative_humidity)
        extinction, absorption, asymmetry = (
            interpolate_humidity(humid, table) for table in (self.extinction, self.absorption, self.asymmetry)
        )
        extinction, albedo = between_wavelengths(self.wavelength, extinction, absorption, wavelength)
        return AerosolOptics(extinction, albedo, asymmetry @ linear_weights(self.wavelength, wavelength))

    def phase_function(
        self, cos_angle: npt.ArrayLike, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike
    ) -> Floats:
        """Scattering phase function.

        Logarithm linear in angle between the tabulated angles, then linear in wavelength and in log(100 - humidity), so
        that the mean over the sphere is exactly 1 everywhere.

        Parameters
        ----------
        cos_angle : (A,) array
            Cosine of the scattering angle.
        wavenumber : (P,) array
            cm^-1, at most 50,000 (0.2 um).
        relative_humidity : (L,) array
            Percent.

        Returns
        -------
        (A, L, P) array

        Raises
        ------
        InputError
            As `optics`, and for a cosine outside -1..1 by more than rounding.
        """
        cosine = np.atleast_1d(np.asarray(cos_angle, dtype=float))
        if not np.all(np.abs(cosine) <= 1 + 1e-9):
            raise InputError("the cosine of the scattering angle must lie between -1 and 1")
        angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        log_phase = np.log(self.phase).reshape(len(self.phase_angle), -1)
        at_angle = np.exp(linear_weights(self.phase_angle, angle).T @ log_phase).reshape(-1, *self.phase.shape[1:])
        at_humidity = np.einsum("hl,ahv->alv", self._log_humidity_weights(relative_humidity), at_angle)
        phase: Floats = at_humidity @ linear_weights(self.phase_wavelength, self._wavelength(wavenumber))
        return phase

    def phase_moments(self, wavenumber: npt.ArrayLike, relative_humidity: npt.ArrayLike) -> Floats:
        """Legendre moments (`MOMENTS`, L, P) of the phase function; arguments and errors as `phase_function`."""
        humid = self._log_humidity_weights(relative_humidity)
        moments: Floats = np.einsum("hl,mhv->mlv", humid, self.moments) @ linear_weights(
            self.phase_wavelength, self._wavelength(wavenumber)
        )
        return moments

    def _wavelength(self, wavenumber: npt.ArrayLike) -> Floats:
        wavenumber = np.atleast_1d(np.asarray(wavenumber, dtype=float))
        limit = 1e4 / self.wavelength[0]
        if not np.all((wavenumber > 0) & (wavenumber <= limit * (1 + 1e-9))):
            raise InputError(f"aerosol '{self.name}' is tabulated for wavenumbers above 0 and up to {limit:.0f} cm-1")
        return 1e4 / wavenumber

    def _humidity(self, relative_humidity: npt.ArrayLike) -> Floats:
        humidity = np.atleast_1d(np.asarray(relative_humidity, dtype=float))
        if not np.all(humidity >= 0):
            raise InputError("relative humidity must be at least 0 percent and a number")
        if self.fixed_humidity is not None:
            humidity = np.full_like(humidity, self.fixed_humidity)
        return humidity

    def _log_humidity_weights(self, relative_humidity: npt.ArrayLike) -> Floats:
        humidity = np.minimum(self._humidity(relative_humidity), self.humidity[-1])
        return log_humidity_weights(self.humidity, humidity)


@cache
def _load(name: str, fixed_humidity: float | None) -> AerosolModel:
    table = tables.aerosol_table(name)
    humidity = np.unique(table["relative_humidity[percent]"])
    extinction, absorption, asymmetry = (
        table[column].reshape(len(humidity), -1) for column in ("extinction", "absorption", "asymmetry")
    )
    return AerosolModel(
        name=name,
        humidity=humidity,
        wavelength=table["wavelength[um]"].reshape(len(humidity), -1)[0],
        extinction=extinction,
        absorption=absorption,
        asymmetry=asymmetry,
        **_phase_of(name),
        fixed_humidity=fixed_humidity,
    )


def _phase_of(name: str) -> dict[str, Floats]:
    if name not in (*FOGS, *OF_KNOWN_COMPONENTS):
        return _phase_of_lowtran(name)
    table = tables.phase_table(name) if name in FOGS else tables.scattering_table(name)
    return {
        "phase_angle": table.angle,
        "phase_wavelength": table.wavelength,
        "phase": table.phase,
        "moments": table.moments,
    }


def _phase_of_lowtran(name: str) -> dict[str, Floats]:
    functions, index = tables.phase_function_tables()
    rows = np.flatnonzero(index["model"] == name)
    phase_columns = list(index)[2:]
    number = np.array([index[column][rows] for column in phase_columns], dtype=int).T
    values = np.array([functions[f"p{n}"] for n in range(1, len(functions))])
    return {
        "phase_angle": functions["angle[degree]"],
        "phase_wavelength": np.array([float(column) for column in phase_columns]),
        "phase": np.moveaxis(values[number - 1], -1, 0),
        "moments": np.moveaxis(_lowtran_moments()[number - 1], -1, 0),
    }


@cache
def _lowtran_moments() -> Floats:
    """Legendre moments (K, `MOMENTS`) of LOWTRAN7's phase functions."""
    functions, _ = tables.phase_function_tables()
    values = np.array([functions[f"p{n}"] for n in range(1, len(functions))])
    angle = np.linspace(0.0, 180.0, _FINE_ANGLES)
    log_phase = linear_weights(functions["angle[degree]"], angle).T @ np.log(values.T)
    moments: Floats = (moment_weights(np.radians(angle), MOMENTS) @ np.exp(log_phase)).T
    return moments / moments[:, :1]


def log_humidity_weights(nodes: Floats, humidity: Floats) -> Floats:
    """Weights (H, L) of tables at humidities (H,) for humidities (L,) [percent], linear in log(100 - humidity)."""
    return linear_weights(-np.log(100 - nodes), -np.log(100 - humidity))


def interpolate_humidity(weights: Floats, table: Floats) -> Floats:
    """Interpolate the logarithm of a (H, W) table with (H, L) weights; a model of one humidity may contain zeros."""
    if len(table) == 1:
        return np.broadcast_to(table, (weights.shape[1], table.shape[1]))
    interpolated: Floats = np.exp(weights.T @ np.log(table))
    return interpolated
