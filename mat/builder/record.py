"""``build.json``: what each file of a folder cost. The databases do not contain these figures, so that the same job
gives the same bytes.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from skyshine.mat.builder.folder import other_files
from skyshine.mat.builder.parts import Part
from skyshine.mat.products.product import TaskReport
from skyshine.mat.tables.build_record import NAME, costs_in
from skyshine.mat.tables.catalog import write_catalog
from skyshine.schemas.whole_files import write_whole


def record_of(
    folder: Path, reports: Sequence[TaskReport], seconds: float, failed: Mapping[str, str] = MappingProxyType({})
) -> dict[str, Any]:
    """What a build cost; files that it kept have the cost of the build that made them, where that is known.

    Parameters
    ----------
    folder : Path
        Folder of the databases.
    seconds : float
        Wall-clock time of the whole build [s].
    failed : mapping of str to str, optional
        Files and folders of sites that could not be built, and why.

    Returns
    -------
    dict
        Folder, seconds, the failed, and for each file whether it was kept, its seconds and stages by clock and
        processor, peak memory, notes, the file whose computation made it too (its cost is that of both) and, of tables
        that state it, the error of the quantity that errs most.
    """
    files, earlier = {}, costs_in(folder)
    for report in reports:
        for name in report.files:
            before = earlier.get(name) if report.kept else None
            files[name] = {**before, "kept": True} if before else _entry(report, name)
            if name != report.files[0]:
                files[name]["made_with"] = report.files[0]
    result = {"folder": str(folder), "seconds": round(seconds, 3), "not_of_this_job": []}
    return {**result, "failed": dict(failed), "files": files}


def write_record(folder: Path, record: Mapping[str, Any]) -> None:
    """Write what `record_of` gives; the records of parts of the job are in it and go."""
    write_whole(folder / NAME, json.dumps(record, indent=2) + "\n")
    for path in folder.glob("build.part-*.json"):
        path.unlink()


def write_part(folder: Path, part: Part, record: Mapping[str, Any], entries: Sequence[Mapping[str, Any]]) -> None:
    """Write the record of a part and the entries of its files in the catalogue."""
    write_whole(folder / f"{part.label}.json", json.dumps({"record": record, "catalog": list(entries)}) + "\n")


def merge_parts(folder: Path, part: Part) -> None:
    """Write record and catalogue of the whole job, once the records of all its parts are there."""
    paths = [folder / f"{Part(number, part.count).label}.json" for number in range(1, part.count + 1)]
    if not all(path.is_file() for path in paths):
        return
    contents = [json.loads(path.read_text(encoding="utf-8")) for path in paths]
    records = [content["record"] for content in contents]
    files = {name: entry for part_record in records for name, entry in part_record["files"].items()}
    failed = {
        name: reason for part_record in records for name, reason in part_record["failed"].items() if name not in files
    }
    seconds = max(part_record["seconds"] for part_record in records)
    record = {"folder": str(folder), "seconds": seconds, "not_of_this_job": other_files(folder, files)}
    write_whole(folder / NAME, json.dumps({**record, "failed": failed, "files": files}, indent=2) + "\n")
    entries = {entry["file"]: entry for content in contents for entry in content["catalog"]}
    if entries:
        write_catalog(folder, list(entries.values()))


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
