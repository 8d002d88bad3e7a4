"""What the classes of a mapper are in a database: materials, mixtures of them, or `unknown`."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.database.levels import Level, pure_level, ranked
from skyshine.tmm.job.materials import UNKNOWN, parts_of


class ClassMixtures:
    """The materials of the classes of a mapper."""

    def __init__(self, names: tuple[str, ...], code_of: dict[str, int]) -> None:
        """`names` are the C classes: materials, mixtures or `unknown`; `code_of` has the codes of all materials."""
        self._codes = np.array(sorted(code_of.values()), np.uint16)
        # Weights of the K materials in the classes; the last row, which -1 means, is that of no material.
        weights = np.zeros((len(self._codes), len(names) + 1), np.int64)
        for number, name in enumerate(names):
            for material, weight in parts_of(name).items() if name != UNKNOWN else ():
                weights[np.searchsorted(self._codes, code_of[material]), number] = weight
        self._table = ranked(self._codes, weights)
        self._pure = bool((np.count_nonzero(weights, axis=0) <= 1).all())

    def of(self, number: npt.NDArray[Any]) -> Level:
        """The materials of classes by number (h, w), -1 for none."""
        if self._pure:
            return pure_level(self._table.code[number])
        return Level(self._table.code[number], self._table.mix_code[number], self._table.mix_weight[number])
