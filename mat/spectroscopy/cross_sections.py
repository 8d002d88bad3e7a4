"""Measured cross sections of gases without lines: heavy molecules in the infrared, ultraviolet and visible bands.

A folder contains ``xs/*.gz``, tables at one temperature each in the format of the AER collection (a line of name, first
and last wavenumber, number of values, temperature; then the values in cm2, ten a line), and
``crs_*_UBremen_cf.dat.gz``, second-degree polynomials in temperature at wavelengths in air. Outside the measured
temperatures the nearest one is used: a polynomial fit is never continued.
"""

from __future__ import annotations

import gzip
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.path_states import PathState
from skyshine.mat.atmosphere.transfer.geometry import refractivity
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.spectroscopy import linebyline, nodes
from skyshine.mat.spectroscopy.gases import GASES, LONGEST_COLUMN
from skyshine.mat.spectroscopy.intervals import PRESENT
from skyshine.mat.spectroscopy.linebyline import CM2_TO_M2
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Names in the headers of the tables, names here, and who measured.
TABLES = {
    "HNO3": ("HNO3", "sums of HITRAN2004 lines at 250 hPa (AER, LBLRTM 9.2)"),
    "CCl3F": ("CFC-11", "S. T. Massie, A. Goldman et al., NCAR, as in HITRAN 1992"),
    "CCl2F2": ("CFC-12", "S. T. Massie, A. Goldman et al., NCAR, as in HITRAN 1992"),
    "CHClF2": ("HCFC-22", "S. T. Massie, A. Goldman et al., NCAR, as in HITRAN 1992"),
    "CCl4": ("CCl4", "University of Denver 1985, 296 K alone, as in HITRAN 1992"),
}
FITS = {"O3": "crs_O3_UBremen_cf.dat.gz", "NO2": "crs_NO2_UBremen_cf.dat.gz", "SO2": "crs_SO2_UBremen_cf.dat.gz"}
FIT_TEXT = (
    "cross sections of K. Bogumil, J. Orphal and J. P. Burrows, University of Bremen (J. Photochem. Photobiol. A 157"
    " (2003) 167)"
)
FIT_REFERENCE = ZERO_CELSIUS  # fit reference of the polynomials
FIT_RANGE = (203.0, 293.0)  # K, the measurements the polynomials were fitted to (Bogumil et al. 2003)
FIT_UNIT = 1e-20  # cm2

_Table = tuple[float, Floats, Floats]  # temperature [K], wavenumbers (K,) [cm^-1], cross sections (K,) [m2]


@dataclass(frozen=True)
class Measurements:
    """Tables of one band: wavenumber (K,) cm^-1 increasing, temperature (T,) K increasing, section (T, K)
    m2/molecule.
    """

    wavenumber: Floats
    temperature: Floats
    section: Floats

    def at(self, wavenumber: Floats, temperature: Floats) -> Floats:
        """Cross sections (T', K'), linear in wavenumber and temperature; zero outside the band, constant outside the
        temperatures.
        """
        columns = np.array([np.interp(wavenumber, self.wavenumber, row, left=0.0, right=0.0) for row in self.section])
        position = np.interp(temperature, self.temperature, np.arange(self.temperature.size))
        lower = np.minimum(position.astype(int), max(self.temperature.size - 2, 0))
        upper = np.minimum(lower + 1, self.temperature.size - 1)
        share = (position - lower)[:, None]
        return np.asarray((1 - share) * columns[lower] + share * columns[upper])


@dataclass(frozen=True)
class Fit:
    """Polynomials: wavenumber (K,) cm^-1 increasing, coefficients (3, K) of powers of T - 273.15 K, m2/molecule."""

    wavenumber: Floats
    coefficients: Floats

    def at(self, wavenumber: Floats, temperature: Floats) -> Floats:
        """Cross sections (T', K'), linear in wavenumber, zero outside the band; temperatures are clipped to
        `FIT_RANGE`, and cross sections to 0.
        """
        away = np.clip(np.asarray(temperature, float), *FIT_RANGE)[:, None] - FIT_REFERENCE
        terms = [np.interp(wavenumber, self.wavenumber, row, left=0.0, right=0.0) for row in self.coefficients]
        return np.asarray(np.maximum(terms[0] + terms[1] * away + terms[2] * away**2, 0.0))


