"""Where the tasks of a build run: processes of this machine, or the workers of a Dask cluster."""

from __future__ import annotations

import ctypes
import multiprocessing
import multiprocessing.connection
import os
import signal
import sys
import threading
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

from skyshine.mat import threads
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.whole_files import PART

# One thread a process for linear algebra, which adds up in another order with more. Tables of lines of sight take what
# cores are left over.
THREAD_LIMITS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
DASK = "dask:"
CONNECT_SECONDS = 30
# Dask's nannies let glibc give every freed array back to the system (distributed.nanny.pre-spawn-environ), and tasks
# then take twice as long. Its own values (mallopt(3): M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX) are those that a
# process comes to by itself.
DASK_TRIM = "65536"
MEMORY_KEPT = {-1: 1 << 28, -3: 1 << 25, -8: 1}
WORKERS_LOST = 5  # times that a task may lose its worker before it counts as the cause


def open_executor(
    name: str | None, jobs: int, folder: Path, variables: Mapping[str, str] | None = None
) -> AbstractContextManager[Executor]:
    """A context manager that gives the executor of a build.

    Parameters
    ----------
    name : str, optional
        ``dask:ADDRESS`` of a scheduler; by default processes of this machine.
    jobs : int
        Processes of this machine.
    folder : path
        Output folder, in which part files of stopped processes are removed.
    variables : mapping, optional
        Environment of the processes of this machine.

    Raises
    ------
    InputError
        The name is no executor, or no scheduler answers at the address.
    """
    if name is None:
        return _local(jobs, folder, variables or {})
    if name.startswith(DASK) and len(name) > len(DASK):
        return _dask(name.removeprefix(DASK))
    raise InputError(f"found --executor '{name}'; allowed: dask:ADDRESS, such as dask:tcp://127.0.0.1:8786")


@contextmanager
def _local(jobs: int, folder: Path, variables: Mapping[str, str]) -> Iterator[Executor]:
    with _environment(THREAD_LIMITS | dict(variables)), _Pool(jobs, folder) as pool:
        yield pool


@contextmanager
def _environment(variables: Mapping[str, str]) -> Iterator[None]:
    saved = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in saved.items():
            os.environ.pop(name, None) if value is None else os.environ.__setitem__(name, value)


@contextmanager
def _dask(address: str) -> Iterator[Executor]:
    from distributed import Client
    from distributed.scheduler import KilledWorker

    try:
        client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        words = " ".join(str(error).split())[:120]
        raise InputError(
            f"found --executor 'dask:{address}', where no scheduler answers ({words}); start one there"
        ) from None
    with client:
        client.register_plugin(_worker_plugin())
        executor = client.get_executor(pure=False, retries=WORKERS_LOST)
        try:
            yield executor
        except KilledWorker as error:
            raise CheckFailed(
                f"the cluster lost its workers ({error}); finished files are kept: run it again"
            ) from None
        finally:
            executor.shutdown(wait=False)


def _worker_plugin() -> Any:
    """Of the workers of a cluster, of those that come later too: one thread a task, and memory kept between arrays."""
    from distributed import WorkerPlugin

    class Prepared(WorkerPlugin):
        name, idempotent = "skyshine", True

        def setup(self, worker: Any) -> None:
            prepare_worker()

    return Prepared()


def prepare_worker() -> None:
    """Set what a Dask worker does otherwise than a process of a local build, unless its environment says how it is to
    be.
    """
    os.environ.setdefault(threads.VARIABLE, "1")
    if os.environ.get("MALLOC_TRIM_THRESHOLD_") == DASK_TRIM and sys.platform == "linux":
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            for setting, value in MEMORY_KEPT.items():
                mallopt(setting, value)


class _Pool(ProcessPoolExecutor):
    """Processes that stop with the build: what is running is dropped, with its part files, when it fails or is
    interrupted.
    """

    def __init__(self, jobs: int, folder: Path):
        super().__init__(jobs, mp_context=multiprocessing.get_context("spawn"), initializer=_follow_parent)
        self.folder = folder

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None
    ) -> Literal[False]:
        workers = list(multiprocessing.active_children())
        if kind is not None:
            for process in workers:
                process.terminate()
        self.shutdown(wait=True, cancel_futures=True)
        for process in workers:
            for part in self.folder.glob(f".*.{process.pid}{PART}"):
                part.unlink(missing_ok=True)
        if kind is BrokenProcessPool:
            raise CheckFailed(
                "a process of the build died, perhaps out of memory; finished files are kept: run it again, "
                "with fewer --jobs"
            ) from value
        return False


def _follow_parent() -> None:
    """Leave interrupts to the parent, and end with it: a killed parent cannot stop its processes itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    sentinel = parent.sentinel

    def end_with_parent() -> None:
        multiprocessing.connection.wait([sentinel])
        os._exit(1)

    threading.Thread(target=end_with_parent, daemon=True).start()
