"""What a file says of one column of air, in SI units, with the place of each value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Literal

import numpy as np

from skyshine.mat.atmosphere.state.gas_amounts import GasAmounts
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Order of rows: as an author sorted them; as a balloon measured them, up and down a little; in no order of their own.
Order = Literal["sorted", "flown", "any"]


@dataclass(frozen=True, eq=False)
class Readings:
    """Rows of a sounding before they are checked.

    Attributes
    ----------
    values : dict of str to (N,) array
        Values by quantity (`units.UNITS`) or gas; NaN where a row has none.
    time : datetime or None
        UTC; None where the file does not say.
    raw : dict of str to (N,) array
        Values in the units of the file, for messages.
    positions : dict of (row, quantity) to (line, column)
        Empty where the file has no lines.
    amounts : GasAmounts
        Amounts of gases that the file states beside its levels, which are scaled to them.
    notes : tuple of str
        What the file says that is not read, and what replaces what it lacks.
    """

    file: Path
    values: Mapping[str, Floats]
    order: Order
    time: datetime | None = None
    raw: Mapping[str, Floats] = field(default_factory=dict)
    positions: Mapping[tuple[int, str], tuple[int, int]] = field(default_factory=dict)
    amounts: GasAmounts = field(default_factory=GasAmounts)
    notes: tuple[str, ...] = ()

    def number(self, row: int, name: str) -> float:
        """A value as the file has it."""
        return float(self.raw.get(name, self.values[name])[row])

    def error(self, row: int, name: str, message: str) -> InputError:
        """An `InputError` at the place of a value."""
        position = self.positions.get((row, name))
        if position is None:
            return InputError(f"level {row + 1}: {message}", file=self.file)
        return InputError(message, file=self.file, line=position[0], column=position[1])

    @property
    def size(self) -> int:
        """Number of rows."""
        return int(np.size(next(iter(self.values.values()), np.empty(0))))
