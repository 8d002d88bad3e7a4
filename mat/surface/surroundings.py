"""Surroundings of a surface: the hours of its shade, the part of the sky that it sees, and the wall it faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

WALL_EMISSIVITY = 0.95  # wall emissivity of masonry, concrete and foliage in the thermal infrared
_COLDEST_WALL, _HOTTEST_WALL = 50.0, 2000.0  # K

Interval = tuple[float, float]  # first and last clock hour; over midnight where the first is later


@dataclass(frozen=True)
class Surroundings:
    """Shade and obstructions of a surface.

    Attributes
    ----------
    shade : tuple of (first, last)
        Clock hours, 0 to 24, between which no light comes from the direction of the Sun; over midnight where the first
        is later.
    sky_view : float
        Share of the sky above the surface that is open, 0 to 1; the rest is a wall. Ground that a tilted surface sees
        stays.
    facing : float or None
        Temperature of the wall [K]; None takes that of the air. The wall reflects no sunlight.
    facing_emissivity : float
        Emissivity of the wall, 0 to 1; it reflects longwave of sky and ground in equal parts, as an upright wall does.

    Raises
    ------
    InputError
        A value is outside its limits, or a wall is described where there is none.
    """

    shade: tuple[Interval, ...] = ()
    sky_view: float = 1.0
    facing: float | None = None
    facing_emissivity: float = WALL_EMISSIVITY

    def __post_init__(self) -> None:
        for start, stop in self.shade:
            if not (0 <= start < 24 and 0 <= stop <= 24) or start == stop:
                raise InputError(
                    f"found shade from {start:g} to {stop:g} h; allowed: two different clock hours of 0 to 24"
                )
        if not 0 <= self.sky_view <= 1:
            raise InputError(f"found sky_view {self.sky_view:g}; allowed: 0 (no sky) to 1 (the whole sky)")
        if not 0 <= self.facing_emissivity <= 1:
            raise InputError(f"found facing_emissivity {self.facing_emissivity:g}; allowed: 0 to 1")
        if self.facing is None:
            return
        if self.sky_view == 1:
            raise InputError("found facing with a sky_view of 1, which leaves no wall; give sky_view below 1")
        if not _COLDEST_WALL <= self.facing <= _HOTTEST_WALL:
            raise InputError(
                f"found facing {self.facing:g} K; allowed: {_COLDEST_WALL:g} to {_HOTTEST_WALL:g} K; give it in kelvin"
            )

    def shaded(self, hours: Floats, step: float) -> Floats:
        """Share of the time around each clock hour (n,) that is in the shade, each `step` [h] long: (n,)."""
        return shaded_share(self.shade, hours, step)

    def sunlight(self, direct: Floats, diffuse: Floats, even: Floats, shaded: Floats) -> tuple[Floats, Floats]:
        """Direct and diffuse irradiance that is left [W m^-2].

        Parameters
        ----------
        direct, diffuse : ndarray
            Irradiance on the unobstructed surface [W m^-2].
        even : ndarray
            Diffuse irradiance on it from the evenly bright part of the sky [W m^-2]. What is above that comes from
            around the Sun and ends with the direct light.
        shaded : (n,) ndarray
            Share of the time in the shade, over the last axis.
        """
        return sunlight_left(direct, diffuse, even, shaded, self.sky_view)

    def longwave(self, view: Floats | float, sky: Floats, air_temperature: Floats) -> tuple[Floats, Floats]:
        """Longwave irradiance of the open sky, and of ground and wall [W m^-2].

        Parameters
        ----------
        view : float or ndarray
            View factor of the whole sky, from the surface without obstructions, 0 to 1; the rest is ground at air
            temperature.
        sky : ndarray
            Irradiance of the whole sky on a level surface [W m^-2].
        air_temperature : ndarray
            [K]
        """
        air = STEFAN_BOLTZMANN * air_temperature**4
        return longwave_left(view, sky, air, self.wall_longwave(sky, air), self.sky_view)

    def wall_longwave(self, sky: Floats, air: Floats) -> Floats:
        """Longwave that the wall emits and reflects [W m^-2] under a sky, beside air of a black body's radiation
        [W m^-2].
        """
        return wall_longwave(sky, air, self.facing, self.facing_emissivity)


@dataclass(frozen=True, eq=False)
class Exposure:
    """Shade and obstructions of P surfaces at n steps of the day, each its own.

    Attributes
    ----------
    shaded : (P, n) ndarray
        Share of each step in which no light comes from the direction of the Sun; P or 1.
    sky_view : (P, 1) ndarray
        View of the sky, as in `Surroundings`; P or 1.
    facing : float, (P, n) ndarray or None
        Temperature of the walls, as in `Surroundings`, or of each surface at each step [K].
    facing_emissivity : float
        Emissivity of the walls, as in `Surroundings`.
    wall_light : float or (P, n) ndarray
        Sunlight that leaves the walls, per area of theirs [W m^-2].
    """

    shaded: Floats
    sky_view: Floats
    facing: float | Floats | None = None
    facing_emissivity: float = WALL_EMISSIVITY
    wall_light: float | Floats = 0.0

    @classmethod
    def of(cls, surroundings: Surroundings, hours: Floats, step: float) -> Exposure:
        """Of all surfaces in the same surroundings, around clock hours (n,), each `step` [h] long."""
        shaded = surroundings.shaded(hours, step)[None, :]
        view = np.array([[surroundings.sky_view]])
        return cls(shaded, view, surroundings.facing, surroundings.facing_emissivity)

    def sunlight(self, view: Floats, direct: Floats, diffuse: Floats, even: Floats) -> tuple[Floats, Floats]:
        """As `Surroundings.sunlight`, with the light of walls in the diffuse part; `view` is that of the whole sky."""
        beam, spread = sunlight_left(direct, diffuse, even, self.shaded, self.sky_view)
        return beam, spread + (1 - self.sky_view) * view * self.wall_light

    def longwave(self, view: Floats, sky: Floats, air_temperature: Floats) -> tuple[Floats, Floats]:
        """As `Surroundings.longwave`."""
        air = STEFAN_BOLTZMANN * air_temperature**4
        wall = wall_longwave(sky, air, self.facing, self.facing_emissivity)
        return longwave_left(view, sky, air, wall, self.sky_view)


def sunlight_left(
    direct: Floats, diffuse: Floats, even: Floats, shaded: Floats, sky_view: Floats | float
) -> tuple[Floats, Floats]:
    """Direct and diffuse irradiance under a shadow and beside a wall, as `Surroundings.sunlight` says."""
    sunlit = 1.0 - shaded
    spread = np.minimum(diffuse, even)
    return direct * sunlit, sky_view * spread + sunlit * (diffuse - spread)


def longwave_left(
    view: Floats | float, sky: Floats, air: Floats, wall: Floats, sky_view: Floats | float
) -> tuple[Floats, Floats]:
    """Longwave of the open sky, and of ground and wall, beside a wall, as `Surroundings.longwave` says.

    `air` and `wall` are what black bodies of their temperatures emit [W m^-2].
    """
    return sky_view * view * sky, (1 - view) * air + (1 - sky_view) * view * wall


def wall_longwave(sky: Floats, air: Floats, facing: float | Floats | None, emissivity: float) -> Floats:
    """Longwave of a wall of the temperature `facing` [K], or of the air's, as `Surroundings.wall_longwave` says."""
    emitted = air if facing is None else STEFAN_BOLTZMANN * facing**4
    wall: Floats = emissivity * emitted + (1 - emissivity) * 0.5 * (sky + air)
    return wall


