"""Running a job file of `tmm`."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from skyshine.schemas.documents import load_model
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path
from skyshine.tmm.build import TextureResult, build_texture
from skyshine.tmm.database import write_texture
from skyshine.tmm.job import TmmJob


def load_job(path: str | os.PathLike, library) -> tuple[TmmJob, Path]:
    """A job and the folder to which its paths are relative.

    Raises
    ------
    InputError
        At the line and column of what is wrong, unknown material names included.
    """
    path = Path(path)
    return load_model(path, TmmJob, context={"materials": library.names}), path.parent


def classify(job: TmmJob, folder: Path, out: str | os.PathLike | None, library) -> Iterator[tuple[TextureResult, Path]]:
    """Build and write the databases of a job one by one.

    Parameters
    ----------
    folder : Path
        Folder of the job file.
    out : path, optional
        Output folder; by default the job's.

    Yields
    ------
    result : TextureResult
    path : Path
        Of its database.

    Raises
    ------
    InputError
        An image or its seeds are wrong, or a file cannot be written.
    """
    target = _inside(folder, job.output) if out is None else Path(out)
    for texture in job.textures:
        result = build_texture(texture, folder, library)
        path = target / f"{texture.name}.tmm.h5"
        write_texture(result, path)
        yield result, path


def _inside(folder: Path, name: str) -> Path:
    try:
        return job_path(folder, name, written=True)
    except ValueError as error:
        raise InputError(f"output: {error}") from None
