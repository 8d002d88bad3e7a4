"""A few states of a job, and a cache of its own, for measurements."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from skyshine.mat.job.load import LoadedJob
from skyshine.schemas.kept_arrays import CACHE_VARIABLE


def sampled(loaded: LoadedJob, count: int) -> LoadedJob:
    """The job with `count` of its states, evenly spread, and without pictures."""
    states, output = len(loaded.trimmed.states), loaded.trimmed.output.model_copy(update={"pictures": False})
    chosen = np.unique(np.linspace(0, states - 1, min(count, states)).round().astype(int))
    requested, trimmed = (
        job.model_copy(update={"states": [job.states[i] for i in chosen], "output": output})
        for job in (loaded.requested, loaded.trimmed)
    )
    return dataclasses.replace(loaded, requested=requested, trimmed=trimmed)


def with_spectral_tolerance(loaded: LoadedJob, tolerance: float) -> LoadedJob:
    """The job with another tolerance of its compiled bands."""
    requested, trimmed = (
        job.model_copy(update={"accuracy": job.accuracy.model_copy(update={"spectral_tolerance": tolerance})})
        for job in (loaded.requested, loaded.trimmed)
    )
    return dataclasses.replace(loaded, requested=requested, trimmed=trimmed)


@contextmanager
def cache_in(folder: Path | None) -> Iterator[None]:
    """With a folder of kept bands of its own, or None for none."""
    before = os.environ.get(CACHE_VARIABLE)
    os.environ[CACHE_VARIABLE] = "" if folder is None else str(folder)
    try:
        yield
    finally:
        os.environ.pop(CACHE_VARIABLE) if before is None else os.environ.__setitem__(CACHE_VARIABLE, before)
