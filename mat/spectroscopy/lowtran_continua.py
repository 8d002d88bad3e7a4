"""Continua of LOWTRAN7: water vapour, nitrogen and oxygen, in the public domain.

`atmospheres/continuum/README.md` says how the packaged tables follow from those of LOWTRAN7 (Kneizys et al. 1988,
AFGL-TR-88-0177). The water vapour continuum is that of Clough et al. 1980 (Proc. SPIE 277, 152) with LOWTRAN7's
corrections. It belongs to lines cut at 25 cm^-1 less their value there, as MT_CKD's does. There is no continuum of CO2,
and none of O2 in the near infrared and the visible.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from skyshine import atmospheres
from skyshine.mat.spectroscopy.continua import AMAGAT_TEMPERATURE, GasContinuum
from skyshine.mat.spectroscopy.linebyline import ATMOSPHERE
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_csv

OXYGEN_TEMPERATURE = 220.0  # K, of the strengths of O2


class LowtranContinua:
    """The packaged continua of LOWTRAN7."""

    name = "lowtran7"
    label = "LOWTRAN7"
    citation = "Continua: F. X. Kneizys et al., Users Guide to LOWTRAN 7, AFGL-TR-88-0177 (1988)."
    terms = "continua of LOWTRAN7 are a work of the US Government"
    notice = "Continua of LOWTRAN7: a work of the US Government, in the public domain."
    changed_by_water: frozenset[str] = frozenset()

    def __init__(self) -> None:
        self._water, self._nitrogen, self._oxygen = (
            list(read_csv(atmospheres.path(f"continuum/{name}.csv")).values())
            for name in ("lowtran7", "lowtran7_n2", "lowtran7_o2")
        )

    def water_coefficients(self, wavenumber: Floats) -> tuple[Floats, Floats, Floats]:
        """Coefficients at wavenumbers (K,) cm^-1, linear between the nodes, 0 beyond 20,000 cm^-1.

        Returns
        -------
        self_continuum, foreign_continuum : (K,) arrays, m2/molecule per cm^-1 at 296 K and 1013 hPa
        self_exponent : (K,) array
        """
        nodes, *coefficients = self._water
        self_continuum, foreign, exponent = (np.interp(wavenumber, nodes, values, right=0.0) for values in coefficients)
        return self_continuum, foreign, exponent

    @property
    def by_gas(self) -> Mapping[str, GasContinuum]:
        """Continua that belong to the lines of a gas."""
        return {"N2": self.n2, "O2": self.o2}

    def n2(
        self,
        wavenumber: Floats,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_fraction: npt.ArrayLike = 0.0,
    ) -> Floats:
        """Collision-induced band at 4.3 um per N2 molecule in air, m2 (DENSTY(4) of SUBROUTINE STDMDL)."""
        nodes, section = self._nitrogen
        density = np.asarray(pressure) / ATMOSPHERE * np.sqrt(AMAGAT_TEMPERATURE / np.asarray(temperature))
        return np.asarray(np.interp(wavenumber, nodes, section, left=0.0, right=0.0) * density)

    def o2(
        self,
        wavenumber: Floats,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_fraction: npt.ArrayLike = 0.0,
    ) -> Floats:
        """Collision-induced band at 6.4 um per O2 molecule in air, m2 (SUBROUTINE O2CONT)."""
        nodes, *coefficients = self._oxygen
        section, linear, quadratic = (
            np.interp(wavenumber, nodes, values, left=0.0, right=0.0) for values in coefficients
        )
        excess = np.asarray(temperature) - OXYGEN_TEMPERATURE
        return np.asarray(section * np.exp(linear * excess + quadratic * excess**2) * pressure / ATMOSPHERE)
