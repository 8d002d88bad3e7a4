"""A batch of many states, timed on a few of them: where the tasks run, by stage, and what that makes of the whole batch."""

from __future__ import annotations

import dataclasses
import os
import tempfile
import time
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.mat.band_cache import CACHE_VARIABLE
from skyshine.mat.build import build
from skyshine.mat.job import LoadedJob


@dataclass(frozen=True)
class BatchTiming:
    """Building a sample of a batch in one place.

    Attributes
    ----------
    place : str
    seconds : float
        By the clock, start of the processes included.
    stages : dict of str to float
        Seconds by stage, added over all tasks.
    same : bool
        Whether the files are those of the first place, byte for byte.
    """

    place: str
    seconds: float
    stages: dict[str, float]
    same: bool


def sampled(loaded: LoadedJob, count: int) -> LoadedJob:
    """The job with `count` of its states, evenly spread, and without pictures."""
    job = loaded.job
    chosen = np.unique(np.linspace(0, len(job.states) - 1, min(count, len(job.states))).round().astype(int))
    output = job.output.model_copy(update={"pictures": False})
    return dataclasses.replace(loaded, job=job.model_copy(update={"states": [job.states[i] for i in chosen], "output": output}))


def bench_batch(loaded: LoadedJob, workers: int, advance: Callable[[int], None] = lambda _: None) -> list[BatchTiming]:
    """Time a job in one process, in `workers` processes, and on a local Dask cluster of as many workers, if Dask is there.

    Bands are compiled anew each time, as the states of a batch differ.
    """
    found: list[BatchTiming] = []
    with tempfile.TemporaryDirectory() as place, _no_cache():
        first = Path(place) / "1"

        def timed(name: str, folder: Path, **where) -> None:
            begin = time.perf_counter()
            report = build(loaded, out=folder, **where)
            seconds, stages = time.perf_counter() - begin, {}
            for entry in _by_task(report):
                for stage, spent in entry["stages"].items():
                    stages[stage] = stages.get(stage, 0.0) + spent
            found.append(BatchTiming(name, seconds, stages, _contents(folder) == _contents(first)))
            advance(1)

        timed("one process", first, jobs=1)
        timed(f"{workers} processes", Path(place) / "n", jobs=workers)
        try:
            import distributed
        except ImportError:
            return found
        with distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
            timed(f"Dask, {workers} workers", Path(place) / "dask", executor=f"dask:{cluster.scheduler_address}")
    return found


def _by_task(report: dict) -> list[dict]:
    """One entry a task: the tables of Sun and Moon, s01b01.atmq and s01b01.lunar_atmq, share their stages."""
    return list({name.split(".")[0]: entry for name, entry in report["files"].items()}.values())


def _contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*.h5")}


@contextmanager
def _no_cache():
    before = os.environ.get(CACHE_VARIABLE)
    os.environ[CACHE_VARIABLE] = ""
    try:
        yield
    finally:
        os.environ.pop(CACHE_VARIABLE) if before is None else os.environ.__setitem__(CACHE_VARIABLE, before)
