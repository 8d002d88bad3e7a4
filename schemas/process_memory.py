"""Memory that a process has held at most."""

from __future__ import annotations

import sys


def peak_memory() -> int | None:
    """Largest resident size of this process so far [byte]; None where the system does not say, as on Windows."""
    try:
        import resource
    except ModuleNotFoundError:
        return None
    unit = 1 if sys.platform == "darwin" else 1024  # getrusage(2) counts bytes there, kibibytes elsewhere
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
