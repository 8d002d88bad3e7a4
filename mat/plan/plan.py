"""What a job needs: the tasks that build its files, what is left out and why, and how large the result is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.job.extra_tables import WEIGHTED_TRANSMITTANCE
from skyshine.mat.job.model import Job, LoadedJob
from skyshine.mat.job.needs import hours_around
from skyshine.mat.tables.band import PLANCK_TEMPERATURES
from skyshine.mat.tables.files import atmosphere_file, band_file, state_file, thermal_file
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import InputError
from skyshine.tmm.load import job_materials
from skyshine.tmm.usage import read_usage

FLOAT_BYTES = 4
# Lines of sight are integrated in steps that end at the ranges of a table; mat bench leaving-out measures it, before
# the ground.
STEP_BOUND = "0.1 % of a value; of path radiance some percent in cells that reach behind the ground"


@dataclass(frozen=True)
class Task:
    """One independent part of a build.

    Attributes
    ----------
    kind : str
        ``texture``, ``atmosphere``, ``temperature``, ``thermal`` (weighted transmittance) or ``band``.
    index : int
        Of the texture, counted from 0, or of the state, counted from 1; of the band for ``band``.
    band : int
        Counted from 1; 0 where the task has none.
    files : tuple of str
        That it writes into the output folder.
    values : int
        Numbers in those files.
    """

    kind: str
    index: int
    band: int
    files: tuple[str, ...]
    values: int


@dataclass(frozen=True)
class LeftOut:
    """Something that the job does not need.

    Attributes
    ----------
    what, why : str
    bound : str
        What leaving it out changes at most.
    restore : str
        The key that brings it back.
    """

    what: str
    why: str
    bound: str
    restore: str


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
    return f"{loaded.job.textures[index].name}.tmm.h5"


def named_materials(loaded: LoadedJob) -> tuple[str, ...]:
    """Materials that the job or the seeds of its textures name: no other can come to be used."""
    job = loaded.job
    names = set(job.materials) if isinstance(job.materials, list) else set()
    for texture in job.textures:
        names |= set(job_materials(texture, loaded.folder))
    return tuple(sorted(names))


def used_materials(loaded: LoadedJob, library: MaterialLibrary, usage_files: list | None = None) -> tuple[str, ...]:
    """Materials to build, in the order of their codes.

    Parameters
    ----------
    usage_files : list of path, optional
        Databases of all textures of the job; without them the materials that the seeds name are taken.

    Raises
    ------
    InputError
        The textures use no known material.
    """
    job = loaded.job
    if job.materials == "all":
        names = set(library.names)
    elif isinstance(job.materials, list):
        names = set(job.materials)
    elif usage_files is None:
        names = set(named_materials(loaded))
    else:
        names = {name for file in usage_files for name, share in read_usage(file).items() if share > 0}
    if not names:
        raise InputError("no material is used: the textures have no texel of a known material; see 'tmm preview'")
    return tuple(name for name in library.names if name in names)


def make_plan(loaded: LoadedJob, library: MaterialLibrary, usage_files: list | None = None) -> Plan:
    """Plan a job.

    Raises
    ------
    InputError
        The job uses no material at all.
    """
    job = loaded.job
    materials = used_materials(loaded, library, usage_files)
    tasks = [Task("texture", i, 0, (texture_file(loaded, i),), 0) for i in range(len(job.textures))]
    states = len(job.states)
    for state in range(1, states + 1):
        for band in job.needed_bands:
            files = tuple(atmosphere_file(state, band, source, states) for source in job.sources)
            tasks.append(Task("atmosphere", state, band, files, len(files) * _atmosphere_values(job)))
            if WEIGHTED_TRANSMITTANCE in job.extra_tables:
                # One class for each material is the most there can be.
                size = len(materials) * PLANCK_TEMPERATURES.size * _paths(job)
                tasks.append(Task("thermal", state, band, (thermal_file(state, band, states),), size))
        size = len(materials) * _surface_values(job)
        tasks.append(Task("temperature", state, 0, (state_file(state, states),), size))
    tasks += [Task("band", band, band, (band_file(band),), 0) for band in job.needed_bands]
    return Plan(tuple(tasks), materials, tuple(_left_out(loaded, library, materials)))


def _atmosphere_values(job: Job) -> int:
    grid = job.atmosphere_grid
    return _paths(job) * (1 + len(grid.source_elevation_deg) * (2 + len(grid.source_azimuth_deg)))


def _paths(job: Job) -> int:
    return len(job.atmosphere_grid.range_km) * len(job.observer_altitudes_km) * len(job.atmosphere_grid.elevation_deg)


def _surface_values(job: Job) -> int:
    grid = job.surface_grid
    return len(job.surface_altitudes_km) * len(grid.azimuth_deg) * len(grid.slope_deg) * len(_times(job))


def _times(job: Job) -> list[float]:
    return hours_around(job.surface_grid.time, job.needs and job.needs.hours)


def _left_out(loaded: LoadedJob, library: MaterialLibrary, materials: tuple[str, ...]) -> list[LeftOut]:
    job, found = loaded.job, []
    unused = set(library.names) - set(materials)
    if unused and job.materials == "used":
        found.append(
            LeftOut(f"{len(unused)} of {len(library)} materials", "no texture uses them", "none", "materials: all")
        )
    level = int(np.sum(np.isin(job.surface_grid.slope_deg, (0.0, 180.0))))
    if level and len(job.surface_grid.azimuth_deg) > 1:
        spared = level * (len(job.surface_grid.azimuth_deg) - 1)
        total = len(job.surface_grid.slope_deg) * len(job.surface_grid.azimuth_deg)
        found.append(
            LeftOut(
                f"{spared} of {total} orientations",
                "level surfaces face no azimuth: solved once and copied",
                "none",
                "nothing to restore: the table holds them",
            )
        )
    found += _not_needed(loaded)
    for source, kind in (("sun", "atmq"), ("moon", "lunar_atmq")):
        if source not in loaded.whole.sources:
            found.append(
                LeftOut(f"{kind} tables", f"sources does not name the {source}", "none", f"sources: [{source}]")
            )
    return found


def _not_needed(loaded: LoadedJob) -> list[LeftOut]:
    """Nodes and sources that nothing within the job's needs reads."""
    job, whole, needs = loaded.job, loaded.whole, loaded.job.needs
    if needs is None:
        return []
    wide = "a wider needs.{0}, or none"
    axes = (
        ("ranges", "range_km", whole.atmosphere_grid.range_km, job.atmosphere_grid.range_km, STEP_BOUND),
        ("observer altitudes", "observer_altitude_km", whole.observer_altitudes_km, job.observer_altitudes_km, "none"),
        ("elevations", "elevation_deg", whole.atmosphere_grid.elevation_deg, job.atmosphere_grid.elevation_deg, "none"),
        (
            "source elevations",
            "hours",
            whole.atmosphere_grid.source_elevation_deg,
            job.atmosphere_grid.source_elevation_deg,
            "none",
        ),
        ("surface altitudes", "surface_altitude_km", whole.surface_altitudes_km, job.surface_altitudes_km, "none"),
        ("slopes", "slope_deg", whole.surface_grid.slope_deg, job.surface_grid.slope_deg, "none"),
        ("times of day", "hours", whole.surface_grid.time, _times(job), "none"),
    )
    found = [
        LeftOut(
            f"{len(nodes) - len(kept)} of {len(nodes)} {name}",
            f"no read within needs.{key} touches them",
            bound,
            wide.format(key),
        )
        for name, key, nodes, kept, bound in axes
        if len(kept) < len(nodes)
    ]
    found += [
        LeftOut(
            f"all files of the band {name}", "needs.bands does not name it", "none", f"{name} in needs.bands, or none"
        )
        for number, name in enumerate(job.band_names, 1)
        if number not in job.needed_bands
    ]
    found += [
        LeftOut(
            f"tables of the {source}",
            "it is below all their elevations in the hours needed",
            "none",
            wide.format("hours"),
        )
        for source in whole.sources
        if source not in job.sources
    ]
    return found
