"""Which of the columns of air in a file is meant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError

FARTHEST_HOURS = 12.0  # from the time that is asked for to a sounding, and between two that are interpolated
_SHOWN = 6  # times that a message lists


@dataclass(frozen=True)
class Choice:
    """Place and time of a sounding.

    Attributes
    ----------
    place : (float, float) or None
        Latitude and longitude, degree.
    time : datetime or None
        UTC; None takes the only sounding of the file, or of `day`.
    day : (datetime, datetime) or None
        Begin and end of the day, UTC.
    interpolated : bool
        Interpolation between the columns of a grid, and between its times; with False the nearest is used.
    """

    place: tuple[float, float] | None = None
    time: datetime | None = None
    day: tuple[datetime, datetime] | None = None
    interpolated: bool = True


def index_of(times: Sequence[datetime | None], choice: Choice, file: Path) -> int:
    """Number of the sounding that is nearest in time, or the only one of the file or the day.

    Raises
    ------
    InputError
        There is none within `FARTHEST_HOURS`, or several without a time to choose by.
    """
    if choice.time is None:
        return _only(times, choice, file)
    distances = [(abs(hours(time, choice.time)), index) for index, time in enumerate(times) if time is not None]
    if not distances:
        raise InputError("does not say when it was measured; allowed: a sounding without a time; remove it", file=file)
    apart, index = min(distances)
    if apart > FARTHEST_HOURS:
        raise InputError(
            f"found no sounding within {FARTHEST_HOURS:g} h of {shown(choice.time)}; the nearest is of"
            f" {shown(times[index])}; take another time or file",
            file=file,
        )
    return index


def _only(times: Sequence[datetime | None], choice: Choice, file: Path) -> int:
    if len(times) == 1:
        return 0
    begin, end = choice.day or (None, None)
    today = [n for n, time in enumerate(times) if begin and end and time and begin <= time < end]
    if len(today) == 1:
        return today[0]
    listed = [shown(times[n]) for n in (today or range(len(times)))]
    more = f" and {len(listed) - _SHOWN} more" if len(listed) > _SHOWN else ""
    raise InputError(
        f"has {len(times)} soundings, {len(today)} of them on the state's day; allowed: one; name its time in the"
        f" job: sounding: {{file: NAME, time: 'hh:mm'}}, or a date of these: {', '.join(listed[:_SHOWN])}{more}",
        file=file,
    )


def hours(earlier: datetime, later: datetime) -> float:
    """From one time to another."""
    return float((later - earlier).total_seconds() / 3600)


def shown(time: datetime | None) -> str:
    """A time in a message."""
    return "an unknown time" if time is None else f"{time:%Y-%m-%d %H:%M} UTC"


def weights(nodes: np.ndarray, at: float, interpolated: bool) -> dict[int, float]:
    """Weights by number of the nodes on both sides of a value, or of the nearest; the end node beyond an end.

    Parameters
    ----------
    nodes : (n,) array
        Nodes in any order.
    """
    order = np.argsort(nodes)
    ascending = np.asarray(nodes, float)[order]
    above = int(np.searchsorted(ascending, at))
    if above in (0, ascending.size):
        return {int(order[min(above, ascending.size - 1)]): 1.0}
    low, high = ascending[above - 1], ascending[above]
    share = (at - low) / (high - low)
    if not interpolated:
        share = float(share > 0.5)
    pairs = {int(order[above - 1]): float(1 - share), int(order[above]): float(share)}
    return {node: weight for node, weight in pairs.items() if weight > 0}
