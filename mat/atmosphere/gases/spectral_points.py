"""Cross sections of the gases at spectral points, interpolated between the nodes of the absorption table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.lagrange import lagrange_weights
from skyshine.mat.radiometry.constants import C2
from skyshine.schemas.arrays import Booleans, Floats, Integers, Singles
from skyshine.schemas.errors import InputError

CONTINUUM = "H2O_continuum"
# Saturated air at 45 C has 9.5 %. Beyond the last node, 8 %, the parabola through the nodes is continued: against
# line sums a cross section of H2O is then wrong by 0.4 % rms at most, of N2 by 6 % in the far wings of its band, where
# it is thin.
MAX_H2O = 0.1
CONTINUUM_PRESSURE, CONTINUUM_TEMPERATURE = 101300.0, 296.0  # Pa, K: reference of MT_CKD (1013 mb)


def water_continuum(
    self_continuum: npt.ArrayLike,
    foreign: npt.ArrayLike,
    exponent: npt.ArrayLike,
    wavenumber: npt.ArrayLike,
    pressure: npt.ArrayLike,
    temperature: npt.ArrayLike,
    h2o_fraction: npt.ArrayLike,
) -> Floats:
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
    nu = np.asarray(wavenumber, float)
    by_water = q * np.asarray(self_continuum, float) * (CONTINUUM_TEMPERATURE / t) ** np.asarray(exponent, float)
    by_air = (1 - q) * np.asarray(foreign, float)
    section: Floats = density * (by_water + by_air) * nu * np.tanh(C2 * nu / (2 * t))
    return section


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

    def __init__(
        self, pressure: npt.ArrayLike, temperature: npt.ArrayLike, h2o_fraction: npt.ArrayLike | None = None
    ) -> None:
        self.pressure, self.temperature = np.asarray(pressure, float), np.asarray(temperature, float)
        self.h2o_fraction = None if h2o_fraction is None else np.asarray(h2o_fraction, float)

    def weights(
        self, pressure: npt.ArrayLike, temperature: npt.ArrayLike, h2o_fraction: npt.ArrayLike | None = None
    ) -> Floats:
        """Weights (L, nodes) over the flattened nodes; pressures below the lowest node are taken there.

        At the lowest pressure a line has its Doppler shape, which depends on temperature alone.
        """
        limited = np.maximum(pressure, self.pressure[0])
        by_pressure = lagrange_weights(np.log(self.pressure), np.log(limited))
        by_temperature = lagrange_weights(self.temperature, temperature)
        weights = by_pressure[:, :, None] * by_temperature[:, None, :]
        if self.h2o_fraction is not None and h2o_fraction is not None:
            by_fraction = lagrange_weights(self.h2o_fraction, h2o_fraction)[:, 1:]
            weights = by_fraction[:, :, None, None] * weights[:, None]
        return weights.reshape(len(weights), -1)


@dataclass(frozen=True)
class GasPoints:
    """A gas at the n points where it absorbs.

    Attributes
    ----------
    position : (n,) int array
        Among all points.
    table : (n, nodes) float32 array
        Logarithm of the cross section, m2/molecule.
    humid : (n, humid nodes) float32 array or None
        Logarithm of the ratio of moist to dry.
    """

    position: Integers
    table: Singles
    humid: Singles | None

    def subset(self, index: Integers, size: int) -> GasPoints:
        """The gas at the points at `index`, of `size` points in all."""
        row_of_point = np.full(size, -1)
        row_of_point[self.position] = np.arange(self.position.size)
        rows = row_of_point[index]
        absorbs = rows >= 0
        humid = None if self.humid is None else self.humid[rows[absorbs]]
        return GasPoints(np.flatnonzero(absorbs), self.table[rows[absorbs]], humid)


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

    wavenumber: Floats
    weight: Floats
    interval: Integers
    interval_edges: Floats
    _continuum: Floats
    _gases: dict[str, GasPoints]
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

    def subset(self, index: Integers | Booleans, weight: npt.ArrayLike | None = None) -> SpectralPoints:
        """The points at `index` (k,), with other weights if given; the intervals keep their numbers."""
        chosen: Integers = np.flatnonzero(index) if index.dtype == bool else np.asarray(index, np.int64)
        return replace(
            self,
            wavenumber=self.wavenumber[chosen],
            weight=self.weight[chosen] if weight is None else np.asarray(weight, float),
            interval=self.interval[chosen],
            _continuum=self._continuum[:, chosen],
            _gases={name: gas.subset(chosen, self.wavenumber.size) for name, gas in self._gases.items()},
        )

    def joined(self, appended: SpectralPoints) -> SpectralPoints:
        """These points and then those of intervals of another table with the same gases and nodes."""
        size, intervals = self.wavenumber.size, len(self.interval_edges)

        def both(name: str) -> GasPoints:
            a, two = self._gases[name], appended._gases[name]
            humid = None
            if a.humid is not None and two.humid is not None:
                humid = np.concatenate([a.humid, two.humid])
            position = np.concatenate([a.position, two.position + size])
            return GasPoints(position, np.concatenate([a.table, two.table]), humid)

        return replace(
            self,
            wavenumber=np.concatenate([self.wavenumber, appended.wavenumber]),
            weight=np.concatenate([self.weight, appended.weight]),
            interval=np.concatenate([self.interval, appended.interval + intervals]),
            interval_edges=np.concatenate([self.interval_edges, appended.interval_edges]),
            _continuum=np.concatenate([self._continuum, appended._continuum], axis=1),
            _gases={name: both(name) for name in self._gases},
        )

    def cross_sections(
        self,
        pressure: npt.ArrayLike,
        temperature: npt.ArrayLike,
        h2o_mole_fraction: npt.ArrayLike,
        gases: Sequence[str] | None = None,
    ) -> dict[str, Floats]:
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
        requested = self.gases if gases is None else list(gases)
        for name in requested:
            if name not in self.gases:
                raise InputError(f"no gas '{name}' in the absorption table; it has {', '.join(self.gases)}")
        dry = self._nodes.weights(pressure, temperature).astype(np.float32)
        moist = None
        result: dict[str, Floats] = {}
        for name in requested:
            if name == CONTINUUM:
                coefficients = self._continuum
                result[name] = water_continuum(
                    coefficients[0],
                    coefficients[1],
                    coefficients[2],
                    self.wavenumber,
                    pressure,
                    temperature,
                    fraction,
                )
                continue
            gas = self._gases[name]
            logarithm = dry @ gas.table.T
            if gas.humid is not None and np.any(fraction > 0):
                if moist is None:
                    limited = np.maximum(pressure, self._humid_nodes.pressure[0])
                    moist = self._humid_nodes.weights(limited, temperature, fraction).astype(np.float32)
                logarithm += moist @ gas.humid.T
            if gas.position.size == self.wavenumber.size:
                result[name] = np.exp(logarithm, dtype=float)
            else:
                result[name] = np.zeros((pressure.size, self.wavenumber.size))
                result[name][:, gas.position] = np.exp(logarithm, dtype=float)
        return result

    def _checked(
        self, pressure: npt.ArrayLike, temperature: npt.ArrayLike, fraction: npt.ArrayLike
    ) -> tuple[Floats, Floats, Floats]:
        arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(a, float)) for a in (pressure, temperature, fraction)))
        nodes = self._nodes
        limits = (
            ("pressure", 1e-2, "hPa", 0.0, nodes.pressure[-1]),
            ("temperature", 1.0, "K", nodes.temperature[0], nodes.temperature[-1]),
            ("water vapour mole fraction", 1.0, "", 0.0, MAX_H2O),
        )
        for values, (name, scale, unit, low, high) in zip(arrays, limits, strict=True):
            inside = (values >= low * (1 - 1e-9)) & (values <= high * (1 + 1e-9))
            if not np.all(inside):
                outside = values[~inside][0] * scale
                raise InputError(
                    f"{name} {outside:.6g} {unit} lies outside the absorption table; "
                    f"allowed: {low * scale:g} to {high * scale:g} {unit}; correct the atmospheric state"
                )
        return (
            np.clip(arrays[0], 1e-12, nodes.pressure[-1]),
            np.clip(arrays[1], nodes.temperature[0], nodes.temperature[-1]),
            np.minimum(arrays[2], MAX_H2O),
        )
