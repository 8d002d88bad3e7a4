"""The band model of gas absorption: spectral points, weights and cross sections, read from the absorption table.

In each interval of a few cm^-1 a handful of monochromatic points with weights represents the interval's mean; at a
point Beer's law is exact, for mixtures of gases and inhomogeneous paths alike. The table is made by
`skyshine.mat.spectroscopy`. This is the one module of the folder that reads files.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise

import h5py
import numpy as np
import numpy.typing as npt

from skyshine import atmospheres
from skyshine.mat.atmosphere.gases.reference_spectra import ReferenceSpectra
from skyshine.mat.atmosphere.gases.spectral_points import CrossSectionNodes, GasPoints, SpectralPoints
from skyshine.schemas.arrays import Floats, Integers, Singles
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import open_database, sound

FILETYPE = "absorption"
# Water vapour continua that may replace a table's own, at the wavenumbers of their files, with the coefficients
# that differ: one closer to radiation measured in humid air, one for comparison with codes of its time, and one in the
# public domain. Packages built without MT_CKD have the last alone.
WATER_CONTINUA = {
    "mt_ckd_4.3_closure": "continuum/mt_ckd_4.3_closure.csv",
    "mt_ckd_2.4": "continuum/mt_ckd_2.4.csv",
    "lowtran7": "continuum/lowtran7.csv",
}
# Names of the coefficients in the table and, with their units, in the files, in the order of
# `spectral_points.water_continuum`.
COEFFICIENTS = ("self_continuum", "foreign_continuum", "self_exponent")
FIRST_CONTINUUM = "mt_ckd_4.3"  # first continuum of tables that do not name theirs
# Where the table has MT_CKD 4.3. Measured longwave of clear humid nights is 4 to 5 W m^-2 above that with 4.3 and 2
# above that with the foreign continuum for closure; pyrgeometers are good to 2 to 5 (tests/validation/
# test_humid_nights.py, test_payerne.py). MT_CKD 2.4, 1 below, lacks what was measured since in the windows at 4 and 2
# um.
PREFERRED_CONTINUUM = "mt_ckd_4.3_closure"
# Attributes of arrays of logarithms: a value is OFFSET + STEP times the sum of the numbers up to its pressure.
STEP, OFFSET = "step", "offset"
# Codes of a gas in an interval, as the table keeps them; larger codes name the entries of its `sources`.
NO_DATA, NEGLIGIBLE = 0, 1


def available_water_continua(table_continuum: str) -> tuple[str, ...]:
    """Names of the water vapour continua that a table can be opened with, its own first."""
    packaged = [name for name, file in WATER_CONTINUA.items() if atmospheres.path(file).is_file()]
    return tuple(dict.fromkeys([table_continuum, *packaged]))


def check_water_continuum(name: str, table_continuum: str) -> None:
    """Refuse a water vapour continuum that this package does not contain.

    Raises
    ------
    InputError
    """
    available = available_water_continua(table_continuum)
    if name not in available:
        without = "" if FIRST_CONTINUUM in available else "; this package was built without MT_CKD"
        raise InputError(f"found water vapour continuum '{name}'; allowed: {', '.join(available)}{without}")


@lru_cache(maxsize=1)
def packaged_water_continuum() -> str:
    """Name of the water vapour continuum of the packaged table, read once a process."""
    with open_database(atmospheres.path("absorption.h5"), FILETYPE) as file:
        return str(file.attrs.get("water_continuum", FIRST_CONTINUUM))


@lru_cache(maxsize=4)
def _continuum_file(name: str) -> tuple[Floats, dict[str, Floats]]:
    """Wavenumbers (K,) cm^-1 and coefficients (K,) by their names in `COEFFICIENTS`."""
    wavenumber, *columns = read_csv(atmospheres.path(name)).items()
    return np.array(wavenumber[1]), {label.split("[")[0]: np.array(values) for label, values in columns}


@lru_cache(maxsize=1)
def default_water_continuum() -> str:
    """Name of the water vapour continuum that is taken where none is named."""
    packaged = packaged_water_continuum()
    return PREFERRED_CONTINUUM if packaged == FIRST_CONTINUUM else packaged


FINE_TABLE = "absorption_fine.h5"  # narrow intervals beside those of the packaged table


class AbsorptionTable:
    """The absorption table; `open` reads what describes it, `points` the intervals that are asked for.

    `own_continuum` is the name of the table's own water vapour continuum, `water_continuum` of another in its place, or
    None.
    """

    own_continuum: str = FIRST_CONTINUUM
    water_continuum: str | None = None
    _has_fine = False

    def __init__(
        self,
        path: str | os.PathLike[str],
        version: str,
        name: str,
        content: str,
        edges: Floats,
        count: npt.ArrayLike,
        error: Floats,
        sources: dict[str, Integers],
    ) -> None:
        self.path, self.version, self.name, self._content = path, version, name, content
        self.interval_edges, self.count, self.error = edges, np.asarray(count), error
        self._first = np.concatenate([[0], np.cumsum(count)])
        self._source_codes = sources

    @classmethod
    def open(cls, path: str | os.PathLike[str] | None = None, water_continuum: str | None = None) -> AbsorptionTable:
        """Open a table, by default the packaged one.

        Parameters
        ----------
        water_continuum : str, optional
            The table's own, which is the default, or one of `WATER_CONTINUA`.

        Raises
        ------
        InputError
            No continuum has that name, or the file is missing, damaged, of another type or of another format version.
        """
        packaged = path is None
        path = atmospheres.path("absorption.h5") if path is None else path
        with open_database(path, FILETYPE) as file, sound(path):
            about = file["intervals"]
            edges = np.stack([about["low"][()], about["high"][()]], axis=1).astype(float)
            codes = {name: group["source"][()] for name, group in file["gases"].items()}
            error = about["error"][()].astype(float)
            version, label = str(file.attrs["data_version"]), str(file.attrs.get("data_name", ""))
            content = str(file.attrs["content_sha256"])
            table = cls(path, version, label, content, edges, about["count"][()], error, codes)
            table.own_continuum = str(file.attrs.get("water_continuum", FIRST_CONTINUUM))
        table._has_fine = packaged
        return table.with_continuum(water_continuum)

    @property
    def fine(self) -> AbsorptionTable | None:
        """A table of narrow intervals with reference spectra over part of the range, or None."""
        table = _fine_table() if self._has_fine else None
        return None if table is None else table.with_continuum(self.water_continuum)

    @property
    def content(self) -> str:
        """The hash of what the points have, the name of another water vapour continuum than the table's own after it,
        and the same of the table of narrow intervals.
        """
        fine = self.fine
        parts = self._content, self.water_continuum, None if fine is None else fine.content
        return " ".join(part for part in parts if part is not None)

    @property
    def gases(self) -> list[str]:
        """Names of the gases, in the order of the file."""
        return list(self._source_codes)

    @property
    def size(self) -> int:
        """Number of spectral points."""
        return int(self._first[-1])

    @property
    def coverage(self) -> list[tuple[float, float]]:
        """Ranges of wavenumber without gaps, cm^-1."""
        return _merged(self.interval_edges)

    def provenance(self, gas: str) -> list[tuple[float, float, str]]:
        """Where a gas's cross sections come from: (low, high, text) for each range of wavenumber, cm^-1."""
        codes = self._source_codes[gas]
        texts = ["no data", "negligible", *self._texts(gas, "sources")]
        return sorted(
            (low, high, texts[code])
            for code in np.unique(codes)
            for low, high in _merged(self.interval_edges[codes == code])
        )

    def terms(self, gas: str) -> list[str]:
        """Licence or terms of the sources that a gas's cross sections come from, each once."""
        terms = [
            text
            for code, text in enumerate(self._texts(gas, "terms"), start=NEGLIGIBLE + 1)
            if code in self._source_codes[gas]
        ]
        return list(dict.fromkeys(terms))

    def gas_error(self, gas: str) -> Floats:
        """Rms error (I,) of the transmittance of a gas in each interval."""
        with open_database(self.path, FILETYPE) as file, sound(self.path):
            error: Floats = file["gases"][gas]["rms_error"][()].astype(float)
        return error

    def _texts(self, gas: str, name: str) -> list[str]:
        """Texts by the codes of a gas from `NEGLIGIBLE` + 1 on."""
        with open_database(self.path, FILETYPE) as file, sound(self.path):
            return [str(text) for text in file["gases"][gas].attrs.get(name, [])]

    def count_between(self, low: float, high: float) -> int:
        """Number of points in the intervals that overlap [low, high] (cm^-1)."""
        overlapping = (self.interval_edges[:, 1] > low) & (self.interval_edges[:, 0] < high)
        return int(self.count[overlapping].sum())

    def points(
        self, low: float, high: float, choose: Callable[[SpectralPoints], Integers] | None = None
    ) -> SpectralPoints:
        """The points of every interval that overlaps [low, high] (cm^-1).

        Parameters
        ----------
        choose : callable, optional
            Which of them are read, by increasing places among all, of which it gets all but the gases; default: all.

        Raises
        ------
        InputError
            The range is empty, or the table does not cover all of it.
        """
        low, high = float(low), float(high)
        if not low < high:
            raise InputError(f"wavenumbers {low:g} to {high:g} cm^-1 are no range; give low:high with low < high")
        if not any(start <= low and high <= stop for start, stop in self.coverage):
            ranges = ", ".join(f"{start:g} to {stop:g}" for start, stop in self.coverage)
            raise InputError(
                f"wavenumbers {low:g} to {high:g} cm^-1 are not covered by the absorption table; allowed: {ranges}"
                " cm^-1"
            )
        overlapping = np.flatnonzero((self.interval_edges[:, 1] > low) & (self.interval_edges[:, 0] < high))
        start, stop = overlapping[0], overlapping[-1] + 1
        with open_database(self.path, FILETYPE) as file, sound(self.path):
            return self._read(file, start, stop, choose)

    def reference_spectra(self, low: float, high: float) -> ReferenceSpectra:
        """Line-by-line spectra between two wavenumbers [cm^-1] of a table that has them."""
        with open_database(self.path, FILETYPE) as file, sound(self.path):
            return ReferenceSpectra.read(file["reference"], low, high)

    def with_continuum(self, name: str | None = None) -> AbsorptionTable:
        """The same table with the water vapour continuum of a name, by default its own, that of its reference spectra.

        Raises
        ------
        InputError
            No continuum has that name.
        """
        if name is not None:
            check_water_continuum(name, self.own_continuum)
        table = copy(self)
        table.water_continuum = None if name == self.own_continuum else name
        return table

    def in_continuum(self, points: SpectralPoints) -> SpectralPoints:
        """Points of the table with its own continuum, in the one it is opened with."""
        return replace(points, _continuum=self._with_continuum(points.wavenumber, points._continuum))

    def _read(
        self, file: h5py.File, start: int, stop: int, choose: Callable[[SpectralPoints], Integers] | None
    ) -> SpectralPoints:
        begin, end = self._first[start], self._first[stop]
        points = file["points"]
        interval = np.repeat(np.arange(stop - start), np.diff(self._first[start : stop + 1]))
        width = np.diff(self.interval_edges[start:stop], axis=1)[:, 0]
        weight = points["weight"][begin:end].astype(float)
        weight *= (width / np.bincount(interval, weight))[interval]  # single precision undone
        water = file["gases/H2O"]
        nodes = CrossSectionNodes(water["pressure"][()], water["temperature"][()])
        fraction = np.concatenate([[0.0], water["h2o_fraction"][()]])
        wavenumber = points["point"][begin:end]
        every = SpectralPoints(
            wavenumber=wavenumber,
            weight=weight,
            interval=interval,
            interval_edges=self.interval_edges[start:stop],
            _continuum=self._with_continuum(
                wavenumber, np.array([points[name][begin:end] for name in COEFFICIENTS], dtype=float)
            ),
            _gases={},
            _nodes=nodes,
            _humid_nodes=CrossSectionNodes(water["humid_pressure"][()], nodes.temperature, fraction),
        )
        chosen = np.arange(interval.size) if choose is None else choose(every)
        gases = {name: self._read_gas(file["gases"][name], name, start, stop, chosen) for name in self.gases}
        return replace(every if choose is None else every.subset(chosen), _gases=gases)

    def _read_gas(self, group: h5py.Group, name: str, start: int, stop: int, chosen: Integers) -> GasPoints:
        """A gas at chosen points of intervals from start to stop; it has rows only where it absorbs."""
        present = self._source_codes[name] > NEGLIGIBLE
        row = np.concatenate([[0], np.cumsum(np.where(present, self.count, 0))])
        begin, end = row[start], row[stop]
        inside = np.repeat(present[start:stop], self.count[start:stop])
        absorbs = inside[chosen]
        kept = (np.cumsum(inside) - 1)[chosen[absorbs]]
        humid = _unpacked(group["log_moist_ratio"], begin, end, kept) if "log_moist_ratio" in group else None
        return GasPoints(np.flatnonzero(absorbs), _unpacked(group["log_cross_section"], begin, end, kept), humid)

    def _with_continuum(self, wavenumber: Floats, packaged: Floats) -> Floats:
        """Coefficients (3, P) of the water vapour continuum: the table's own outside the range of another one."""
        if self.water_continuum is None:
            return packaged
        nodes, values = _continuum_file(WATER_CONTINUA[self.water_continuum])
        inside = (wavenumber >= nodes[0]) & (wavenumber <= nodes[-1])
        coefficients: Floats = np.array(
            [
                np.where(inside, np.interp(wavenumber, nodes, values[name]), row) if name in values else row
                for name, row in zip(COEFFICIENTS, packaged, strict=True)
            ]
        )
        return coefficients


