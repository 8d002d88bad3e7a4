"""The gases of the band model: their lines, line shapes, continua and the columns that make a line matter."""

from __future__ import annotations

import functools
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.spectroscopy import line_mixing, linebyline
from skyshine.mat.spectroscopy.lines import LineList, merge_lines, read_lines
from skyshine.schemas.arrays import Booleans, Floats
from skyshine.schemas.errors import InputError

LONGEST_COLUMN = 300e3 * 2.5e25  # molecules of air m^-2: 300 km at sea level
NEGLIGIBLE_DEPTH = 1e-4  # lines weaker than this at their centre on that path are omitted
MIXING = "CO2"
HITRAN = "HITRAN2012 lines (Rothman et al. 2013, JQSRT 130, 4); partition sums TIPS-2021 (Gamache et al. 2021)"


@dataclass(frozen=True)
class Gas:
    """What the line-by-line sum needs to know of a gas.

    Attributes
    ----------
    molecule : int
        HITRAN number; 0 where there are no lines but measured cross sections.
    largest_fraction : float
        Largest mole fraction along a 300 km path that has to be right; sets which lines are kept.
    self_fraction : float
        Typical mole fraction, for self broadening (H2O: of its own, an axis of the table).
    """

    name: str
    molecule: int
    largest_fraction: float
    self_fraction: float = 0.0
    shape: int = linebyline.PLAIN


GASES = {
    gas.name: gas
    for gas in (
        Gas("H2O", 1, 2e-2, shape=linebyline.PEDESTAL_REMOVED),
        Gas("CO2", 2, 1e-3, 4e-4, shape=linebyline.SUB_LORENTZIAN),
        Gas("CH4", 6, 4e-6),
        Gas("O3", 3, 3e-7),
        Gas("N2O", 4, 6e-7),
        Gas("CO", 5, 1e-6),
        Gas("O2", 7, 0.21, 0.21),
        Gas("N2", 22, 0.78, 0.78),
        Gas("HNO3", 12, 2e-9),
        Gas("NO2", 10, 5e-8),
        Gas("SO2", 9, 5e-8),
        Gas("CFC-11", 0, 3e-10),
        Gas("CFC-12", 0, 6e-10),
        Gas("HCFC-22", 0, 5e-10),
        Gas("CCl4", 0, 2e-10),
    )
}


def _mixing(name: str, wavenumber: Floats) -> Booleans:
    """Where lines of a gas are not summed one by one, because they mix."""
    low, high = line_mixing.RANGE
    return np.asarray((name == MIXING) & (wavenumber >= low) & (wavenumber <= high), bool)


