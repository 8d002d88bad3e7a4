"""What a scene reads of the tables of a job, and what the job costs when it builds no more."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skyshine.mat.api.check import JobCheck, checked
from skyshine.mat.job.load import load_job
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.render.needs_text import needs_text, with_needs
from skyshine.mat.render.query_limits import LEAST_SHARE, SceneNeeds, scene_needs
from skyshine.mat.render.reads import scene_reads
from skyshine.mat.render.scene_file import load_scene
from skyshine.schemas.errors import InputError
from skyshine.schemas.progress import Progress, silent
from skyshine.schemas.whole_files import part_file


@dataclass(frozen=True, eq=False, repr=False)
class JobNeeds:
    """The needs of a scene for a job.

    Attributes
    ----------
    needs : SceneNeeds
        Query limits with their reasons, and materials that other ones replace.
    text : str
        The key `needs` of a job in YAML, with the reasons as comments.
    whole, reduced : JobCheck
        Plans of the job as it is written, and with these needs.
    """

    needs: SceneNeeds
    text: str
    whole: JobCheck
    reduced: JobCheck

    def __repr__(self) -> str:
        return f"<JobNeeds of {len(self.needs.limits)} keys: {self.saving}>"

    @property
    def saving(self) -> str:
        """Cost of the build with the needs beside that of the job as it is written."""
        full, reduced = self.whole, self.reduced
        return (
            f"{reduced.bytes / 1e6:.1f} MB of {full.bytes / 1e6:.1f} MB,"
            f" {reduced.cost.total:.0f} s of {full.cost.total:.0f} s of one core, estimated"
        )

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write a copy of the job with these needs.

        Parameters
        ----------
        path : path
            A new file in the folder of the job, to which the paths in the job are relative.

        Raises
        ------
        InputError
            The path is in another folder or is the job itself, or cannot be written.
        """
        target, job = Path(path), self.whole.loaded
        if target.resolve().parent != job.folder or target.resolve() == job.file.resolve():
            raise InputError(
                f"found --out {target}; allowed: another file in the folder of the job, {job.folder}, to which its "
                "paths are relative"
            )
        part = part_file(target)
        try:
            part.write_text(with_needs(job.file.read_text(encoding="utf-8"), self.text), encoding="utf-8")
            load_job(part)
            part.replace(target)
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror or error}; name another file", file=target) from None
        finally:
            part.unlink(missing_ok=True)
        return target


def needs(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    job: str | os.PathLike[str],
    *,
    least_share: float = LEAST_SHARE,
    progress: Progress = silent,
) -> JobNeeds:
    """Cast the rays of a scene's cameras, and find what its frames read of the tables of a job.

    Parameters
    ----------
    scene : path or mapping
        A YAML scene, or its content.
    job : path
        A YAML job, whose site and date place the Sun; its tables must reach what the scene reads.
    least_share : float
        Share of the pixels, 0 to 0.5. The most similar material replaces one with less.
    progress : callable, optional
        Called as ``progress(total, description)``; its result is a context manager that gives a function of the number
        done.

    Raises
    ------
    InputError
        The tables of the job do not reach what the scene reads, or lack its bands, state, source or materials.

    Examples
    --------
    >>> import skyshine.mat
    >>> less = skyshine.mat.needs("demo/scene.yaml", "demo/job.yaml")  # doctest: +SKIP
    >>> less.write("demo/less.yaml")  # doctest: +SKIP
    """
    loaded_scene, loaded = load_scene(scene), load_job(job)
    library = job_materials(loaded.trimmed.own_materials)
    limits = scene_needs(loaded_scene, scene_reads(loaded_scene, progress), library, loaded, least_share)
    content = dict(loaded.document.data) | {"needs": {limit.key: limit.value for limit in limits.limits}}
    reduced = load_job(content, folder=loaded.folder)
    text = needs_text(loaded_scene.document.file.name, limits)
    return JobNeeds(limits, text, checked(loaded), checked(reduced))