class CrossSectionSource:
    """All measured bands of one gas."""

    terms = "published measurements, to be cited; the figures here are means over intervals derived from them"

    def __init__(self, name: str, bands: Sequence[Measurements | Fit], provenance: str) -> None:
        self.name, self.bands, self.provenance = name, list(bands), provenance

    def covers(self, low: float, high: float) -> bool:
        """Whether a band overlaps [low, high] cm^-1."""
        return bool(any(band.wavenumber[0] < high and band.wavenumber[-1] > low for band in self.bands))

    def at(self, wavenumber: npt.ArrayLike, temperature: npt.ArrayLike) -> Floats:
        """Cross sections in m2/molecule at wavenumbers (K,) cm^-1, increasing, and temperatures (T,) K; (T, K)."""
        temperature = np.atleast_1d(np.asarray(temperature, float))
        wavenumber = np.asarray(wavenumber, float)
        return np.asarray(sum(band.at(wavenumber, temperature) for band in self.bands))


def read_cross_sections(folder: str | os.PathLike[str]) -> list[CrossSectionSource]:
    """The gases of a folder.

    Raises
    ------
    InputError
        The folder contains none of the tables, or a file is damaged.
    """
    folder = Path(folder)
    tables: dict[str, dict[tuple[float, int], list[_Table]]] = {}
    for path in sorted((folder / "xs").glob("*.gz")):
        name, wavenumber, temperature, section = read_table(path)
        if name in TABLES:
            tables.setdefault(name, {}).setdefault((wavenumber[0], wavenumber.size), []).append(
                (temperature, wavenumber, section)
            )
    sources = []
    for formula, bands in tables.items():
        name, who = TABLES[formula]
        text = f"measured cross sections: {who}; collection of AER"
        sources.append(CrossSectionSource(name, [_band(members) for members in bands.values()], text))
    for name, file in FITS.items():
        if (folder / file).exists():
            sources.append(CrossSectionSource(name, [read_fit(folder / file)], FIT_TEXT))
    if not sources:
        raise InputError(
            "contains no cross sections (xs/*.gz, crs_*_UBremen_cf.dat.gz); --cross-sections needs their folder",
            file=folder,
        )
    return sorted(sources, key=lambda source: source.name)


def _band(members: list[_Table]) -> Measurements:
    members = sorted(members, key=lambda member: member[0])
    return Measurements(members[0][1], np.array([m[0] for m in members]), np.array([m[2] for m in members]))


def read_table(path: Path) -> tuple[str, Floats, float, Floats]:
    """Name of the molecule, wavenumbers (K,) cm^-1, temperature in K and cross sections (K,) m2 of a table.

    Negative values, which are noise around 0, become 0.
    """
    lines = _text(path).splitlines()
    try:
        head = lines[0]
        name, count, temperature = head[:10].strip(), int(head[30:40]), float(head[40:50])
        wavenumber = np.linspace(float(head[10:20]), float(head[20:30]), count)
        values = np.array([float(line[i : i + 10]) for line in lines[1:] for i in range(0, len(line.rstrip()), 10)])
        if values.size < count:
            raise ValueError(f"{values.size} values instead of {count}")
    except (IndexError, ValueError) as error:
        raise InputError(f"is not a table of cross sections ({error})", file=path) from None
    return name, wavenumber, temperature, np.maximum(values[:count], 0.0) * CM2_TO_M2


