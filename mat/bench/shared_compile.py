"""Bands of one job at many settings: sampled once, their points chosen by each tolerance."""

from __future__ import annotations

import shutil
import time
from collections.abc import Sequence
from functools import partial
from itertools import product
from pathlib import Path
from typing import TypeAlias

from skyshine.mat.atmosphere.band.cache import shared_samples
from skyshine.mat.bench.sample import cache_in
from skyshine.mat.builder.executors import open_executor
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.scene.bands import all_points, response_of
from skyshine.mat.scene.compiled import StateBand
from skyshine.mat.threads import VARIABLE, core_count

Seconds: TypeAlias = dict[tuple[int, int], float]  # by state and band, counted from 1


def compile_bands(settings: Sequence[tuple[LoadedJob, Path]], folder: Path) -> list[Seconds]:
    """Compile the bands of settings of one job, each into an empty cache of its own.

    Parameters
    ----------
    settings : sequence of (LoadedJob, Path)
        Jobs that differ in their accuracy, with their caches.

    Returns
    -------
    list of dict
        Processor seconds of each setting by state and band, as if it were compiled alone.
    """
    for cache in {cache for _, cache in settings}:
        shutil.rmtree(cache, ignore_errors=True)
        cache.mkdir(parents=True)
    job = settings[0][0].trimmed
    numbers = list(product(range(1, len(job.states) + 1), job.needed_bands))
    with open_executor(None, min(len(numbers), core_count()), folder, {VARIABLE: "1"}) as pool:
        seconds = list(pool.map(partial(_compiled, list(settings)), numbers))
    return [dict(zip(numbers, of_setting, strict=True)) for of_setting in zip(*seconds, strict=True)]


def _compiled(settings: list[tuple[LoadedJob, Path]], number: tuple[int, int]) -> list[float]:
    """Processor seconds of a state and band at each setting, with those of a sample that another setting has taken."""
    state, band = number
    job, spent = settings[0][0].trimmed, []
    all_points(response_of(job.bands[band - 1]), job.water_continuum)  # read before it is timed
    with shared_samples() as samples:
        for loaded, cache in settings:
            before, begin = len(samples), time.process_time()
            with cache_in(cache):
                StateBand.of(loaded.on_date_of_state(state), state, band)
            sampled_before = sum(seconds for _, seconds in samples.values()) if len(samples) == before else 0.0
            spent.append(time.process_time() - begin + sampled_before)
    return spent
