"""Temperatures between the solver's times.

Linear reading between 96 times of a day errs by more than the solver. Akima's cubic takes each slope from its
neighbours alone, so that a sunrise or a shadow, which bends the curve at one time, does not ring through the day.
"""

from __future__ import annotations

import numpy as np

from skyshine.schemas.arrays import Floats, Reals


def at_hours_of_day(values: Reals, hours: Floats) -> Reals:
    """Periodic values of a day at any of its hours.

    Parameters
    ----------
    values : (columns, N) ndarray
        Values at k / N of the day.
    hours : (T,) ndarray
        Clock hours [h].

    Returns
    -------
    (columns, T) ndarray
        Those of the times that the values have are the values themselves.

    References
    ----------
    Akima (1970), A new method of interpolation and smooth curve fitting based on local procedures, J. ACM 17, 589-602.

    Examples
    --------
    >>> at_hours_of_day(np.array([[1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0, 1.0]]), np.array([0.0, 4.5, 13.5])).round(3)
    array([[1. , 2.5, 4. ]])
    """
    steps = values.shape[1]
    position = (hours % 24.0) * (steps / 24.0)
    before = np.floor(position).astype(int)
    share = (position - before).astype(values.dtype)
    before %= steps
    if not np.any(share):
        return values[:, before]
    rise = np.roll(values, -1, axis=1)
    rise -= values
    slope = _slopes(rise)
    after = (before + 1) % steps
    slope_before, slope_after, difference = slope[:, before], slope[:, after], rise[:, before]
    read: Reals = values[:, before]
    # Hermite's cubic in Horner's form, from the rise over the cell and the slopes at its ends.
    read += share * (
        slope_before
        + share
        * ((3 * difference - 2 * slope_before - slope_after) + share * (slope_before + slope_after - 2 * difference))
    )
    return read


def in_steps(values: Reals, steps: int) -> Floats:
    """Periodic values (columns, N) of a day in a number of steps, as `at_hours_of_day`."""
    hours: Floats = np.arange(float(steps)) * (24.0 / steps)
    return at_hours_of_day(values, hours).astype(np.float64)


def _slopes(rise: Reals) -> Reals:
    """Akima's slopes (columns, N) per step at the times, of the rise that follows each."""
    previous = np.roll(rise, 1, axis=1)
    bend = np.abs(rise - previous)  # at each time
    following, preceding = np.roll(bend, -1, axis=1), np.roll(bend, 1, axis=1)
    total = following + preceding
    following *= previous
    preceding *= rise
    following += preceding
    straight = total == 0
    np.divide(following, total, out=following, where=~straight)
    return np.where(straight, 0.5 * (previous + rise), following) if np.any(straight) else following
