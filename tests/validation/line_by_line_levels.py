"""A state's absorption summed line by line: the reference against which faster ways are judged."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.gases.spectral_points import water_continuum
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.continua import ContinuumModel
from skyshine.mat.spectroscopy.gases import GASES, LineLibrary
from skyshine.schemas.arrays import Floats

_WITHOUT_SOURCE = ("no data", "negligible")


def judged_gases(library: LineLibrary, table: AbsorptionTable, low: float, high: float) -> tuple[list[str], list[str]]:
    """Gases of a table that line lists describe over all of a range, and those they do not.

    Parameters
    ----------
    library : LineLibrary
    table : AbsorptionTable
    low, high : float
        cm^-1.

    Returns
    -------
    judged, others : lists of str
        A gas is among the others where the table has it from another source than lines somewhere in the range.
    """
    listed = {gas.name for gas in library.gases}
    judged: list[str] = []
    others: list[str] = []
    for gas in table.gases:
        parts = [(a, b) for a, b, text in table.provenance(gas) if text not in _WITHOUT_SOURCE and a < high and b > low]
        if not parts:
            continue
        complete = gas in listed and all(library.covers(gas, a, b) for a, b in _intervals(table, parts))
        (judged if complete else others).append(gas)
    return judged, others


def _intervals(table: AbsorptionTable, parts: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Edges of the table's intervals that lie in one of the parts."""
    edges = table.interval_edges
    return [(a, b) for a, b in edges for first, last in parts if a >= first and b <= last]


def absorption_at_levels(
    library: LineLibrary,
    continua: ContinuumModel,
    state: AtmosphericState,
    gases: Sequence[str],
    low: float,
    high: float,
) -> Floats:
    """Absorption of an interval on the grid of `linebyline.interval_grid`, at the levels of a state.

    Parameters
    ----------
    library : LineLibrary
    continua : ContinuumModel
    state : AtmosphericState
        N levels.
    gases : sequence of str
        With H2O comes its continuum.
    low, high : float
        cm^-1.

    Returns
    -------
    (N, K) array
        m^2 per molecule of air.
    """
    wavenumber = linebyline.interval_grid(low, high)
    total = np.zeros((state.altitude.size, wavenumber.size))
    humidity = state.mole_fraction["H2O"]
    for name in gases:
        gas, fraction = GASES[name], state.mole_fraction[name]
        for level, (pressure, temperature) in enumerate(zip(state.pressure, state.temperature, strict=True)):
            air = ([pressure], [temperature], humidity[level] if name == "H2O" else gas.self_fraction)
            section = library.interval_spectrum(name, low, high, *air)[0, 0]
            if name in continua.by_gas:
                section = section + continua.by_gas[name](wavenumber, pressure, temperature, humidity[level])
            total[level] += fraction[level] * section
    if "H2O" in gases:
        coefficients = continua.water_coefficients(wavenumber)
        section = water_continuum(*coefficients, wavenumber, state.pressure, state.temperature, humidity)
        total += humidity[:, None] * section
    return total
