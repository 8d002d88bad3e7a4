"""One task of a plan to its files: keep what the same job wrote before, or compute and write; and their pictures."""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import Context, Identity, TaskReport
from skyshine.mat.products.table import PRODUCTS
from skyshine.mat.scene.moisture import job_library
from skyshine.mat.tables.catalog import catalog_entry
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path
from skyshine.schemas.process_memory import peak_memory
from skyshine.schemas.whole_files import part_file

PICTURES = "pictures"  # folder in the output folder


def run_task(task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool) -> TaskReport:
    """Run one task of a plan; safe to call in another process.

    Parameters
    ----------
    folder : Path
        Folder of the output.
    materials : tuple of str
        Materials to build, for tasks that depend on them.
    fresh : bool
        Build even what is there.

    Raises
    ------
    InputError
        A file of the job does not fit, or a file cannot be written.
    """
    begin, spent = time.perf_counter(), time.process_time()
    report = TaskReport(task.files)
    product, context = PRODUCTS[task.kind], _context(task, loaded, materials)
    identities = product.identity(context)
    if not fresh and _are_current(identities, folder):
        report.kept = True
    else:
        for identity, content in zip(identities, product.compute(context, report), strict=True):
            with report.stage("write"):
                identity.write(folder, content)
            if error := identity.error_kelvin(content):
                report.error_kelvin[identity.file] = error
    report.entries = [catalog_entry(folder, name) for name in task.files]
    report.seconds = time.perf_counter() - begin
    report.processor_seconds = time.process_time() - spent
    report.peak_memory = peak_memory()
    return report


def is_kept(task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...]) -> bool:
    """Whether the files of a task are there, from the same job. Arguments as `run_task`."""
    if not all((folder / name).is_file() for name in task.files):
        return False
    return _are_current(PRODUCTS[task.kind].identity(_context(task, loaded, materials)), folder)


def _are_current(identities: Iterable[Identity[Any]], folder: Path) -> bool:
    return all(identity.is_current(folder) for identity in identities)


def _context(task: Task, loaded: LoadedJob, materials: tuple[str, ...]) -> Context:
    """What a task is computed from, on the date of its state."""
    if task.kind.of_state:
        loaded = loaded.on_date_of_state(task.index)
    return Context(task, loaded, materials, job_library(loaded.trimmed))


def draw_task(task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...]) -> None:
    """Draw the files of a task into the folder ``pictures``; safe to call in another process. Arguments as `run_task`.

    Raises
    ------
    InputError
        A picture cannot be written.
    """
    for identity in PRODUCTS[task.kind].identity(_context(task, loaded, materials)):
        draw_file(identity, folder)


def draw_file(identity: Identity[Any], folder: Path) -> None:
    """Draw a file into the folder ``pictures``, unless its picture is younger than it."""
    picture, file = folder / PICTURES / f"{identity.file.removesuffix('.h5')}.png", folder / identity.file
    if picture.is_file() and picture.stat().st_mtime >= file.stat().st_mtime:
        return
    part = part_file(picture)
    part = part.with_name(f"{part.name}.png")
    try:
        job_path(folder, PICTURES, for_output=True)  # an existing link there leads nowhere else
        picture.parent.mkdir(parents=True, exist_ok=True)
        identity.draw(folder, part)
        os.replace(part, picture)
    except ValueError as error:
        raise InputError(str(error), file=picture.parent) from None
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}; check free space and permissions", file=picture
        ) from None
    finally:
        part.unlink(missing_ok=True)
