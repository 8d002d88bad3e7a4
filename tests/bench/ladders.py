"""Sets of spectral points from many to few: one axis of error against run time."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.band.compile import CompiledBand, compile_band
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.band.selection import select_points
from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, SpectralPoints
from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.optics import gas_absorption
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.spectroscopy.training import TRAINING_PROFILES
from skyshine.schemas.arrays import Floats, Integers

VISIBILITY = 23.0  # km, of rural haze
# The paths on which bands are compiled: those of a usual job.
GRID = PathGrid(
    range_km=np.array([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100.0]),
    altitude_km=np.array([0.0, 0.5, 1, 2, 4, 8, 12]),
    elevation_deg=np.array([-90.0, -60, -30, -15, -5, 0, 5, 15, 30, 60, 90]),
    source_elevation_deg=np.array([5.0, 30, 60, 90]),
    source_azimuth_deg=np.array([0.0, 90, 180]),
)
# Choice of points in wider intervals: as many as an interval of the table has, as exact.
_MOST_POINTS, _TOLERANCE = 16, 4e-4
# Below the error of any band of 64 points; a narrow band ends its ladder where it holds this.
_COMPILE_TOLERANCE = 1e-4
# Air masses of the vertical paths and lengths [m] of the level ones on which they are chosen.
_AIR_MASSES = (1.0, 2.0, 5.0, 15.0, 38.0)
_BOTTOMS = (0.0, 2e3, 6e3, 12e3)  # m
_LENGTHS = (100.0, 300.0, 1e3, 3e3, 1e4, 3e4, 1e5)


def merged_intervals(points: SpectralPoints, width: float, gases: Sequence[str]) -> tuple[Integers, Floats, Integers]:
    """Points of wider intervals, chosen among those of the narrow ones.

    Parameters
    ----------
    points : SpectralPoints
    width : float
        cm^-1, a multiple of the points' own intervals; the last interval may be narrower.
    gases : sequence of str
        Names as `SpectralPoints.cross_sections` takes them.

    Returns
    -------
    index : (k,) int array
    weight : (k,) array, cm^-1
    group : (I,) int array
        The wide interval of each narrow one.
    """
    low = points.interval_edges[:, 0]
    group = np.floor((low - low[0]) / width + 1e-9).astype(int)
    rows = np.concatenate([_paths(points, name, gases) for name in TRAINING_PROFILES])
    index, weight = [], []
    for number in range(group[-1] + 1):
        member = np.flatnonzero(group[points.interval] == number)
        member_weight = points.weight[member]
        chosen, share, _ = select_points(
            rows[:, member].T,
            rows[:, member] @ member_weight / member_weight.sum(),
            tolerance=_TOLERANCE,
            max_points=_MOST_POINTS,
            total_weight=member_weight.sum(),
        )
        order = np.argsort(member[chosen])
        index.append(member[chosen][order])
        weight.append(share[order])
    return np.concatenate(index), np.concatenate(weight), group


def _paths(points: SpectralPoints, name: str, gases: Sequence[str]) -> Floats:
    """Transmittances (R, P) of vertical and level paths through a standard profile."""
    in_profile = {gas for gas in gases if gas in load_profile(name).mole_fraction} | {"H2O_continuum"}
    state = AtmosphericState.from_profile(name, aerosol=Aerosol("none"))
    absorption = gas_absorption(state, points, [gas for gas in gases if gas in in_profile])
    total = sum(absorption.values(), np.zeros((state.altitude.size, points.wavenumber.size)))
    column = _trapezoid(state.altitude, state.number_density)
    rows = []
    for bottom in _BOTTOMS:
        above = np.where(state.altitude >= bottom, column, 0.0) @ total
        here = int(np.searchsorted(state.altitude, bottom))
        rows += [np.exp(-mass * above) for mass in _AIR_MASSES]
        rows += [np.exp(-length * state.number_density[here] * total[here]) for length in _LENGTHS]
    return np.array(rows)


def _trapezoid(altitude: Floats, density: Floats) -> Floats:
    """Column of each level by the trapezoidal rule."""
    step = np.diff(altitude)
    column: Floats = density * 0.5 * (np.append(step, 0.0) + np.append(0.0, step))
    return column


def compiled(state: AtmosphericState, points: SpectralPoints, response: SpectralResponse, count: int) -> CompiledBand:
    """A band compiled to a number of points.

    Parameters
    ----------
    state : AtmosphericState
    points : SpectralPoints
    response : SpectralResponse
    count : int

    Returns
    -------
    CompiledBand
    """
    band = band_points(points, response)
    sun = solar_irradiance(band.points.wavenumber)
    return compile_band(state, band, GRID, sun, tolerance=_COMPILE_TOLERANCE, max_points=count)


def with_continuum(gases: Sequence[str]) -> list[str]:
    """Names as `SpectralPoints.cross_sections` takes them: the water vapour continuum follows water vapour."""
    return [part for gas in gases for part in ((gas, CONTINUUM) if gas == "H2O" else (gas,))]


def write_measured(path: Path, result: dict[str, Any], draw: Callable[[Path], None]) -> None:
    """Write what was measured as JSON, and its picture beside it; folders that are missing are made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draw(path.with_suffix(".png"))
    path.write_text(json.dumps(result, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
