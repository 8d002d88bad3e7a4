"""``build.json``: what each file of a folder cost. The databases do not contain these figures, so that the same job
gives the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from skyshine.mat.products.product import TaskReport
from skyshine.mat.tables.build_record import NAME, cost_of
from skyshine.schemas.whole_files import write_whole


def write_record(
    folder: Path,
    reports: Sequence[TaskReport],
    others: Sequence[str],
    seconds: float,
    failed: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Any]:
    """Write what a build cost; files that it kept have the cost of the build that made them, where that is known.

    Parameters
    ----------
    folder : Path
        Folder of the databases.
    reports : sequence of TaskReport
    others : sequence of str
        Databases in the folder that this build did not write or keep: of an earlier job, say.
    seconds : float
        Wall-clock time of the whole build [s].
    failed : mapping of str to str, optional
        Files that could not be built, and why.

    Returns
    -------
    dict
        What was written: folder, seconds, the others, the failed, and for each file whether it was kept, its seconds
        and stages by clock and processor, peak memory, notes and, of tables that state it, the error of the quantity
        that errs most.
    """
    files = {}
    for report in reports:
        for name in report.files:
            before = cost_of(folder / name) if report.kept else None
            files[name] = {**before, "kept": True} if before else _entry(report, name)
    result = {"folder": str(folder), "seconds": round(seconds, 3), "not_of_this_job": list(others)}
    result |= {"failed": dict(failed), "files": files}
    write_whole(folder / NAME, json.dumps(result, indent=2) + "\n")
    return result


def _entry(report: TaskReport, name: str) -> dict[str, Any]:
    entry = {
        "kept": report.kept,
        "seconds": round(report.seconds, 3),
        "processor_seconds": round(report.processor_seconds, 3),
        "stages": {stage: round(value, 3) for stage, value in report.stages.items()},
        "processor_stages": {stage: round(value, 3) for stage, value in report.processor_stages.items()},
        "peak_memory_bytes": report.peak_memory,
        "notes": list(report.notes),
    }
    error = report.error_kelvin.get(name)
    return entry if error is None else entry | {"error_kelvin": error}
