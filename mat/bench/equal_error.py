"""Seconds of a unit of work at an error that both a peer and this project reach."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.schemas.arrays import Floats
from skyshine.schemas.quantity import quantity


@dataclass(frozen=True)
class Measured:
    """Processor seconds and error of a setting."""

    name: str
    seconds: float
    error: float


def matched(ours: Sequence[Measured], theirs: Sequence[Measured]) -> tuple[float, Measured, Measured]:
    """The least error that some setting of both reaches, and the quickest setting of each that does.

    Examples
    --------
    >>> error, own, peer = matched([Measured("a", 1.0, 0.3), Measured("b", 2.0, 0.1)], [Measured("c", 9.0, 0.2)])
    >>> error, own.name, peer.name
    (0.2, 'b', 'c')
    """
    error = max(min(setting.error for setting in method) for method in (ours, theirs))
    quickest = [
        min((setting for setting in method if setting.error <= error), key=lambda setting: setting.seconds)
        for method in (ours, theirs)
    ]
    return error, quickest[0], quickest[1]


@dataclass(frozen=True)
class EqualError:
    """Seconds of a unit of work at an error that both reach.

    Attributes
    ----------
    work, peer : str
    error : float
        In `units`.
    units : str
    ours, theirs : float
        Processor seconds of a unit of work.
    note : str
        Settings that reach the error, and by what they are judged.
    """

    work: str
    peer: str
    error: float
    units: str
    ours: float
    theirs: float
    note: str

    @classmethod
    def of(
        cls, work: str, peer: str, units: str, ours: Sequence[Measured], theirs: Sequence[Measured], judged: str
    ) -> EqualError:
        """The comparison of settings, and by what they are judged."""
        error, setting, peer_setting = matched(ours, theirs)
        note = f"{setting.name} beside {peer_setting.name}; {judged}"
        return cls(work, peer, error, units, setting.seconds, peer_setting.seconds, note)

    @property
    def described(self) -> dict[str, Any]:
        """As plain values."""
        return {
            "work": self.work,
            "peer": self.peer,
            "error": quantity(self.error, self.units),
            "time_of_this_job": quantity(self.ours, "s"),
            "time": quantity(self.theirs, "s"),
            "note": self.note,
        }


def rms(error: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(error**2)))