class LineLibrary:
    """The line lists of a folder; files are named after the HITRAN molecule number: ``01_*.par``, ``.par.gz``,
    ``.par.xz``.

    Attributes
    ----------
    provenance, terms : str
        Provenance and terms of the lines, as tables name them.
    """

    provenance, terms = HITRAN, "figures computed from HITRAN, which asks to be cited (Rothman et al. 2013)"
    needed: tuple[str, ...] = ("H2O", "CO2")

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)
        self._lists: dict[str, tuple[LineList, list[tuple[float, float]]]] = {}
        if not self.folder.is_dir():
            raise InputError("is not a folder; --lines needs the folder of the HITRAN records", file=folder)

    @functools.cached_property
    def gases(self) -> list[Gas]:
        """The gases whose lines are here, in the order of the HITRAN numbers."""
        listed = [gas for gas in GASES.values() if gas.molecule and self._paths(gas)]
        missing = [name for name in self.needed if GASES[name] not in listed]
        if missing:
            raise InputError(f"has no line list of {', '.join(missing)} (files 01_*.par, 02_*.par)", file=self.folder)
        return sorted(listed, key=lambda gas: gas.molecule)

    def _paths(self, gas: Gas) -> list[Path]:
        return sorted(self.folder.glob(f"{gas.molecule:02d}_*.par*"))

    def _read(self, name: str) -> tuple[LineList, list[tuple[float, float]]]:
        """The lines that matter on the longest column, and the first and last wavenumber of each file."""
        if name not in self._lists:
            self._lists[name] = self._read_files(name)
        return self._lists[name]

    def _read_files(self, name: str) -> tuple[LineList, list[tuple[float, float]]]:
        gas = GASES[name]
        paths = self._paths(gas)
        if not paths:
            raise InputError(f"has no line list of {name} (a file {gas.molecule:02d}_*.par)", file=self.folder)
        lists = [read_lines(path) for path in paths]
        spans = [(part.wavenumber[0], part.wavenumber[-1]) for part in lists]
        lines = merge_lines(lists)
        return lines.select(strongest(lines) * gas.largest_fraction * LONGEST_COLUMN > NEGLIGIBLE_DEPTH), spans

    @functools.cached_property
    def _mixed(self) -> line_mixing.MixedLines:
        return line_mixing.MixedLines(line_mixing.read_bands(self._paths(GASES[MIXING])))

    def _single(self, name: str, low: float, high: float) -> LineList:
        """As `near`, without the lines of the bands that mix."""
        lines = self.near(name, low, high)
        return lines.select(~self._mixed.includes(lines))

    def interval_spectrum(
        self,
        name: str,
        low: float,
        high: float,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        self_fraction: float,
    ) -> Floats:
        """Cross sections (P, T, K) of a gas's lines on the fine grid of an interval, m2/molecule.

        Arguments as `linebyline.interval_spectrum`.
        """
        mixing = _mixing(name, linebyline.interval_grid(low, high))
        air, shape = (low, high, pressure, temperature, self_fraction), GASES[name].shape
        if not mixing.any():
            return linebyline.interval_spectrum(self.near(name, low, high), *air, shape)
        out = linebyline.interval_spectrum(self._single(name, low, high), *air, shape)
        out += self._mixed.cross_sections(linebyline.interval_grid(low, high), pressure, temperature)
        if not mixing.all():
            out[..., ~mixing] = linebyline.interval_spectrum(self.near(name, low, high), *air, shape)[..., ~mixing]
        return out

    def point_cross_sections(
        self,
        name: str,
        wavenumber: Floats,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        self_fraction: float,
    ) -> Floats:
        """Cross sections (P, T, K) of a gas's lines at wavenumbers (K,), m2/molecule.

        Arguments as `linebyline.point_cross_sections`.
        """
        mixing = _mixing(name, wavenumber)
        out = np.zeros((np.size(pressure), np.size(temperature), wavenumber.size))
        for mask, source in ((~mixing, self.near), (mixing, self._single)):
            if mask.any():
                at = wavenumber[mask]
                lines = source(name, at.min(), at.max())
                out[..., mask] = linebyline.point_cross_sections(
                    lines, at, pressure, temperature, self_fraction, GASES[name].shape
                )
        if mixing.any():
            out[..., mixing] += self._mixed.cross_sections(wavenumber[mixing], pressure, temperature)
        return out

    def lines(self, name: str) -> LineList:
        """The lines of a gas that matter on the longest column.

        Raises
        ------
        InputError
            The folder has no line list of this gas.
        """
        return self._read(name)[0]

    def covers(self, name: str, low: float, high: float) -> bool:
        """Whether [low, high] cm^-1 overlaps the lines of a file; a file counts as complete from its first line to its
        last.
        """
        return any(start < high and stop > low for start, stop in self._read(name)[1])

    def near(self, name: str, low: float, high: float) -> LineList:
        """The lines of a gas that reach into [low, high] cm^-1 (a pressure shift's width is added)."""
        margin = linebyline.CUT_OFF + 0.5
        return self.lines(name).between(low - margin, high + margin)


class GeneratedLibrary(LineLibrary):
    """Lists of `python -m mat.maintain.lines generate`, for gases of which the user's lists have no lines."""

    provenance = (
        "lines generated from published constants and band strengths (mat.maintain.lines.rotors); partition sums"
        " TIPS-2021 (Gamache et al. 2021)"
    )
    terms = "figures computed from published constants, to be cited"
    needed = ()


def strongest(lines: LineList) -> Floats:
    """Largest cross section at the line centre, m2/molecule, from 200 to 330 K at a width of 0.05 cm^-1; (N,) for N
    lines.
    """
    strength, _, _ = linebyline.line_parameters(lines, np.array([200.0, 330.0]))
    largest = np.maximum(strength.max(0), lines.strength * linebyline.CM2_TO_M2)
    return np.asarray(largest / (np.pi * 0.05))
