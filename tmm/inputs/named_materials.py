"""The materials that a texture job names."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from skyshine.schemas.errors import InputError
from skyshine.tmm.inputs.polygons import seed_names
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import TextureJob


def job_materials(job: TextureJob, base_folder: Path) -> tuple[str, ...]:
    """Names of all materials that a job may find, those of its GeoJSON and model files included.

    Beside seeds, a model finds the seeds' materials alone.
    Raises InputError: such a file cannot be read.
    """
    names = set(job.materials)
    for seeds in (job.seeds, job.overrides):
        if seeds is not None:
            names |= seed_names(seeds, Path(base_folder)) - {UNKNOWN}
    if job.model is not None and job.seeds is None and not job.scene_materials:
        from skyshine.tmm.classify.model_file import model_path, read_model

        names |= set(read_model(model_path(job.model, base_folder)).names)
    return tuple(sorted(names))


def refuse_without_materials(job: TextureJob, names: Collection[str]) -> None:
    """Raise InputError where a job names no material at all: a database has one at least."""
    if names:
        return
    look = "; 'tmm check' shows their colours" if job.clusters is not None else ""
    raise InputError(f"'{job.name}' names no material; allowed: one or more, of which texels may be{look}; name one")
