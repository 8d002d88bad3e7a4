"""Whether the files of a plan are within the sizes that its job allows."""

from __future__ import annotations

from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.plan import FLOAT_BYTES, Kind, Plan

GIGABYTE = 1e9  # bytes
_GRIDS = {Kind.TEMPERATURE: "surface_grid"}  # the other kinds have atmosphere_grid


def check_size(loaded: LoadedJob, plan: Plan, sites: int = 1) -> None:
    """Refuse a job whose tables are too large, before anything is computed; of several `sites`, as many times the plan
    of one.

    Raises
    ------
    InputError
        A file, or all files together, take more than the job's ``output`` allows; sizes are those before compression.
    """
    output = loaded.requested.output
    largest = max(plan.tasks, key=lambda task: task.values / len(task.files))
    count = largest.values // len(largest.files)
    size = FLOAT_BYTES * count
    if size > output.max_file_gigabytes * GIGABYTE:
        grid = _GRIDS.get(largest.kind, "atmosphere_grid")
        raise loaded.document.error(
            (grid,),
            f"{grid}: found {count:.3g} values, {size / GIGABYTE:.3g} GB, in {largest.files[0]}; allowed: at most"
            f" {output.max_file_gigabytes:g} GB a file before compression (output.max_file_gigabytes); name fewer nodes"
            " or materials, or raise it",
        )
    if sites * plan.bytes > output.max_gigabytes * GIGABYTE:
        files = sites * sum(len(task.files) for task in plan.tasks)
        raise loaded.document.error(
            ("output",),
            f"found {sites * plan.bytes / GIGABYTE:.3g} GB of tables in {files:,} files; allowed: at most"
            f" {output.max_gigabytes:g} GB before compression (output.max_gigabytes); name fewer states, nodes or"
            " materials, or raise it",
        )
