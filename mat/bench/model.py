"""Settings that are not built: errors of thinned tables, times by the numbers of their values."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from skyshine.mat.bench.pixel_errors import TablesOf, sets_of
from skyshine.mat.bench.rungs import STAGES, Rung
from skyshine.mat.bench.settings import Setting
from skyshine.mat.bench.thinned import thinned, value_counts
from skyshine.mat.budget.built_tables import Tables
from skyshine.schemas.arrays import Floats

BY_VALUES = ("tables", "temperature")  # stages whose time goes by the values of atmosphere and of temperatures
_UNTESTED = 0.25  # relative uncertainty of a stage where fewer than three settings were built


@dataclass
class ModelledRung:
    """A setting that is not built.

    Attributes
    ----------
    stages : dict of str to float
        Processor seconds by `STAGES`.
    uncertainty : float
        Of their sum, s.
    size : float
        Bytes.
    errors : dict
        As `Rung.errors`.
    """

    setting: Setting
    stages: dict[str, float]
    uncertainty: float
    size: float
    errors: dict[str, Any] = field(default_factory=dict)

    @property
    def seconds(self) -> float:
        """Processor seconds of the whole build."""
        return sum(self.stages.values())


@dataclass(frozen=True, eq=False)
class TimeModel:
    """Times of builds from those that were measured.

    Seconds of the tables and of the temperatures are linear in the numbers of their values between the builds, and as
    between the two nearest beyond them; all other stages have the mean of the builds.

    Attributes
    ----------
    rungs : list of Rung
        Built, at least one.
    """

    rungs: list[Rung]

    @cached_property
    def _counts(self) -> Floats:
        """Values (R, 2) of atmosphere and of temperatures in the built rungs."""
        return np.array([counts(rung, rung.tables) for rung in self.rungs], float)

    def _measured(self, stage: str) -> Floats:
        return np.array([rung.cost.stages[stage] for rung in self.rungs if rung.cost is not None])

    def stages(self, values: tuple[int, int]) -> tuple[dict[str, float], float]:
        """Processor seconds by stage of tables of so many values, and the uncertainty of their sum [s]: half the spread
        of the other stages, and the share by which each middle build is missed by the others.
        """
        seconds, variance, others = {}, 0.0, np.zeros(len(self.rungs))
        for stage in STAGES:
            measured = self._measured(stage)
            if stage not in BY_VALUES:
                seconds[stage] = float(measured.mean())
                others += measured
                continue
            column = BY_VALUES.index(stage)
            seconds[stage] = _between(self._counts[:, column], measured, values[column])
            variance += (seconds[stage] * _missed(self._counts[:, column], measured)) ** 2
        return seconds, float(np.sqrt(variance + (np.ptp(others) / 2) ** 2))

    def size(self, values: tuple[int, int]) -> float:
        """Bytes of databases of so many values, linear as the times are."""
        return _between(self._counts.sum(axis=1), np.array([rung.size for rung in self.rungs], float), sum(values))


def counts(rung: Rung, tables: TablesOf) -> tuple[int, int]:
    """Values of atmosphere and of temperatures of a job's databases."""
    job, air, surface = rung.loaded.trimmed, 0, {}
    for state, band, source in sets_of(job):
        of_set, surface[state] = value_counts(tables(state, band, source))
        air += of_set
    return air, sum(surface.values())


def modelled(
    setting: Setting, kelvin: float, finest: Rung, finest_kelvin: float, model: TimeModel
) -> tuple[ModelledRung, TablesOf]:
    """A coarser setting, from the tables of the finest: an interval's error goes with the square of its length.

    Parameters
    ----------
    kelvin, finest_kelvin : float
        Tolerances of the setting, and of the tables that are thinned.
    """
    factor = interval_factor(kelvin, finest_kelvin)

    def tables(state: int, band: int, source: str) -> Tables:
        return thinned(finest.tables(state, band, source), factor, factor)

    values = counts(finest, tables)
    stages, uncertainty = model.stages(values)
    return ModelledRung(setting, stages, uncertainty, model.size(values)), tables


def interval_factor(kelvin: float, finest_kelvin: float) -> float:
    """How many times as long intervals are at a tolerance as at a finer one, for what is linear between nodes.

    Examples
    --------
    >>> interval_factor(2.0, 0.5)
    2.0
    """
    return float(np.sqrt(max(kelvin / finest_kelvin, 1.0)))


def _between(values: Floats, seconds: Floats, at: float) -> float:
    """Seconds at a number of values, by the two measured ones around it or nearest to it; never falling, above 0."""
    order = np.argsort(values)
    values, seconds = values[order], np.maximum.accumulate(seconds[order])
    if values.size == 1 or np.ptp(values) == 0:
        return float(seconds.mean())
    upper = int(np.clip(np.searchsorted(values, at), 1, values.size - 1))
    low, high = values[upper - 1], values[upper]
    slope = (seconds[upper] - seconds[upper - 1]) / max(high - low, 1.0)
    return float(max(seconds[upper - 1] + slope * (at - low), 0.0))


def _missed(values: Floats, seconds: Floats) -> float:
    """Largest relative difference of a measured time from that which the others give, of all but the extremes."""
    order = np.argsort(values)
    middle = order[1:-1]
    if not middle.size:
        return _UNTESTED
    errors = [
        abs(_between(np.delete(values, k), np.delete(seconds, k), values[k]) / max(seconds[k], 1e-9) - 1)
        for k in middle
    ]
    return float(max(errors))