def read_fit(path: Path) -> Fit:
    """Polynomials of a file of wavelengths (nm, in air) and three coefficients."""
    try:
        rows = np.loadtxt(_text(path).splitlines(), comments="#", ndmin=2)
        wavelength, coefficients = rows[:, 0], rows[:, 1:4].T
    except (IndexError, ValueError) as error:
        raise InputError(f"is not a table of wavelengths and three coefficients ({error})", file=path) from None
    near = 1e7 / wavelength
    wavenumber = near / (1 + refractivity(near))  # vacuum; the index at the wavelength in air is right to 1e-8
    order = np.argsort(wavenumber)
    return Fit(wavenumber[order], coefficients[:, order] * FIT_UNIT * CM2_TO_M2)


def _text(path: Path) -> str:
    try:
        with gzip.open(path, "rt", encoding="latin-1") as file:
            return file.read()
    except (OSError, EOFError) as error:
        raise InputError(f"cannot be read: {error}; --cross-sections needs gzip files", file=path) from None


def spread(section: Floats, grid: Floats, wavenumber: Floats, weight: Floats) -> Floats:
    """Cross sections at the points of an interval whose weighted distribution is that of the whole interval.

    The points are put in the order of the cross section at their places; each then has the mean over the share of the
    sorted cross sections that its weight represents. So the interval's mean is exact, whatever the points were chosen
    for.

    Parameters
    ----------
    section : (T, K) array, m2/molecule, on a fine even grid (K,) cm^-1 of the interval
    grid : (K,) array
    wavenumber, weight : (n,) arrays, of the points

    Returns
    -------
    (n, T) array, m2/molecule
    """
    local = np.interp(wavenumber, grid, section.mean(axis=0))
    order = np.argsort(local, kind="stable")
    edges = np.concatenate([[0.0], np.cumsum(weight[order])]) / weight.sum()
    steps = np.linspace(0.0, 1.0, grid.size + 1)
    result = np.empty((wavenumber.size, len(section)))
    for t, row in enumerate(np.sort(section, axis=1)):
        integral = np.interp(edges, steps, np.concatenate([[0.0], np.cumsum(row)]) / grid.size)
        result[order, t] = np.diff(integral) / np.diff(edges)
    return np.asarray(np.maximum(result, 0.0))


def overlay(
    source: CrossSectionSource,
    low: float,
    high: float,
    wavenumber: Floats,
    weight: Floats,
    states: Sequence[PathState],
) -> tuple[Floats | None, float]:
    """Cross sections of a gas at the points of [low, high] cm^-1, and their error.

    Parameters
    ----------
    wavenumber, weight : (n,) arrays, cm^-1
    states : list of PathState
        Held-out atmospheres and paths.

    Returns
    -------
    section : (n, P, T) array, m2/molecule, or None where the gas is negligible
    error : float
        rms error of the interval's transmittance by this gas alone, against the cross sections on a fine grid.
    """
    grid = linebyline.interval_grid(low, high)
    fine = source.at(grid, nodes.TEMPERATURE)
    if fine.max() * GASES[source.name].largest_fraction * LONGEST_COLUMN <= PRESENT:
        return None, 0.0
    section = spread(fine, grid, wavenumber, weight)
    errors = [_errors(fine, section.T, weight / weight.sum(), state, source.name) for state in states]
    shape = (wavenumber.size, nodes.PRESSURE.size, nodes.TEMPERATURE.size)
    rms = float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
    return np.broadcast_to(section[:, None, :], shape), rms


def _errors(fine: Floats, reduced: Floats, weight: Floats, state: PathState, gas: str) -> Floats:
    """Error (R,) of the mean transmittance on each path of a state whose transmittances by single gases are targets."""
    position = np.interp(state.temperature, nodes.TEMPERATURE, np.arange(nodes.TEMPERATURE.size))
    lower = np.minimum(position.astype(int), nodes.TEMPERATURE.size - 2)
    share = (position - lower)[:, None]
    columns = state.columns[state.apart] * state.fraction[gas]
    means = []
    for table, shares in ((fine, None), (reduced, weight)):
        depth = columns @ ((1 - share) * table[lower] + share * table[lower + 1])
        means.append(np.average(np.exp(-depth), axis=1, weights=shares))
    return np.asarray(means[1] - means[0])
