"""The plan of a job: its files, its omissions with their reasons, its size and time."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.builder.failures import unread_sites
from skyshine.mat.job.load import JobSites, LoadedJob, job_sites
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.plan.left_out import LeftOut
from skyshine.mat.plan.plan import FLOAT_BYTES, Plan, make_plan
from skyshine.mat.plan.resources import Resources, resources, together
from skyshine.mat.plan.size import check_size
from skyshine.mat.products.reach import tolerance_notes
from skyshine.mat.scene.agreement import air_warnings, twilight_warnings
from skyshine.mat.scene.check import check_scene
from skyshine.mat.scene.notes import ground_notes, surface_notes
from skyshine.mat.scene.sources import source_hours
from skyshine.mat.scene.summary import state_summaries
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.result import Result
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False, repr=False)
class JobCheck(Result):
    """A valid job with its plan.

    Attributes
    ----------
    loaded : LoadedJob
    plan : Plan
    source_up : dict of str to list of (str, str)
        Local clock times between which each source is up, on the day of the first state.
    states : list of dict
        Summary of each state, of one site after the other.
    cost : Resources
        Processor time, hours on so many cores, disk and memory, estimated within a factor of 1.5.
    warnings : list of str
        Contradictions between weather, profile, sounding and the site of a weather file, and tolerances that a build
        will probably not reach, with numbers.
    surfaces : list of str
        What the job changes in materials of the library, with numbers.
    sites : tuple of str
        Names of the sites, of a job that has several; times of sources and what is omitted are those of the first.
    """

    loaded: LoadedJob
    plan: Plan
    source_up: dict[str, list[tuple[str, str]]]
    states: list[dict[str, Any]]
    cost: Resources
    warnings: list[str]
    surfaces: list[str]
    sites: tuple[str, ...] = ()

    @cached_property
    def left_out(self) -> list[LeftOut]:
        """Each omission with its reason, the bound of the change and the way to restore it; computed when asked for."""
        from skyshine.mat.plan.physics import physics_left_out

        return [*self.plan.left_out, *physics_left_out(self.loaded)]

    @cached_property
    def continua(self) -> list[str]:
        """What the choice between water vapour continua changes in the bands, where it is much; computed when asked
        for.
        """
        from skyshine.mat.scene.continuum_spread import spread_warnings

        return spread_warnings(self.loaded)

    @property
    def seconds(self) -> dict[str, float]:
        """Processor seconds by stage."""
        return self.cost.seconds

    @property
    def files(self) -> list[str]:
        """Names of the files that a build writes."""
        return [name for task in self.plan.tasks for name in task.files]

    @property
    def materials(self) -> list[str]:
        """Names of the materials that a build solves."""
        return list(self.plan.materials)

    @property
    def bytes(self) -> int:
        """Size of the tables before compression."""
        return self.plan.bytes

    def to_xarray(self) -> xarray.Dataset:
        """The plan as an `xarray.Dataset`: bytes before compression of each file, processor seconds of each stage.

        Files that one task writes have equal sizes. Sizes of textures and of band properties are not a number: no plan
        knows them.
        """
        sizes = {
            name: FLOAT_BYTES * task.values / len(task.files) if task.values else np.nan
            for task in self.plan.tasks
            for name in task.files
        }
        return dataset(
            {"file": ("1", np.array(list(sizes), str)), "stage": ("1", np.array(list(self.seconds), str))},
            {
                "size_before_compression": (("file",), "byte", np.array(list(sizes.values()), float)),
                "estimated_time": (("stage",), "s", np.array(list(self.seconds.values()), float)),
            },
            {"job": self.loaded.trimmed.name, "materials": ", ".join(self.materials)},
        )

    def __repr__(self) -> str:
        return (
            f"<JobCheck '{self.loaded.trimmed.name}': {len(self.files)} files, {len(self.materials)} materials,"
            f" {self.cost.disk / 1e6:.1f} MB, about {self.cost.total:.0f} s of one core>"
        )


def check(job: str | os.PathLike[str] | Mapping[str, Any]) -> JobCheck:
    """Check a job as `mat check` does; what it accepts, `build` builds.

    Parameters
    ----------
    job : path or mapping
        A YAML job, or its content; paths in a mapping are relative to the working directory.

    Raises
    ------
    InputError
        The first thing in the job that does not fit.

    Examples
    --------
    >>> import skyshine.mat
    >>> plan = skyshine.mat.check(skyshine.mat.example("ship"))
    >>> "s01.htt.h5" in plan.files
    True
    """
    sites = job_sites(job)
    return checked(sites.load(0)) if sites.names == ("",) else _checked_sites(sites)


def _checked_sites(sites: JobSites) -> JobCheck:
    """The plan of all sites: each is read and checked as a build does."""
    failed: dict[str, InputError] = {}
    parts: dict[str, JobCheck] = {}
    for number, name in enumerate(sites.names):
        try:
            loaded = sites.load(number)
            parts[name] = checked(loaded, len(sites.names))
        except InputError as error:
            failed[name] = error
    if failed:
        raise unread_sites(failed)
    first = next(iter(parts.values()))
    tasks = {task.files: task for part in parts.values() for task in part.plan.tasks}  # bands are of all sites
    return replace(
        first,
        plan=replace(first.plan, tasks=tuple(tasks.values())),
        states=[state | {"site": name} for name, part in parts.items() for state in part.states],
        cost=together([part.cost for part in parts.values()]),
        warnings=[f"site {name}: {text}" for name, part in parts.items() for text in part.warnings],
        sites=sites.names,
    )


def checked(loaded: LoadedJob, sites: int = 1) -> JobCheck:
    """The plan of a job that is read already, one of so many sites, as `check`.

    Raises
    ------
    InputError
        The first thing in the job that does not fit.
    """
    plan = make_plan(loaded, job_materials(loaded.trimmed.own_materials))
    check_size(loaded, plan, sites)
    check_scene(loaded)
    return JobCheck(
        loaded,
        plan,
        source_hours(loaded.trimmed.on_date_of_state(1)),
        state_summaries(loaded.trimmed),
        resources(loaded, plan),
        [
            *loaded.warnings,
            *air_warnings(loaded.trimmed),
            *twilight_warnings(loaded.trimmed),
            *tolerance_notes(loaded, plan.materials),
        ],
        [*surface_notes(loaded.trimmed, plan.materials), *ground_notes(loaded.trimmed, plan.materials)],
    )
