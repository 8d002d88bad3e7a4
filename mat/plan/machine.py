"""How fast this machine is, for estimates of times that were measured on another one."""

from __future__ import annotations

import time
from functools import cache

import numpy as np

# s of a processor of the machine on which the constants of `plan.cost` were measured (2.5 GHz server, two cores).
_REFERENCE = 2.5e-3
_TRIALS = 6  # the fastest counts: others were interrupted


@cache
def machine_slowness() -> float:
    """Processor time of a build on this machine over that on the machine of the estimates, from 15 ms of the work that
    builds do: exponentials of long arrays, calls on short ones, Python.
    """
    return min(_trial() for _ in range(_TRIALS)) / _REFERENCE


def _trial() -> float:
    long, short = -np.linspace(0.01, 5.0, 16_000).reshape(16, 1000), np.arange(44.0)
    work = np.zeros_like(long)  # written once: a first use of memory takes as long as the exponentials
    begin = time.process_time()
    for _ in range(16):
        np.cumsum(np.exp(long, out=work), axis=0, out=work)
    for number in range(600):
        (short * 1.5 + number).sum()
    return time.process_time() - begin
