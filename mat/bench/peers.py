"""Peers of a job: they compute no pixel, so they are compared by seconds per line of sight or per column."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.bench import energyplus, lowtran
from skyshine.mat.bench.rungs import Rung
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import response_of
from skyshine.mat.scene.grids import path_grid
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Integers
from skyshine.schemas.errors import InputError
from skyshine.schemas.quantity import quantity

LOWTRAN, ENERGYPLUS = "LOWTRAN7", "EnergyPlus"
_PEER_CELLS = 24  # random cells of the grid for each peer
# m; with levels above, or with as many levels as it takes otherwise, its multiple scattering gives no numbers.
_PEER_TOP = 60e3
_PEER_LEVELS = lowtran.MAX_LEVELS - 1
VISIBILITY = 23.0  # km, of rural haze
# The paths on which bands are compiled: those of a usual job.
GRID = PathGrid(
    range_km=np.array([0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100.0]),
    altitude_km=np.array([0.0, 0.5, 1, 2, 4, 8, 12]),
    elevation_deg=np.array([-90.0, -60, -30, -15, -5, 0, 5, 15, 30, 60, 90]),
    source_elevation_deg=np.array([5.0, 30, 60, 90]),
    source_azimuth_deg=np.array([0.0, 90, 180]),
)


@dataclass(frozen=True)
class Comparison:
    """A peer beside a job by one unit of work.

    Attributes
    ----------
    peer, work : str
    seconds, ours : float or None
        Processor seconds of a unit of work: of the peer, None where it is absent; of the job as it is built.
    count : int
        Units of work in the job.
    note : str
        What the peer computes, or why it is absent.
    """

    peer: str
    work: str
    seconds: float | None
    ours: float
    count: int
    note: str

    @property
    def described(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "peer": self.peer,
            "work": self.work,
            "time": quantity(np.nan if self.seconds is None else self.seconds, "s"),
            "time_of_this_job": quantity(self.ours, "s"),
            "count": self.count,
            "note": self.note,
        }


def comparisons(
    rung: Rung, library: MaterialLibrary, *, lowtran_path: str | None, say: Callable[[str], object]
) -> list[Comparison]:
    """LOWTRAN7 for lines of sight at nodes of the job's axes in each band, EnergyPlus for columns of one day.

    Parameters
    ----------
    rung : Rung
        The job as it is written, built.
    library : MaterialLibrary
    lowtran_path : str, optional
        Path as in `lowtran.find_source`.
    say : callable
        Told what is measured.

    Raises
    ------
    InputError
        `lowtran_path` leads to no source.
    """
    say(f"measuring {LOWTRAN}")
    program, origin = lowtran.built_program(lowtran_path)
    job, grid = rung.loaded.trimmed, path_grid(rung.loaded.trimmed)
    lines = int(np.prod(grid.shape)) * len(job.sources)
    results = []
    for number in job.needed_bands:
        response = response_of(job.bands[number - 1])
        limits = response.lower, response.upper
        seconds, note = None, origin
        if program is not None:
            try:
                state = atmospheric_state(job.site, job.states[0])
                seconds = _peer_seconds(program, state, _for_peer(grid), limits)
                note = "single lines of sight with multiple scattering, in steps of 5 cm^-1"
            except InputError as error:
                note = f"skipped: {error}"
        work = f"a node of the job's axes, {limits[0]:g}-{limits[1]:g} um"
        results.append(Comparison(LOWTRAN, work, seconds, _of_band(rung, number) / lines, lines, note))
    columns = _columns(rung, library)
    say(f"measuring {ENERGYPLUS}")
    run = energyplus.measure()
    one_day, note = run.one_day, run.note
    results.append(
        Comparison(ENERGYPLUS, "a column of one periodic day", one_day, _solving(rung) / columns, columns, note)
    )
    return results


def _for_peer(grid: PathGrid) -> PathGrid:
    """The axes of which the peer's lines of sight are drawn: those of the job, or usual ones where the job names none
    that it computes.
    """
    up = (grid.elevation_deg > 0) & (grid.elevation_deg < 90)
    far = (grid.range_km >= 1) & (grid.range_km <= 40)
    covered = up.any() and far.any() and (grid.altitude_km < 20).any() and (grid.source_elevation_deg > 0).any()
    return grid if covered else GRID


def _peer_seconds(program: Path, state: AtmosphericState, grid: PathGrid, limits: tuple[float, float]) -> float:
    """Mean processor seconds of LOWTRAN7 for a cell of a grid, at cells above the ground drawn at random."""
    generator = np.random.default_rng(0)
    low, high = (5.0 * round(1e4 / edge / 5.0) for edge in reversed(limits))
    highest = int(np.searchsorted(state.altitude, _PEER_TOP, side="right")) - 1
    levels = np.unique(np.linspace(0, highest, _PEER_LEVELS).astype(int))
    air = thinned(replace(state, aerosols=()), levels)
    up = grid.elevation_deg[(grid.elevation_deg > 0) & (grid.elevation_deg < 90)]
    sights = [
        lowtran.Sight(
            1e3 * generator.choice(grid.altitude_km[grid.altitude_km < 20]),
            generator.choice(up),
            1e3 * generator.choice(grid.range_km[(grid.range_km >= 1) & (grid.range_km <= 40)]),
            sun=(
                generator.choice(grid.source_elevation_deg[grid.source_elevation_deg > 0]),
                generator.choice(grid.source_azimuth_deg),
            ),
        )
        for _ in range(_PEER_CELLS)
    ]
    haze = lowtran.Haze(aerosol=1, visibility=VISIBILITY)
    return float(lowtran.run(program, air, sights, low, high, haze=haze).seconds.mean())


def _of_band(rung: Rung, band: int) -> float:
    """Processor seconds to choose the points of a band and to compute its tables, of one state."""
    states = len(rung.loaded.trimmed.states)
    return (
        _seconds(rung, lambda kind, number: kind is Kind.ATMOSPHERE and number == band, ("accuracy", "write")) / states
    )


def _solving(rung: Rung) -> float:
    """Processor seconds of the heat balance of a state."""
    return _seconds(rung, lambda kind, _: kind is Kind.TEMPERATURE, ("accuracy", "write", "response")) / len(
        rung.loaded.trimmed.states
    )


def _seconds(rung: Rung, chosen: Callable[[Kind, int], bool], without: tuple[str, ...]) -> float:
    tasks = () if rung.cost is None else rung.cost.tasks
    return sum(
        spent
        for task in tasks
        if chosen(Kind(task.kind), task.band)
        for stage, spent in task.stages.items()
        if stage not in without
    )


def _columns(rung: Rung, library: MaterialLibrary) -> int:
    """Surface columns of a state: materials by altitudes, slopes and azimuths; level faces have no azimuth."""
    grid, job = rung.loaded.trimmed.surface_grid, rung.loaded.trimmed
    level = sum(slope in (0.0, 180.0) for slope in grid.slope_deg)
    planes = level + (len(grid.slope_deg) - level) * len(grid.azimuth_deg)
    return len(make_plan(rung.loaded, library).materials) * len(job.surface_altitudes_km) * planes


def thinned(state: AtmosphericState, levels: Integers) -> AtmosphericState:
    """A state at some of its levels, by their indices."""
    return replace(
        state,
        altitude=state.altitude[levels],
        pressure=state.pressure[levels],
        temperature=state.temperature[levels],
        mole_fraction={gas: values[levels] for gas, values in state.mole_fraction.items()},
        aerosols=tuple(replace(part, extinction_550=part.extinction_550[levels]) for part in state.aerosols),
    )
