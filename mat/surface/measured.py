"""Measured sunlight and sky longwave in place of those of a state's clear sky."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.surface.sun_path import SOLAR_CONSTANT, SUN_STEPS, SunPath, sun_hours
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

# A reading is shared among the times of its interval as the clear sky's light is, unless it is more than this many
# times the clear one's mean: at sunrise, where a little light has no shape worth following.
_LARGEST_CLEAR_RATIO = 10.0
_NIGHT = -1.0  # degree: elevation of the Sun's centre below which an interval counts as night
_DAY = 100  # day of a year: any
_STRAY = 20.0  # W m^-2 that instruments may show then


@dataclass(frozen=True, eq=False)
class MeasuredRadiation:
    """Means over the intervals that end at given hours of a day that repeats, at the altitude of the weather.

    Attributes
    ----------
    hours : (n,) ndarray
        Local clock, ascending; each interval begins where the one before ends.
    direct, diffuse : (n,) ndarray
        Direct normal and diffuse horizontal irradiance [W m^-2].
    longwave : (n,) ndarray or None
        Longwave irradiance of the sky on a level surface [W m^-2]; None: that of the state.
    """

    hours: Floats
    direct: Floats
    diffuse: Floats
    longwave: Floats | None = None

    @classmethod
    def of_total(cls, hours: Floats, total: Floats, sun: SunPath, longwave: Floats | None = None) -> MeasuredRadiation:
        """Direct and diffuse light from means of the total on level ground.

        Parameters
        ----------
        hours, total, longwave : (n,) ndarray
            Arrays as the attributes, `total` global horizontal irradiance [W m^-2].

        Notes
        -----
        The parts are those of the mean height of the Sun while it is up in an interval. The standard error of the
        diffuse share of an hour is about 0.1.

        References
        ----------
        Erbs, Klein and Duffie (1982), Solar Energy 28, 293-302, as in pvlib.
        """
        import pvlib

        # pvlib knows the light above the air by the day of the year, we by the Sun's distance: parts scale with it.
        scale = float(pvlib.irradiance.get_extra_radiation(_DAY)) * sun.sun_distance**2 / SOLAR_CONSTANT
        sine, direct, diffuse = np.sin(np.radians(sun.solar_elevation)), np.zeros(hours.size), total.astype(float)
        measured = cls(hours, direct, diffuse, longwave)
        interval = measured._intervals()
        for number in range(hours.size):
            inside = interval == number
            sines = sine[inside & (sine > 0)]
            if sines.size:
                share, zenith = sines.size / np.count_nonzero(inside), np.degrees(np.arccos(sines.mean()))
                parts = pvlib.irradiance.erbs(total[number] / share * scale, zenith, _DAY)
                direct[number], diffuse[number] = (share * parts[name] / scale for name in ("dni", "dhi"))
        return measured

    def refuse_light_at_night(self, sun: SunPath) -> None:
        """Raise InputError where light was measured in an interval in which the Sun is down."""
        up = sun.solar_elevation > _NIGHT
        interval = self._intervals()
        for name in ("direct", "diffuse"):
            means = getattr(self, name)
            for number in np.flatnonzero(means > _STRAY):
                if not np.any(up[interval == number]):
                    raise InputError(
                        f"found {means[number]:g} W m^-2 of {name} light in the time to {self.hours[number]:g} h, when"
                        " the Sun is down; check date, place and utc_offset_h against the file"
                    )

    def sunlight(self, sun: SunPath, direct: Floats, diffuse: Floats) -> tuple[Floats, Floats]:
        """Direct normal and diffuse horizontal irradiance at `sun_hours()`, with the measured mean of every interval.

        Parameters
        ----------
        direct, diffuse : (SUN_STEPS,) ndarray
            Irradiance of the clear sky at the altitude of the weather [W m^-2], by which light is distributed within an
            interval.

        Raises
        ------
        InputError
            Light was measured while the Sun is down.
        """
        self.refuse_light_at_night(sun)
        up = sun.solar_elevation > _NIGHT
        interval = self._intervals()
        sun_up = up.astype(float)
        return self._shared(self.direct, interval, direct * up, sun_up), self._shared(
            self.diffuse, interval, diffuse, sun_up
        )

    def sky_longwave(self) -> Floats | None:
        """Longwave at `sun_hours()` [W m^-2], (SUN_STEPS,), linear between the middles of intervals; None: unknown."""
        if self.longwave is None:
            return None
        before = np.append(self.hours[-1] - 24.0, self.hours[:-1])
        middles = 0.5 * (before + self.hours) % 24.0
        series: Floats = np.interp(sun_hours(), middles, self.longwave, period=24.0)
        return series

    def _intervals(self) -> Integers:
        """Number of the interval of each of `sun_hours()`; the time at which one ends is still in it."""
        intervals: Integers = np.searchsorted(self.hours, sun_hours(), side="left") % self.hours.size
        return intervals

    def _shared(self, means: Floats, interval: Integers, clear: Floats, sun_up: Floats) -> Floats:
        """Readings at `sun_hours()` with the shape of the clear sky's light, evenly while the Sun is up where that is
        too weak.
        """
        distributed = np.zeros(SUN_STEPS)
        for number in np.unique(interval):
            inside, mean = interval == number, means[number]
            shape = clear[inside] if mean <= _LARGEST_CLEAR_RATIO * clear[inside].mean() else sun_up[inside]
            if shape.any():
                distributed[inside] = mean * shape / shape.mean()
        return distributed
