"""Paths that a job names: read against its folder, and kept inside it unless the user says otherwise."""

from __future__ import annotations

import os
from pathlib import Path

StrPath = str | os.PathLike[str]

# Bytes of a name and of a path that Linux, macOS and Windows open (POSIX NAME_MAX, PATH_MAX).
NAME_LIMIT, PATH_LIMIT = 255, 4095
ALLOW_OUTSIDE = "SKYSHINE_ALLOW_OUTSIDE"  # environment variable, so that processes of a build inherit the permission


def allow_outside() -> None:
    """Let the jobs of this process and its children name paths outside their folders."""
    os.environ[ALLOW_OUTSIDE] = "1"


def job_path(folder: StrPath | None, name: str, *, for_output: bool = False) -> Path:
    """Path of a file or folder that a job names.

    Parameters
    ----------
    folder : path or None
        Folder of the job; None for a path that the user gives to a command or function, which may be anywhere.
    name : str
        Path as the job states it.
    for_output : bool
        Whether it will be written to; then an absolute path counts as outside too.

    Raises
    ------
    ValueError
        It leads out of the folder, and the user has not allowed that; or it is too long for a file.
    """
    if "\0" in name:
        raise ValueError(f"found {name!r}; allowed: a path without null characters")
    longest = max((len(os.fsencode(part)) for part in Path(name).parts), default=0)
    if longest > NAME_LIMIT or len(os.fsencode(name)) > PATH_LIMIT:
        raise ValueError(
            f"found '{name[:20]}...', a name of {longest} bytes; allowed: names of {NAME_LIMIT} at most, paths of"
            f" {PATH_LIMIT}; shorten it"
        )
    if folder is None:
        return Path(name)
    path = Path(folder, name)
    absolute = Path(name).is_absolute()
    escapes = for_output if absolute else not _inside(path, Path(folder))
    if escapes and os.environ.get(ALLOW_OUTSIDE) != "1":
        raise ValueError(
            f"found '{name}', which leads out of the job's folder; allowed: a path inside it; move it there, or give"
            f" --allow-outside (or set {ALLOW_OUTSIDE}=1)"
        )
    return path


def _inside(path: Path, folder: Path) -> bool:
    """Whether a path stays in a folder, both as it is written and after its links are followed."""
    lexical = Path(os.path.abspath(path)).is_relative_to(os.path.abspath(folder))
    return lexical and Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))
