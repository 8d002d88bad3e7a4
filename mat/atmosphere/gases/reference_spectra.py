"""Line-by-line spectra of the paths of a fine absorption table, in cells far narrower than its intervals."""

from __future__ import annotations

from dataclasses import dataclass

import h5py
import numpy as np

from skyshine.mat.atmosphere.gases.path_states import PathState
from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, SpectralPoints
from skyshine.schemas.arrays import Booleans, Floats, Integers


@dataclass(frozen=True, eq=False)
class ReferenceSpectra:
    """Spectra of paths through several atmospheres.

    Attributes
    ----------
    fitted : (M,) bool array
        Rows of the states to which weights are fitted.
    emission : (M,) bool array
        Rows of thermal radiance; the others are transmittances.
    atmosphere : (M,) int array
        Number of the state of each row.
    cell : (C,) array
        Middle of each cell, cm^-1, even; the cells of whole intervals.
    value : (M, C) array
        Means over the cells, as `PathState.values` of each state in turn.
    """

    states: tuple[PathState, ...]
    fitted: Booleans
    emission: Booleans
    atmosphere: Integers
    cell: Floats
    value: Floats

    @classmethod
    def read(cls, group: h5py.Group, low: float, high: float) -> ReferenceSpectra:
        """The cells between two wavenumbers [cm^-1] of the group of a table."""
        cell = group["cell"][()]
        start, stop = np.searchsorted(cell, (low, high))
        value = group["value"][:, start:stop] * float(group["value"].attrs["scale_factor"])
        names = [name.decode() if isinstance(name, bytes) else str(name) for name in group["gas"][()]]
        arrays = {name: group[name][()].astype(float) for name in ("pressure", "temperature", "columns", "slabs")}
        states = []
        for number, fractions in enumerate(group["fraction"][()].astype(float)):
            fraction = dict(zip(names, fractions, strict=True))
            columns = arrays["columns"][number]
            states.append(
                PathState(
                    arrays["pressure"][number],
                    arrays["temperature"][number],
                    fraction["H2O"],
                    fraction,
                    columns,
                    np.zeros(len(columns), dtype=bool),
                    list(arrays["slabs"][number]),
                )
            )
        fit = group["fitted"][()].astype(bool)
        rows = [np.arange(len(state.columns) + len(state.emission)) >= len(state.columns) for state in states]
        atmosphere = np.repeat(np.arange(len(rows)), [row.size for row in rows])
        return cls(tuple(states), fit[atmosphere], np.concatenate(rows), atmosphere, cell[start:stop], value)

    def at_points(self, points: SpectralPoints, *, fitted: bool) -> Floats:
        """The same rows of the fitted states, or of the others, at spectral points (P,): (m, P).

        The continuum of the points must be that of the spectra. Gases without a spectrum of their own are omitted.
        """
        gases = [name for name in points.absorbing if name == CONTINUUM or name in self.states[0].fraction]
        middle = points.interval_edges.mean(axis=1)[points.interval]
        rows = []
        start = 0
        for state in self.states:
            size = len(state.columns) + len(state.emission)
            if self.fitted[start] == fitted:
                sections = points.cross_sections(state.pressure, state.temperature, state.h2o_fraction, gases)
                total = np.zeros((state.pressure.size, points.wavenumber.size))
                for name, section in sections.items():
                    total += section * state.fraction["H2O" if name == CONTINUUM else name][:, None]
                rows.append(state.values(total, middle))
            start += size
        return np.concatenate(rows).astype(float)
