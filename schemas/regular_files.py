"""Files that are opened for reading must be regular ones: reading a pipe or a device may never end."""

from __future__ import annotations

import os
import stat

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath


def refuse_special_file(path: StrPath, missing: str = "check the path") -> None:
    """Refuse what is not a regular file before it is opened.

    Parameters
    ----------
    missing : str
        What to do where there is nothing.

    Raises
    ------
    InputError
        The path names a folder, a pipe, a socket or a device, or nothing at all.
    """
    try:
        mode = os.stat(path).st_mode
    except FileNotFoundError:
        raise InputError(f"does not exist; {missing}", file=path) from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {getattr(error, 'strerror', error)}; check the path", file=path) from None
    if stat.S_ISDIR(mode):
        raise InputError("is a folder; name one of the files in it", file=path)
    if not stat.S_ISREG(mode):
        raise InputError("is a pipe, socket or device; allowed: a regular file; name one", file=path)
