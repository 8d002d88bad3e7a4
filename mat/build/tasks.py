"""One task of a plan to its files: compute, measure the error, write; or keep what the same job wrote before."""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Callable
from pathlib import Path

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import TaskReport
from skyshine.schemas.errors import InputError
from skyshine.schemas.whole_files import part_file


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
    from skyshine.mat.products import atmosphere as atmosphere_product
    from skyshine.mat.products import band as band_product
    from skyshine.mat.products import emission as emission_product
    from skyshine.mat.products import temperature as temperature_product
    from skyshine.mat.products import texture as texture_product

    modules = {
        "texture": texture_product,
        "band": band_product,
        "temperature": temperature_product,
        "atmosphere": atmosphere_product,
        "thermal": emission_product,
    }
    return modules[kind].run
