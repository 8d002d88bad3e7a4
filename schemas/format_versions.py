"""The version of all file formats, and the only rule by which a reader accepts a file."""

from __future__ import annotations

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import StrPath

FORMAT_VERSION = "1.0"  # format version of databases, catalogue, flat and graphics exports, and packaged tables
FORMAT_MAJOR = FORMAT_VERSION.split(".")[0]


def check_version(path: StrPath, version: object) -> None:
    """Refuse a file of another major version; a later minor version only adds fields, which readers pass over.

    Raises
    ------
    InputError

    Examples
    --------
    >>> check_version("s01.htt.h5", "1.0")
    """
    if str(version).split(".")[0] != FORMAT_MAJOR:
        raise InputError(
            f"has format_version {version!r}; allowed: {FORMAT_MAJOR}.x; build it again with this version of skyshine",
            file=path,
        )
