"""Continua of the MT_CKD model: water vapour, carbon dioxide, nitrogen and oxygen.

Sources: Mlawer et al. 2012 (Phil. Trans. R. Soc. A 370, 2520) and 2023 (MT_CKD 4.3); for N2 Lafferty et al. 1996 (Appl.
Opt. 35, 5911) and Hartmann et al. 2017; for O2 Thibault et al. 1997 (Appl. Opt. 36, 563; 6.4 um), Mate et al. 1999 (J.
Geophys. Res. 104, 30585; 1.27 um), Mlawer et al. 1998 (J. Geophys. Res. 103, 3859; 1.06 um and the A band) and
Greenblatt et al. 1990 (J. Geophys. Res. 95, 18577; O2-O2 in the visible). The coefficients are AER's, their notice
travels with whatever is derived from them (`Continua.notice`).
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.lagrange import lagrange_weights
from skyshine.mat.radiometry.constants import C2, ZERO_CELSIUS
from skyshine.mat.spectroscopy import line_mixing
from skyshine.mat.spectroscopy.linebyline import CM2_TO_M2
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Cross section per molecule in m2 at wavenumber [cm^-1], pressure [Pa], temperature [K] and mole fraction of H2O, which
# broadcast against each other.
GasContinuum = Callable[[Floats, npt.ArrayLike, npt.ArrayLike, npt.ArrayLike], Floats]

H2O_FILE, OTHERS_FILE, NOTICE_FILE = "mt_ckd_4.3_h2o.nc", "mt_ckd_n2_o2_co2_o3.nc", "MT_CKD_NOTICE.md"

REFERENCE_PRESSURE = 101300.0  # Pa, of all coefficients (MT_CKD: 1013 mb)
REFERENCE_TEMPERATURE = 296.0  # K
AMAGAT_TEMPERATURE = ZERO_CELSIUS
LOSCHMIDT = 2.68675e19  # molecules cm^-3 at 1 atm and 273.15 K, as MT_CKD uses it
N2_DRY, O2_DRY = 0.78084, 0.20946  # mole fractions of dry air, US Standard Atmosphere 1976

# O2 at 1.06 um (Mlawer et al. 1998): centre and half width (cm^-1), strength of two Lorentzians, and the common decay
# towards low wavenumbers (cm^-1). 1.054: MT_CKD's adjustment of the strength.
O2_1060 = ((9375.0, 58.96, 1.166e-4 * 1.054), (9439.0, 45.04, 3.086e-5 * 1.054))
O2_1060_DECAY, O2_1060_RANGE = 176.1, (9100.0, 11000.0)
# Greenblatt et al. 1990 measured 89.5 cm of 55 atm O2 at 296 K; MT_CKD keeps their optical depths.
GREENBLATT_PATH = 89.5 * (55.0 * AMAGAT_TEMPERATURE / REFERENCE_TEMPERATURE) ** 2  # cm amagat^2


class ContinuumModel(Protocol):
    """Continua of all gases, by one author.

    Attributes
    ----------
    name : str
        Name of the water vapour continuum in a job.
    label : str
        Label of the model in provenance.
    citation, terms, notice : str
        What to cite, on what terms figures may be used, and the notice that travels with them.
    changed_by_water : frozenset of str
        Gases whose continuum depends on the amount of water vapour.
    by_gas : mapping
        Continua that belong to the lines of a gas, by its name.
    """

    @property
    def name(self) -> str: ...
    @property
    def label(self) -> str: ...
    @property
    def citation(self) -> str: ...
    @property
    def terms(self) -> str: ...
    @property
    def notice(self) -> str: ...
    @property
    def changed_by_water(self) -> frozenset[str]: ...
    @property
    def by_gas(self) -> Mapping[str, GasContinuum]: ...
    def water_coefficients(self, wavenumber: Floats) -> tuple[Floats, Floats, Floats]: ...


def radiation_term(wavenumber: Floats, temperature: npt.ArrayLike) -> Floats:
    """nu tanh(c2 nu / 2 T), cm^-1: turns MT_CKD coefficients into cross sections (Clough et al. 1989)."""
    return np.asarray(wavenumber * np.tanh(C2 * wavenumber / (2 * np.asarray(temperature))))


@dataclass(frozen=True)
class Coefficients:
    """Samples (N,) on an even wavenumber grid, zero outside it.

    Attributes
    ----------
    low, step : float
        First wavenumber and step, cm^-1.
    values : (N,) array
    """

    low: float
    step: float
    values: Floats

    def at(self, wavenumber: npt.ArrayLike) -> Floats:
        """Interpolated at wavenumbers (K,) with cubics; never beyond the smallest and largest of the samples around."""
        wavenumber = np.asarray(wavenumber, float)
        position = (wavenumber - self.low) / self.step
        inside = (position >= 0) & (position <= self.values.size - 1)
        cell = np.clip(position.astype(int), 1, self.values.size - 3)
        fraction = position - cell
        samples = self.values[cell[..., None] + np.arange(-1, 3)]
        weights = lagrange_weights(np.arange(-1.0, 3.0), np.where(inside, fraction, 0.0))
        value = np.sum(samples * weights, axis=-1)
        return np.asarray(np.where(inside, np.clip(value, samples.min(-1), samples.max(-1)), 0.0))


class Continua:
    """The continuum coefficients of a folder with MT_CKD's netCDF files."""

    name = "mt_ckd_4.3"
    label = "MT_CKD"
    citation = "Continua: E. J. Mlawer et al., Phil. Trans. R. Soc. A 370 (2012) 2520-2556; MT_CKD 4.3 (2023)."
    terms = "MT_CKD under AER's notice"
    changed_by_water = frozenset({"N2"})

    def __init__(self, folder: str | os.PathLike[str]) -> None:
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

    @property
    def by_gas(self) -> Mapping[str, GasContinuum]:
        """Continua that belong to the lines of a gas."""
        return {"CO2": self.co2, "N2": self.n2, "O2": self.o2}

    def water_coefficients(self, wavenumber: Floats) -> tuple[Floats, Floats, Floats]:
        """MT_CKD 4.3 at wavenumbers (K,) cm^-1.

        Returns
        -------
        self_continuum, foreign_continuum : (K,) arrays, m2/molecule per cm^-1 at 296 K and 1013 hPa
        self_exponent : (K,) array
        """
        self_continuum = self._water["self_absco_ref"].at(wavenumber) * CM2_TO_M2
        foreign = self._water["for_absco_ref"].at(wavenumber) * CM2_TO_M2
        return self_continuum, foreign, self._water["self_texp"].at(wavenumber)

    def foreign_for_closure(self, wavenumber: Floats) -> Floats:
        """Foreign continuum of MT_CKD 4.3 for radiative closure at wavenumbers (K,), as `water_coefficients`."""
        return self._water["for_closure_absco_ref"].at(wavenumber) * CM2_TO_M2

    def before_4(self, name: str, wavenumber: Floats) -> Floats:
        """Coefficients of water vapour before MT_CKD 4 at wavenumbers (K,) of their grid: bs296, bs260 or bfh2o, 1e-20
        cm3.
        """
        return self._others[name].at(wavenumber)

    def co2(
        self,
        wavenumber: Floats,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_fraction: npt.ArrayLike = 0.0,
    ) -> Floats:
        """Continuum per CO2 molecule, m2; arguments broadcast. Zero where lines mix: their wings are whole there."""
        single = (wavenumber < line_mixing.RANGE[0]) | (wavenumber > line_mixing.RANGE[1])
        scale = np.where(single, self._others["bfco2"].at(wavenumber), 0.0) * 1e-20 * CM2_TO_M2
        factor = self._others["x_factor_co2"].at(wavenumber)
        pressure, temperature = np.asarray(pressure), np.asarray(temperature)
        density = pressure / REFERENCE_PRESSURE * REFERENCE_TEMPERATURE / temperature
        correction = np.where(factor > 0, factor, 1.0)
        return np.asarray(scale * correction * density * radiation_term(wavenumber, temperature))

    def n2(
        self,
        wavenumber: Floats,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_fraction: npt.ArrayLike = 0.0,
    ) -> Floats:
        """Collision-induced fundamental (4.3 um) and first overtone per N2 molecule in moist air, m2."""
        at_272, at_228 = self._others["xn2_272"].at(wavenumber), self._others["xn2_228"].at(wavenumber)
        temperature, h2o_fraction = np.asarray(temperature), np.asarray(h2o_fraction)
        exponent = (1 / temperature - 1 / 272.0) / (1 / 228.0 - 1 / 272.0)
        both = (at_272 > 0) & (at_228 > 0)
        ratio = np.where(both, at_228, 1.0) / np.where(both, at_272, 1.0)
        fundamental = np.where(both, at_272, 0.0) * ratio**exponent
        by_oxygen = 1.294 - 0.4545 * temperature / REFERENCE_TEMPERATURE  # efficiency against N2, Lafferty et al. 1996
        by_water = 9 / 7 * self._others["a_h2o"].at(wavenumber)
        dry = 1 - h2o_fraction
        partners = dry * (N2_DRY + O2_DRY * by_oxygen) + h2o_fraction * by_water
        overtone = self._others["xn2"].at(wavenumber)  # one efficiency for all partners
        return self._induced(fundamental * partners + overtone, wavenumber, pressure, temperature)

    def o2(
        self,
        wavenumber: Floats,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_fraction: npt.ArrayLike = 0.0,
    ) -> Floats:
        """Collision-induced bands per O2 molecule in air, m2: 6.4, 1.27 and 1.06 um, around the A band, O2-O2 in the
        visible.
        """
        temperature, h2o_fraction = np.asarray(temperature), np.asarray(h2o_fraction)
        slope = self._others["o2_t"].at(wavenumber)
        fundamental = self._others["o2_f"].at(wavenumber) * np.exp(
            slope * (1 / REFERENCE_TEMPERATURE - 1 / temperature)
        )
        dry = 1 - h2o_fraction
        # Efficiencies of Mate et al. 1999, whose coefficients are for a mixture of 21 % O2 in N2: 0.21 + 0.3 * 0.79 =
        # 0.446.
        partners = dry * (O2_DRY + 0.3 * N2_DRY) / 0.446 + h2o_fraction
        strength = (
            fundamental
            + self._others["o2_inf1"].at(wavenumber) * partners
            + _o2_1060(wavenumber) * dry
            + self._others["o2_inf3"].at(wavenumber)
            + self._others["o2_invis"].at(wavenumber) / GREENBLATT_PATH * dry * O2_DRY
        )
        return self._induced(strength, wavenumber, pressure, temperature)

    @staticmethod
    def _induced(strength: Floats, wavenumber: Floats, pressure: npt.ArrayLike, temperature: Floats) -> Floats:
        """Cross section, m2, of an induced strength in cm^-1 amagat^-2."""
        amagats = np.asarray(pressure) / REFERENCE_PRESSURE * AMAGAT_TEMPERATURE / temperature
        per_wavenumber = strength / wavenumber * radiation_term(wavenumber, temperature)
        return np.asarray(per_wavenumber * amagats / LOSCHMIDT * CM2_TO_M2)


