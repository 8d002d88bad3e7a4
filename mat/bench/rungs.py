"""A job built at one setting: timed by stage, and kept for the next run."""

from __future__ import annotations

import hashlib
import json
import shutil
import time
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import skyshine
from skyshine.mat.bench.sample import cache_in, sampled
from skyshine.mat.bench.settings import Setting
from skyshine.mat.bench.shared_compile import Seconds
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import LoadedJob, load_job
from skyshine.mat.plan.plan import Kind, Plan, make_plan, texture_file
from skyshine.mat.products.product import Context
from skyshine.mat.products.table import PRODUCTS
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.threads import core_count
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.process_memory import children_seconds
from skyshine.schemas.whole_files import write_whole

STAGES = ("compile", "tables", "temperature", "accuracy", "writing", "textures", "start and rest")
_NAMED = {"compile": "compile", "accuracy": "accuracy", "write": "writing"}
_OF_KIND = {Kind.TEXTURE: "textures", Kind.TEMPERATURE: "temperature"}
RECORD, FILES = "rung.json", "built"


@dataclass(frozen=True)
class TaskTime:
    """Processor seconds of a task by stage; `kind` and `band` as `plan.Task`."""

    kind: str
    band: int
    stages: dict[str, float]


@dataclass(frozen=True)
class BuildTime:
    """What one build took.

    Attributes
    ----------
    processor : float
        Seconds of all processes of the build, their start included.
    wall : float
        Seconds by the clock.
    """

    processor: float
    wall: float
    tasks: tuple[TaskTime, ...]

    @property
    def stages(self) -> dict[str, float]:
        """Processor seconds by `STAGES`, which add up to those of the build."""
        seconds = dict.fromkeys(STAGES, 0.0)
        for task in self.tasks:
            for stage, spent in task.stages.items():
                seconds[_stage(Kind(task.kind), stage)] += spent
        seconds[STAGES[-1]] = max(self.processor - sum(seconds.values()), 0.0)
        return seconds


def _stage(kind: Kind, name: str) -> str:
    """To which of `STAGES` a stage of a task belongs."""
    if kind is Kind.TEXTURE:
        return _OF_KIND[kind]
    return _NAMED.get(name) or _OF_KIND.get(kind, "tables")


