"""Continua of the MT_CKD model: water vapour, carbon dioxide, nitrogen and oxygen.

Sources: Mlawer et al. 2012 (Phil. Trans. R. Soc. A 370, 2520) and 2023 (MT_CKD 4.3); for N2 Lafferty et al. 1996 (Appl. Opt. 35,
5911) and Hartmann et al. 2017; for O2 Thibault et al. 1997 (Appl. Opt. 36, 563). The coefficients are AER's, their
notice travels with whatever is derived from them (`Continua.notice`).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.interpolation import lagrange_weights
from skyshine.mat.spectroscopy.linebyline import C2, CM2_TO_M2
from skyshine.schemas.errors import InputError

H2O_FILE, OTHERS_FILE, NOTICE_FILE = "mt_ckd_4.3_h2o.nc", "mt_ckd_n2_o2_co2_o3.nc", "MT_CKD_NOTICE.md"

REFERENCE_PRESSURE = 101300.0  # Pa, of all coefficients (MT_CKD: 1013 mb)
REFERENCE_TEMPERATURE = 296.0  # K
AMAGAT_TEMPERATURE = 273.15  # K
LOSCHMIDT = 2.68675e19  # molecules cm^-3 at 1 atm and 273.15 K, as MT_CKD uses it
N2_DRY, O2_DRY = 0.78084, 0.20946  # mole fractions of dry air, US Standard Atmosphere 1976


def radiation_term(wavenumber, temperature):
    """nu tanh(c2 nu / 2 T), cm^-1: turns MT_CKD coefficients into cross sections (Clough et al. 1989)."""
    return wavenumber * np.tanh(C2 * wavenumber / (2 * temperature))


@dataclass(frozen=True)
class Coefficients:
    """Samples on an even wavenumber grid, zero outside it."""

    low: float
    step: float
    values: np.ndarray

    def at(self, wavenumber):
        """Interpolated with cubics in the coefficient; never below the smallest of the samples around."""
        wavenumber = np.asarray(wavenumber, float)
        position = (wavenumber - self.low) / self.step
        inside = (position >= 0) & (position <= self.values.size - 1)
        cell = np.clip(position.astype(int), 1, self.values.size - 3)
        fraction = position - cell
        around = self.values[cell[..., None] + np.arange(-1, 3)]
        weights = lagrange_weights(np.arange(-1.0, 3.0), np.where(inside, fraction, 0.0))
        value = np.sum(around * weights, axis=-1)
        return np.where(inside, np.clip(value, around.min(-1), around.max(-1)), 0.0)


class Continua:
    """The continuum coefficients of a folder that holds MT_CKD's netCDF files."""

    def __init__(self, folder):
        self.folder = Path(folder)
        water = _variables(self.folder / H2O_FILE)
        grid = water["wavenumbers"][0]
        self._water = {
            name: Coefficients(float(grid[0]), float(grid[1] - grid[0]), values)
            for name, (values, _) in water.items()
            if np.shape(values) == grid.shape
        }
        self._others = {
            name: Coefficients(float(a["wavenumber_lower_bound"]), float(a["wavenumber_resolution"]), values)
            for name, (values, a) in _variables(self.folder / OTHERS_FILE).items()
            if "wavenumber_lower_bound" in a
        }

    @functools.cached_property
    def notice(self) -> str:
        """The notice of AER that must accompany anything derived."""
        return " ".join((self.folder / NOTICE_FILE).read_text(encoding="utf-8").replace("&copy;", "(c)").split())

    def water_coefficients(self, wavenumber):
        """MT_CKD 4.3 at wavenumbers (K,) cm^-1.

        Returns
        -------
        self_continuum, foreign_continuum : (K,) arrays, m2/molecule per cm^-1 at 296 K and 1013 hPa
        self_exponent : (K,) array
        """
        self_continuum = self._water["self_absco_ref"].at(wavenumber) * CM2_TO_M2
        foreign = self._water["for_absco_ref"].at(wavenumber) * CM2_TO_M2
        return self_continuum, foreign, self._water["self_texp"].at(wavenumber)

    def co2(self, wavenumber, pressure, temperature, h2o_fraction=0.0):
        """Continuum per CO2 molecule, m2; arguments broadcast."""
        scale = self._others["bfco2"].at(wavenumber) * 1e-20 * CM2_TO_M2
        factor = self._others["x_factor_co2"].at(wavenumber)
        exponent = self._others["tdep_bandhead"].at(wavenumber)  # zero outside 2386 to 2434 cm^-1
        density = pressure / REFERENCE_PRESSURE * REFERENCE_TEMPERATURE / temperature
        correction = np.where(factor > 0, factor, 1.0) * (temperature / 246.0) ** exponent
        return scale * correction * density * radiation_term(wavenumber, temperature)

    def n2(self, wavenumber, pressure, temperature, h2o_fraction=0.0):
        """Collision-induced fundamental (4.3 um) and first overtone per N2 molecule in moist air, m2."""
        warm, cold = self._others["xn2_272"].at(wavenumber), self._others["xn2_228"].at(wavenumber)
        exponent = (1 / temperature - 1 / 272.0) / (1 / 228.0 - 1 / 272.0)
        both = (warm > 0) & (cold > 0)
        ratio = np.where(both, cold, 1.0) / np.where(both, warm, 1.0)
        fundamental = np.where(both, warm, 0.0) * ratio**exponent
        by_oxygen = 1.294 - 0.4545 * temperature / REFERENCE_TEMPERATURE  # efficiency against N2, Lafferty et al. 1996
        by_water = 9 / 7 * self._others["a_h2o"].at(wavenumber)
        dry = 1 - h2o_fraction
        partners = dry * (N2_DRY + O2_DRY * by_oxygen) + h2o_fraction * by_water
        overtone = self._others["xn2"].at(wavenumber)  # one efficiency for all partners
        return self._induced(fundamental * partners + overtone, wavenumber, pressure, temperature)

    def o2(self, wavenumber, pressure, temperature, h2o_fraction=0.0):
        """Collision-induced fundamental (6.4 um) per O2 molecule, m2."""
        slope = self._others["o2_t"].at(wavenumber)
        strength = self._others["o2_f"].at(wavenumber) * np.exp(slope * (1 / REFERENCE_TEMPERATURE - 1 / temperature))
        return self._induced(strength, wavenumber, pressure, temperature)

    @staticmethod
    def _induced(strength, wavenumber, pressure, temperature):
        amagats = pressure / REFERENCE_PRESSURE * AMAGAT_TEMPERATURE / temperature
        per_wavenumber = strength / wavenumber * radiation_term(wavenumber, temperature)
        return per_wavenumber * amagats / LOSCHMIDT * CM2_TO_M2


def _variables(path):
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            return {
                name: (np.ma.filled(v[...], np.nan).astype(float), {key: v.getncattr(key) for key in v.ncattrs()})
                for name, v in file.variables.items()
            }
    except OSError as error:
        raise InputError(f"cannot be read: {error}; --continua needs the folder of the MT_CKD files", file=path) from None
