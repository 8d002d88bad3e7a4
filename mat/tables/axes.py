"""The axes of the tables: names, units, and rules of interpolation and of values outside."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis

RULES = LINEAR, PERIODIC, FOLDED, EXACT = "linear", "linear_periodic", "linear_folded", "exact"
CLOCK_UNIT = "h"  # unit of hours of the local clock, whatever midnight a file counts them from
POLICIES = ERROR, CLAMP = "error", "clamp"
DARK_BELOW = "dark_below"  # attribute of axes of source elevation


@dataclass(frozen=True)
class AxisRule:
    """How values between and outside the nodes of an axis are read.

    Attributes
    ----------
    nodes : (n,) ndarray
        Strictly ascending.
    interpolation : str
        ``linear`` (with a `period`: the nodes contain a part of it, and values come back after it); ``linear_periodic``
        (the axis closes after `period`); ``linear_folded`` (an angle and its mirror image are the same: the nodes span
        half the `period`); ``exact`` (codes).
    period : float
        0 where the axis does not repeat.
    out_of_range : str
        ``error`` or ``clamp``.
    dark_below : float
        Elevation of a source at and below which the air has no light of the source; NaN where the file does not state
        it.
    """

    name: str
    nodes: np.ndarray
    interpolation: str = LINEAR
    period: float = 0.0
    out_of_range: str = ERROR
    dark_below: float = np.nan

    @classmethod
    def of(cls, name: str, axis: Axis) -> AxisRule:
        """The rule that a file states for one of its axes.

        Raises
        ------
        InputError
            The nodes are not ascending numbers, or this reader does not support the rule.
        """
        attributes, nodes = axis.attributes, np.asarray(axis.values)
        rule = cls(
            name,
            nodes,
            str(attributes.get("interpolation", LINEAR)),
            _number(attributes.get("period", 0.0)),
            str(attributes.get("out_of_range", ERROR)),
            _number(attributes.get(DARK_BELOW, np.nan)),
        )
        numbers = nodes.ndim == 1 and nodes.size > 0 and nodes.dtype.kind in "iuf" and np.all(np.isfinite(nodes))
        if not numbers or np.any(np.diff(nodes) <= 0):
            raise InputError(f"the axis '{name}' is not a list of ascending numbers; build the file again")
        if rule.interpolation not in RULES or (
            rule.interpolation in (PERIODIC, FOLDED) and not 0 < rule.period < np.inf
        ):
            raise InputError(
                f"the axis '{name}' is read by '{rule.interpolation}' with period {rule.period:g}; supported: "
                f"{', '.join(RULES)}; upgrade skyshine, or build the file again"
            )
        if rule.out_of_range not in POLICIES:
            raise InputError(
                f"the axis '{name}' has out_of_range '{rule.out_of_range}'; allowed: {', '.join(POLICIES)}"
            )
        if DARK_BELOW in attributes and not -90 <= rule.dark_below <= 0:
            raise InputError(
                f"the axis '{name}' has {DARK_BELOW} {rule.dark_below:g}; allowed: -90 to 0; build it again"
            )
        return rule

    def locate(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Neighbouring nodes of `values`.

        Returns
        -------
        lower, upper : (...) int ndarray
        weight : (...) ndarray
            Of `upper`, 0 to 1.

        Raises
        ------
        InputError
            A value is not finite, lies outside the axis, or is not a node of an exact axis.
        """
        values = np.asarray(values)
        if self.interpolation == EXACT:
            return self._exact(values)
        values, nodes = values.astype(float), self.nodes
        lowest, highest = (values.min(), values.max()) if values.size else (nodes[0], nodes[0])
        if not (np.isfinite(lowest) and np.isfinite(highest)):
            raise InputError(f"{self.name}: found a value that is not finite; allowed: finite numbers")
        if self.interpolation == PERIODIC:
            nodes = np.append(nodes, nodes[0] + self.period)
            values = nodes[0] + np.mod(values - nodes[0], self.period)
        elif self.interpolation == FOLDED:
            values = np.abs(np.mod(values + self.period / 2, self.period) - self.period / 2)
            values = self._bounded(values, nodes, values.min(initial=nodes[0]), values.max(initial=nodes[0]))
        elif self.period > 0:
            original, values = values, values - self.period * np.floor((values - nodes[0]) / self.period)
            values = self._bounded(values, nodes, values.min(initial=nodes[0]), values.max(initial=nodes[0]), original)
        else:
            values = self._bounded(values, nodes, lowest, highest)
        if nodes.size == 1:
            lower = np.zeros(values.shape, int)
            return lower, lower, np.zeros(values.shape)
        # Searching the nodes between the ends keeps the lower node inside the axis without clipping.
        lower = np.searchsorted(nodes[1:-1], values, side="right")
        weight = (values - nodes.take(lower)) / np.diff(nodes).take(lower)
        upper = lower + 1
        return lower, upper % self.nodes.size if self.interpolation == PERIODIC else upper, weight

    def _bounded(
        self, values: np.ndarray, nodes: np.ndarray, lowest: float, highest: float, original: np.ndarray | None = None
    ) -> np.ndarray:
        if lowest >= nodes[0] and highest <= nodes[-1]:
            return values
        if self.out_of_range == ERROR:
            outside = np.ravel((values if original is None else original)[(values < nodes[0]) | (values > nodes[-1])])[
                0
            ]
            raise InputError(
                f"{self.name}: found {outside:g}; allowed: {nodes[0]:g} to {nodes[-1]:g}; stay inside, build "
                "the file with more nodes, or read the nearest one with table.clamped() or mat query --clamp"
            )
        return np.asarray(np.clip(values, nodes[0], nodes[-1]))

    def _exact(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if values.dtype.kind not in "iuf":
            raise InputError(f"{self.name}: found {np.ravel(values)[:1].tolist()}; allowed: numbers")
        position = np.clip(np.searchsorted(self.nodes, values), 0, self.nodes.size - 1)
        wrong = self.nodes[position] != values
        if np.any(wrong):
            unknown = np.ravel(np.asarray(values)[wrong])[0] if values.ndim else values
            allowed = ", ".join(f"{node:g}" for node in self.nodes[:64])
            raise InputError(f"{self.name}: found {unknown}; allowed: {allowed}; name one of them")
        return position, position, np.zeros(values.shape)


def _number(value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        return np.nan


def table_axis(
    values: npt.ArrayLike,
    units: str,
    long_name: str,
    *,
    interpolation: str = LINEAR,
    period: float = 0.0,
    standard_name: str | None = None,
) -> Axis:
    """An axis for a file, with the rule by which readers interpolate on it, and its name in the CF conventions."""
    attributes: dict[str, Any] = {"interpolation": interpolation, "out_of_range": ERROR}
    if period:
        attributes["period"] = period
    if standard_name is not None:
        attributes["standard_name"] = standard_name
    return Axis(values, units, long_name, attributes)
