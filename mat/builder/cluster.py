"""Tasks of a build on the workers of a Dask cluster.

The scheduler of Dask runs a task again whose worker is lost. What the client alone can mend is mended here: a scheduler
that was lost is asked for again, and the build sends the tasks that it had (`TaskLost`). Workers need no state of their
own: one that does not see the output folder computes in a temporary one, and its files come back with the result.
"""

from __future__ import annotations

import ctypes
import logging
import os
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skyshine.mat import threads
from skyshine.mat.builder.failures import TaskLost
from skyshine.mat.builder.tasks import is_kept, run_task
from skyshine.mat.plan.plan import Kind
from skyshine.mat.products.product import TaskReport
from skyshine.schemas.errors import CheckFailed, InputError
from skyshine.schemas.whole_files import PART, write_whole

if TYPE_CHECKING:
    from distributed import Client

CONNECT_SECONDS = 30.0  # wait for a scheduler [s]
RECONNECT_SECONDS = 600.0  # for a scheduler that was there before
# Dask's nannies let glibc give every freed array back to the system (distributed.nanny.pre-spawn-environ), and tasks
# then take twice as long. Its own values (mallopt(3): M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, M_ARENA_MAX) are those that a
# process comes to by itself.
DASK_TRIM = "65536"
MEMORY_KEPT = {-1: 1 << 28, -3: 1 << 25, -8: 1}
_log = logging.getLogger("skyshine.mat.build")


@dataclass(frozen=True)
class Fetched:
    """What a worker made that does not see the output folder.

    Attributes
    ----------
    files : dict of str to bytes
        Contents by name.
    """

    report: TaskReport
    files: dict[str, bytes]


@contextmanager
def open_cluster(address: str, folder: Path) -> Iterator[Executor]:
    """A context manager that gives an executor whose tasks run on the workers of a scheduler.

    Raises
    ------
    InputError
        No scheduler answers at the address.
    """
    token = folder / f".{uuid.uuid4().hex}{PART}"
    try:
        cluster = _Cluster(address, token, _connected(address, CONNECT_SECONDS))
    except (OSError, ValueError) as error:
        words = " ".join(str(error).split())[:120]
        raise InputError(
            f"found --executor 'dask:{address}', where no scheduler answers ({words}); start one there"
        ) from None
    try:
        token.touch()
        with cluster:
            yield cluster
    finally:
        token.unlink(missing_ok=True)


def _connected(address: str, seconds: float) -> Client:
    from distributed import Client

    return Client(address, timeout=seconds, set_as_default=False)


