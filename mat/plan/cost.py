"""What a build will take, estimated from its plan by a measured model.

Constants are fits to ten builds of one to four states in 3 to 12 um, of the starter among them, in processor seconds of
one core of a 2.5 GHz server; tests/validation/test_build_cost.py says how good they are on other jobs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np

from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.plan.plan import PLACED_ON, Plan, measured_on, response_planes
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.air_cells import shared_cells
from skyshine.mat.scene.atmosphere import air_key
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.grids import path_scope
from skyshine.mat.scene.moisture import job_library

START = 1.9  # s for the libraries of a process
TASK = 0.9  # s for what a table of the air reads and writes
# s for each band, and for each of its spectral points: for the choice of points, and for their errors in an air.
CHOICE_BAND, CHOICE_POINT = 0.7, 6.5e-4
TEST_BAND, TEST_POINT = 0.4, 6.0e-4
# Times as much of a choice for the airs of a cell, and of errors in airs inside it; s for a band of a state of it.
CELL, CELL_TESTS, SHARED_TEST = 2.6, 1.6, 0.15
# s for the channels of a band of one source, for each of its wavelengths: where light of the Sun counts, and where it
# hardly does. Then the share of a further source, which keeps the nodes of the first.
CHANNEL, CHANNEL_LONG, LONGEST_SUN, FURTHER_SOURCE = 0.20, 0.11, 5.5, 0.45
# Times as much for a band in the window around 3.8 um alone, of which reflected sunlight is the most.
WINDOW, SUNLIT = (3.3, 4.25), 5.0
# Share of that which remains at a coarse tolerance, and the tolerance [K] and the finest for which the constants are
# valid.
FIXED, FINEST, FINEST_PRICED = 0.62, 0.5, 0.05
CELL_NODES, SHARED = 5.5, 0.45  # times as much for the nodes of similar airs, and for a state on them
PROBES, SHARED_PROBES, PROBES_OF_SOURCE = 0.6, 2.0, 0.2  # s for measured errors, on shared nodes so many times as much
_PARTS = 1000  # lines, to know which share of them samples the part of the paths that needs leave
GRID_NODE = 3e-7  # s for each node of path radiance on the axes of a job, evaluated from the channels
# s for the sky of a state, for each material under it, for placing its times of day, and for each distinct surface
# column, its forcing included.
SKY, MATERIAL, TIMES, COLUMN = 1.4, 0.008, 0.01, 2.3e-5
# s for placing nodes of temperatures by a tolerance, for a state and for each material, and for their tables at 0.5 K:
# with the response to shade below, of builds of 15, 60 and 120 materials.
PLACED, PLACED_MATERIAL, PLACED_TABLE = 1.5, 0.09, 0.03
# s for each material and plane of the response to shade, and for the whole solutions of a material that measure it.
RESPONSE_PLANE, SHADE_ERROR = 4.5e-3, 0.03
# Times as much of these for surfaces on which a film of water may lie: it is solved again until film and temperature
# agree, on more times of day; for a column that has rain, and for each of its hours. Fitted to six days of June with
# none to five hours, which differ by up to a factor of 1.4.
FILM, FILM_HOUR = 4.0, 1.0
# Times as much of a column for leaves and soil together: 86 to 148 us beside 30, batches of 1,152; and where both may
# be wet (one day of drizzle with a stand of grass).
OPEN, OPEN_WET = 4.0, 16.0
# s for solving the ground around the surfaces of a state, and its walls, at each altitude.
GROUND, WALLS = 0.03, 0.08
BAND = 0.17  # s for the tables of a band's reflectance
PICTURE = 0.5  # s for each file that is drawn
TEXTURE = 8.3  # s for each texture of a megapixel or so


@dataclass(frozen=True)
class Changes:
    """Changes of a job: no pictures, tolerances so many times as large, at most so many sources and bands."""

    pictures: bool = True
    coarser: float = 1.0
    sources: int | None = None
    bands: int | None = None

    def but(self, **changes: Any) -> Changes:
        """The same with some others."""
        return replace(self, **changes)


def estimate(loaded: LoadedJob, plan: Plan, changes: Changes | None = None) -> dict[str, float]:
    """Processor seconds of a build that keeps and finds nothing, by stage; of the job as it is written, or changed."""
    changes = changes or Changes()
    job = loaded.trimmed
    part = path_scope(loaded).lines(_PARTS, 0) / _PARTS
    states, sources = len(job.states), len(job.sources[: changes.sources])
    responses = [response_of(job.bands[number - 1]) for number in job.needed_bands[: changes.bands]]
    bands = len(responses)
    points = sum(absorption_table().count_between(*response.wavenumber_range) for response in responses)
    cells = shared_cells(loaded.requested)
    sharing, chosen = states - cells.count(None), choices(loaded)
    of_cells = len(set(cells) - {None})
    nodes = prod(map(len, job.atmosphere_axes().values())) if job.atmosphere_grid.writes_tables else 0
    kelvin = _times_as_many(job.atmosphere_grid.tolerance, changes, 1.0)
    channels = sum(map(_channel_seconds, responses)) * (FIXED + (1 - FIXED) * kelvin)
    channels *= part * max(0.0, 1 + FURTHER_SOURCE * (sources - 1))
    probes = states - sharing + SHARED_PROBES * sharing
    files = sum(len(task.files) for task in plan.tasks)
    choice, test = CHOICE_BAND * bands + CHOICE_POINT * points, TEST_BAND * bands + TEST_POINT * points
    return {
        "start": START,
        "compile": part
        * (
            (chosen + (CELL - 1) * of_cells) * choice
            + (chosen + (CELL_TESTS - 1) * of_cells) * test
            + SHARED_TEST * bands * sharing
        ),
        "atmosphere": channels * (states - sharing + CELL_NODES * of_cells + SHARED * sharing) + TASK * states * bands,
        "accuracy": part * probes * bands * (PROBES + PROBES_OF_SOURCE * sources),
        "grid": GRID_NODE * nodes * states * bands * sources,
        **_of_surfaces(job, plan, changes),
        "bands": BAND * bands,
        "textures": TEXTURE * len(job.texture_jobs),
        "pictures": PICTURE * files if job.output.pictures and changes.pictures else 0.0,
    }


def film(state: State) -> float:
    """How many times as long temperatures of a state take that may have a film of water."""
    rain = state.weather.water.get("rain_mm_h")
    return 1.0 if rain is None else FILM + FILM_HOUR * 24 * float(np.mean(np.asarray(rain[-1]) > 0))


def _of_surfaces(job: Job, plan: Plan, changes: Changes) -> dict[str, float]:
    """Processor seconds for temperatures and for their response to shade."""
    surface = job.surface_grid
    level = int(np.sum(np.isin(surface.slope_deg, (0.0, 180.0))))
    planes = level + (len(surface.slope_deg) - level) * len(surface.azimuth_deg)
    library = job_library(job)
    wet = [film(state) for state in job.states]
    opened = OPEN if max(wet) == 1 else OPEN_WET
    balances = sum(1.0 if library[name].opened is None else opened for name in plan.materials)
    days = sum(factor * (1 + len(state.weather.days_before)) for factor, state in zip(wet, job.states, strict=True))
    shaded, materials = response_planes(job), len(plan.materials)
    measured = sum(
        factor * (1 + len(state.weather.days_before)) * measured_on(state, materials)
        for factor, state in zip(wet, job.states, strict=True)
    )
    if surface.tolerance is None:
        times = TIMES * min(materials, PLACED_ON) if surface.time is None else 0.0
        solved = (MATERIAL * materials + times) * sum(wet)
        solved += COLUMN * balances * len(job.surface_altitudes_km) * planes * days
    else:
        finer = _times_as_many(surface.tolerance, changes, 2.0)
        solved = (PLACED + PLACED_MATERIAL * balances) * sum(wet) + PLACED_TABLE * balances * finer * days
    return {
        "temperature": SKY * len(job.states) + solved + _surroundings(job),
        "shade": balances * RESPONSE_PLANE * shaded * sum(wet) + (SHADE_ERROR if shaded else 0.0) * measured,
    }


def _channel_seconds(response: SpectralResponse) -> float:
    """Processor seconds for the channels of a band of one source at `FINEST`, on nodes that are placed for it."""
    count = band_wavelengths(response).size
    if response.lower >= LONGEST_SUN:
        return CHANNEL_LONG * count
    sunlit = WINDOW[0] <= response.lower and response.upper <= WINDOW[1]
    return CHANNEL * count * (SUNLIT if sunlit else 1.0)


def _times_as_many(tolerance: str, changes: Changes, power: float) -> float:
    """How many times as many nodes a tolerance takes as `FINEST`."""
    return float((FINEST / max(changes.coarser * tolerance_parts(tolerance)[0], FINEST_PRICED)) ** power)


def _surroundings(job: Job) -> float:
    """Processor seconds for the ground and the walls around the surfaces of all states."""
    grounds = sum(state.ground_material is not None for state in job.states)
    walls = sum(state.surroundings is not None and state.surroundings.wall.material is not None for state in job.states)
    return GROUND * grounds + WALLS * walls * len(job.surface_altitudes_km)


def choices(loaded: LoadedJob) -> int:
    """How often the points of the bands are chosen, where those that states share meet the tolerance."""
    job = loaded.requested
    return len(
        {_air(state) if cell is None else cell for state, cell in zip(job.states, shared_cells(job), strict=True)}
    )


def _air(state: State) -> tuple[Any, ...]:
    return air_key(state), state.ground_material
