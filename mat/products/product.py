"""What a product of a build is: the files that it writes, how their content is computed, what that cost."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol, TypeVar

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import resolved_text
from skyshine.mat.plan.plan import Task
from skyshine.mat.tables.files import FileType
from skyshine.mat.tables.stated_error import worst_kelvin
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.hdf5 import Group, Header, is_current, write_file

Content = TypeVar("Content")
Written = TypeVar("Written", contravariant=True)


@dataclass(frozen=True)
class Context:
    """What a task is computed from.

    Attributes
    ----------
    loaded : LoadedJob
        Its site on the date of the task's state, where the task has one.
    materials : tuple of str
        Materials to build, for products that depend on them.
    """

    task: Task
    loaded: LoadedJob
    materials: tuple[str, ...]
    library: MaterialLibrary


@dataclass
class TaskReport:
    """What a task did and what it cost.

    Attributes
    ----------
    kept : bool
        The files were there already, from the same job.
    processor_seconds : float
        Processor time of the whole process during the task [s].
    stages, processor_stages : dict of str to float
        Seconds by stage, by the clock and of the whole process.
    peak_memory : int or None
        Largest resident size of the process so far, bytes.
    notes : list of str
        What was omitted inside the task, and the like.
    error_kelvin : dict of str to dict
        Errors by file: the quantity with the largest error, its 99th percentile and its maximum [K]; only of tables
        that state them.
    entries : list of dict
        Entries of the files in the catalogue.
    """

    files: tuple[str, ...]
    kept: bool = False
    seconds: float = 0.0
    processor_seconds: float = 0.0
    stages: dict[str, float] = field(default_factory=dict)
    processor_stages: dict[str, float] = field(default_factory=dict)
    peak_memory: int | None = None
    notes: list[str] = field(default_factory=list)
    error_kelvin: dict[str, dict[str, Any]] = field(default_factory=dict)
    entries: list[dict[str, Any]] = field(default_factory=list)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count the time of the body under a name."""
        begin, spent = time.perf_counter(), time.process_time()
        yield
        self.stages[name] = self.stages.get(name, 0.0) + time.perf_counter() - begin
        self.processor_stages[name] = self.processor_stages.get(name, 0.0) + time.process_time() - spent


class Identity(Protocol[Written]):
    """One file of a product: what it depends on, and how its content is written and drawn."""

    @property
    def file(self) -> str:
        """Name in the output folder."""

    def is_current(self, folder: Path) -> bool:
        """Whether the file is there, undamaged, from the same content and versions."""

    def write(self, folder: Path, content: Written) -> None:
        """Write the file whole or not at all."""

    def draw(self, folder: Path, picture: Path) -> None:
        """Draw the written file into a PNG."""

    def error_kelvin(self, content: Written) -> dict[str, Any] | None:
        """What the content states of its error: `stated_error.worst_kelvin`."""


class Product(Protocol[Content]):
    """One kind of task: the files it writes, and the content of each.

    `skyshine.mat.builder.tasks.run_task` keeps, writes and draws them.
    """

    def identity(self, context: Context) -> tuple[Identity[Content], ...]:
        """The files of a task, in the order of its `files`."""

    def compute(self, context: Context, report: TaskReport) -> Iterator[Content]:
        """The content of each of those files, in the same order.

        Parameters
        ----------
        report : TaskReport
            Is given the stages and notes of the computation.

        Yields
        ------
        content
            As the `Identity` of the file writes it.
        """


@dataclass(frozen=True)
class TableIdentity:
    """A database of the table builder: its type and what of the job it depends on.

    Attributes
    ----------
    data_version : str
        Version of the packaged data that the table is computed from.
    resolved : dict
        What of the job it depends on.
    """

    file: str
    kind: FileType
    data_version: str
    resolved: dict[str, Any]

    @property
    def header(self) -> Header:
        """The root attributes of the file."""
        return Header(self.kind.name, self.data_version, resolved_text(self.resolved), self.kind.title)

    def is_current(self, folder: Path) -> bool:
        """Whether the file is there, undamaged, from the same content and versions."""
        return is_current(folder / self.file, self.header)

    def write(self, folder: Path, content: Group) -> None:
        """Write the file whole or not at all."""
        write_file(folder / self.file, content, self.header)

    def draw(self, folder: Path, picture: Path) -> None:
        """Draw the written file into a PNG."""
        from skyshine.mat.tables.pictures import draw

        draw(folder / self.file, picture)

    def error_kelvin(self, content: Group) -> dict[str, Any] | None:
        """What the table states of its error."""
        return worst_kelvin(content)
