"""Sources of the cross sections of a gas: its lines and their continuum, or data that replace them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from skyshine.mat.spectroscopy import line_mixing, nodes
from skyshine.mat.spectroscopy.continua import ContinuumModel
from skyshine.mat.spectroscopy.gases import GASES, LineLibrary
from skyshine.schemas.arrays import Floats


class Source(Protocol):
    """Where cross sections of one gas come from, and on what terms."""

    @property
    def name(self) -> str: ...
    @property
    def provenance(self) -> str: ...
    @property
    def terms(self) -> str: ...
    def covers(self, low: float, high: float) -> bool: ...


class SpectralSource(Source, Protocol):
    """A source on which the choice of points rests."""

    def spectrum(self, wavenumber: Floats, low: float, high: float) -> Floats: ...
    def moist_spectrum(self, wavenumber: Floats, low: float, high: float) -> Floats | None: ...
    def points(self, wavenumber: Floats, low: float, high: float) -> tuple[Floats, Floats | None]: ...


SourceT = TypeVar("SourceT", bound=Source, covariant=True)


class GasSources(Generic[SourceT]):
    """All sources of one gas: the first that covers an interval gives its cross sections there."""

    def __init__(self, name: str, sources: Sequence[SourceT]) -> None:
        self.name, self.sources = name, list(sources)

    def number(self, low: float, high: float) -> int | None:
        """Number of the source for [low, high] cm^-1, or None where there is none."""
        return next((n for n, source in enumerate(self.sources) if source.covers(low, high)), None)

    def source(self, low: float, high: float) -> SourceT | None:
        """The source for [low, high] cm^-1, or None."""
        number = self.number(low, high)
        return None if number is None else self.sources[number]


class LineSource:
    """A gas summed line by line."""

    def __init__(self, name: str, library: LineLibrary, continua: ContinuumModel) -> None:
        self.name, self.gas = name, GASES[name]
        self._library, self._continua = library, continua
        self._continuum = continua.by_gas.get(name)

    @property
    def provenance(self) -> str:
        """The line list, and the continuum that is added to it."""
        return self._library.provenance + (
            f"; {self.name} continuum of {self._continua.label}" if self._continuum else ""
        )

    @property
    def terms(self) -> str:
        """Terms of the lines and of the continua."""
        return f"{self._library.terms}; {self._continua.terms}"

    def covers(self, low: float, high: float) -> bool:
        """Whether there are line lists for [low, high] cm^-1."""
        return self._library.covers(self.name, low, high)

    def spectrum(self, wavenumber: Floats, low: float, high: float) -> Floats:
        """Cross sections (P, T, K) in dry air on the fine grid of an interval, m2/molecule."""
        return self._on_grid(wavenumber, low, high, nodes.PRESSURE, 0.0)

    def moist_spectrum(self, wavenumber: Floats, low: float, high: float) -> Floats | None:
        """The same (Q - 1, H, T, K) at `nodes.H2O_FRACTION[1:]` and the H highest pressures; None where water vapour's
        amount changes nothing.
        """
        if not self._changed_by_water:
            return None
        pressure = nodes.PRESSURE[nodes.HUMID_PRESSURE :]
        return np.array([self._on_grid(wavenumber, low, high, pressure, q) for q in nodes.H2O_FRACTION[1:]])

    @property
    def _changed_by_water(self) -> bool:
        return self.name == "H2O" or self.name in self._continua.changed_by_water

    def _on_grid(self, wavenumber: Floats, low: float, high: float, pressure: Floats, h2o_fraction: float) -> Floats:
        """Cross sections (P, T, K) on the fine grid of an interval, m2/molecule."""
        lines = self._library.interval_spectrum(
            self.name, low, high, pressure, nodes.TEMPERATURE, self._self_fraction(h2o_fraction)
        )
        return np.asarray(lines + self._continuum_at(wavenumber, pressure, nodes.TEMPERATURE, h2o_fraction))

    def _self_fraction(self, h2o_fraction: float) -> float:
        return h2o_fraction if self.name == "H2O" else self.gas.self_fraction

    def points(self, wavenumber: Floats, low: float, high: float) -> tuple[Floats, Floats | None]:
        """Cross sections at chosen wavenumbers (K,) at the nodes of the table.

        Returns
        -------
        dry : (K, P, T) array, m2/molecule
        humid : (K, Q - 1, H, T) array of log ratios to dry air, or None where water vapour's amount changes nothing
        """
        dry = self.cross_sections(wavenumber, nodes.PRESSURE, nodes.TEMPERATURE)
        if not self._changed_by_water:
            return dry, None
        pressure = nodes.PRESSURE[nodes.HUMID_PRESSURE :]
        ratios = []
        for q in nodes.H2O_FRACTION[1:]:
            moist = self.cross_sections(wavenumber, pressure, nodes.TEMPERATURE, q)
            ratios.append(np.log(np.maximum(moist, 1e-60) / np.maximum(dry[:, nodes.HUMID_PRESSURE :], 1e-60)))
        return dry, np.stack(ratios, axis=1)

    def cross_sections(
        self,
        wavenumber: npt.ArrayLike,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_fraction: float = 0.0,
    ) -> Floats:
        """Cross sections (K, P, T) in m2/molecule at any wavenumbers, pressures and temperatures, summed without a
        grid.
        """
        wavenumber, pressure, temperature = (np.asarray(a, float) for a in (wavenumber, pressure, temperature))
        total = self._library.point_cross_sections(
            self.name, wavenumber, pressure, temperature, self._self_fraction(h2o_fraction)
        )
        return np.moveaxis(total + self._continuum_at(wavenumber, pressure, temperature, h2o_fraction), -1, 0)

    def _continuum_at(self, wavenumber: Floats, pressure: Floats, temperature: Floats, h2o_fraction: float) -> Floats:
        """Cross sections (P, T, K), or one zero where the gas has no continuum."""
        if self._continuum is None:
            return np.zeros((1, 1, 1))
        return self._continuum(wavenumber, pressure[:, None, None], temperature[:, None], h2o_fraction)


class MixedLineSource(LineSource):
    """A gas summed line by line where its lines mix."""

    @property
    def provenance(self) -> str:
        """The line list, and how its lines are coupled; there is no continuum."""
        return f"{self._library.provenance}; {line_mixing.SOURCE}"

    def covers(self, low: float, high: float) -> bool:
        """Whether the lines mix in [low, high] cm^-1."""
        return low >= line_mixing.RANGE[0] and high <= line_mixing.RANGE[1] and super().covers(low, high)
