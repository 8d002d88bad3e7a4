"""A batch of many states, timed on a sample: by place and stage, with an estimate for the whole batch."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.band.cache import Origin
from skyshine.mat.bench.sample import cache_in
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.plan.cost import choices

_NEW = {Origin.FITTED.value, Origin.SIMILAR.value}  # notes of a task that chose points


@dataclass(frozen=True)
class BatchTiming:
    """Building a sample of a batch in one place.

    Attributes
    ----------
    executor : str
    workers : int
    seconds : float
        Wall time; for processes of this machine it includes their start.
    processor_seconds : float
        Processor time of all tasks, which does not depend on the load of the machine.
    stages : dict of str to float
        Seconds by stage, added over all tasks.
    further : float
        Seconds that the tasks of one more state take a process which has its points.
    choice : float
        Seconds that a process takes to choose the points of all bands for another air.
    identical : bool
        Whether the files are those of the first place, byte for byte.
    """

    executor: str
    workers: int
    seconds: float
    processor_seconds: float
    stages: dict[str, float]
    further: float
    choice: float
    identical: bool

    def whole(self, sample: Size, batch: Size) -> float:
        """Seconds of the whole batch: those of the sample, and the further states and airs evenly on all workers.

        Each process chooses the points of an air that it meets, and meets it if there are as many states of it.
        """
        meets = min(self.workers, batch.states / batch.airs)
        more = (batch.states - sample.states) * self.further + (batch.airs - sample.airs) * meets * self.choice
        return self.seconds + more / self.workers


@dataclass(frozen=True)
class Size:
    """How many states a job has, and for how many airs, or cells of similar airs, points are chosen."""

    states: int
    airs: int

    @classmethod
    def of(cls, loaded: LoadedJob) -> Size:
        return cls(len(loaded.trimmed.states), choices(loaded))


def bench_batch(loaded: LoadedJob, workers: int, advance: Callable[[int], None] = lambda _: None) -> list[BatchTiming]:
    """Time a job in one process, in `workers` processes, and on a local Dask cluster of as many workers, if Dask is
    there.

    No band comes from the cache folder; what a process keeps, it keeps for this job alone.
    """
    timings: list[BatchTiming] = []
    with tempfile.TemporaryDirectory() as scratch, cache_in(None):
        reference = Path(scratch) / "1"

        def timed(name: str, count: int, folder: Path, **where: Any) -> None:
            begin = time.perf_counter()
            report = build(loaded, out=folder, **where)
            seconds = time.perf_counter() - begin
            timings.append(_timing(name, count, seconds, report, _contents(folder) == _contents(reference)))
            advance(1)

        timed("one process", 1, reference, jobs=1)
        timed(f"{workers} processes", workers, Path(scratch) / "n", jobs=workers)
        try:
            import distributed
        except ImportError:
            return timings
        with distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
            timed(
                f"Dask, {workers} workers",
                workers,
                Path(scratch) / "dask",
                executor=f"dask:{cluster.scheduler_address}",
            )
    return timings


def _timing(executor: str, workers: int, seconds: float, report: dict[str, Any], identical: bool) -> BatchTiming:
    # One entry a task: the tables of Sun and Moon, s01b01.atmq and s01b01.lunar_atmq, share theirs.
    tasks = {name.split(".")[0]: entry for name, entry in report["files"].items()}
    of_states = {name: entry for name, entry in tasks.items() if name.startswith("s")}
    states = {name.split("b")[0] for name in of_states}
    stages: dict[str, float] = {}
    for entry in tasks.values():
        for stage, spent in entry["stages"].items():
            stages[stage] = stages.get(stage, 0.0) + spent
    chosen = {name: entry["stages"]["compile"] for name, entry in of_states.items() if _NEW & set(entry["notes"])}
    further = (sum(entry["seconds"] for entry in of_states.values()) - sum(chosen.values())) / len(states)
    bands = {name.split("b")[1] for name in chosen}
    choice = sum(
        float(np.mean([spent for name, spent in chosen.items() if name.endswith(f"b{band}")])) for band in bands
    )
    work = sum(entry["processor_seconds"] for entry in tasks.values())
    return BatchTiming(executor, workers, seconds, work, stages, further, choice, identical)


def _contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.h5")}