def shaded_share(shade: Sequence[Interval], hours: Floats, step: float) -> Floats:
    """Share in the shade of the time around each clock hour.

    Parameters
    ----------
    shade : sequence of (first, last)
        Clock hours; over midnight where the first is later. Intervals may overlap.
    hours : (n,) ndarray
        [h]
    step : float
        Length of the time around each [h].
    """
    edges = np.asarray(hours, float)[:, None] + 0.5 * step * np.array([-1.0, 1.0])
    covered = np.diff(_shade_before(shade, edges), axis=1)[:, 0] / step
    # Differences of hours leave 1e-13 of the sunlight in full shade.
    share: Floats = np.clip(np.round(covered, 10), 0.0, 1.0)
    return share


def _shade_before(shade: Sequence[Interval], hours: Floats) -> Floats:
    """Hours of shade from midnight of day 0 to each time, which may lie on other days."""
    spans: list[list[float]] = []
    parts = [part for start, stop in shade for part in _within_day(start, stop)]
    for start, stop in sorted(parts):
        if spans and start <= spans[-1][1]:
            spans[-1][1] = max(spans[-1][1], stop)
        else:
            spans.append([start, stop])
    day, hour = np.divmod(hours, 24.0)
    total = np.zeros(np.shape(hours))
    for start, stop in spans:
        total += np.clip(hour, start, stop) - start + day * (stop - start)
    return total


def _within_day(start: float, stop: float) -> list[Interval]:
    return [(start, stop)] if start < stop else [(start, 24.0), (0.0, stop)]
