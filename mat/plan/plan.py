"""What a job needs: the tasks that build its files, what is omitted and why, and how large the result is."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import prod
from pathlib import Path

import numpy as np

from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.plan.left_out import LeftOut, tables_left_out, temperature_times
from skyshine.mat.surface.response_nodes import LAG_STARTS, OFFSETS, RESPONSE_HOURS, response_slopes
from skyshine.mat.tables.files import atmosphere_file, band_file, state_file
from skyshine.mat.tables.gridded import QUANTITIES
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.database.usage import read_usage
from skyshine.tmm.inputs.named_materials import job_materials, refuse_without_materials

FLOAT_BYTES = 4  # bytes of a float of single precision
_VALUES_IN_CHANNELS = 300_000  # values of tables in channels, whose nodes a tolerance places: those of 0.5 K in 3-5 um
_VALUES_OF_RESPONSE = RESPONSE_HOURS.size * (LAG_STARTS.size + OFFSETS.size + 3)  # values of response of a plane


class Kind(StrEnum):
    """Kinds of task; `skyshine.mat.products.table` has a product for each."""

    TEXTURE = "texture"
    ATMOSPHERE = "atmosphere"
    TEMPERATURE = "temperature"
    BAND = "band"

    @property
    def of_state(self) -> bool:
        """Whether its tasks are each of one state, on the date of that state."""
        return self in (Kind.ATMOSPHERE, Kind.TEMPERATURE)

    @property
    def reads_materials(self) -> bool:
        """Whether its tasks need the materials that the textures use, so that they wait for the textures."""
        return self in (Kind.TEMPERATURE, Kind.BAND)


@dataclass(frozen=True)
class Task:
    """One independent part of a build.

    Attributes
    ----------
    index : int
        Number of the texture, counted from 0, or of the state or band, counted from 1.
    band : int
        Counted from 1; 0 where the task has none.
    files : tuple of str
        Names of the files that the task writes into the output folder; with several sites, in a folder of its site.
    values : int
        Numbers in those files.
    """

    kind: Kind
    index: int
    band: int
    files: tuple[str, ...]
    values: int


@dataclass(frozen=True)
class Plan:
    """The tasks of a job and what it leaves out."""

    tasks: tuple[Task, ...]
    materials: tuple[str, ...]
    left_out: tuple[LeftOut, ...]

    @property
    def bytes(self) -> int:
        """Size of all files before compression."""
        return FLOAT_BYTES * sum(task.values for task in self.tasks)


def texture_file(loaded: LoadedJob, index: int) -> str:
    """Name of the database of a texture."""
    return f"{loaded.trimmed.texture_jobs[index].name}.tmm.h5"


def named_materials(loaded: LoadedJob) -> tuple[str, ...]:
    """Materials that the job or the seeds of its textures name: no other can come to be used."""
    job = loaded.trimmed
    names = set(job.materials) if isinstance(job.materials, list) else set()
    for texture in job.texture_jobs:
        names |= set(job_materials(texture, loaded.folder))
    return tuple(sorted(names))


def used_materials(
    loaded: LoadedJob, library: MaterialLibrary, usage_files: list[Path] | None = None
) -> tuple[str, ...]:
    """Materials to build, in the order of their codes.

    Parameters
    ----------
    usage_files : list of path, optional
        Databases of all textures that the job classifies; without them the materials that the seeds name are taken.

    Raises
    ------
    InputError
        The textures use no known material.
    """
    job = loaded.trimmed
    if job.materials == "all":
        names = set(library.names)
    elif isinstance(job.materials, list):
        names = set(job.materials)
    elif usage_files is None:
        names = set(named_materials(loaded))
    else:
        names = {name for file in usage_files for name, share in read_usage(file).items() if share > 0}
    if job.materials == "used":
        names |= _of_finished(job, library)
    selected = None if job.query_limits is None else job.query_limits.materials
    if selected is not None:
        names &= set(selected)
        if not names:
            raise InputError(
                f"no material of the job is in needs.materials, {', '.join(selected)}; name some that are used"
            )
    grounds = {state.ground_material for state in job.states if state.ground_material is not None}
    if not names:
        raise InputError("no material is used: the textures have no texel of a known material; see 'tmm preview'")
    return tuple(name for name in library.names if name in names | grounds)


def _of_finished(job: Job, library: MaterialLibrary) -> set[str]:
    """Materials that the finished textures of a job use."""
    materials: set[str] = set()
    for file in job.finished_textures:
        names = {name for name, share in read_usage(file).items() if share > 0}
        for name in sorted(names - set(library.names)):
            raise InputError(f"uses the material '{name}'; {nearest(name, library.names)}; add it", file=file)
        materials |= names
    return materials


def make_plan(loaded: LoadedJob, library: MaterialLibrary, usage_files: list[Path] | None = None) -> Plan:
    """Plan a job.

    Raises
    ------
    InputError
        The job uses no material at all, or a texture names none.
    """
    job = loaded.trimmed
    for texture in job.texture_jobs:
        refuse_without_materials(texture, job_materials(texture, loaded.folder))
    materials = used_materials(loaded, library, usage_files)
    tasks = [Task(Kind.TEXTURE, i, 0, (texture_file(loaded, i),), 0) for i in range(len(job.texture_jobs))]
    states, folder = len(job.states), f"{loaded.site_name}/" if loaded.site_name else ""
    for state in range(1, states + 1):
        for band in job.needed_bands:
            files = tuple(folder + atmosphere_file(state, band, source, states) for source in job.sources)
            tasks.append(Task(Kind.ATMOSPHERE, state, band, files, len(files) * _atmosphere_values(job)))
        size = len(materials) * (surface_values(job) + response_values(job))
        tasks.append(Task(Kind.TEMPERATURE, state, 0, (folder + state_file(state, states),), size))
    tasks += [Task(Kind.BAND, band, band, (band_file(band),), 0) for band in job.needed_bands]
    return Plan(tuple(tasks), materials, tuple(tables_left_out(loaded, library, materials)))


def _atmosphere_values(job: Job) -> int:
    """Numbers in an atmospheric file: those of the channels, and of the tables on five axes."""
    return _VALUES_IN_CHANNELS + grid_values(job)


def grid_values(job: Job) -> int:
    """Numbers in the tables on the five axes of a job, 0 where it has none."""
    if not job.atmosphere_grid.writes_tables:
        return 0
    lengths = [len(nodes) for nodes in job.atmosphere_axes().values()]
    return sum(prod(lengths[:count]) for _, count in QUANTITIES.values())


def surface_values(job: Job) -> int:
    """Numbers in the temperatures of a material, on the axes as the job has them."""
    grid = job.surface_grid
    return len(job.surface_altitudes_km) * len(grid.azimuth_deg) * len(grid.slope_deg) * len(temperature_times(job))


def response_values(job: Job) -> int:
    """Numbers in the response of a material to shade."""
    return response_planes(job) * _VALUES_OF_RESPONSE


# Materials, at random, on which nodes of temperatures are placed, and on which each of many states is measured, others
# on each date.
PLACED_ON, MEASURED_ON = 24, 16


def measured_on(state: State, materials: int) -> int:
    """Number of the materials on which errors of a state's temperatures are measured."""
    return min(materials, MEASURED_ON) if state.is_one_of_many else materials


def response_planes(job: Job) -> int:
    """How many planes of each material have a response to shade in the temperature table."""
    if job.query_limits is not None and not job.query_limits.shade:
        return 0
    altitudes = min(2, len(job.surface_altitudes_km))
    return altitudes * response_slopes(np.array(job.surface_grid.slope_deg, float)).size