@dataclass(eq=False)
class Rung:
    """A setting of a job with its databases, and what is known of them.

    Attributes
    ----------
    loaded : LoadedJob
        The job at this setting, with the states that are built.
    folder : Path
        Contains the record of the rung and the folder of its databases.
    cost : BuildTime or None
        None before it is built.
    size : int
        Bytes of the databases.
    refusal : str
        Why the setting cannot be built, in one line; empty where that is not known.
    compiled : dict of (int, int) to float
        Processor seconds of the bands that are compiled already, by state and band.
    """

    setting: Setting
    loaded: LoadedJob
    folder: Path
    cost: BuildTime | None = None
    size: int = 0
    refusal: str = ""
    compiled: Seconds = field(default_factory=dict)

    @classmethod
    def of(cls, setting: Setting, as_written: LoadedJob, folder: Path, states: int) -> Rung:
        """The job at a setting, with so many of its states.

        Raises
        ------
        InputError
            The job does not take the setting.
        """
        loaded = sampled(load_job(setting.content, folder=as_written.folder), states)
        return cls(setting, loaded, folder / setting.name.replace(" ", "_"))

    @property
    def files(self) -> Path:
        """Folder of the databases."""
        return self.folder / FILES

    @property
    def _digest(self) -> str:
        """Digest of the job, the version of the package and the cores that a build takes."""
        values = [self.loaded.requested.model_dump(mode="json"), skyshine.__version__, core_count()]
        return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()

    def resume(self, library: MaterialLibrary) -> None:
        """Take over what an earlier run measured, where the databases are those of the same job and version."""
        try:
            record = json.loads((self.folder / RECORD).read_text(encoding="utf-8"))
            spent = record["time"]
            measured = spent and BuildTime(
                spent["processor"], spent["wall"], tuple(TaskTime(**task) for task in spent["tasks"])
            )
            size, refusal = int(record["size"]), str(record["refusal"])
            same_job = record["digest"] == self._digest
        except (OSError, ValueError, KeyError, TypeError):
            return
        if same_job and refusal:
            self.refusal = refusal
        elif same_job and measured and self._is_current(library):
            self.cost, self.size = measured, size

    def _is_current(self, library: MaterialLibrary) -> bool:
        """Whether all databases are there, undamaged and of this job."""
        textures = [self.files / texture_file(self.loaded, i) for i in range(len(self.loaded.trimmed.texture_jobs))]
        if not all(file.is_file() for file in textures):
            return False
        plan = make_plan(self.loaded, library, textures or None)
        for task in plan.tasks:
            loaded = self.loaded.on_date_of_state(task.index) if task.kind.of_state else self.loaded
            context = Context(task, loaded, plan.materials, job_library(loaded.trimmed))
            if not all(identity.is_current(self.files) for identity in PRODUCTS[task.kind].identity(context)):
                return False
        return True

    def tables(self, state: int, band: int, source: str) -> Tables:
        """The databases of a state, a band and a source."""
        return Tables.open(self.files, state, band, source, self.loaded.trimmed)

    def seconds(self, kind: Kind, *stages: str) -> float:
        """Processor seconds of some stages, or of all, of the tasks of a kind; not a number where none has them."""
        tasks = [] if self.cost is None else [task.stages for task in self.cost.tasks if Kind(task.kind) is kind]
        seconds = [task[name] for task in tasks for name in task if name in stages or not stages]
        return sum(seconds) if seconds else float("nan")

    @property
    def cache(self) -> Path:
        """Folder of the bands, compiled before the build, and skies that it keeps, for the truth of the same job."""
        return self.folder / "cache"

    def build(self, library: MaterialLibrary, textures_of: Rung | None = None) -> BuildTime:
        """Build everything but the bands in `cache` again, keep there what it computes of the job, and record how long
        it took, with the time that the bands have taken.

        Parameters
        ----------
        library : MaterialLibrary
        textures_of : Rung, optional
            Rung of the same textures: they are copied, and their time is counted.

        Raises
        ------
        InputError, CheckFailed
            As the build of a job. That a tolerance cannot be held is kept too.
        """
        if self.refusal:
            raise CheckFailed(self.refusal)
        plan = make_plan(self.loaded, library)
        finished = None if textures_of is None else textures_of.cost
        shared = [task.files[0] for task in plan.tasks if task.kind is Kind.TEXTURE] if finished else []
        shutil.rmtree(self.files, ignore_errors=True)
        for folder in (self.files, self.cache):
            folder.mkdir(parents=True, exist_ok=True)
        if textures_of is not None:
            for name in shared:
                shutil.copy(textures_of.files / name, self.files)
        children, parent, begin = children_seconds(), time.process_time(), time.perf_counter()
        try:
            with cache_in(self.cache):
                result = build(self.loaded, out=self.files, fresh=not shared)
        except CheckFailed as error:
            if not isinstance(error.__cause__, BrokenProcessPool):  # which may not happen again
                self.refusal = " ".join(str(error).split())
                self.keep()
            raise
        wall = time.perf_counter() - begin + max(self.compiled.values(), default=0.0)
        processor = children_seconds() - children + time.process_time() - parent + sum(self.compiled.values())
        tasks = _tasks(plan, result["files"], self.compiled)
        if finished is not None:
            copied = tuple(task for task in finished.tasks if Kind(task.kind) is Kind.TEXTURE)
            tasks = (*(task for task in tasks if Kind(task.kind) is not Kind.TEXTURE), *copied)
            processor += sum(sum(task.stages.values()) for task in copied)
        self.cost = BuildTime(processor, wall, tasks)
        self.size = sum((self.files / name).stat().st_size for name in result["files"])
        self.keep()
        return self.cost

    def keep(self) -> None:
        """Write the record, for `resume`."""
        record = {
            "digest": self._digest,
            "time": None if self.cost is None else asdict(self.cost),
            "size": self.size,
            "refusal": self.refusal,
        }
        write_whole(self.folder / RECORD, json.dumps(record, indent=1) + "\n")


def _tasks(plan: Plan, files: dict[str, Any], compiled: Seconds) -> tuple[TaskTime, ...]:
    """Times of the tasks of a plan, from the record of a build, whose files of one task have the same entry; with those
    of bands compiled before.
    """
    tasks = []
    for task in plan.tasks:
        stages = dict(files[task.files[0]]["processor_stages"])
        if task.kind is Kind.ATMOSPHERE:
            stages["compile"] = stages.get("compile", 0.0) + compiled.get((task.index, task.band), 0.0)
        tasks.append(TaskTime(task.kind.value, task.band, stages))
    return tuple(tasks)
