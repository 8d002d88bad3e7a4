"""From a plan to files: the executor, progress, what is kept, the catalogue."""

from __future__ import annotations

import json
import multiprocessing
import os
import signal
import time
from collections.abc import Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from skyshine.mat.atmosphere import threads
from skyshine.mat.job import LoadedJob
from skyshine.mat.plan import Plan, Task, make_plan, texture_file
from skyshine.mat.products import TaskReport, run_task
from skyshine.mat.scene import check_scene
from skyshine.mat.tables.catalog import write_catalog
from skyshine.materials.library import load_library
from skyshine.schemas.commands import progress
from skyshine.schemas.errors import CheckFailed, InputError

# One thread a process for linear algebra, which adds up in another order with more. Tables of lines of sight take what cores are
# left over.
THREAD_LIMITS = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


def build(loaded: LoadedJob, *, out: str | os.PathLike | None = None, jobs: int | None = None, fresh: bool = False):
    """Build all files of a job.

    Parameters
    ----------
    out : path, optional
        Output folder; by default the one that the job names.
    jobs : int, optional
        Processes; by default one a core.
    fresh : bool
        Build files again that the same job has built before.

    Returns
    -------
    dict
        Folder, seconds, and for each file whether it was kept, its seconds, stages and peak memory.

    Raises
    ------
    InputError
        The job does not fit, or a file cannot be written.
    """
    begin = time.perf_counter()
    library = load_library()
    folder = Path(out) if out is not None else loaded.folder / loaded.job.output.folder
    plan = make_plan(loaded, library)
    check_scene(loaded)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot be made: {error.strerror}; name another output folder", file=folder) from None
    reports = _run_all(loaded, plan, folder, jobs or os.cpu_count() or 1, fresh)
    names = [name for report in reports for name in report.files]
    write_catalog(folder, names)
    result = _result(folder, reports, time.perf_counter() - begin)
    (folder / "build.json").write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")
    return result


def _run_all(loaded: LoadedJob, plan: Plan, folder: Path, jobs: int, fresh: bool) -> list[TaskReport]:
    """Run the tasks: textures and atmospheres first, then what needs the materials that the textures use."""
    first = [task for kind in ("texture", "atmosphere") for task in plan.tasks if task.kind == kind]
    later = [task for task in plan.tasks if task.kind in ("temperature", "band")]
    reports: dict[Task, TaskReport] = {}
    atmospheres = sum(task.kind == "atmosphere" for task in first)
    limits = THREAD_LIMITS | {threads.VARIABLE: str(max(1, jobs // max(1, atmospheres)))}
    saved = {name: os.environ.get(name) for name in limits}
    os.environ.update(limits)
    try:
        with (
            progress(len(plan.tasks), f"building {loaded.job.name}") as advance,
            _Pool(min(jobs, len(plan.tasks)), folder) as executor,
        ):
            waiting = {executor.submit(run_task, task, loaded, folder, (), fresh): task for task in first}
            textures = sum(task.kind == "texture" for task in first)
            if not textures:
                waiting |= _submit_later(executor, loaded, later, folder, fresh)
            while waiting:
                done, _ = wait(waiting, return_when=FIRST_COMPLETED)
                for future in done:
                    task = waiting.pop(future)
                    reports[task] = future.result()
                    advance(1)
                    textures -= task.kind == "texture"
                    if task.kind == "texture" and not textures:
                        waiting |= _submit_later(executor, loaded, later, folder, fresh)
    finally:
        for name, value in saved.items():
            os.environ.pop(name, None) if value is None else os.environ.__setitem__(name, value)
    return [reports[task] for task in plan.tasks]


def _submit_later(executor, loaded: LoadedJob, tasks: Iterable[Task], folder: Path, fresh: bool) -> dict[Future, Task]:
    usage = [folder / texture_file(loaded, i) for i in range(len(loaded.job.textures))]
    materials = make_plan(loaded, load_library(), usage or None).materials
    return {executor.submit(run_task, task, loaded, folder, materials, fresh): task for task in tasks}


class _Pool(ProcessPoolExecutor):
    """Processes that stop with the build: what is running is dropped, with its part files, when it fails or is interrupted."""

    def __init__(self, jobs: int, folder: Path):
        super().__init__(jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_leave_interrupts_to_parent)
        self.folder = folder

    def __exit__(self, kind, value, traceback):
        workers = list(multiprocessing.active_children())
        if kind is not None:
            for process in workers:
                process.terminate()
        self.shutdown(wait=True, cancel_futures=True)
        for process in workers:
            for part in self.folder.glob(f".*.{process.pid}.part"):
                part.unlink(missing_ok=True)
        if kind is BrokenProcessPool:
            raise CheckFailed(
                "a process of the build died, perhaps for want of memory; finished files are kept: run it again, "
                "with fewer --jobs"
            ) from value
        return False


def _leave_interrupts_to_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _result(folder: Path, reports: list[TaskReport], seconds: float) -> dict:
    files = {
        name: {
            "kept": report.kept,
            "seconds": round(report.seconds, 3),
            "stages": {stage: round(value, 3) for stage, value in report.stages.items()},
            "peak_memory_bytes": report.peak_memory,
            "notes": list(report.notes),
        }
        for report in reports
        for name in report.files
    }
    return {"folder": str(folder), "seconds": round(seconds, 3), "files": files}
