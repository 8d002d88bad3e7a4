"""What a build will take, estimated from its plan by a measured model.

Constants are fits to builds of the starter job (the channels) and of five days of a year with three to 133 materials
(the rest), on one core of a 2.5 GHz server, in processor seconds; tests/validation/test_build_cost.py says how good
they are. Another machine takes its own multiple.
"""

from __future__ import annotations

from math import prod
from typing import Any

import numpy as np

from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.plan.plan import Plan, response_planes
from skyshine.mat.scene.air_cells import shared_cells
from skyshine.mat.scene.atmosphere import air_key
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.grids import path_scope
from skyshine.mat.scene.moisture import job_library

# s for each band, and for each of its spectral points: for the choice of points, and for their errors in an air.
CHOICE_BAND, CHOICE_POINT = 0.16, 1.3e-3
TEST_BAND, TEST_POINT = 0.16, 7.0e-4
TABLE_POINTS = 44  # spectral points for which the constants below hold
HARMONICS = 1.4  # s for harmonics of ambient light and the faces on which they are measured
# s for the fields of the channels at 0.5 K, and for the lines on which their nodes are placed and measured.
CHANNEL_LINES, CHANNEL_PROBES = 2.6, 0.5
FINEST, FINEST_PRICED = 0.5, 0.05  # tolerance [K] of these, and the finest by which they are multiplied
SHARED_TABLE, SHARED_PROBES = 0.3, 0.5  # of these, in a state on the nodes of similar airs
_PARTS = 1000  # lines, to know which share of them samples the part of the paths that needs leave
COMPILED_POINTS = 64  # the most that a compiled band has
GRID_NODE = 3e-7  # s for each node of path radiance on the axes of a job, evaluated from the channels
# s for the sky of a state, for each material under it, for placing its times of day, and for each distinct surface
# column, its forcing included.
SKY, MATERIAL, TIMES, COLUMN = 0.2, 0.008, 0.01, 2.3e-5
# s for each material and plane of the response to shade, and for the whole solutions of a material that measure it.
RESPONSE_PLANE, SHADE_ERROR = 3.5e-3, 0.026
# Times as much of these, columns too, for surfaces on which a film of water may lie: it is solved again until film and
# temperature agree, on more times of day. Fitted to a June day with a shower at noon.
FILM, FILM_SHADE = 28.0, 40.0
# Times as much of a column for leaves and soil together: 86 to 148 us beside 30, batches of 1,152.
OPEN = 4.0
# s for solving the ground around the surfaces of a state, and its walls, at each altitude.
GROUND, WALLS = 0.03, 0.08
PICTURE = 0.45  # s for each file that is drawn
TEXTURE = 5.5  # s for each texture of a megapixel or so


def estimate(loaded: LoadedJob, plan: Plan) -> dict[str, float]:
    """Processor seconds of a build that keeps and finds nothing, by stage."""
    job = loaded.trimmed
    share, part = COMPILED_POINTS / TABLE_POINTS, path_scope(loaded).lines(_PARTS, 0) / _PARTS
    sets, sources = len(job.states), len(job.sources)
    bands = [job.bands[number - 1] for number in job.needed_bands]
    points = [absorption_table().count_between(*band.wavenumber_range) for band in map(response_of, bands)]
    # Half as much work at twice the tolerance: nodes of the two axes that bend most go with its root each.
    kelvin = FINEST / max(tolerance_parts(job.atmosphere_grid.tolerance)[0], FINEST_PRICED)
    sharing = sets - shared_cells(loaded.requested).count(None)
    tables = choices(loaded) + SHARED_TABLE * sharing
    probes = sets - (1 - SHARED_PROBES) * sharing
    nodes = prod(map(len, job.atmosphere_axes().values())) if job.atmosphere_grid.writes_tables else 0
    surface = job.surface_grid
    level = int(np.sum(np.isin(surface.slope_deg, (0.0, 180.0))))
    planes = level + (len(surface.slope_deg) - level) * len(surface.azimuth_deg)
    library = job_library(job)
    balances = sum(1.0 if library[name].opened is None else OPEN for name in plan.materials)
    columns = balances * len(job.surface_altitudes_km) * planes
    material = MATERIAL + (TIMES if surface.time is None else 0.0)
    shaded = response_planes(job)
    rainy = ["rain_mm_h" in state.weather.water for state in job.states]
    lengths = [1 + len(state.weather.days_before) for state in job.states]
    solved = sum(FILM if film else 1.0 for film in rainy)
    shades = sum(FILM_SHADE if film else 1.0 for film in rainy)
    days = sum(length * (FILM if film else 1.0) for length, film in zip(lengths, rainy, strict=True))
    shade_days = sum(length * (FILM_SHADE if film else 1.0) for length, film in zip(lengths, rainy, strict=True))
    files = sum(len(task.files) for task in plan.tasks)
    return {
        "compile": part * choices(loaded) * (CHOICE_BAND * len(points) + CHOICE_POINT * sum(points))
        + part * distinct_airs(job) * (TEST_BAND * len(points) + TEST_POINT * sum(points)),
        "atmosphere": tables * len(points) * sources * CHANNEL_LINES * part * share * kelvin,
        "harmonics": sets * len(points) * sources * HARMONICS * (share if job.ambient_harmonics else 0.0),
        "accuracy": probes * len(points) * sources * part * CHANNEL_PROBES * share,
        "grid": GRID_NODE * nodes * sets * len(points) * sources,
        "temperature": sets * SKY
        + solved * material * len(plan.materials)
        + COLUMN * columns * days
        + _surroundings(job),
        "shade": len(plan.materials)
        * (shades * RESPONSE_PLANE * shaded + shade_days * (SHADE_ERROR if shaded else 0.0)),
        "textures": TEXTURE * len(job.texture_jobs),
        "pictures": PICTURE * files if job.output.pictures else 0.0,
    }


def _surroundings(job: Job) -> float:
    """Processor seconds for the ground and the walls around the surfaces of all states."""
    grounds = sum(state.ground_material is not None for state in job.states)
    walls = sum(state.surroundings is not None and state.surroundings.wall.material is not None for state in job.states)
    return GROUND * grounds + WALLS * walls * len(job.surface_altitudes_km)


def distinct_airs(job: Job) -> int:
    """In how many airs the points of the bands are tested."""
    return len({_air(state) for state in job.states})


def choices(loaded: LoadedJob) -> int:
    """How often the points of the bands are chosen, where those that states share hold the tolerance."""
    job = loaded.requested
    return len(
        {_air(state) if cell is None else cell for state, cell in zip(job.states, shared_cells(job), strict=True)}
    )


def _air(state: State) -> tuple[Any, ...]:
    return air_key(state), state.ground_material
