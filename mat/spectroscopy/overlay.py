"""Gases with measured cross sections, added to intervals whose points are chosen already."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.atmosphere.gases.path_states import PathState
from skyshine.mat.spectroscopy import linebyline, nodes
from skyshine.mat.spectroscopy.cross_sections import CrossSectionSource, spread
from skyshine.mat.spectroscopy.gases import GASES, LONGEST_COLUMN
from skyshine.mat.spectroscopy.intervals import PRESENT
from skyshine.schemas.arrays import Floats


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
