"""One axis of an array, and the error of a scene or a file that does not fit."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .layouts import CODES, COUNTS, LAST_CODE, RULES

Floats = NDArray[np.float64]


class SceneError(Exception):
    """The scene or a file does not fit; the text says what is allowed."""


@dataclass(frozen=True)
class Axis:
    """One axis: its nodes and the rule by which a runtime reads between and outside them."""

    name: str
    nodes: Floats
    rule: str
    period: float
    clamps: bool
    dark_below: float  # of source elevations: no light of the source is left there; NaN where the file does not say

    def fault(self) -> str:
        """What in the rule or the nodes is not as the format has it; empty where nothing is."""
        rules, period = RULES.get(self.name, (("linear",), 0.0))
        first, last = self.nodes[0], self.nodes[-1]
        if self.rule not in rules:
            return f"interpolation '{self.rule:.40}'; allowed: {' or '.join(rules)}"
        if self.period != period:
            return f"period {self.period:g}; allowed: {period:g}"
        if self.name == "source_elevation" and not (math.isnan(self.dark_below) or -90 <= self.dark_below <= 0):
            return f"dark_below {self.dark_below:g}; allowed: -90 to 0"
        if not np.all(np.isfinite(self.nodes)) or np.any(np.diff(self.nodes) <= 0):
            return "nodes that are not ascending numbers"
        if (self.rule == "linear_folded" and (first < 0 or last > period / 2)) or (
            period and (last > first + period or (self.rule == "linear_periodic" and last == first + period))
        ):
            return "nodes beyond its period"
        if self.name in CODES:
            known = self.nodes.size in COUNTS[self.name] and tuple(self.nodes) == CODES[self.name][: self.nodes.size]
            return "" if known else "codes that are not those of the format"
        if self.rule == "exact" and (first < 1 or last > LAST_CODE):
            return f"codes beyond 1 to {LAST_CODE}"
        return ""

    def locate(self, value: float) -> tuple[int, int, float]:
        """Index of the lower and the upper node, and the weight of the upper one."""
        if not math.isfinite(value):
            raise SceneError(f"{self.name}: found {value}; allowed: finite numbers")
        nodes, count = self.nodes, self.nodes.size
        if self.rule == "exact":
            at = np.flatnonzero(nodes == value)
            if at.size == 0:
                raise SceneError(f"{self.name}: found {value:g}; allowed: a code of the file")
            return int(at[0]), int(at[0]), 0.0
        if self.rule == "linear_periodic":
            nodes = np.append(nodes, nodes[0] + self.period)
            value = nodes[0] + (value - nodes[0]) % self.period
        elif self.rule == "linear" and self.period > 0:
            value -= self.period * math.floor((value - nodes[0]) / self.period)
        elif self.rule == "linear_folded":
            value = abs((value + self.period / 2) % self.period - self.period / 2)
        if not self.clamps and not nodes[0] <= value <= nodes[-1]:
            raise SceneError(f"{self.name}: found {value:g}; allowed: {nodes[0]:g} to {nodes[-1]:g}")
        value = min(max(value, nodes[0]), nodes[-1])
        lower = min(max(int(np.searchsorted(nodes, value, side="right")) - 1, 0), max(nodes.size - 2, 0))
        upper = min(lower + 1, nodes.size - 1)
        weight = float((value - nodes[lower]) / (nodes[upper] - nodes[lower])) if upper > lower else 0.0
        return lower, upper % count, weight
