"""What happens to a build when one of its tasks fails: the others go on, the failures are listed at the end."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor, CancelledError
from pathlib import Path

from skyshine.mat.plan.plan import Kind, Task
from skyshine.schemas.errors import CheckFailed, InputError

_log = logging.getLogger("skyshine.mat.build")


class TaskLost(Exception):
    """A task whose result will not come: its scheduler is gone. The build sends it again."""


def stops_the_build(task: Task, error: Exception, folder: Path) -> bool:
    """Whether no other task could do better: its processes are gone, the folder cannot be written, or it is a texture,
    whose materials the tables wait for.
    """
    lost = isinstance(error, BrokenExecutor | CancelledError)
    file = error.file if isinstance(error, InputError) else None
    return lost or task.kind is Kind.TEXTURE or (file is not None and Path(file).is_relative_to(folder))


def messages(failed: Mapping[Task, Exception]) -> dict[str, str]:
    """The reason by file, in one line each."""
    return {name: _words(error) for task, error in failed.items() for name in task.files}


def refuse_failures(failed: Mapping[Task, Exception], sites: Mapping[str, InputError], files: int) -> None:
    """Log each file that failed, of `files` in all, and each site whose job could not be read; raise what the build
    ends with.

    Raises
    ------
    InputError
        All failures are input that is wrong; at the place of the first.
    CheckFailed
        At least one is something else.
    """
    for site, unread in sites.items():
        _log.error("failed: site %s: %s", site, unread)
    if sites and not failed:
        raise unread_sites(sites)
    if not failed:
        return
    reasons = messages(failed)
    for name, reason in reasons.items():
        _log.error("failed: %s: %s", name, reason)
    failure = next(iter(failed.values()))
    end = (
        f"{len(reasons)} of {files} files failed ({', '.join(list(reasons)[:4])}{', ...' if len(reasons) > 4 else ''});"
        " the others are built; mend the cause and build again, which keeps them"
    )
    if all(isinstance(error, InputError) for error in failed.values()):
        assert isinstance(failure, InputError)
        raise InputError(
            f"{failure.message}; {end}", file=failure.file, line=failure.line, column=failure.column
        ) from failure
    raise CheckFailed(f"{_words(failure)}; {end}") from failure


def unread_sites(sites: Mapping[str, InputError]) -> InputError:
    """The error of the first site that could not be read, with how many others."""
    error = next(iter(sites.values()))
    end = (
        f"{len(sites)} of the sites cannot be read ({', '.join(list(sites)[:4])}{', ...' if len(sites) > 4 else ''});"
        " the others are complete; mend the cause and run it again"
    )
    return InputError(f"{error.message}; {end}", file=error.file, line=error.line, column=error.column)


def _words(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, InputError) else f"{type(error).__name__}: {text}"[:300]
