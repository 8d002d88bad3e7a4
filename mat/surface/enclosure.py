"""Ground and walls around the surfaces of a scene: what they radiate and reflect, by the hour.

All surfaces of a place have one horizon, ground and walls too: a point in the middle of a street or at the edge
of a forest, not a model of its houses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.surface.altitudes import between_altitudes
from skyshine.mat.surface.horizon import ASPECTS, LEVEL, Horizon, ViewFactors
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Planes of the surfaces around: the ground, then walls that face each of the aspects [degree].
SLOPES = np.array([0.0, *[90.0] * ASPECTS.size])
AZIMUTHS = np.array([0.0, *ASPECTS])
LARGEST_WALL_ALBEDO = 0.99  # below 1, so that light between walls that hide the whole sky has an end


@dataclass(frozen=True, eq=False)
class Emitter:
    """Ground, or the walls of all aspects.

    Attributes
    ----------
    emissivity : float
        Emissivity for longwave, above 0 to 1; the rest is reflected evenly to all sides.
    albedo : float
        Albedo for sunlight, reflected evenly to all sides.
    temperature : (L, 1 or 8, SUN_STEPS) ndarray or None
        Temperature by altitude and aspect [K]; None: the air temperature.

    Raises
    ------
    InputError
        A value is outside its limits.
    """

    emissivity: float
    albedo: float
    temperature: Floats | None = None

    def __post_init__(self) -> None:
        if not 0 < self.emissivity <= 1:
            raise InputError(f"found emissivity {self.emissivity:g} of ground or walls; allowed: above 0, up to 1")
        if not 0 <= self.albedo <= 1:
            raise InputError(f"found albedo {self.albedo:g} of ground or walls; allowed: 0 to 1")


@dataclass(frozen=True, eq=False)
class Enclosure:
    """What surfaces see beside the sky.

    Attributes
    ----------
    horizon : Horizon
        Walls reach from the level up to it, and hide the direct light of the Sun behind them.
    sky_view : float
        Open share of the sky above the horizon, 0 to 1; walls hide the rest, but no direct light.
    altitude : (L,) ndarray
        Altitudes of the temperatures [m], increasing.
    ground_under : callable or None
        Temperature (L, 1, SUN_STEPS) [K] of the ground in the shade and beside the walls of `Surroundings`; None where
        it does not follow its heat balance.

    Raises
    ------
    InputError
        A value is outside its limits.
    """

    ground: Emitter
    walls: Emitter
    horizon: Horizon = LEVEL
    sky_view: float = 1.0
    altitude: Floats | tuple[float, ...] = (0.0,)
    ground_under: Callable[[Surroundings], Floats] | None = None

    def __post_init__(self) -> None:
        if not 0 <= self.sky_view <= 1:
            raise InputError(f"found sky_view {self.sky_view:g}; allowed: 0 (no sky) to 1 (the whole sky)")
        if self.walls.albedo > LARGEST_WALL_ALBEDO:
            raise InputError(f"found albedo {self.walls.albedo:g} of walls; allowed: 0 to {LARGEST_WALL_ALBEDO:g}")

    @property
    def open(self) -> bool:
        """Whether there are no walls."""
        return self.horizon.level and self.sky_view == 1

    def under(self, surroundings: Surroundings | None) -> Enclosure:
        """The same with ground that has the shade of the surfaces before which it lies."""
        if surroundings is None or self.ground_under is None:
            return self
        return replace(self, ground=replace(self.ground, temperature=self.ground_under(surroundings)))

    def views(self, slope: Floats, azimuth: Floats) -> ViewFactors:
        """View factors of planes (P,) [degree]."""
        return ViewFactors.of(self.horizon, self.sky_view, np.asarray(slope, float), np.asarray(azimuth, float))

    @cached_property
    def between(self) -> ViewFactors:
        """View factors of ground and walls themselves."""
        return self.views(SLOPES, AZIMUTHS)

    def light_of_sky(
        self, views: ViewFactors, slope: Floats, sun: SunPath, direct: Floats, diffuse: Floats, level: Floats
    ) -> tuple[Floats, Floats]:
        """Direct and diffuse irradiance of planes that is left of that without the enclosure [W m^-2].

        Parameters
        ----------
        views : ViewFactors
            View factors of the planes.
        slope : (P,) ndarray
            [degree]
        direct, diffuse : (A, P, SUN_STEPS) ndarray
            Light of Sun and sky without the enclosure [W m^-2].
        level : (A, SUN_STEPS) ndarray
            Diffuse irradiance of a level surface without that from around the Sun [W m^-2]. What a plane has above its
            view of such a sky comes from around the Sun, and ends with the direct light.
        """
        unobstructed = 0.5 * (1 + np.cos(np.radians(slope)))
        share = np.divide(views.sky, unobstructed, out=np.zeros_like(unobstructed), where=unobstructed > 0)[:, None]
        visible = ~self.horizon.hides(sun.solar_elevation, sun.solar_azimuth)
        even = np.minimum(diffuse, unobstructed[:, None] * level[:, None])
        return direct * visible, share * even + visible * (diffuse - even)

    def temperature(self, altitude: Floats, air: Floats) -> Floats:
        """Temperature of ground and walls.

        Parameters
        ----------
        altitude : (A,) ndarray
            [m]; beyond the altitudes of the enclosure, the nearest is taken.
        air : (A, SUN_STEPS) ndarray
            [K]

        Returns
        -------
        (A, 9, SUN_STEPS) ndarray
            [K], the ground first.
        """
        kelvin = np.empty((len(altitude), SLOPES.size, SUN_STEPS))
        for planes, emitter in ((slice(0, 1), self.ground), (slice(1, None), self.walls)):
            if emitter.temperature is None:
                kelvin[:, planes] = air[:, None]
            else:
                nodes = np.asarray(self.altitude, float)
                kelvin[:, planes] = between_altitudes(nodes, emitter.temperature, altitude)
        return kelvin

    def longwave(self, altitude: Floats, sky: Floats, air: Floats) -> Floats:
        """Longwave that ground and walls emit and reflect.

        Parameters
        ----------
        altitude : (A,) ndarray
            [m]
        sky : (A, SUN_STEPS) ndarray
            Irradiance of the whole sky on a level surface [W m^-2].
        air : (A, SUN_STEPS) ndarray
            [K]

        Returns
        -------
        (A, 9, SUN_STEPS) ndarray
            Per area of theirs [W m^-2].
        """
        emissivity = self._by_plane(self.ground.emissivity, self.walls.emissivity)
        emitted = emissivity[:, None] * STEFAN_BOLTZMANN * self.temperature(altitude, air) ** 4
        light = emitted + ((1 - emissivity) * self.between.sky)[:, None] * sky[:, None]
        return self._exchanged(1 - emissivity, light)

    def sunlight(self, received: Floats) -> Floats:
        """Sunlight that ground and walls reflect, once and again [W m^-2], (A, 9, SUN_STEPS).

        `received` (A, 9, SUN_STEPS) is the irradiance of each by Sun and sky [W m^-2].
        """
        albedo = self._by_plane(self.ground.albedo, self.walls.albedo)
        return self._exchanged(albedo, albedo[:, None] * received)

    def _by_plane(self, ground: float, walls: float) -> Floats:
        return np.array([ground, *[walls] * ASPECTS.size])

    def _exchanged(self, reflectance: Floats, leaving: Floats) -> Floats:
        """What leaves ground and walls (A, 9, N) once they have lit each other."""
        view_factors = np.column_stack([self.between.ground, self.between.walls])
        matrix = np.eye(SLOPES.size) - reflectance[:, None] * view_factors
        return np.asarray(np.linalg.solve(matrix, leaving))
