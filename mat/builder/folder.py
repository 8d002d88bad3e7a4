"""The output folder of a build: who writes into it, what killed builds left in it, what is not of the job."""

from __future__ import annotations

from collections.abc import Container, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from skyshine.mat.builder.parts import Part
from skyshine.mat.builder.tasks import PICTURES
from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import PART

LOCK = "build.lock"
_PART_SECONDS = 60.0  # in which another part has looked at the folder


@contextmanager
def sole_build_in(folder: Path, part: Part | None = None) -> Iterator[None]:
    """Keep other builds out of a folder, but other parts of the same job; a whole build removes part files of killed
    ones.

    The system frees the lock of a killed process.

    Raises
    ------
    InputError
        Another build writes into it, or it cannot be written.
    """
    lock = FileLock(folder / LOCK, timeout=0 if part is None else _PART_SECONDS)
    part_lock = lock if part is None else FileLock(folder / f"{part.label}.lock", timeout=0)
    try:
        with lock:
            if part is not None:
                part_lock.acquire()
            else:
                for path in folder.glob("build.part-*.lock"):
                    with FileLock(path, timeout=0):
                        path.unlink()
                _clean(folder)
                yield
        if part is not None:
            try:
                yield
            finally:
                part_lock.release()
    except Timeout:
        raise InputError(
            "another build writes into this folder; wait for it, or name another --out", file=folder
        ) from None
    except OSError as error:
        if isinstance(error, FileNotFoundError) and error.filename and not _inside(error.filename, folder):
            raise InputError("does not exist; name a file that is there", file=error.filename) from None
        raise InputError(
            f"cannot be written: {error.strerror or error}; check free space and permissions", file=folder
        ) from None


def _inside(path: str, folder: Path) -> bool:
    return Path(path).resolve().is_relative_to(folder.resolve())


def _clean(folder: Path) -> None:
    sites = [path for path in folder.iterdir() if path.is_dir() and not path.is_symlink()]
    pictures = [path for path in (folder / PICTURES).glob("*") if path.is_dir()]
    for directory in (folder, *sites, *pictures):
        for part in [*directory.glob(f".*{PART}"), *directory.glob(f".*{PART}.png")]:
            part.unlink(missing_ok=True)


def other_files(folder: Path, built: Container[str]) -> list[str]:
    """Databases of a folder and of its sites that a build did not write or keep."""
    paths = [*folder.glob("*.h5"), *folder.glob("*/*.h5")]
    return sorted(name for path in paths if (name := path.relative_to(folder).as_posix()) not in built)
