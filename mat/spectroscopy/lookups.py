"""Gases without line lists: representative cross sections of REPTRAN, shaped within its bands by LOWTRAN7.

REPTRAN (Gasteiger et al. 2014, JQSRT 148, 99) gives, in bands of 15 cm^-1, a few representative wavelengths with
weights and the cross sections of each gas there over pressure and temperature (from HITRAN2004). Where in the band
an absorption lies is not known any more, so the representatives are spread evenly over the fine grid of an interval:
the gas is then uncorrelated with the lines of the others. How absorption changes between the intervals of one band
follows the 5 cm^-1 parameters of LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177).
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.mat.spectroscopy import linebyline, nodes
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

STEM = "reptran_thermal_coarse"
UNIT = 1e-20  # m2, of the lookups
SHAPE_LIMITS = (0.2, 5.0)  # shape limits of an interval's share in its band
# A band's representatives contain its variety already: the shape may change the transmittance of the band by this much
# through the whole atmosphere, and is flattened where it would change it more.
SHAPE_EFFECT = 0.005
# That atmosphere: column [m^-2] and the pressure [Pa] and temperature [K] where most of it is. O3: 350 Dobson units of
# 2.687e20 m^-2; N2O: 0.33 ppmv of the 2.15e29 m^-2 of air above sea level.
WHOLE_COLUMN = {"O3": (9.4e22, 50e2, 220.0), "N2O": (7.1e22, 500e2, 250.0)}
# Fractional steps of the sequences that spread representatives: the inverse golden ratio, and the square root of 2,
# less 1.
_SPREAD = {"O3": (5**0.5 - 1) / 2, "N2O": 2**0.5 - 1}
TEXT = (
    "REPTRAN lookups (Gasteiger et al. 2014, JQSRT 148, 99; HITRAN2004 lines), 15 cm-1 bands, shaped by the 5 cm-1"
    " parameters of LOWTRAN7 (Kneizys et al. 1988)"
)


class LookupSource:
    """A gas from the REPTRAN lookups of a folder and the Fortran source of LOWTRAN7.

    Raises
    ------
    InputError
        A file is missing or lacks what it should contain.
    """

    provenance = TEXT
    terms = "figures derived from published lookups, to be cited; LOWTRAN7 is a work of the US Government"

    def __init__(self, name: str, folder: str | os.PathLike[str], lowtran: str | os.PathLike[str]) -> None:
        self.name = name
        folder = Path(folder)
        bands, lookup = _variables(folder / f"{STEM}.cdf"), _variables(folder / f"{STEM}.lookup.{name}.cdf")
        self._low, self._high = 1e7 / bands["wvlmax"], 1e7 / bands["wvlmin"]
        self._members, self._weights = bands["iwvl"].astype(int), bands["iwvl_weight"]
        self._count = bands["nwvl_in_band"].astype(int)
        self._row = {int(index): row for row, index in enumerate(lookup["wvl_index"])}
        self._lookup = lookup
        self._shape = band_parameters(lowtran, name)

    def covers(self, low: float, high: float) -> bool:
        """Whether a band contains all of [low, high] cm^-1."""
        return self._containing(low, high).size > 0

    def _containing(self, low: float, high: float) -> Integers:
        """Numbers of the bands that cover all of [low, high] cm^-1."""
        return np.flatnonzero((self._low <= low + 0.01) & (self._high >= high - 0.01))

    def spectrum(self, wavenumber: Floats, low: float, high: float) -> Floats:
        """Cross sections (P, T, K) on the fine grid of an interval, m2/molecule."""
        table, member = self._members_at(wavenumber, low, high)
        return np.asarray(np.moveaxis(table, 0, -1)[..., member])

    def moist_spectrum(self, wavenumber: Floats, low: float, high: float) -> None:
        """None: water vapour's amount changes nothing."""

    def points(self, wavenumber: Floats, low: float, high: float) -> tuple[Floats, None]:
        """Cross sections (K, P, T) at wavenumbers of the fine grid, m2/molecule; water vapour's amount changes
        nothing.
        """
        table, member = self._members_at(wavenumber, low, high)
        return table[member], None

    def _members_at(self, wavenumber: npt.ArrayLike, low: float, high: float) -> tuple[Floats, Integers]:
        """Cross sections (M, P, T) of the representatives of an interval, and the one at each wavenumber (K,)."""
        band = int(self._containing(low, high)[0])
        count = self._count[band]
        members, weights = self._members[:count, band], self._weights[:count, band]
        step = (high - low) / linebyline.interval_grid(low, high).size
        position = np.rint((np.asarray(wavenumber) - low) / step - 0.5)
        share = np.cumsum(weights / weights.sum())
        member = np.searchsorted(share, (position * _SPREAD[self.name]) % 1.0)
        table = np.array([self._at_nodes(int(index)) for index in members]) * self._share(band, low, high)
        return table, np.minimum(member, count - 1)

    def _at_nodes(self, index: int) -> Floats:
        """Cross sections (P, T) of one representative at the nodes; zero where the lookup has no entry for the gas."""
        if index not in self._row:
            return np.zeros((nodes.PRESSURE.size, nodes.TEMPERATURE.size))
        values = np.log(np.maximum(self._lookup["xsec"][:, 0, self._row[index], :] * UNIT, 1e-45))
        offsets, reference = self._lookup["t_pert"], self._lookup["t_ref"]
        by_level = np.array(
            [np.interp(nodes.TEMPERATURE - t, offsets, v) for t, v in zip(reference, values.T, strict=True)]
        )
        order = np.argsort(self._lookup["pressure"])
        pressure = np.log(self._lookup["pressure"][order])
        columns = [np.interp(np.log(nodes.PRESSURE), pressure, column) for column in by_level[order].T]
        return np.asarray(np.exp(np.array(columns).T))

    def _share(self, band: int, low: float, high: float) -> float:
        """Absorption of an interval over that of its band, from LOWTRAN7's parameters at the interval's edges."""
        edges = np.arange(np.rint(self._low[band]), np.rint(self._high[band]) + 1, 5.0)
        values = np.array([self._shape.get(int(v), 0.0) for v in edges])
        if np.any(values <= 0):
            return 1.0
        at_edges = np.mean(np.interp((low, high), edges, values))
        parts = 0.5 * (values[1:] + values[:-1])
        shares = np.clip(np.append(at_edges, parts) / np.mean(parts), *SHAPE_LIMITS)
        return float(1 + (shares[0] - 1) * self._steepness(band, shares[1:]))

    def _steepness(self, band: int, shares: Floats) -> float:
        """How much of its departures from 1 the shape of a band keeps, 0 to 1: 1 where it changes too little to
        matter.
        """
        column, pressure, temperature = WHOLE_COLUMN[self.name]
        node = np.abs(np.log(nodes.PRESSURE / pressure)).argmin(), np.abs(nodes.TEMPERATURE - temperature).argmin()
        count = self._count[band]
        depth = column * np.array([self._at_nodes(int(index))[node] for index in self._members[:count, band]])
        weight = self._weights[:count, band] / self._weights[:count, band].sum()

        def excess(part: float) -> float:
            shaped = np.mean([weight @ np.exp(-(1 + (share - 1) * part) * depth) for share in shares])
            return float(abs(shaped - weight @ np.exp(-depth)) - SHAPE_EFFECT)

        return 1.0 if excess(1.0) <= 0 else float(scipy.optimize.brentq(excess, 0.0, 1.0, xtol=1e-6))


