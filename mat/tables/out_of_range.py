"""Policy of a table for values outside the axes of its file: refuse or clamp."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

from skyshine.mat.tables.axes import CLAMP, AxisRule
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import Axis


@dataclass(frozen=True)
class OutOfRange:
    """Axes on which a value outside reads the nearest node; the others do what the file states, which is to refuse it.

    Attributes
    ----------
    everywhere : bool
        Whether all axes do.
    axes : frozenset of str
        Names of those that do.
    """

    everywhere: bool = False
    axes: frozenset[str] = frozenset()

    @classmethod
    def clamping(cls, names: Collection[str], axes: Collection[str]) -> OutOfRange:
        """The policy that clamps some of the known axes, or all where none is named.

        Raises
        ------
        InputError
            An axis that does not exist.
        """
        for name in names:
            if name not in axes:
                raise InputError(f"found the axis '{name}'; {nearest(name, sorted(axes))}")
        return cls(not names, frozenset(names))

    def rule(self, name: str, axis: Axis) -> AxisRule:
        """The rule of an axis of a file under this policy."""
        return self.applied(AxisRule.of(name, axis))

    def applied(self, rule: AxisRule, name: str | None = None) -> AxisRule:
        """A rule under this policy, which may know its axis by another name."""
        clamps = self.everywhere or (name or rule.name) in self.axes
        return replace(rule, out_of_range=CLAMP) if clamps else rule


AS_STATED = OutOfRange()
