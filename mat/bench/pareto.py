"""Pareto front: settings that no other setting beats in both error and time."""

from __future__ import annotations

from collections.abc import Sequence


def unbeaten(points: Sequence[tuple[float, float]]) -> list[bool]:
    """Whether each point (seconds, error) is on the Pareto front; of equal points both are."""
    return [not any(_beats(rival, point) for rival in points) for point in points]


def _beats(rival: tuple[float, float], point: tuple[float, float]) -> bool:
    return rival[0] <= point[0] and rival[1] <= point[1] and rival != point
