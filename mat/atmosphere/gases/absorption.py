"""The band model of gas absorption: spectral points, weights and cross sections, read from the absorption table.

In each interval of a few cm^-1 a handful of monochromatic points with weights stands for the interval's mean; at a
point Beer's law holds exactly, for mixtures of gases and inhomogeneous paths alike. The table is made by
`skyshine.mat.spectroscopy`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from skyshine import atmospheres
from skyshine.mat.atmosphere.gases.lagrange import lagrange_weights
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import open_database, sound

FILETYPE, FORMAT_MAJOR = "absorption", 1
CONTINUUM = "H2O_continuum"
# Water vapour continua by name: the table's own, and an older one for comparison with codes of its time, at the
# wavenumbers of its file.
WATER_CONTINUA = {"mt_ckd_4.3": None, "mt_ckd_2.4": "continuum/mt_ckd_2.4.csv"}
# Codes of a gas in an interval, as the table keeps them; larger codes name the entries of its `sources`.
NO_DATA, NEGLIGIBLE = 0, 1
C2 = 1.438776877  # cm K, second radiation constant, CODATA 2018
# Saturated air at 45 C holds 9.5 %. Beyond the last node, 8 %, the parabola through the nodes is continued: against
# line sums a cross section of H2O is then wrong by 0.4 % rms at most, of N2 by 6 % in the far wings of its band, where
# it is thin.
MOST_H2O = 0.1
CONTINUUM_PRESSURE, CONTINUUM_TEMPERATURE = 101300.0, 296.0  # Pa, K: reference of MT_CKD (1013 mb)


def water_continuum(self_continuum, foreign, exponent, wavenumber, pressure, temperature, h2o_fraction):
    """Water vapour continuum per H2O molecule (Mlawer et al. 2012, 2023: MT_CKD 4.3).

    Parameters
    ----------
    self_continuum, foreign, exponent : (P,) arrays
        Coefficients at 296 K and 1013 hPa, m2/molecule per cm^-1, and the temperature exponent of the self continuum.
    wavenumber : (P,) array, cm^-1
    pressure, temperature, h2o_fraction : (L,) arrays, Pa, K, 1

    Returns
    -------
    (L, P) array, m2/molecule
    """
    t = np.asarray(temperature, float)[:, None]
    q = np.asarray(h2o_fraction, float)[:, None]
    density = np.asarray(pressure, float)[:, None] / CONTINUUM_PRESSURE * CONTINUUM_TEMPERATURE / t
    by_water = q * self_continuum * (CONTINUUM_TEMPERATURE / t) ** exponent
    return density * (by_water + (1 - q) * foreign) * wavenumber * np.tanh(C2 * wavenumber / (2 * t))


@lru_cache(maxsize=2)
def _continuum_file(name):
    """Wavenumbers (K,) cm^-1 and coefficients (3, K) as those of `water_continuum`."""
    return np.split(np.array(list(read_csv(atmospheres.path(WATER_CONTINUA[name])).values())), [1])


class CrossSectionNodes:
    """Interpolation on the (pressure, temperature) nodes: cubics in log pressure and temperature, of the log cross
    section.

    Parameters
    ----------
    pressure : (N,) array, Pa, increasing
    temperature : (T,) array, K, increasing
    h2o_fraction : (Q,) array, optional
        A further axis in front; the interpolated quantity is 0 at its first node, 0, which is not stored.
    """

    def __init__(self, pressure, temperature, h2o_fraction=None):
        self.pressure, self.temperature = np.asarray(pressure, float), np.asarray(temperature, float)
        self.h2o_fraction = None if h2o_fraction is None else np.asarray(h2o_fraction, float)

    def weights(self, pressure, temperature, h2o_fraction=None):
        """Weights (L, nodes) over the flattened nodes; pressures below the lowest node are taken there.

        At the lowest pressure a line has its Doppler shape, which depends on temperature alone.
        """
        held = np.maximum(pressure, self.pressure[0])
        by_pressure = lagrange_weights(np.log(self.pressure), np.log(held))
        by_temperature = lagrange_weights(self.temperature, temperature)
        weights = by_pressure[:, :, None] * by_temperature[:, None, :]
        if self.h2o_fraction is not None:
            by_fraction = lagrange_weights(self.h2o_fraction, h2o_fraction)[:, 1:]
            weights = by_fraction[:, :, None, None] * weights[:, None]
        return weights.reshape(len(weights), -1)


@dataclass(frozen=True)
class _GasPoints:
    """A gas at the points where it absorbs: position among all points, log cross sections, log of the moist to dry
    ratio.
    """

    position: np.ndarray
    table: np.ndarray
    humid: np.ndarray | None

    def subset(self, index, size):
        where = np.full(size, -1)
        where[self.position] = np.arange(self.position.size)
        rows = where[index]
        found = rows >= 0
        humid = None if self.humid is None else self.humid[rows[found]]
        return _GasPoints(np.flatnonzero(found), self.table[rows[found]], humid)


@dataclass(frozen=True)
class SpectralPoints:
    """Spectral points of successive intervals.

    Attributes
    ----------
    wavenumber, weight : (P,) arrays, cm^-1
        Within an interval the weights sum to its width.
    interval : (P,) int array
        The interval of each point, counted from 0.
    interval_edges : (I, 2) array, cm^-1
    """

    wavenumber: np.ndarray
    weight: np.ndarray
    interval: np.ndarray
    interval_edges: np.ndarray
    _continuum: np.ndarray
    _gases: dict
    _nodes: CrossSectionNodes
    _humid_nodes: CrossSectionNodes

    @property
    def gases(self) -> list[str]:
        """The gases of the table, and the water vapour continuum."""
        return [*self._gases, CONTINUUM]

    @property
    def absorbing(self) -> list[str]:
        """The gases that absorb at one of these points at least; the others' cross sections are 0."""
        return [*(name for name, gas in self._gases.items() if gas.position.size), CONTINUUM]

    def subset(self, index, weight=None) -> SpectralPoints:
        """The points at `index` (k,), with other weights if given; the intervals keep their numbers."""
        index = np.asarray(index)
        if index.dtype == bool:
            index = np.flatnonzero(index)
        return replace(
            self,
            wavenumber=self.wavenumber[index],
            weight=self.weight[index] if weight is None else np.asarray(weight, float),
            interval=self.interval[index],
            _continuum=self._continuum[:, index],
            _gases={name: gas.subset(index, self.wavenumber.size) for name, gas in self._gases.items()},
        )

    def cross_sections(self, pressure, temperature, h2o_mole_fraction, gases: Sequence[str] | None = None) -> dict:
        """Absorption cross sections per molecule of each gas.

        Parameters
        ----------
        pressure : (L,) array, Pa
            Up to the table's largest, 1100 hPa. Below its smallest, 1e-5 hPa, lines keep their Doppler shape.
        temperature : (L,) array, K
        h2o_mole_fraction : (L,) array
        gases : sequence of str, optional
            Default: all, with the water vapour continuum as ``H2O_continuum``.

        Returns
        -------
        dict of (L, P) arrays, m2/molecule
            Zero where a gas has no data or is negligible, see `AbsorptionTable.provenance`.

        Raises
        ------
        InputError
            A value lies outside the table, or a gas is not in it.
        """
        pressure, temperature, fraction = self._checked(pressure, temperature, h2o_mole_fraction)
        wanted = self.gases if gases is None else list(gases)
        for name in wanted:
            if name not in self.gases:
                raise InputError(f"no gas '{name}' in the absorption table; it holds {', '.join(self.gases)}")
        dry = self._nodes.weights(pressure, temperature).astype(np.float32)
        moist = None
        result = {}
        for name in wanted:
            if name == CONTINUUM:
                result[name] = water_continuum(*self._continuum, self.wavenumber, pressure, temperature, fraction)
                continue
            gas = self._gases[name]
            logarithm = dry @ gas.table.T
            if gas.humid is not None and np.any(fraction > 0):
                if moist is None:
                    held = np.maximum(pressure, self._humid_nodes.pressure[0])
                    moist = self._humid_nodes.weights(held, temperature, fraction).astype(np.float32)
                logarithm += moist @ gas.humid.T
            if gas.position.size == self.wavenumber.size:
                result[name] = np.exp(logarithm, dtype=float)
            else:
                result[name] = np.zeros((pressure.size, self.wavenumber.size))
                result[name][:, gas.position] = np.exp(logarithm, dtype=float)
        return result

    def _checked(self, pressure, temperature, fraction):
        arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(a, float)) for a in (pressure, temperature, fraction)))
        nodes = self._nodes
        limits = (
            ("pressure", 1e-2, "hPa", 0.0, nodes.pressure[-1]),
            ("temperature", 1.0, "K", nodes.temperature[0], nodes.temperature[-1]),
            ("water vapour mole fraction", 1.0, "", 0.0, MOST_H2O),
        )
        for values, (name, scale, unit, low, high) in zip(arrays, limits, strict=True):
            inside = (values >= low * (1 - 1e-9)) & (values <= high * (1 + 1e-9))
            if not np.all(inside):
                bad = values[~inside][0] * scale
                raise InputError(
                    f"{name} {bad:.6g} {unit} lies outside the absorption table; "
                    f"allowed: {low * scale:g} to {high * scale:g} {unit}; correct the atmospheric state"
                )
        pressure, temperature, fraction = arrays
        temperature = np.clip(temperature, nodes.temperature[0], nodes.temperature[-1])
        return np.clip(pressure, 1e-12, nodes.pressure[-1]), temperature, np.minimum(fraction, MOST_H2O)


