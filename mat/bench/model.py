"""Settings that are not built: errors of thinned tables, times by the numbers of their values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from skyshine.mat.bench.pixel_errors import SetErrors, Variant
from skyshine.mat.bench.rungs import STAGES, Rung
from skyshine.mat.bench.settings import Setting
from skyshine.mat.bench.thinned import thinned
from skyshine.mat.job.fields import tolerance_parts
from skyshine.schemas.arrays import Floats

BY_VALUES = ("tables", "temperature")  # stages whose time goes by the values of atmosphere and of temperatures
_UNTESTED = 0.25  # relative uncertainty of a stage where fewer than three settings were built


@dataclass(frozen=True)
class ModelledRung:
    """A setting that is not built.

    Attributes
    ----------
    setting : Setting
    stages : dict of str to float
        Processor seconds by `STAGES`.
    uncertainty : float
        Of their sum, s.
    size : float
        Bytes.
    """

    setting: Setting
    stages: dict[str, float]
    uncertainty: float
    size: float

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
    rungs : sequence of R Rung
        Built, at least one.
    values : (R, 2) array
        Numbers of values of atmosphere and of temperatures in their tables.
    """

    rungs: Sequence[Rung]
    values: Floats

    @classmethod
    def of(cls, rungs: Sequence[Rung], sets: Sequence[SetErrors]) -> TimeModel:
        """The model by rungs whose tables were measured."""
        return cls(rungs, np.array([counts(sets, rung.setting.name) for rung in rungs], float))

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
            seconds[stage] = _between(self.values[:, column], measured, values[column])
            variance += (seconds[stage] * _missed(self.values[:, column], measured)) ** 2
        return seconds, float(np.sqrt(variance + (np.ptp(others) / 2) ** 2))

    def size(self, values: tuple[int, int]) -> float:
        """Bytes of databases of so many values, linear as the times are."""
        return _between(self.values.sum(axis=1), np.array([rung.size for rung in self.rungs], float), sum(values))


def counts(sets: Sequence[SetErrors], name: str) -> tuple[int, int]:
    """Values of atmosphere and of temperatures of a variant's tables; states have the latter in common."""
    surface = {of_set.state: of_set.values[name][1] for of_set in sets}
    return sum(of_set.values[name][0] for of_set in sets), sum(surface.values())


def kelvin_of_nodes(rung: Rung) -> float:
    """Tolerance of the nodes of a rung's atmosphere."""
    return tolerance_parts(rung.loaded.trimmed.atmosphere_grid.tolerance)[0]


def thinner(rung: Rung, finest: Rung) -> Variant:
    """A coarser setting by the tables of the finest: an interval's error goes with the square of its length."""
    factor = interval_factor(kelvin_of_nodes(rung), kelvin_of_nodes(finest))
    return Variant(rung.setting.name, finest, partial(thinned, air=factor, surface=factor))


def modelled(setting: Setting, sets: Sequence[SetErrors], model: TimeModel) -> ModelledRung:
    """Times and size of a setting by the numbers of values of its thinned tables."""
    values = counts(sets, setting.name)
    return ModelledRung(setting, *model.stages(values), model.size(values))


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
