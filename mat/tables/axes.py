"""The axes of the tables: names, units, and how a reader interpolates and leaves them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis

LINEAR, PERIODIC, FOLDED, EXACT = "linear", "linear_periodic", "linear_folded", "exact"


@dataclass(frozen=True)
class AxisRule:
    """How values between and outside the nodes of an axis are read.

    Attributes
    ----------
    name : str
    nodes : (n,) ndarray
        Strictly ascending.
    interpolation : str
        ``linear``; ``linear_periodic`` (the axis closes after `period`); ``linear_folded`` (an angle and its
        mirror image are the same: the nodes span half the `period`); ``exact`` (codes).
    period : float
        0 where the axis does not repeat.
    out_of_range : str
        ``error`` or ``clamp``.
    """

    name: str
    nodes: np.ndarray
    interpolation: str = LINEAR
    period: float = 0.0
    out_of_range: str = "error"

    @classmethod
    def of(cls, name: str, axis: Axis) -> AxisRule:
        """The rule that a file states for one of its axes."""
        read = axis.attributes
        return cls(
            name,
            np.asarray(axis.values),
            str(read.get("interpolation", LINEAR)),
            float(read.get("period", 0.0)),
            str(read.get("out_of_range", "error")),
        )

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
        if values.dtype.kind == "f" and not np.all(np.isfinite(values)):
            raise InputError(f"{self.name}: found a value that is not finite; allowed: finite numbers")
        if self.interpolation == EXACT:
            return self._exact(values)
        values, nodes = values.astype(float), self.nodes
        if self.interpolation == PERIODIC:
            nodes = np.append(nodes, nodes[0] + self.period)
            values = nodes[0] + np.mod(values - nodes[0], self.period)
        elif self.interpolation == FOLDED:
            values = np.abs(np.mod(values + self.period / 2, self.period) - self.period / 2)
        values = self._bounded(values, nodes)
        lower = np.clip(np.searchsorted(nodes, values, side="right") - 1, 0, max(nodes.size - 2, 0))
        upper = np.minimum(lower + 1, nodes.size - 1)
        span = np.where(upper > lower, nodes[upper] - nodes[lower], 1.0)
        weight = (values - nodes[lower]) / span
        return lower, upper % self.nodes.size, weight

    def _bounded(self, values: np.ndarray, nodes: np.ndarray) -> np.ndarray:
        outside = (values < nodes[0]) | (values > nodes[-1])
        if self.out_of_range == "error" and np.any(outside):
            found = np.ravel(values[outside])[0] if values.ndim else values
            raise InputError(
                f"{self.name}: found {found:g}; allowed: {nodes[0]:g} to {nodes[-1]:g}; stay inside, or ask for "
                "out_of_range='clamp'"
            )
        return np.clip(values, nodes[0], nodes[-1])

    def _exact(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        position = np.clip(np.searchsorted(self.nodes, values), 0, self.nodes.size - 1)
        wrong = self.nodes[position] != values
        if np.any(wrong):
            found = np.ravel(np.asarray(values)[wrong])[0] if values.ndim else values
            known = ", ".join(f"{node:g}" for node in self.nodes[:64])
            raise InputError(f"{self.name}: found {found}; allowed: {known}; name one of them")
        return position, position, np.zeros(values.shape)


def table_axis(values, units: str, long_name: str, *, interpolation: str = LINEAR, period: float = 0.0) -> Axis:
    """An axis for a file, with the rule by which readers interpolate on it."""
    attributes: dict = {"interpolation": interpolation, "out_of_range": "error"}
    if period:
        attributes["period"] = period
    return Axis(values, units, long_name, attributes)
