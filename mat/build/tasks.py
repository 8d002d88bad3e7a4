"""One task of a plan to its files: compute, measure the error, write; or keep what the same job wrote before."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path

from skyshine.mat.job.model import LoadedJob, resolved_text
from skyshine.mat.plan.plan import Task
from skyshine.mat.tables.files import FileType
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group, Header, content_hash, open_database, part_file, write_file


@dataclass
class TaskReport:
    """What a task did and what it cost.

    Attributes
    ----------
    files : tuple of str
    kept : bool
        The files were there already, from the same job.
    seconds : float
    processor_seconds : float
        Of the whole process meanwhile.
    stages : dict of str to float
        Seconds by stage.
    peak_memory : int
        Largest resident size of the process so far, bytes.
    notes : list of str
        What was left out inside the task, and the like.
    """

    files: tuple[str, ...]
    kept: bool = False
    seconds: float = 0.0
    processor_seconds: float = 0.0
    stages: dict[str, float] = field(default_factory=dict)
    peak_memory: int = 0
    notes: list[str] = field(default_factory=list)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of the body under a name."""
        begin = time.perf_counter()
        yield
        self.stages[name] = self.stages.get(name, 0.0) + time.perf_counter() - begin


@dataclass(frozen=True)
class Product:
    """A database about to be written: its type and what of the job it depends on."""

    path: Path
    kind: FileType
    data_version: str
    resolved: dict

    @property
    def header(self) -> Header:
        return Header(
            self.kind.name, self.kind.format_version, self.data_version, resolved_text(self.resolved), self.kind.title
        )

    def is_there(self) -> bool:
        """Whether the file exists, undamaged, from the same content and versions."""
        expected = {
            "job": self.header.job,
            "format_version": self.kind.format_version,
            "data_version": self.data_version,
            "generator": f"skyshine {metadata.version('skyshine')}",
        }
        try:
            with open_database(self.path, self.kind.name) as file:
                same = all(file.attrs.get(name) == value for name, value in expected.items())
                return same and content_hash(file) == file.attrs.get("content_sha256")
        except (InputError, OSError):
            return False

    def write(self, root: Group) -> None:
        write_file(self.path, root, self.header)


def run_task(task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool) -> TaskReport:
    """Run one task of a plan; safe to call in another process.

    Parameters
    ----------
    materials : tuple of str
        To build, for tasks that depend on them.
    fresh : bool
        Build even what is there.

    Raises
    ------
    InputError
    """
    begin, spent = time.perf_counter(), time.process_time()
    report = TaskReport(task.files)
    if task.kind in ("atmosphere", "temperature", "thermal"):
        loaded = loaded.of_state(task.index)
    _runner(task.kind)(task, loaded, folder, materials, fresh, report)
    if loaded.job.output.pictures:
        with report.stage("pictures"):
            _draw(task, loaded, folder, report.kept)
    report.seconds = time.perf_counter() - begin
    report.processor_seconds = time.process_time() - spent
    report.peak_memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    return report


def _draw(task: Task, loaded: LoadedJob, folder: Path, kept: bool) -> None:
    """Draw the files of a task into the folder ``pictures``; those of kept files only where they are missing."""
    from skyshine.mat.tables.pictures import draw
    from skyshine.tmm.preview import draw as draw_texture

    for name in task.files:
        picture = folder / "pictures" / f"{name.removesuffix('.h5')}.png"
        if kept and picture.is_file():
            continue
        part = part_file(picture).with_suffix(".part.png")
        try:
            picture.parent.mkdir(exist_ok=True)
            if task.kind == "texture":
                draw_texture(folder / name, part, loaded.folder / loaded.job.textures[task.index].image)
            else:
                draw(folder / name, part)
            os.replace(part, picture)
        except OSError as error:
            raise InputError(
                f"cannot be written: {error.strerror or error}; check space and rights", file=picture
            ) from None
        finally:
            part.unlink(missing_ok=True)


def _runner(kind: str) -> Callable:
    from skyshine.mat.products import atmosphere as atmosphere_product, band as band_product, emission as emission_product, temperature as temperature_product, texture as texture_product

    modules = {
        "texture": texture_product,
        "band": band_product,
        "temperature": temperature_product,
        "atmosphere": atmosphere_product,
        "thermal": emission_product,
    }
    return modules[kind].run
