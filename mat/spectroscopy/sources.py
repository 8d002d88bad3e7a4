"""Where the cross sections of a gas come from: its lines and the continuum that belongs to it, or what stands in for
them.
"""

from __future__ import annotations

import numpy as np

from skyshine.mat.spectroscopy import linebyline, nodes
from skyshine.mat.spectroscopy.gases import GASES, HITRAN


class GasSources:
    """All there is of one gas: the first source that covers an interval gives its cross sections there."""

    def __init__(self, name, sources):
        self.name, self.sources = name, list(sources)

    def number(self, low, high) -> int | None:
        """Number of the source for [low, high] cm^-1, or None where there is none."""
        return next((n for n, source in enumerate(self.sources) if source.covers(low, high)), None)

    def source(self, low, high):
        """The source for [low, high] cm^-1, or None."""
        number = self.number(low, high)
        return None if number is None else self.sources[number]


class LineSource:
    """A gas summed line by line."""

    terms = "figures computed from HITRAN, which asks to be cited (Rothman et al. 2013); MT_CKD under AER's notice"

    def __init__(self, name, library, continua):
        self.name, self.gas = name, GASES[name]
        self._library = library
        self._continuum = getattr(continua, self.gas.continuum) if self.gas.continuum else None

    @property
    def provenance(self) -> str:
        return HITRAN + (f"; {self.name} continuum of MT_CKD" if self._continuum else "")

    def covers(self, low, high) -> bool:
        """Whether there are line lists for [low, high] cm^-1."""
        return self._library.covers(self.name, low, high)

    def spectrum(self, wavenumber, low, high):
        """Cross sections (P, T, K) in dry air on the fine grid of an interval, m2/molecule."""
        lines = linebyline.interval_spectrum(
            self._library.near(self.name, low, high),
            low,
            high,
            nodes.PRESSURE,
            nodes.TEMPERATURE,
            self.gas.self_fraction,
            self.gas.shape,
        )
        return lines + self._continuum_at(wavenumber, nodes.PRESSURE, nodes.TEMPERATURE, 0.0)

    def points(self, wavenumber, low, high):
        """Cross sections at chosen wavenumbers (K,) at the nodes of the table.

        Returns
        -------
        dry : (K, P, T) array, m2/molecule
        humid : (K, Q - 1, H, T) array of log ratios to dry air, or None where water vapour's amount changes nothing
        """
        dry = self.cross_sections(wavenumber, nodes.PRESSURE, nodes.TEMPERATURE)
        if self.name != "H2O" and self.gas.continuum != "n2":
            return dry, None
        pressure = nodes.PRESSURE[nodes.HUMID_PRESSURE :]
        ratios = []
        for q in nodes.H2O_FRACTION[1:]:
            moist = self.cross_sections(wavenumber, pressure, nodes.TEMPERATURE, q)
            ratios.append(np.log(np.maximum(moist, 1e-60) / np.maximum(dry[:, nodes.HUMID_PRESSURE :], 1e-60)))
        return dry, np.stack(ratios, axis=1)

    def cross_sections(self, wavenumber, pressure, temperature, h2o_fraction=0.0):
        """Cross sections (K, P, T) in m2/molecule at any wavenumbers, pressures and temperatures, summed without a
        grid.
        """
        wavenumber, pressure, temperature = (np.asarray(a, float) for a in (wavenumber, pressure, temperature))
        own = h2o_fraction if self.name == "H2O" else self.gas.self_fraction
        lines = self._library.near(self.name, wavenumber.min(), wavenumber.max())
        total = linebyline.point_cross_sections(lines, wavenumber, pressure, temperature, own, self.gas.shape)
        return np.moveaxis(total + self._continuum_at(wavenumber, pressure, temperature, h2o_fraction), -1, 0)

    def _continuum_at(self, wavenumber, pressure, temperature, h2o_fraction):
        if self._continuum is None:
            return 0.0
        return self._continuum(wavenumber, pressure[:, None, None], temperature[:, None], h2o_fraction)