def _o2_1060(wavenumber: npt.ArrayLike) -> Floats:
    """The band at 1.06 um, cm^-1 amagat^-2 in dry air (Mlawer et al. 1998)."""
    wavenumber = np.asarray(wavenumber, float)
    total = np.zeros(wavenumber.shape)
    for centre, width, strength in O2_1060:
        away = wavenumber - centre
        damping = np.exp(np.minimum(away, 0.0) / O2_1060_DECAY)
        total = total + strength * damping / (np.pi * width * (1 + (away / width) ** 2))
    inside = (wavenumber > O2_1060_RANGE[0]) & (wavenumber < O2_1060_RANGE[1])
    # Given in 1e-20 cm2 per molecule at 1013 hPa and 296 K.
    cross_section = np.where(inside, total, 0.0) * 1e-20
    return np.asarray(cross_section * LOSCHMIDT * REFERENCE_TEMPERATURE / AMAGAT_TEMPERATURE)


def _variables(path: Path) -> dict[str, tuple[Floats, dict[str, Any]]]:
    """Values and attributes of the variables of a netCDF file, by name; missing values are NaN."""
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            return {
                name: (np.ma.filled(v[...], np.nan).astype(float), {key: v.getncattr(key) for key in v.ncattrs()})
                for name, v in file.variables.items()
            }
    except OSError as error:
        raise InputError(
            f"cannot be read: {error}; --continua needs the folder of the MT_CKD files", file=path
        ) from None
