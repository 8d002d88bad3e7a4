"""Lifting of databases of older formats to the present one: the arrays stay as they are, byte for byte."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py

from skyshine.mat.tables.named_materials import COORDINATES, NAMES, needs_names
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import check_version, open_database, sound
from skyshine.schemas.hdf5_digest import DIGEST, DIGEST_VERSION, content_hash, digest_holds, dims_of
from skyshine.schemas.paths import StrPath
from skyshine.schemas.whole_files import part_file

_ATMOSPHERE = {
    "ambient_radiance_harmonics": "light on tilted faces",
    "thermal_path_radiance_ratio": "light of moonless nights",
}
# Parts of a file by an array of each.
_PARTS = {
    "htt": {"response_kernel": "response to shade", "sun_elevation": "tracks of Sun and Moon"},
    "atmq": _ATMOSPHERE,
    "lunar_atmq": _ATMOSPHERE,
}


def convert(path: StrPath, folder: StrPath, versions: Mapping[str, Sequence[str]]) -> tuple[Path, str, str]:
    """Write a database in the present format of its type under its own name into a folder.

    Parameters
    ----------
    path : path
        Of the same major version; a file of the present format is copied.
    folder : path
    versions : mapping of str to sequence of str
        The present format versions of each file type, one for each major version.

    Returns
    -------
    target : Path
    old, new : str
        Format versions.

    Raises
    ------
    InputError
        The file cannot be read, is not what its digest says, is of another type or major version, lies in that folder,
        or the folder cannot be written.
    """
    source, target = Path(path), Path(folder) / Path(path).name
    old, new = _versions(source, versions)
    part = part_file(target)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists() and target.samefile(source):
            raise InputError("would be written over itself; name another folder with --out", file=path)
        shutil.copyfile(source, part)
        if old != new:
            with h5py.File(part, "r+", libver=("v110", "v110")) as file, sound(path):
                _lift(file, new)
        os.replace(part, target)
    except OSError as error:
        words = error.strerror or " ".join(str(error).split())[:160]
        raise InputError(f"cannot be written: {words}; check free space and permissions", file=target) from None
    finally:
        part.unlink(missing_ok=True)
    return target, old, new


def parts_lacking(path: StrPath) -> list[str]:
    """What a build of today would add to a file: parts that its older format had not, and that nothing but a build
    can compute.

    Parameters
    ----------
    path : path
        Of a sound file.
    """
    with open_database(Path(path)) as file, sound(path):
        parts = _PARTS.get(str(file.attrs["filetype"]), {})
        return [words for name, words in parts.items() if name not in file]


def _versions(path: Path, versions: Mapping[str, Sequence[str]]) -> tuple[str, str]:
    """The format version of a sound file and the present one of its type."""
    with open_database(path) as file, sound(path):
        filetype, old = str(file.attrs["filetype"]), str(file.attrs["format_version"])
        if filetype not in versions:
            raise InputError(f"holds '{filetype}'; {nearest(filetype, versions)}; name another file", file=path)
        check_version(path, filetype, old, *(_numbers(version)[0] for version in versions[filetype]))
        new = next(version for version in versions[filetype] if _numbers(version)[0] == _numbers(old)[0])
        if _numbers(old) > _numbers(new):
            raise InputError(f"has format_version {old}; this version writes {new}; upgrade skyshine", file=path)
        if not digest_holds(file):
            raise InputError(
                f"{DIGEST} does not match: the file was changed or damaged; build it again from its job", file=path
            )
    return old, new


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split("."))


def _lift(file: h5py.File, version: str) -> None:
    """Bring a file of digest version 1 to the present format."""
    if NAMES in file:
        for name, item in file.items():
            if isinstance(item, h5py.Dataset) and not item.is_scale and needs_names(name, dims_of(item)):
                item.attrs[COORDINATES] = NAMES
    file.attrs["format_version"] = version
    file.attrs["digest_version"] = DIGEST_VERSION
    file.attrs[DIGEST] = content_hash(file)
