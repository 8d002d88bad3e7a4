"""From a plan to files: the executor, progress, what is kept, the catalogue."""

from __future__ import annotations

import logging
import os
import time
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from dataclasses import dataclass, field
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from skyshine.mat import threads
from skyshine.mat.builder.executors import open_executor
from skyshine.mat.builder.failures import TaskLost, messages, refuse_failures, stops_the_build
from skyshine.mat.builder.folder import other_files, sole_build_in
from skyshine.mat.builder.parts import Part
from skyshine.mat.builder.record import merge_parts, record_of, write_part, write_record
from skyshine.mat.builder.tasks import draw_task, run_task
from skyshine.mat.job.load import JobSites, LoadedJob
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.plan.plan import Kind, Task, make_plan, texture_file, used_materials
from skyshine.mat.plan.size import check_size
from skyshine.mat.products.product import TaskReport
from skyshine.mat.scene.check import check_scene
from skyshine.mat.tables.catalog import write_catalog
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.progress import Progress, silent

LOST_TIMES = 5  # that a task may be lost before the build ends
WINDOW = 4_000  # tasks that a cluster has at a time; later sites are read when it has fewer
_log = logging.getLogger("skyshine.mat.build")


@dataclass(frozen=True, eq=False)
class Work:
    """A task with the job of its site."""

    task: Task
    loaded: LoadedJob


@dataclass
class Outcome:
    """What became of the tasks of a build.

    Attributes
    ----------
    reports : dict of Task to TaskReport
        Those that ended well.
    failed : dict of Task to Exception
        The others.
    sites : dict of str to InputError
        Sites whose job could not be read.
    drawable : list of Work
        Tasks whose files are to be drawn.
    """

    reports: dict[Task, TaskReport] = field(default_factory=dict)
    failed: dict[Task, Exception] = field(default_factory=dict)
    sites: dict[str, InputError] = field(default_factory=dict)
    drawable: list[Work] = field(default_factory=list)


