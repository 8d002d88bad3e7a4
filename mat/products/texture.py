"""The ``.tmm`` database of one texture."""

from __future__ import annotations

from pathlib import Path

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import TaskReport
from skyshine.materials.library import load_library
from skyshine.tmm.mapping.texture_map import map_texture
from skyshine.tmm.mapping.write import is_current, write_texture


def run(
    task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool, report: TaskReport
) -> None:
    """Build the material codes of a texture; arguments as `products.run_task`."""
    library, job = load_library(), loaded.job.textures[task.index]
    path = folder / task.files[0]
    if not fresh and is_current(path, job, loaded.folder, library.version):
        report.kept = True
        return
    with report.stage("train"):
        mapped = map_texture(job, loaded.folder, library)
    with report.stage("classify and write"):
        write_texture(mapped, path)
    if mapped.quality.whole.tested:
        report.notes.append(f"held-out seeds: accuracy {mapped.quality.whole.overall_accuracy:.3f}")
