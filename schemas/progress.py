"""How long work reports its progress: to a callable that the caller passes in."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext

# Shows how much is done; a progress bar gives a context manager that says when some more is.
Advance = Callable[[float], None]
Progress = Callable[[float, str], AbstractContextManager[Advance]]


def silent(total: float, description: str) -> AbstractContextManager[Advance]:
    """No progress is shown."""
    return nullcontext(lambda amount: None)