def build(
    job: LoadedJob | JobSites,
    *,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    executor: str | None = None,
    part: str | None = None,
    pictures: bool | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Build all files of a job; then draw them.

    Parameters
    ----------
    job : LoadedJob or JobSites
    out : path, optional
        Output folder; by default the one that the job names.
    jobs : int, optional
        Processes; by default one a core.
    fresh : bool
        Build files again that the same job has built before.
    executor : str, optional
        ``dask:ADDRESS`` of a scheduler; by default processes of this machine.
    part : str, optional
        ``I/N``: the I-th of N disjoint parts of the states, into the same folder. Bands and textures, which all states
        have in common, are built by the part that comes to them first. The part that ends last writes the catalogue.
    pictures : bool, optional
        Whether the files are drawn once all are ready; by default as the job says.
    progress : callable, optional
        ``progress(total, description)`` gives a context manager; what it yields is called with the tasks done since.

    Returns
    -------
    dict
        Folder, seconds, databases of the folder that are not of this job, and for each file whether it was kept, its
        seconds, stages and peak memory.

    Raises
    ------
    InputError
        The job does not fit, a file cannot be written, or another build writes into the folder. Where only some tables
        or sites fail, once the others are built.
    CheckFailed
        A process of the build died, or a table failed for another reason than its input.
    """
    begin = time.perf_counter()
    sites = job if isinstance(job, JobSites) else JobSites.of(job)
    share, outcome = None if part is None else Part.of_text(part), Outcome()
    batches = _batches(sites, share, outcome)
    start = next(batches, None)
    if start is None:
        if outcome.sites:
            raise next(iter(outcome.sites.values()))
        raise InputError(f"found --part {part}, which has no state; allowed: at most as many parts as states")
    loaded = start[0].loaded
    folder = Path(out).resolve() if out is not None else loaded.output_folder
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}; name another output folder", file=folder) from None
    drawn = loaded.trimmed.output.pictures if pictures is None else pictures
    of_state = sum(work.task.kind.of_state for work in start)
    further = 0 if share is not None else len(sites.names) - len(outcome.sites) - 1
    total = len(start) + of_state * further
    jobs = min(jobs or threads.core_count(), total)
    atmospheres = sum(work.task.kind == Kind.ATMOSPHERE for work in start)
    spare = {threads.VARIABLE: str(max(1, jobs // max(1, atmospheres)))}
    with sole_build_in(folder, share), open_executor(executor, jobs, folder, spare) as processes:
        run = _Run(folder, fresh, processes, outcome, drawn, WINDOW if executor else jobs)
        run.all(start, batches, total, progress)
        reports, reasons = list(outcome.reports.values()), messages(outcome.failed)
        reasons |= {f"{site}/": str(error) for site, error in outcome.sites.items()}
        entries = [entry for report in reports for entry in report.entries]
        record = record_of(folder, reports, time.perf_counter() - begin, reasons)
        if share is not None:
            write_part(folder, share, record, entries)
            merge_parts(folder, share)
        else:
            if entries:
                write_catalog(folder, entries)
            record["not_of_this_job"] = other_files(folder, {*record["files"], *reasons})
            write_record(folder, record)
        if drawn:
            ready = f"{folder}: {len(record['files'])} files ready in {record['seconds']:.1f} s; pictures follow"
            _draw_all(outcome.drawable, folder, processes, progress, ready)
        refuse_failures(outcome.failed, outcome.sites, len(record["files"]) + len(messages(outcome.failed)))
        return record


def _batches(sites: JobSites, share: Part | None, outcome: Outcome) -> Iterator[list[Work]]:
    """The tasks of each site, read when they are asked for: textures, what waits for none of them, the others. Tasks of
    all sites in common come with the first.
    """
    common = True
    for number, name in enumerate(sites.names):
        if share is not None and not share.has_site(number, len(sites.names)):
            continue
        try:
            loaded = sites.load(number)
            plan = make_plan(loaded, job_materials(loaded.trimmed.own_materials))
            check_size(loaded, plan, len(sites.names))
            check_scene(loaded)
        except InputError as error:
            if not name:
                raise
            outcome.sites[name] = error
            continue
        states = len(loaded.trimmed.states)
        works = [
            Work(task, loaded)
            for task in plan.tasks
            if (common if not task.kind.of_state else True)
            and (
                share is None or not task.kind.of_state or share.has_state(number, len(sites.names), task.index, states)
            )
        ]
        if not any(work.task.kind.of_state for work in works):
            continue
        common = False
        works.sort(key=lambda work: (work.task.kind != Kind.TEXTURE, work.task.kind.reads_materials))
        yield works


class _Run:
    """The tasks of a build on their way through an executor, `window` at a time."""

    def __init__(
        self, folder: Path, fresh: bool, executor: Executor, outcome: Outcome, drawn: bool, window: int
    ) -> None:
        self.folder, self.fresh, self.executor, self.outcome, self.drawn = folder, fresh, executor, outcome, drawn
        self.window = window
        self.ready: deque[Work] = deque()
        self.held: deque[Work] = deque()  # until the textures are there
        self.running: dict[Future[TaskReport], Work] = {}
        self.ended: SimpleQueue[Future[TaskReport]] = SimpleQueue()
        self.textures = 0
        self.lost: Counter[Task] = Counter()
        self.again: list[Work] = []  # failed once, for another reason than their input
        self.order: dict[Task, None] = {}

    def all(self, start: Sequence[Work], batches: Iterator[list[Work]], total: int, progress: Progress) -> None:
        """Run all tasks; those that failed for another reason than their input a second time, after all others."""
        self._take(start)
        with progress(total, f"building {start[0].loaded.trimmed.name}") as advance:
            while True:
                self._submit(batches)
                if not self.running:
                    if not self.again:
                        break
                    self.ready.extend(self.again)
                    self.again = []
                    continue
                future = self.ended.get()
                self._ended(self.running.pop(future), future, total, advance)
        outcome = self.outcome
        outcome.reports = {task: outcome.reports[task] for task in self.order if task in outcome.reports}
        outcome.failed = {task: outcome.failed[task] for task in self.order if task in outcome.failed}

    def _take(self, works: Sequence[Work]) -> None:
        self.textures += sum(work.task.kind == Kind.TEXTURE for work in works)
        self.order |= dict.fromkeys(work.task for work in works)
        for work in works:
            (self.held if self.textures and work.task.kind.reads_materials else self.ready).append(work)

    def _submit(self, batches: Iterator[list[Work]]) -> None:
        while len(self.running) < self.window:
            if not self.ready:
                works = next(batches, None)
                if works is None:
                    return
                self._take(works)
                continue
            work = self.ready.popleft()
            task = work.task
            materials = _materials(work.loaded, self.folder) if task.kind.reads_materials else ()
            loaded = work.loaded.with_state_alone(task.index) if task.kind.of_state else work.loaded
            future = self.executor.submit(run_task, task, loaded, self.folder, materials, self.fresh)
            self.running[future] = work
            future.add_done_callback(self.ended.put)

    def _ended(self, work: Work, future: Future[TaskReport], total: int, advance: Any) -> None:
        task, outcome = work.task, self.outcome
        try:
            report = future.result()
        except TaskLost as error:
            self.lost[task] += 1
            if self.lost[task] > LOST_TIMES:
                raise CheckFailed(
                    f"{task.files[0]} was lost {LOST_TIMES + 1} times ({error}); finished files are kept: run it again"
                ) from None
            self.ready.appendleft(work)
            return
        except Exception as error:
            if stops_the_build(task, error, self.folder):
                raise
            if not isinstance(error, InputError) and task not in outcome.failed:
                self.again.append(work)
                outcome.failed[task] = error
                return
            outcome.failed[task] = error
        else:
            outcome.failed.pop(task, None)
            outcome.reports[task] = report
            if self.drawn:
                outcome.drawable.append(work)
            _say(work.loaded, task, report, f"{len(outcome.reports)} of {total} done")
        advance(1)
        if task.kind is Kind.TEXTURE:
            self.textures -= 1
            if not self.textures:
                self.ready.extendleft(reversed(self.held))  # temperatures take long: not after all atmospheres
                self.held.clear()


def _draw_all(works: Sequence[Work], folder: Path, executor: Executor, progress: Progress, ready: str) -> None:
    """Say that the files are ready, and draw those of finished tasks in the processes of the build."""
    with progress(len(works), "drawing pictures") as advance:
        _log.info(ready)
        futures = [
            executor.submit(draw_task, work.task, work.loaded, folder, _materials(work.loaded, folder))
            for work in works
        ]
        for future in as_completed(futures):
            future.result()
            advance(1)


def _say(loaded: LoadedJob, task: Task, report: TaskReport, progress: str) -> None:
    """Log a line for each file of a finished task: which state, its seconds, the error that it reached."""
    job = loaded.trimmed
    count = len(job.states) if task.kind.of_state else len(job.bands) if task.band or task.kind is Kind.BAND else 0
    part = f", {'state' if task.kind.of_state else 'band'} {task.index} of {count}" if count else ""
    for name in report.files:
        error = report.error_kelvin.get(name)
        reached = f", 99 % within {error['p99']:.2g} K" if error else ""
        built = f"built in {report.seconds:.1f} s" if name == report.files[0] else f"built with {report.files[0]}"
        what = "kept" if report.kept else built
        _log.info("%s%s: %s%s; %s", name, part, what, reached, progress)


def _materials(loaded: LoadedJob, folder: Path) -> tuple[str, ...]:
    """The materials to build: those of the job, or those that its finished textures use."""
    usage = [folder / texture_file(loaded, i) for i in range(len(loaded.trimmed.texture_jobs))]
    return used_materials(loaded, job_materials(loaded.trimmed.own_materials), usage or None)
