"""Memory that a process has held at most, and processor time of its children."""

from __future__ import annotations

import os
import sys

from skyshine.schemas.errors import CheckFailed


def peak_memory() -> int | None:
    """Largest resident size of this process so far [byte]; None where the system does not say, as on Windows."""
    try:
        import resource
    except ImportError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024  # getrusage(2) counts bytes there, kibibytes elsewhere
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def children_seconds() -> float:
    """Processor seconds of the children of this process that have ended.

    Raises
    ------
    CheckFailed
        The system does not count them, as Windows: what is measured with them is not known there.
    """
    if os.name != "posix":
        raise CheckFailed(
            "this system does not count the processor time of ended processes; run this on Linux or macOS"
        )
    spent = os.times()
    return spent.children_user + spent.children_system
