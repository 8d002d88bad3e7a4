"""What a product of a build is: its identity, its computation, and the report of what it cost."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from skyshine.mat.job.model import resolved_text
from skyshine.mat.tables.files import FileType
from skyshine.schemas.hdf5 import Group, Header, is_current, write_file


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
        return is_current(self.path, self.header)

    def write(self, root: Group) -> None:
        write_file(self.path, root, self.header)
