"""Monochromatic spectral points: absorption summed line by line at every wavenumber of a fine grid.

They take the place of the band model's points where a spectrum is wanted finer than its intervals. Gases without line
lists over the whole range (and the water vapour continuum, which is smooth) come from the band model, as the mean cross
section of each of its intervals: true where a gas absorbs evenly, too opaque where its lines are far apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, SpectralPoints
from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.continua import ContinuumModel
from skyshine.mat.spectroscopy.gases import GASES, LineLibrary
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError

FINEST = 0.01  # cm^-1, of a bin; lines of the lower air are wider
MOST_POINTS = 5_000_000  # largest number of points of a line-by-line grid, for memory: 40 MB an array


@dataclass(frozen=True)
class LineByLinePoints(SpectralPoints):
    """Points on the reference grid of each bin; `interval` and `interval_edges` are those of the bins.

    Attributes
    ----------
    summed : tuple of str
        Gases whose lines are summed.
    """

    summed: tuple[str, ...]
    _band: SpectralPoints
    _library: LineLibrary
    _continua: ContinuumModel
    _cache: dict[tuple[str, int, bytes], Floats]

    @classmethod
    def of(
        cls, band: SpectralPoints, library: LineLibrary, continua: ContinuumModel, low: float, high: float, width: float
    ) -> LineByLinePoints:
        """Points of bins of a width that cover a range from its lower end on.

        Parameters
        ----------
        band : SpectralPoints
            Points of the band model, over the same range.
        continua : ContinuumModel
            Continua of single gases; the continuum of water vapour is that of `band`.
        low, high, width : float
            [cm^-1]; the last bin may reach beyond `high`, but not beyond the band's last interval.

        Raises
        ------
        InputError
            A width below `FINEST`, one that no whole number of bins fits, or more than `MOST_POINTS` points.
        """
        count = (high - low) / width
        if not (width >= FINEST and round(count) >= 1 and abs(count - round(count)) < 1e-6 * max(count, 1.0)):
            raise InputError(
                f"found the resolution {width:g} cm-1 for {low:g} to {high:g} cm-1; allowed: a whole number of bins of"
                f" at least {FINEST:g} cm-1; change resolution or limits"
            )
        if (high - low) / linebyline.fine_step(low) > MOST_POINTS:
            raise InputError(
                f"line by line, {low:g} to {high:g} cm-1 take more than {MOST_POINTS} points; allowed: a narrower range"
            )
        edges = low + (high - low) * np.arange(round(count) + 1) / round(count)
        bins = np.stack([edges[:-1], edges[1:]], axis=1)
        grids = [linebyline.interval_grid(float(a), float(b)) for a, b in bins]
        number = np.repeat(np.arange(len(grids)), [grid.size for grid in grids])
        wavenumber = np.concatenate(grids)
        order = np.argsort(band.wavenumber, kind="stable")
        continuum = np.array([np.interp(wavenumber, band.wavenumber[order], row[order]) for row in band._continuum])
        listed = [gas.name for gas in library.gases if gas.name in band.gases]
        return cls(
            wavenumber=wavenumber,
            weight=((bins[:, 1] - bins[:, 0]) / np.bincount(number))[number],
            interval=number,
            interval_edges=bins,
            _continuum=continuum,
            _gases=band._gases,
            _nodes=band._nodes,
            _humid_nodes=band._humid_nodes,
            summed=tuple(name for name in listed if _covered(library, name, band)),
            _band=band,
            _library=library,
            _continua=continua,
            _cache={},
        )

    @property
    def absorbing(self) -> list[str]:
        """The gases that absorb in the range."""
        return list(dict.fromkeys([*self.summed, *self._band.absorbing]))

    def subset(self, index: Integers | Booleans, weight: npt.ArrayLike | None = None) -> LineByLinePoints:
        """The points at `index` (k,), with other weights if given; the bins keep their numbers."""
        chosen: Integers = np.flatnonzero(index) if index.dtype == bool else np.asarray(index, np.int64)
        return replace(
            self,
            wavenumber=self.wavenumber[chosen],
            weight=self.weight[chosen] if weight is None else np.asarray(weight, float),
            interval=self.interval[chosen],
            _continuum=self._continuum[:, chosen],
        )

    def cross_sections(
        self,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_mole_fraction: npt.ArrayLike,
        gases: Sequence[str] | None = None,
    ) -> dict[str, Floats]:
        """As `SpectralPoints.cross_sections`; (L, P) arrays, m2/molecule."""
        pressure, temperature, fraction = self._checked(pressure, temperature, h2o_mole_fraction)
        requested = self.gases if gases is None else list(gases)
        even = [name for name in requested if name not in self.summed and name != CONTINUUM]
        result = self._of_intervals(pressure, temperature, fraction, even)
        if CONTINUUM in requested:
            result |= self._water_continuum(pressure, temperature, fraction)
        levels = pressure, temperature, fraction
        for name in (name for name in requested if name in self.summed):
            section = np.empty((pressure.size, self.wavenumber.size))
            for number in np.unique(self.interval):
                inside = self.interval == number
                grid = linebyline.interval_grid(*map(float, self.interval_edges[number]))
                spectrum = self._summed_lines(name, int(number), *levels)
                section[:, inside] = spectrum[:, np.searchsorted(grid, self.wavenumber[inside])]
            result[name] = section
        return {name: result[name] for name in requested}

    def _summed_lines(self, name: str, number: int, pressure: Floats, temperature: Floats, humidity: Floats) -> Floats:
        """Cross sections (L, K) of a gas on the grid of a bin; those of the last two bins are kept."""
        key = name, number, pressure.tobytes() + temperature.tobytes() + humidity.tobytes()
        if key not in self._cache:
            for old in [old for old in self._cache if old[1] < number - 1]:
                del self._cache[old]
            gas, (low, high) = GASES[name], map(float, self.interval_edges[number])
            grid = linebyline.interval_grid(low, high)
            rows = []
            for p, t, q in zip(pressure, temperature, humidity, strict=True):
                self_fraction = float(q) if name == "H2O" else gas.self_fraction
                row = self._library.interval_spectrum(name, low, high, [p], [t], self_fraction)[0, 0]
                if name in self._continua.by_gas:
                    row = row + self._continua.by_gas[name](grid, float(p), float(t), float(q))
                rows.append(row)
            self._cache[key] = np.array(rows)
        return self._cache[key]

    def _of_intervals(
        self, pressure: Floats, temperature: Floats, fraction: Floats, gases: Sequence[str]
    ) -> dict[str, Floats]:
        """Mean cross sections of the band model's intervals at the points, (L, P) by gas."""
        band = self._band
        number = np.clip(np.searchsorted(band.interval_edges[:, 1], self.wavenumber), 0, len(band.interval_edges) - 1)
        needed = np.flatnonzero(np.isin(band.interval, np.unique(number)))
        points = band.subset(needed)
        share = points.weight / np.bincount(points.interval, points.weight)[points.interval]
        means: dict[str, Floats] = {}
        for name, section in points.cross_sections(pressure, temperature, fraction, gases=gases).items():
            sums = np.stack([np.bincount(points.interval, share * row, len(band.interval_edges)) for row in section])
            means[name] = sums[:, number].astype(float)
        return means

    def _water_continuum(self, pressure: Floats, temperature: Floats, fraction: Floats) -> dict[str, Floats]:
        return super().cross_sections(pressure, temperature, fraction, gases=[CONTINUUM])


def _covered(library: LineLibrary, name: str, band: SpectralPoints) -> bool:
    """Whether the lines of a gas were recorded over all of the band's intervals in which the band model has the gas."""
    present = np.unique(band.interval[band._gases[name].position])
    return present.size > 0 and all(library.covers(name, *map(float, band.interval_edges[i])) for i in present)