class _Cluster(Executor):
    """An executor over one scheduler, and over that which takes its place."""

    def __init__(self, address: str, token: Path, client: Client) -> None:
        self.address, self.token, self.client = address, token, client
        self.waiting: set[Any] = set()  # Dask forgets tasks whose futures nobody keeps
        self.fetches = False  # whether a worker has sent files
        self.closed = False
        workers = len(client.scheduler_info(n_workers=-1)["workers"])
        _log.info("%d workers at %s, dashboard %s; waiting for the first file", workers, address, client.dashboard_link)

    def submit(self, function: Callable[..., Any], /, *arguments: Any, **keywords: Any) -> Future[Any]:
        """Send a task to the cluster; a database that came back from a worker is looked for here before."""
        outer: Future[Any] = Future()
        if self.fetches and (function is not run_task or self._is_here(*arguments)):
            _settle(outer, function, arguments)
            return outer
        inner = self._client().submit(on_worker, function, arguments, str(self.token), pure=False)
        self.waiting.add(inner)
        inner.add_done_callback(lambda ended: self._finish(ended, outer, function, arguments))
        return outer

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster; what it has not begun is dropped."""
        self.closed = True
        self.client.close(timeout=5)

    def _is_here(self, task: Any, loaded: Any, folder: Path, materials: tuple[str, ...], fresh: bool) -> bool:
        return not fresh and is_kept(task, loaded, folder, materials)

    def _client(self) -> Client:
        """The client, connected: another one where its scheduler was lost for good.

        Raises
        ------
        CheckFailed
            No scheduler has come back.
        """
        deadline = time.monotonic() + RECONNECT_SECONDS
        while self.client.status != "running":
            remaining = deadline - time.monotonic()
            if remaining <= 0:
                raise CheckFailed(
                    f"no scheduler has come back to {self.address} in {RECONNECT_SECONDS:.0f} s; finished files are"
                    " kept: start one and run it again"
                )
            if self.client.status == "closed":
                try:
                    self.client = _connected(self.address, min(remaining, CONNECT_SECONDS))
                except (OSError, ValueError):
                    continue
            time.sleep(0.2)
        return self.client

    def _finish(self, inner: Any, outer: Future[Any], function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        """Hand on what a task on the cluster came to; called in a thread of the client."""
        self.waiting.discard(inner)
        if self.closed:
            outer.cancel()
            return
        try:
            result = inner.result() if inner.status in ("finished", "error") else TaskLost("its scheduler was lost")
        except Exception as error:
            result = _refined(error)
        if isinstance(result, Exception):
            outer.set_exception(result)
        elif isinstance(result, Fetched):
            self.fetches = True
            try:
                _place(result, arguments[2])
                outer.set_result(result.report)
            except Exception as error:
                outer.set_exception(error)
        elif isinstance(result, _NotHere):
            self.fetches = True
            _settle(outer, function, arguments)
        else:
            outer.set_result(result)


class _NotHere:
    """Answer of a worker that does not see what a task reads."""


def _refined(error: Exception) -> Exception:
    """The error of a task; in words of a build where it is one of the cluster."""
    from distributed import CancelledError
    from distributed.scheduler import KilledWorker

    if isinstance(error, KilledWorker):
        return CheckFailed(f"lost its worker again and again, memory may have run out there ({error})")
    if isinstance(error, CancelledError) or type(error).__module__.startswith("distributed"):
        return TaskLost(" ".join(str(error).split())[:120])
    return error


def _settle(outer: Future[Any], function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    """Run a task here."""
    try:
        with _one_thread_of_algebra():
            outer.set_result(function(*arguments))
    except Exception as error:
        outer.set_exception(error)


def _place(result: Fetched, folder: Path) -> None:
    for name, content in result.files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_whole(folder / name, content)


def on_worker(function: Callable[..., Any], arguments: tuple[Any, ...], token: str) -> Any:
    """Run a task on a worker: in the output folder, where it sees it by its token, otherwise in a temporary one, from
    which the files are sent back. Pictures, and textures, whose images it does not see then, are left to the client.
    """
    prepare_worker()
    if Path(token).is_file():
        return function(*arguments)
    if function is not run_task or arguments[0].kind is Kind.TEXTURE:
        return _NotHere()
    task, loaded, _, materials, _ = arguments
    with tempfile.TemporaryDirectory(prefix="skyshine-") as scratch:
        report = run_task(task, loaded, Path(scratch), materials, True)
        return Fetched(report, {name: Path(scratch, name).read_bytes() for name in report.files})


def prepare_worker() -> None:
    """Set what a Dask worker does otherwise than a process of a local build, unless its environment says how it is to
    be; linear algebra has one thread whatever that says, for with more it adds up in another order.
    """
    _one_thread_of_algebra()  # for good: another task may run beside this one
    os.environ.setdefault(threads.VARIABLE, "1")
    if os.environ.get("MALLOC_TRIM_THRESHOLD_") == DASK_TRIM and sys.platform == "linux":
        mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
        if mallopt is not None:
            for setting, value in MEMORY_KEPT.items():
                mallopt(setting, value)


def _one_thread_of_algebra() -> AbstractContextManager[Any]:
    """Limit linear algebra to one thread, until the returned context ends, if it is used as one."""
    from threadpoolctl import threadpool_limits

    limits: AbstractContextManager[Any] = threadpool_limits(1, user_api="blas")
    return limits
