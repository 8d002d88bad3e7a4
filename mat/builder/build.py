"""From a plan to files: the executor, progress, what is kept, the catalogue."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, Executor, Future, as_completed, wait
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from skyshine.mat import threads
from skyshine.mat.builder.executors import open_executor
from skyshine.mat.builder.failures import messages, refuse_failures, stops_the_build
from skyshine.mat.builder.record import write_record
from skyshine.mat.builder.tasks import PICTURES, draw_task, run_task
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Kind, Plan, Task, make_plan, texture_file, used_materials
from skyshine.mat.plan.size import check_size
from skyshine.mat.products.product import TaskReport
from skyshine.mat.scene.check import check_scene
from skyshine.mat.tables.catalog import write_catalog
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError
from skyshine.schemas.progress import Progress, silent
from skyshine.schemas.whole_files import PART

LOCK = "build.lock"
_log = logging.getLogger("skyshine.mat.build")


def build(
    loaded: LoadedJob,
    *,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    fresh: bool = False,
    executor: str | None = None,
    pictures: bool | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Build all files of a job; then draw them.

    Parameters
    ----------
    out : path, optional
        Output folder; by default the one that the job names.
    jobs : int, optional
        Processes; by default one a core.
    fresh : bool
        Build files again that the same job has built before.
    executor : str, optional
        ``dask:ADDRESS`` of a scheduler whose workers see the same folders; by default processes of this machine.
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
        fail, once the others are built.
    CheckFailed
        A process of the build died, or a table failed for another reason than its input.
    """
    begin = time.perf_counter()
    library = load_library()
    folder = Path(out).resolve() if out is not None else loaded.output_folder
    plan = make_plan(loaded, library)
    check_size(loaded, plan)
    check_scene(loaded)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}; name another output folder", file=folder) from None
    drawn = loaded.trimmed.output.pictures if pictures is None else pictures
    jobs = min(jobs or os.cpu_count() or 1, len(plan.tasks))
    atmospheres = sum(task.kind == Kind.ATMOSPHERE for task in plan.tasks)
    spare = {threads.VARIABLE: str(max(1, jobs // max(1, atmospheres)))}
    with _only_build_in(folder), open_executor(executor, jobs, folder, spare) as processes:
        reports, failed = _run_all(loaded, plan, folder, fresh, processes, progress)
        names = [name for report in reports.values() for name in report.files]
        if names:
            write_catalog(folder, names)
        reasons = messages(failed)
        others = sorted({path.name for path in folder.glob("*.h5")} - set(names) - set(reasons))
        record = write_record(folder, list(reports.values()), others, time.perf_counter() - begin, reasons)
        if drawn:
            ready = f"{folder}: {len(names)} files ready in {record['seconds']:.1f} s; pictures follow"
            _draw_all(loaded, reports, folder, processes, progress, ready)
        refuse_failures(failed, len(names) + len(reasons))
        return record


@contextmanager
def _only_build_in(folder: Path) -> Iterator[None]:
    """Keep other builds out of a folder; remove part files of killed ones.

    The system frees the lock of a killed process.
    """
    lock = FileLock(folder / LOCK, timeout=0)
    try:
        with lock:
            for directory in (folder, folder / PICTURES):
                for part in [*directory.glob(f".*{PART}"), *directory.glob(f".*{PART}.png")]:
                    part.unlink(missing_ok=True)
            yield
    except Timeout:
        raise InputError(
            "another build writes into this folder; wait for it, or name another --out", file=folder
        ) from None
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}; check free space and permissions", file=folder
        ) from None


def _run_all(
    loaded: LoadedJob, plan: Plan, folder: Path, fresh: bool, executor: Executor, progress: Progress
) -> tuple[dict[Task, TaskReport], dict[Task, Exception]]:
    """Run the tasks: textures and atmospheres first, then what needs the materials that the textures use.

    Returns
    -------
    dict
        The reports of the tasks that ended well, in the order of the plan.
    dict
        The errors of the others.
    """
    independent = [task for task in plan.tasks if not task.kind.reads_materials]
    independent.sort(key=lambda task: task.kind != Kind.TEXTURE)
    later = [task for task in plan.tasks if task.kind.reads_materials]
    reports: dict[Task, TaskReport] = {}
    failed: dict[Task, Exception] = {}
    with progress(len(plan.tasks), f"building {loaded.trimmed.name}") as advance:
        waiting = {executor.submit(run_task, task, loaded, folder, (), fresh): task for task in independent}
        textures = sum(task.kind == Kind.TEXTURE for task in independent)
        if not textures:
            waiting |= _submit_later(executor, loaded, later, folder, fresh)
        while waiting:
            finished, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in finished:
                task = waiting.pop(future)
                try:
                    reports[task] = future.result()
                except Exception as error:
                    if stops_the_build(task, error, folder):
                        raise
                    failed[task] = error
                else:
                    _say(loaded, task, reports[task], f"{len(reports)} of {len(plan.tasks)} done")
                advance(1)
                textures -= task.kind == Kind.TEXTURE
                if task.kind == Kind.TEXTURE and not textures:
                    waiting |= _submit_later(executor, loaded, later, folder, fresh)
    ended, wrong = ([task for task in plan.tasks if task in among] for among in (reports, failed))
    return {task: reports[task] for task in ended}, {task: failed[task] for task in wrong}


def _draw_all(
    loaded: LoadedJob,
    reports: Mapping[Task, TaskReport],
    folder: Path,
    executor: Executor,
    progress: Progress,
    ready: str,
) -> None:
    """Say that the files are ready, and draw those of finished tasks in the processes of the build."""
    materials = _materials(loaded, folder)
    with progress(len(reports), "drawing pictures") as advance:
        _log.info(ready)
        for future in as_completed(executor.submit(draw_task, task, loaded, folder, materials) for task in reports):
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
        what = "kept" if report.kept else f"built in {report.seconds:.1f} s"
        _log.info("%s%s: %s%s; %s", name, part, what, reached, progress)


def _submit_later(
    executor: Executor, loaded: LoadedJob, tasks: Iterable[Task], folder: Path, fresh: bool
) -> dict[Future[TaskReport], Task]:
    materials = _materials(loaded, folder)
    return {executor.submit(run_task, task, loaded, folder, materials, fresh): task for task in tasks}


def _materials(loaded: LoadedJob, folder: Path) -> tuple[str, ...]:
    """The materials to build: those of the job, or those that its finished textures use."""
    usage = [folder / texture_file(loaded, i) for i in range(len(loaded.trimmed.texture_jobs))]
    return used_materials(loaded, load_library(), usage or None)