def band_parameters(lowtran: str | os.PathLike[str], name: str) -> dict[int, float]:
    """LOWTRAN7's absorption parameter C' of a gas by wavenumber (cm^-1, every 5), read from its Fortran source."""
    try:
        text = Path(lowtran).read_text(encoding="latin-1")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; --lowtran needs lowtran7.f", file=lowtran) from None
    joined = re.sub(r"\n {5}\S", " ", re.sub(r"(?m)^[Cc*!].*\n", "", text))
    numbers = re.compile(r"[-+]?\d*\.?\d+")
    lows = _data(joined, rf"IWL{name}", lowtran)
    highs = _data(joined, rf"IWH{name}", lowtran)
    values: list[float] = []
    for block in re.findall(rf"DATA\s+C\d+{name}\s*/([^/]*)/", joined):
        values += [float(number) for number in numbers.findall(block)]
    wavenumbers = [
        v for low, high in zip(lows, highs, strict=True) if low >= 0 for v in range(int(low), int(high) + 1, 5)
    ]
    if len(values) != len(wavenumbers):
        raise InputError(f"has {len(values)} parameters of {name} for {len(wavenumbers)} wavenumbers", file=lowtran)
    return {v: 10.0**value for v, value in zip(wavenumbers, values, strict=True)}


def _data(text: str, name: str, path: str | os.PathLike[str]) -> list[float]:
    """Numbers of a DATA statement in Fortran text whose continuation lines are joined."""
    statement = re.search(rf"DATA\s+{name}\s*/([^/]*)/", text)
    if statement is None:
        raise InputError(f"has no DATA of {name}; --lowtran needs lowtran7.f", file=path)
    return [float(number) for number in statement.group(1).split(",")]


def _variables(path: Path) -> dict[str, npt.NDArray[Any]]:
    import netCDF4

    try:
        with netCDF4.Dataset(path) as file:
            return {name: np.asarray(v[...]) for name, v in file.variables.items()}
    except OSError as error:
        raise InputError(
            f"cannot be read: {error}; --lookups needs the folder of the REPTRAN files", file=path
        ) from None
