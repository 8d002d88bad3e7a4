"""Sun, sky and weather on the surfaces of a scene, at the solver's own times.

The caller gives the Sun's directions at `SUN_STEPS` times of the day. Irradiance on each plane is computed at all of
them and then averaged over the solver's steps, so that sunrise on a wall keeps its energy whatever the step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.surface.altitudes import between_altitudes
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.enclosure import AZIMUTHS, SLOPES, Emitter, Enclosure
from skyshine.mat.surface.horizon import ViewFactors
from skyshine.mat.surface.step_means import step_means
from skyshine.mat.surface.sun_path import SUN_STEPS, SunPath, sun_hours
from skyshine.mat.surface.surroundings import Surroundings
from skyshine.mat.surface.weather import NearSurfaceAir
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

_LARGEST_ALTITUDE_RATIO = 3.0  # times that measured light may be stronger on a mountain: the Sun rises earlier there
# degree: the light around a lower Sun comes from here, for the half of its surroundings below the horizon is dark; of
# 1 to 20 this and 15 are nearest to the radiative transfer (tests/mat/quantities/test_aureole.py).
LOWEST_AUREOLE = 10.0
_FAINTEST_LIGHT = 1e-30  # W m^-2: below, under clouds of optical depth 100 and more, cubic slopes leave the numbers


@dataclass(frozen=True, eq=False)
class Sky:
    """Irradiance from the clear atmosphere by altitude and elevation of the Sun.

    Attributes
    ----------
    altitude : ndarray, shape (L,)
        Increasing [m].
    pressure : ndarray, shape (L,)
        [Pa]
    solar_elevation : ndarray, shape (E,)
        Increasing, geometric [degree].
    direct, diffuse : ndarray, shape (L, E)
        Direct normal and diffuse horizontal irradiance [W m^-2] at the day's distance of the Sun.
    aureole : ndarray, shape (E,)
        Share of the diffuse irradiance that comes from around the Sun, at all altitudes.
    emissivity : ndarray, shape (L,)
        Longwave irradiance over that of a black body at the temperature of the air there.
    ground_albedo : float
        Albedo of the surroundings, for sunlight.
    enclosure : Enclosure or None
        Ground and walls around all surfaces; None: an open plain that is as warm as the air.
    """

    altitude: Floats
    pressure: Floats
    solar_elevation: Floats
    direct: Floats
    diffuse: Floats
    aureole: Floats
    emissivity: Floats
    ground_albedo: float
    enclosure: Enclosure | None = None

    def at(self, name: str, altitude: Floats) -> Floats:
        """A quantity at altitudes (A,) [m], linear between the levels: (A, ...).

        Raises
        ------
        InputError
            An altitude lies outside the levels.
        """
        low, high = self.altitude[0], self.altitude[-1]
        if np.min(altitude) < low or np.max(altitude) > high:
            raise InputError(
                f"found surface altitudes {np.min(altitude):g} to {np.max(altitude):g} m; "
                f"allowed: {low:g} to {high:g} m, the levels of the sky; change the altitude axis"
            )
        return between_altitudes(self.altitude, np.asarray(getattr(self, name), float), altitude)

    def pressure_at(self, altitude: Floats) -> Floats:
        """Pressure [Pa] at any altitudes [m]: its logarithm is linear between the levels and beyond them."""
        step = np.clip(np.searchsorted(self.altitude, altitude) - 1, 0, len(self.altitude) - 2)
        logarithm = np.log(self.pressure)
        slope = np.diff(logarithm) / np.diff(self.altitude)
        pressure: Floats = np.exp(logarithm[step] + slope[step] * (altitude - self.altitude[step]))
        return pressure

    def irradiance(self, sun: SunPath, cloud_fraction: Floats | float, altitude: Floats) -> tuple[Floats, Floats]:
        """Direct normal and diffuse horizontal irradiance under cloud.

        Parameters
        ----------
        cloud_fraction : float or (SUN_STEPS,) ndarray
            0 to 1.
        altitude : (A,) ndarray
            [m]

        Returns
        -------
        direct, diffuse : (A, SUN_STEPS) ndarray
            [W m^-2]

        Notes
        -----
        Monotone cubic between the elevations; no overshoot at sunrise.

        References
        ----------
        Cloud: global irradiance times 1 - 0.75 n^3.4 (Kasten and Czeplak 1980, Solar Energy 24, 177-189); direct light
        comes through the gaps of the cloud.
        """
        from scipy.interpolate import PchipInterpolator

        low, high = self.solar_elevation[[0, -1]]
        elevation = np.clip(sun.solar_elevation, low, high)
        direct, diffuse = (
            PchipInterpolator(self.solar_elevation, np.where(light < _FAINTEST_LIGHT, 0.0, light), axis=1)(elevation)
            for light in (self.at("direct", altitude), self.at("diffuse", altitude))
        )
        sine = np.maximum(np.sin(np.radians(sun.solar_elevation)), 0.0)
        total = (direct * sine + diffuse) * (1 - 0.75 * cloud_fraction**3.4)
        direct = direct * (1 - cloud_fraction)
        return direct, np.maximum(total - direct * sine, 0.0)

    def aureole_at(self, solar_elevation: Floats) -> Floats:
        """`aureole` under a clear sky at elevations of the Sun [degree]."""
        return np.interp(solar_elevation, self.solar_elevation, self.aureole)

    def longwave(self, air_temperature: Floats, cloud_fraction: Floats | float, altitude: Floats) -> Floats:
        """Longwave irradiance of the whole sky on a level surface.

        Parameters
        ----------
        air_temperature : (A, SUN_STEPS) ndarray
            Air temperature at the time [K]; the emissivity of the clear sky does not depend on it.
        cloud_fraction : float or (SUN_STEPS,) ndarray
            0 to 1.
        altitude : (A,) ndarray
            [m]

        Returns
        -------
        (A, SUN_STEPS) ndarray
            [W m^-2]

        References
        ----------
        Cloud: emissivity (1 - 0.84 n) e + 0.84 n, Unsworth and Monteith (1975), Q. J. R. Meteorol. Soc. 101, 13-24.
        """
        emissivity = self.at("emissivity", altitude)[:, None]
        emissivity = (1 - 0.84 * cloud_fraction) * emissivity + 0.84 * cloud_fraction
        return emissivity * STEFAN_BOLTZMANN * air_temperature**4


def plane_irradiance(
    slope: npt.ArrayLike,
    azimuth: npt.ArrayLike,
    solar_elevation: npt.ArrayLike,
    solar_azimuth: npt.ArrayLike,
    direct: Floats | float,
    diffuse: Floats | float,
    ground_albedo: float,
    aureole: npt.ArrayLike,
) -> tuple[Floats, Floats, Floats]:
    """Direct, diffuse and ground-reflected irradiance on planes; arguments broadcast against each other.

    Parameters
    ----------
    slope, azimuth : array_like
        Slope and azimuth of the plane [degree]: 0 faces up, 180 down; azimuth of its normal from north eastward.
    solar_elevation, solar_azimuth : array_like
        [degree]
    direct, diffuse : array_like
        Direct normal and diffuse horizontal irradiance [W m^-2].
    aureole : array_like
        Share of the diffuse irradiance that comes from around the Sun.

    Returns
    -------
    direct, diffuse, reflected : ndarray
        [W m^-2]

    References
    ----------
    Diffuse: a circumsolar and an even part, the form of Hay and Davies (1980), with a share from `Sky.aureole` in place
    of their direct light over that above the atmosphere.
    Ground: isotropic, Liu and Jordan (1963), Solar Energy 7, 53-74.
    """
    cosine = sun_cosine(slope, azimuth, solar_elevation, solar_azimuth)
    sine = np.maximum(np.sin(np.radians(solar_elevation)), 0.0)
    above = np.maximum(solar_elevation, LOWEST_AUREOLE)
    ratio = sun_cosine(slope, azimuth, above, solar_azimuth) / np.sin(np.radians(above))
    view = 0.5 * (1 + np.cos(np.radians(slope)))
    aureole = np.asarray(aureole, float)
    reflected = ground_albedo * (1 - view) * (direct * sine + diffuse)
    return direct * cosine, diffuse * (aureole * ratio + (1 - aureole) * view), reflected


def sun_cosine(
    slope: npt.ArrayLike, azimuth: npt.ArrayLike, solar_elevation: npt.ArrayLike, solar_azimuth: npt.ArrayLike
) -> Floats:
    """Cosine of the angle between the Sun and the normal of planes, 0 where it is behind; as `plane_irradiance`."""
    tilt, height = np.radians(slope), np.radians(solar_elevation)
    turn = np.radians(np.subtract(solar_azimuth, azimuth))
    cosine: Floats = np.cos(tilt) * np.sin(height) + np.sin(tilt) * np.cos(height) * np.cos(turn)
    return cosine.clip(0.0, 1.0)


def _carried(light: Floats, clear_at_station: Floats, clear: Floats) -> Floats:
    """Measured light (SUN_STEPS,) at the altitudes of clear light (A, SUN_STEPS), by the ratio of the clear sky's."""
    ratio = np.divide(clear, clear_at_station, out=np.ones_like(clear), where=clear_at_station > 0)
    carried: Floats = light * np.clip(ratio, 0.0, _LARGEST_ALTITUDE_RATIO)
    return carried