@lru_cache(maxsize=1)
def _fine_table() -> AbsorptionTable | None:
    """The packaged table of narrow intervals, opened once a process."""
    path = atmospheres.path(FINE_TABLE)
    return AbsorptionTable.open(path) if path.is_file() else None


def _unpacked(dataset: h5py.Dataset, begin: int, end: int, kept: Integers) -> Singles:
    """Some of the rows from begin to end of an array that is stored as differences along pressure, its last axis but
    one.
    """
    rows = dataset[begin:end]
    steps = np.ascontiguousarray(np.moveaxis(rows if kept.size == len(rows) else rows[kept], -2, 0))
    for before, node in pairwise(steps):  # sums that do not fit 16 bits wrap, as the differences did
        node += before
    values: Singles = np.moveaxis(steps, 0, -2).astype(np.float32, order="C")
    values *= np.float32(dataset.attrs[STEP])
    values += np.float32(dataset.attrs[OFFSET])
    return values.reshape(kept.size, math.prod(dataset.shape[1:]))


def _merged(edges: Floats) -> list[tuple[float, float]]:
    """Ranges without gaps of intervals (I, 2) in their order."""
    starts = np.flatnonzero(np.append(True, edges[1:, 0] > edges[:-1, 1]))
    ends = np.append(starts[1:], len(edges)) - 1
    return list(zip(edges[starts, 0].tolist(), edges[ends, 1].tolist(), strict=True)) if len(edges) else []
