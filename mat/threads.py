"""Cores, and threads of one process: numpy releases the interpreter's lock in the long array operations of transfer."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

Result = TypeVar("Result")

VARIABLE = "SKYSHINE_THREADS"
# One thread a process for linear algebra, which adds up in another order with more; as environment of processes that
# have not imported numpy yet.
LINEAR_ALGEBRA = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def core_count() -> int:
    """Number of processor cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def thread_count() -> int:
    """Number of threads: the environment's SKYSHINE_THREADS, by default one per core."""
    text = os.environ.get(VARIABLE, "")
    return max(1, int(text)) if text.isdecimal() else core_count()


def parallel_map(action: Callable[..., Result], *arguments: Iterable[Any]) -> list[Result]:
    """Results of an action on each item, in their order, whatever the number of threads.

    Parameters
    ----------
    *arguments : iterables
        Arguments of the action, of one length.

    Raises
    ------
    ValueError
        The iterables differ in length.
    """
    items = list(zip(*arguments, strict=True))
    workers = min(thread_count(), len(items))
    if workers <= 1:
        return [action(*item) for item in items]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda item: action(*item), items))