@dataclass(frozen=True, eq=False)
class Scene:
    """Planes under a sky, with their `Forcing` at any number of steps.

    Attributes
    ----------
    sun : SunPath
    weather : NearSurfaceAir
    sky : Sky
    altitude : ndarray, shape (A,)
        Altitudes of the surfaces [m].
    slope, azimuth : ndarray, shape (P,)
        Slope and azimuth of the planes [degree].
    surroundings : Surroundings or None
        Shade and obstructions of all planes.

    Notes
    -----
    Columns are altitudes x planes, planes fastest. Where the sky has no enclosure, a plane sees the sky by
    (1 + cos slope) / 2 and otherwise level ground, which radiates as a black body at air temperature, the usual
    assumption where the surroundings are not modelled (EnergyPlus Engineering Reference, exterior longwave radiation).
    Longwave and reflected sunlight of walls count as those of the ground.
    """

    sun: SunPath
    weather: NearSurfaceAir
    sky: Sky
    altitude: Floats
    slope: Floats
    azimuth: Floats
    surroundings: Surroundings | None = None

    @cached_property
    def _air(self) -> tuple[Floats, Floats, Floats]:
        """Air temperature, vapour pressure and pressure, each (A, SUN_STEPS), pressure (A, 1) where it does not
        change.
        """
        altitude = np.asarray(self.altitude, float)
        return self.weather.at(altitude, self.sky.pressure_at(np.append(altitude, self.weather.altitude)))

    @cached_property
    def _enclosure(self) -> Enclosure | None:
        """The enclosure of the sky; ground before tilted surfaces has their shade."""
        enclosure = self.sky.enclosure
        return enclosure.under(self.surroundings) if enclosure is not None and np.any(self.slope) else enclosure

    @cached_property
    def _views(self) -> ViewFactors | None:
        """View factors of the planes in the enclosure."""
        enclosure = self._enclosure
        return None if enclosure is None else enclosure.views(self.slope, self.azimuth)

    @cached_property
    def _shortwave(self) -> tuple[Floats, Floats, Floats]:
        """Direct, diffuse and reflected on the planes, each (A, P, SUN_STEPS)."""
        slope = np.asarray(self.slope, float)
        direct, diffuse, reflected = self._on_planes(slope, np.asarray(self.azimuth, float), self._views)
        view = 0.5 * (1 + np.cos(np.radians(self.slope)))
        if self._views is not None:
            view, reflected = self._views.sky, self._views.received(self._sunlight_around)
        if self.surroundings is None:
            return direct, diffuse, reflected
        even = view[None, :, None] * self._sunlight[1][:, None, :]
        even *= (1 - self._aureole)[:, None, :]
        shaded = self.surroundings.shaded(sun_hours(), 24.0 / SUN_STEPS)
        return *self.surroundings.sunlight(direct, diffuse, even, shaded), reflected

    def _on_planes(self, slope: Floats, azimuth: Floats, views: ViewFactors | None) -> tuple[Floats, Floats, Floats]:
        """Direct and diffuse on planes (P,), and reflected by ground on an open plain, each (A, P, SUN_STEPS)."""
        direct, diffuse = self._sunlight
        received = plane_irradiance(
            slope[None, :, None],
            azimuth[None, :, None],
            self.sun.solar_elevation[None, None, :],
            self.sun.solar_azimuth[None, None, :],
            direct[:, None, :],
            diffuse[:, None, :],
            self.sky.ground_albedo,
            self._aureole[:, None, :],
        )
        if views is None or self._enclosure is None:
            return received
        return *self._enclosure.light_of_sky(
            views, slope, self.sun, *received[:2], (1 - self._aureole) * diffuse
        ), received[2]

    @cached_property
    def _sun_cosine(self) -> Floats:
        """Cosine of the Sun's angle of incidence on the planes, (P, SUN_STEPS)."""
        slope, azimuth = (np.asarray(angles, float)[:, None] for angles in (self.slope, self.azimuth))
        return sun_cosine(slope, azimuth, self.sun.solar_elevation[None, :], self.sun.solar_azimuth[None, :])

    @property
    def _around(self) -> Enclosure:
        """The enclosure; on an open plain the ground alone."""
        plain = Emitter(1.0, self.sky.ground_albedo)
        return self._enclosure or Enclosure(plain, Emitter(1.0, 0.0))

    @cached_property
    def _sunlight_around(self) -> Floats:
        """Reflected by ground and walls, (A, 9, SUN_STEPS)."""
        direct, diffuse, _ = self._on_planes(SLOPES, AZIMUTHS, self._around.between)
        received = direct + diffuse
        if self.surroundings is not None and self._enclosure is not None:
            even = self._around.between.sky[0] * ((1 - self._aureole) * self._sunlight[1])
            shaded = self.surroundings.shaded(sun_hours(), 24.0 / SUN_STEPS)
            received[:, 0] = sum(self.surroundings.sunlight(direct[:, 0], diffuse[:, 0], even, shaded))
        return self._around.sunlight(received)

    @cached_property
    def _longwave_around(self) -> Floats:
        """Emitted and reflected by ground and walls, (A, 9, SUN_STEPS)."""
        return self._around.longwave(self.altitude, self._longwave, self._air[0])

    @cached_property
    def _longwave(self) -> Floats:
        """Longwave irradiance of the whole sky on a level surface, (A, SUN_STEPS)."""
        altitude, measured = np.asarray(self.altitude, float), self.weather.radiation
        series = None if measured is None else measured.sky_longwave()
        if series is None:
            return self.sky.longwave(self._air[0], self.weather.cloud_fraction, altitude)
        clear = self.sky.longwave(self._air[0], 0.0, altitude)
        clear_at_station = self.sky.longwave(self.weather.air_temperature[None], 0.0, self._station_altitude)
        return series * clear / clear_at_station

    @cached_property
    def _sunlight(self) -> tuple[Floats, Floats]:
        """Direct normal and diffuse horizontal irradiance, each (A, SUN_STEPS).

        Measured light changes with altitude as that of the clear sky.
        """
        altitude, measured = np.asarray(self.altitude, float), self.weather.radiation
        if measured is None:
            return self.sky.irradiance(self.sun, self.weather.cloud_fraction, altitude)
        clear = self.sky.irradiance(self.sun, 0.0, altitude)
        direct, diffuse = (part[0] for part in self.sky.irradiance(self.sun, 0.0, self._station_altitude))
        light = measured.sunlight(self.sun, direct, diffuse)
        return (
            _carried(light[0], direct, clear[0]),
            _carried(light[1], diffuse, clear[1]),
        )

    @cached_property
    def _aureole(self) -> Floats:
        """Share of the diffuse light that comes from around the Sun, (A, SUN_STEPS): that of the clear sky, in
        proportion to direct light, which comes through the same gaps of cloud.
        """
        clear = self.sky.irradiance(self.sun, 0.0, np.asarray(self.altitude, float))
        (direct, diffuse), share = self._sunlight, self.sky.aureole_at(self.sun.solar_elevation)
        clear_sky = diffuse * clear[0]
        return share * np.minimum(
            np.divide(direct * clear[1], clear_sky, out=np.zeros_like(clear_sky), where=clear_sky > 0), 1.0
        )

    @property
    def days(self) -> list[Callable[[int], Forcing]]:
        """`forcing` of the days of the weather, oldest first and this one last, each kept once computed.

        All have the sky of this day, its ground and walls among it.
        """
        scenes = [replace(self, sun=sun, weather=weather) for sun, weather in self.weather.before]
        return [lru_cache(maxsize=None)(scene.forcing) for scene in (*scenes, self)]

    @property
    def _station_altitude(self) -> Floats:
        """Altitude of the weather within the levels of the sky [m], (1,)."""
        return np.clip([self.weather.altitude], *self.sky.altitude[[0, -1]])

    def open_air(self, steps: int) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Direct normal and diffuse horizontal light, longwave of the whole sky [W m^-2], air temperature [K], and the
        share of diffuse light from around the Sun.

        Each (A, steps). Light of the Sun and from around it is that which the horizon leaves; other diffuse light and
        longwave are of the whole sky.
        """
        direct, diffuse = self._sunlight
        circumsolar = self._aureole * diffuse
        hidden = (1 - self._visible) * circumsolar
        fields = (direct * self._visible, diffuse - hidden, self._longwave, self._air[0], circumsolar - hidden)
        direct, diffuse, longwave, air, circumsolar = (step_means(field, steps) for field in fields)
        share = np.divide(circumsolar, diffuse, out=np.zeros_like(diffuse), where=diffuse > 0)
        return direct, diffuse, longwave, air, share

    @property
    def _visible(self) -> Floats:
        """1 where the Sun is not behind the horizon, (SUN_STEPS,)."""
        hidden = self._around.horizon.hides(self.sun.solar_elevation, self.sun.solar_azimuth)
        return np.where(hidden, 0.0, 1.0)

    def forcing(self, steps: int) -> Forcing:
        """The forcing of all columns, (A * P, steps)."""
        planes = len(self.slope)
        air, vapour, pressure, longwave = (
            np.repeat(step_means(field, steps), planes, axis=0) for field in (*self._air, self._longwave)
        )
        direct, diffuse, reflected = (step_means(part, steps).reshape(-1, steps) for part in self._shortwave)
        cosine = np.tile(np.cos(np.radians(self.slope)), len(self.altitude))[:, None]
        view = 0.5 * (1 + cosine)
        if self._views is None:
            ground = (1 - view) * STEFAN_BOLTZMANN * air**4
        else:
            view = np.tile(self._views.sky, len(self.altitude))[:, None]
            ground = step_means(self._views.received(self._longwave_around), steps).reshape(-1, steps)
        sine = np.maximum(np.sin(np.radians(self.sun.solar_elevation)), 0.0)
        light = self._sunlight[0] * self._visible * sine + self._sunlight[1]
        sky = view * longwave
        if self.surroundings is not None:
            surroundings = self.surroundings
            wall = surroundings.wall_longwave(longwave, STEFAN_BOLTZMANN * air**4)
            sky, ground = surroundings.sky_view * view * longwave, ground + (1 - surroundings.sky_view) * view * wall
        season = self.weather.ground_at(self.altitude)
        if season:
            season["ground_mean"] = np.repeat(season["ground_mean"], planes, axis=0)
        return Forcing(
            shortwave_direct=direct,
            shortwave_diffuse=diffuse,
            shortwave_reflected=reflected,
            longwave_sky=sky,
            longwave_ground=ground,
            air_temperature=air,
            vapour_pressure=vapour,
            pressure=pressure,
            wind_speed=step_means(self.weather.wind_speed[None, :], steps),
            cos_slope=cosine,
            wind_height=np.array([[self.weather.wind_height]]),
            air_height=np.array([[self.weather.air_height]]),
            open_light=np.repeat(step_means(light, steps), planes, axis=0),
            sun_cosine=np.tile(step_means(self._sun_cosine, steps), (len(self.altitude), 1)),
            **{
                name: step_means(series[None, :], steps)
                for name in ("rain", "soil_moisture", "snow_age")
                if (series := getattr(self.weather, name)) is not None
            },
            **season,
        )
