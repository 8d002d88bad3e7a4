"""What a build will take, estimated from its plan by a measured model.

Constants are fits to builds of the starter job, of the default grid and of five days of a year, with three to 133
materials, on one core of a 2.5 GHz server, in processor seconds; tests/validation/test_build_cost.py says how good they
are. Another machine takes its own multiple.
"""

from __future__ import annotations

from math import prod
from typing import Any

import numpy as np

from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.plan.plan import Kind, Plan, response_planes
from skyshine.mat.scene.air_cells import shared_cells
from skyshine.mat.scene.atmosphere import air_key
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.grids import path_scope
from skyshine.mat.tables.band import PLANCK_TEMPERATURES

# s for each band, and for each of its spectral points: for the choice of points, and for their errors in an air.
CHOICE_BAND, CHOICE_POINT = 0.16, 1.3e-3
TEST_BAND, TEST_POINT = 0.16, 7.0e-4
# s for each line of sight, each node of the path radiance and each source elevation (sky light), of a table of 44
# points.
TABLE_LINE, TABLE_NODE, TABLE_SOURCE, TABLE_POINTS = 8.5e-4, 4.5e-6, 0.09, 44
# s for harmonics of ambient light at TABLE_POINTS: of the sky, for each source elevation in it, for each line of sight,
# and for the faces on which they are measured.
HARMONIC_SKY, HARMONIC_SOURCE, HARMONIC_LINE, HARMONIC_FACES = 0.5, 0.065, 6.0e-4, 0.7
# s for the fields of tables in channels at 0.5 K, and for the lines on which their nodes are placed and measured.
CHANNEL_LINES, CHANNEL_PROBES = 6.0, 5.0
SHARED_TABLE, SHARED_PROBES = 0.3, 0.5  # of these, in a state on the nodes of similar airs
_PARTS = 1000  # lines, to know which share of them samples the part of the paths that needs leave
COMPILED_POINTS = 64  # the most that a compiled band has
MEASURED = 1.0  # s for the lines of sight on which a table is measured, at TABLE_POINTS
# s for each spectral point and range of a line of sight of weighted transmittance, and for each weight there; lines
# beside the table's.
EMISSION_END, EMISSION_WEIGHT, EMISSION_LINES = 3e-8, 1.5e-10, 600
# s for the sky of a state, for each material under it, for placing its times of day, and for each distinct surface
# column, its forcing included.
SKY, MATERIAL, TIMES, COLUMN = 0.2, 0.008, 0.01, 2.3e-5
# s for each material and plane of the response to shade, and for the whole solutions of a material that measure it.
RESPONSE_PLANE, SHADE_ERROR = 3.5e-3, 0.026
# Times as much of these, columns too, for surfaces on which a film of water may lie: it is solved again until film and
# temperature agree, on more times of day. Fitted to a June day with a shower at noon.
FILM, FILM_SHADE = 28.0, 40.0
# s for solving the ground around the surfaces of a state, and its walls, at each altitude.
GROUND, WALLS = 0.03, 0.08
PICTURE = 0.45  # s for each file that is drawn
TEXTURE = 1.0  # s for each texture of a megapixel or so


def estimate(loaded: LoadedJob, plan: Plan) -> dict[str, float]:
    """Processor seconds of a build that keeps and finds nothing, by stage.

    Tables whose nodes a tolerance places count as they stand in the job: how many it takes is not known before.
    """
    job, grid = loaded.trimmed, loaded.trimmed.atmosphere_grid
    share, part = COMPILED_POINTS / TABLE_POINTS, path_scope(loaded).lines(_PARTS, 0) / _PARTS
    sets, sources = len(job.states), len(job.sources)
    wanted = [job.bands[number - 1] for number in job.needed_bands]
    points = [absorption_table().points(*band.wavenumber_range).wavenumber.size for band in map(response_of, wanted)]
    path, light = (job.atmosphere_axes(name) for name in ("path_radiance_ratio", "ambient_radiance"))
    lines = len(light["altitude_km"]) * len(light["elevation_deg"])
    heights = len(light["source_elevation_deg"])
    path_lines, nodes = len(path["altitude_km"]) * len(path["elevation_deg"]), prod(map(len, path.values()))
    one = share * (TABLE_LINE * path_lines + TABLE_NODE * nodes + TABLE_SOURCE * heights)
    tilted = share if job.ambient_harmonics else 0.0
    measured, tables, probes = MEASURED * share, float(sets), float(sets)
    if grid.in_channels:
        one, measured = CHANNEL_LINES * part * share, CHANNEL_PROBES * share
        sharing = sets - shared_cells(loaded.requested).count(None)
        tables = choices(loaded) + SHARED_TABLE * sharing
        probes = sets - (1 - SHARED_PROBES) * sharing
    harmonics = tilted * (HARMONIC_SKY + HARMONIC_SOURCE * heights + HARMONIC_LINE * lines)
    surface = job.surface_grid
    level = int(np.sum(np.isin(surface.slope_deg, (0.0, 180.0))))
    planes = level + (len(surface.slope_deg) - level) * len(surface.azimuth_deg)
    columns = len(plan.materials) * len(job.surface_altitudes_km) * planes
    material = MATERIAL + (TIMES if surface.time is None else 0.0)
    shaded = response_planes(job)
    rainy = ["rain_mm_h" in state.weather.water for state in job.states]
    lengths = [1 + len(state.weather.days_before) for state in job.states]
    solved = sum(FILM if film else 1.0 for film in rainy)
    shades = sum(FILM_SHADE if film else 1.0 for film in rainy)
    days = sum(length * (FILM if film else 1.0) for length, film in zip(lengths, rainy, strict=True))
    shade_days = sum(length * (FILM_SHADE if film else 1.0) for length, film in zip(lengths, rainy, strict=True))
    weights = EMISSION_WEIGHT * len(plan.materials) * PLANCK_TEMPERATURES.size
    emitted = job.atmosphere_axes("beta_star_thermal")
    emitted_lines = len(emitted["altitude_km"]) * len(emitted["elevation_deg"]) + EMISSION_LINES * part
    emission = (EMISSION_END + weights) * emitted_lines * len(emitted["range_km"])
    weighted = {task.band for task in plan.tasks if task.kind is Kind.THERMAL}
    files = sum(len(task.files) for task in plan.tasks)
    return {
        "compile": part * choices(loaded) * (CHOICE_BAND * len(points) + CHOICE_POINT * sum(points))
        + part * distinct_airs(job) * (TEST_BAND * len(points) + TEST_POINT * sum(points)),
        "atmosphere": tables * len(points) * sources * one,
        "harmonics": sets * len(points) * sources * harmonics,
        "accuracy": probes * len(points) * sources * part * (measured + HARMONIC_FACES * tilted),
        "weighted transmittance": sets
        * emission
        * sum(count for number, count in zip(job.needed_bands, points, strict=True) if number in weighted),
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