class AbsorptionTable:
    """The absorption table; `open` reads what describes it, `points` the intervals that are asked for.

    `content` is the hash of what the points hold, the name of the water vapour continuum after it where that is not the
    table's own.
    """

    water_continuum = "mt_ckd_4.3"

    def __init__(self, path, version, name, content, edges, count, error, gases, sources, terms, errors):
        self.path, self.version, self.name, self.content = path, version, name, content
        self.interval_edges, self.count, self.error = edges, np.asarray(count), error
        self._first = np.concatenate([[0], np.cumsum(count)])
        self._source_codes, self._source_texts, self._terms, self.gas_error = gases, sources, terms, errors

    @classmethod
    def open(cls, path=None, water_continuum="mt_ckd_4.3") -> AbsorptionTable:
        """Open a table, by default the packaged one.

        Parameters
        ----------
        path : path, optional
        water_continuum : str
            One of `WATER_CONTINUA`.

        Raises
        ------
        InputError
            No continuum has that name, or the file is missing, damaged, of another type or of another format version.
        """
        if water_continuum not in WATER_CONTINUA:
            raise InputError(f"found water vapour continuum '{water_continuum}'; allowed: {', '.join(WATER_CONTINUA)}")
        path = atmospheres.path("absorption.h5") if path is None else path
        with open_database(path, FILETYPE, FORMAT_MAJOR) as file, sound(path):
            about = file["intervals"]
            edges = np.stack([about["low"][()], about["high"][()]], axis=1).astype(float)
            codes = {name: group["source"][()] for name, group in file["gases"].items()}
            texts = {name: [str(text) for text in group.attrs["sources"]] for name, group in file["gases"].items()}
            terms = {
                name: [str(text) for text in group.attrs.get("terms", [])] for name, group in file["gases"].items()
            }
            errors = {name: group["rms_error"][()] for name, group in file["gases"].items()}
            error = about["error"][()].astype(float)
            version, label = str(file.attrs["data_version"]), str(file.attrs.get("data_name", ""))
            content = str(file.attrs["content_sha256"])
            table = cls(path, version, label, content, edges, about["count"][()], error, codes, texts, terms, errors)
        if WATER_CONTINUA[water_continuum] is not None:
            table.water_continuum = water_continuum
            table.content += f" {water_continuum}"
        return table

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
        texts = ["no data", "negligible", *self._source_texts[gas]]
        found = []
        for code in np.unique(codes):
            found += [(low, high, texts[code]) for low, high in _merged(self.interval_edges[codes == code])]
        return sorted(found)

    def terms(self, gas: str) -> list[str]:
        """Licence or terms of the sources that a gas's cross sections come from, each once."""
        used = [
            text for code, text in enumerate(self._terms[gas], start=NEGLIGIBLE + 1) if code in self._source_codes[gas]
        ]
        return list(dict.fromkeys(used))

    def points(self, low: float, high: float) -> SpectralPoints:
        """The points of every interval that overlaps [low, high] (cm^-1).

        Raises
        ------
        InputError
            The range is empty, or the table does not cover all of it.
        """
        low, high = float(low), float(high)
        if not low < high:
            raise InputError(f"wavenumbers {low:g} to {high:g} cm^-1 are no range; give low:high with low < high")
        if not any(first <= low and high <= last for first, last in self.coverage):
            ranges = ", ".join(f"{first:g} to {last:g}" for first, last in self.coverage)
            raise InputError(
                f"wavenumbers {low:g} to {high:g} cm^-1 are not covered by the absorption table; allowed: {ranges}"
                " cm^-1"
            )
        overlapping = np.flatnonzero((self.interval_edges[:, 1] > low) & (self.interval_edges[:, 0] < high))
        first, last = overlapping[0], overlapping[-1] + 1
        with open_database(self.path, FILETYPE, FORMAT_MAJOR) as file, sound(self.path):
            return self._read(file, first, last)

    def _read(self, file, first, last):
        begin, end = self._first[first], self._first[last]
        points = file["points"]
        interval = np.repeat(np.arange(last - first), np.diff(self._first[first : last + 1]))
        width = np.diff(self.interval_edges[first:last], axis=1)[:, 0]
        weight = points["weight"][begin:end].astype(float)
        weight *= (width / np.bincount(interval, weight))[interval]  # single precision undone
        coefficients = ("self_continuum", "foreign_continuum", "self_exponent")
        gases = {name: _read_gas(group, self._first, first, last) for name, group in file["gases"].items()}
        any_group = next(iter(file["gases"].values()))
        nodes = CrossSectionNodes(any_group["pressure"][()], any_group["temperature"][()])
        water = file["gases/H2O"]
        fraction = np.concatenate([[0.0], water["h2o_fraction"][()]])
        wavenumber = points["point"][begin:end]
        return SpectralPoints(
            wavenumber=wavenumber,
            weight=weight,
            interval=interval,
            interval_edges=self.interval_edges[first:last],
            _continuum=self._with_continuum(
                wavenumber, np.array([points[name][begin:end] for name in coefficients], dtype=float)
            ),
            _gases=gases,
            _nodes=nodes,
            _humid_nodes=CrossSectionNodes(water["humid_pressure"][()], nodes.temperature, fraction),
        )

    def _with_continuum(self, wavenumber, own):
        """Coefficients (3, P) of the water vapour continuum: the table's own outside the range of another one."""
        if WATER_CONTINUA[self.water_continuum] is None:
            return own
        (nodes,), values = _continuum_file(self.water_continuum)
        inside = (wavenumber >= nodes[0]) & (wavenumber <= nodes[-1])
        return np.where(inside, [np.interp(wavenumber, nodes, row) for row in values], own)


def _read_gas(group, first_point, first, last):
    """The rows of a gas in intervals first to last; a gas has rows only where it absorbs."""
    present = group["source"][()] > NEGLIGIBLE
    counts = np.where(present, np.diff(first_point), 0)
    row = np.concatenate([[0], np.cumsum(counts)])
    begin, end = row[first], row[last]
    inside = np.repeat(present[first:last], np.diff(first_point[first : last + 1]))
    humid = _unpacked(group["log_moist_ratio"], begin, end) if "log_moist_ratio" in group else None
    return _GasPoints(np.flatnonzero(inside), _unpacked(group["log_cross_section"], begin, end), humid)


def _unpacked(dataset, begin, end):
    packed = dataset[begin:end].reshape(end - begin, math.prod(dataset.shape[1:]))
    scale, offset = np.float32(dataset.attrs["scale_factor"]), np.float32(dataset.attrs["add_offset"])
    return packed.astype(np.float32) * scale + offset


def _merged(edges):
    merged = []
    for low, high in edges:
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], float(high))
        else:
            merged.append((float(low), float(high)))
    return merged
