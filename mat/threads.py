"""Threads of one process: numpy lets go of the interpreter's lock in the long array operations of transfer."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

VARIABLE = "SKYSHINE_THREADS"


def thread_count() -> int:
    """What the environment's SKYSHINE_THREADS says, or one a core."""
    text = os.environ.get(VARIABLE, "")
    return max(1, int(text)) if text.isdecimal() else os.cpu_count() or 1


def each(action, *arguments):
    """Results of an action on each item, in their order; the same however many threads work.

    Parameters
    ----------
    action : callable
    *arguments : iterables
        Of its arguments, of one length.
    """
    items = list(zip(*arguments, strict=True))
    workers = min(thread_count(), len(items))
    if workers <= 1:
        return [action(*item) for item in items]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda item: action(*item), items))
