"""Part files that a process left behind when it was killed."""

from __future__ import annotations

import os
from pathlib import Path

from skyshine.schemas.whole_files import PART, part_file


def remove_abandoned(path: Path) -> None:
    """Remove the part files of `path` whose process on this machine has ended.

    Only files named as `part_file` names them, with this machine's name and the number of a process that is no more,
    are removed: any other file, such as ``.NAME.part``, is the user's.
    """
    current = part_file(path).name
    prefix, suffix = current.removesuffix(f"{os.getpid()}{PART}"), PART
    try:
        names = os.listdir(path.parent)
    except OSError:
        return  # no folder yet
    for name in names:
        number = name.removeprefix(prefix).removesuffix(suffix)
        if name == f"{prefix}{number}{suffix}" and number.isascii() and number.isdecimal() and _ended(int(number)):
            path.with_name(name).unlink(missing_ok=True)


def _ended(process: int) -> bool:
    if os.name != "posix":  # elsewhere a signal would end the process, and its open file cannot be removed anyway
        return False
    try:
        os.kill(process, 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        return False
    return False
