"""A weather record with the temperature of the surface beneath it, as it was measured."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.surface.record import Record, equal_steps
from skyshine.mat.surface.weather_readings import (
    NEEDED_COLUMNS,
    SKIN_COLUMNS,
    SURFACE_COLUMNS,
    WATER_COLUMNS,
    Readings,
    forcing_of,
    record_readings,
)
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

LONGEST_MEAN = 1800.0  # s: readings at shorter steps are averaged to at most this
_STRAY = 0.01  # fraction of a step by which a reading may miss its time
_COLDEST = 100.0  # K: what a radiometer shows of a surface that emits less than it reflects


@dataclass(frozen=True, eq=False)
class MeasuredRecord:
    """Weather at equal steps, and the skin where it was measured.

    Attributes
    ----------
    skin : (N,) ndarray
        Surface temperature [K] or upwelling longwave [W m^-2]; NaN where there is none.
    radiometric : bool
        Whether `skin` is longwave.
    file : Path or None
        File of the record, for messages.
    """

    record: Record
    skin: Floats
    radiometric: bool
    file: Path | None = None

    def temperature(self, emissivity: float) -> tuple[Floats, Floats]:
        """Skin temperature [K] of a surface of this emissivity and its derivative by it, each (N,).

        What a radiometer sees is emission and the reflected part of the sky's longwave.
        """
        if not self.radiometric:
            return self.skin, np.zeros_like(self.skin)
        sky = self.record.values["lw_down"]
        fourth = (self.skin - (1.0 - emissivity) * sky) / (emissivity * STEFAN_BOLTZMANN)
        bend = (sky - self.skin) / (emissivity**2 * STEFAN_BOLTZMANN)
        reflects = fourth < _COLDEST**4
        kelvin = np.where(reflects, _COLDEST, np.abs(fourth) ** 0.25)
        return kelvin, np.where(reflects, 0.0, 0.25 * bend / kelvin**3)

    def averaged(self, longest: float = LONGEST_MEAN) -> MeasuredRecord:
        """Means of as many steps as last `longest` [s] at most; the skin's where half of its readings are there."""
        many = max(int(longest / self.record.step + _STRAY), 1)
        if many == 1:
            return self
        count = self.record.steps // many * many

        def parts(values: Floats) -> Floats:
            return values[:count].reshape(-1, many)

        finite = np.isfinite(parts(self.skin))
        enough = finite.sum(axis=1) >= 0.5 * many
        total = np.where(finite, parts(self.skin), 0.0).sum(axis=1)
        skin = np.where(enough, total / np.maximum(finite.sum(axis=1), 1), np.nan)
        middle = np.timedelta64(round(0.5e3 * (many - 1) * self.record.step), "ms")
        values = {name: parts(series).mean(axis=1) for name, series in self.record.values.items()}
        record = replace(self.record, start=self.record.start + middle, step=many * self.record.step, values=values)
        return replace(self, record=record, skin=skin)


def read_measured(file: str | os.PathLike[str]) -> MeasuredRecord:
    """Read a forcing CSV that has a column surface_temperature or lw_up too, in which cells may be empty.

    Parameters
    ----------
    file : path
        Otherwise as `read_record` takes it. Rows may be missing, up to three hours; the weather between is linear then.

    Raises
    ------
    InputError
        With file:line:column of what does not fit: both columns or neither, or times that are not at equal steps.
    """
    readings = record_readings(file, [*NEEDED_COLUMNS, "sw_down", tuple(SKIN_COLUMNS)])
    present = [name for name in SKIN_COLUMNS if name in readings.values]
    if len(present) > 1:
        raise InputError(
            f"found the columns {' and '.join(present)}; allowed: one of them; remove the other", file=file
        )
    changing = [name for name in (*WATER_COLUMNS, *SURFACE_COLUMNS) if name in readings.values]
    if changing:
        raise InputError(
            f"found the column {changing[0]}; allowed: weather over a surface that stays as it is, whose numbers a fit"
            " finds; remove the column, and the rainy days",
            file=file,
        )
    if present == ["lw_up"] and "lw_down" not in readings.values:
        raise InputError("found lw_up without lw_down, of which a surface reflects a part; add the column", file=file)
    _refuse_unequal(readings)
    record = forcing_of(readings)
    skin = np.full(record.steps, np.nan)
    skin[np.round((readings.time - readings.time[0]) / record.step).astype(int)] = readings.values[present[0]]
    return MeasuredRecord(record, skin, present == ["lw_up"], readings.file)


def _refuse_unequal(readings: Readings) -> None:
    """Raise InputError at the first reading that is not a whole number of steps after the one before."""
    step, _ = equal_steps(readings.time)
    later = np.diff(readings.time) / step
    wrong = (np.abs(later - np.round(later)) > _STRAY) | (np.round(later) < 1)
    if np.any(wrong):
        row = int(np.argmax(wrong))
        raise InputError(
            f"time: found a reading {later[row] * step:g} s after the one before; allowed: whole multiples of the"
            f" record's step of {step:g} s; bring the record to equal steps",
            file=readings.file,
            line=readings.lines[row + 1],
            column=1,
        )
