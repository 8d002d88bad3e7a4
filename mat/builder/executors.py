"""Where the tasks of a build run: processes of this machine, or a cluster (`cluster.py`)."""

from __future__ import annotations

import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from types import TracebackType
from typing import Literal

from skyshine.mat.threads import LINEAR_ALGEBRA
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.processes import FreshProcesses
from skyshine.schemas.whole_files import PART

DASK = "dask:"


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
        from skyshine.mat.builder.cluster import open_cluster

        return open_cluster(name.removeprefix(DASK), folder)
    raise InputError(f"found --executor '{name}'; allowed: dask:ADDRESS, such as dask:tcp://127.0.0.1:8786")


@contextmanager
def _local(jobs: int, folder: Path, variables: Mapping[str, str]) -> Iterator[Executor]:
    with _environment(LINEAR_ALGEBRA | dict(variables)), _Pool(jobs, folder) as pool:
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


class _Pool(ProcessPoolExecutor):
    """Processes that stop with the build: what is running is dropped, with its part files, when it fails or is
    interrupted.
    """

    def __init__(self, jobs: int, folder: Path):
        super().__init__(jobs, mp_context=FreshProcesses(), initializer=_follow_parent)
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
                "a process of the build died; memory may have run out; finished files are kept: run it again with fewer"
                " jobs"
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
