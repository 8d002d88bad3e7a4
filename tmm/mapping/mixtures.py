"""What the classes of a mapper are in a database: materials, mixtures of them, and mixtures by the posterior."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.database.levels import PERCENT, Level, pure_level, ranked
from skyshine.tmm.job.materials import parts_of

_UNIT = 1 << 20  # of a posterior, which is ranked and rounded as an integer


class ClassMixtures:
    """The materials of the classes of a mapper."""

    def __init__(self, names: tuple[str, ...], code_of: dict[str, int]) -> None:
        """`names` are those of the C classes, materials or mixtures; `code_of` has the codes of all materials."""
        self._codes = np.array(sorted(code_of.values()), np.uint16)
        # Weights of the K materials in the classes; the last row, which -1 means, is that of no material.
        weights = np.zeros((len(self._codes), len(names) + 1), np.int64)
        for number, name in enumerate(names):
            for material, weight in parts_of(name).items():
                weights[np.searchsorted(self._codes, code_of[material]), number] = weight
        self._table = ranked(self._codes, weights)
        self._shares = weights[:, :-1] / np.maximum(weights[:, :-1].sum(axis=0), 1)
        self._pure = bool((np.count_nonzero(weights, axis=0) <= 1).all())

    def of(self, number: npt.NDArray[Any]) -> Level:
        """The materials of classes by number (h, w), -1 for none."""
        if self._pure:
            return pure_level(self._table.code[number])
        return Level(self._table.code[number], self._table.mix_code[number], self._table.mix_weight[number])

    def likeliest(self, posterior: npt.NDArray[np.float32], number: npt.NDArray[Any]) -> Level:
        """Mixtures of the three likeliest materials, in whole percent.

        The posterior is taken as it is: on aerial sheets its shares were nearer to the truth than with the calibrated
        confidence for the class found (Brier's score .104 against .106).

        Parameters
        ----------
        posterior : (C, h, w) float32
            Of each class, not negative.
        number : (h, w) int
            The class found; -1 for none, which makes no mixture.
        """
        found = number >= 0
        total = posterior.sum(axis=0)
        counts = np.rint(posterior * (found * _UNIT / np.where(total > 0, total, 1))).astype(np.int64)
        # One more than its equals: rounding and the order of codes leave the class found the first.
        at = np.where(found, number, 0)[np.newaxis]
        np.put_along_axis(counts, at, np.take_along_axis(counts, at, 0) + found, 0)
        return ranked(self._codes, self._by_material(counts), PERCENT)

    def _by_material(self, counts: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
        """Counts (K, h, w) of the materials of counts (C, h, w) of classes."""
        if self._shares.shape[0] == self._shares.shape[1] and (self._shares == np.eye(len(self._shares))).all():
            return counts
        return np.rint(np.tensordot(self._shares, counts, 1)).astype(np.int64)
