"""Reading a job file of `tmm`."""

from __future__ import annotations

import os
from pathlib import Path

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.documents import parse_model, read_yaml
from skyshine.tmm.job.model import TmmJob


def load_job(path: str | os.PathLike[str], library: MaterialLibrary) -> tuple[TmmJob, Path]:
    """A job and the folder to which its paths are relative.

    Raises InputError: at the line and column of what is wrong, unknown material names and paths out of the folder
    included.
    """
    path = Path(path)
    document = read_yaml(path)
    job = parse_model(document, TmmJob, {"materials": library.names, "folder": path.parent})
    return job, path.parent
