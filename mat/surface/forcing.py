"""Sun, sky and weather on the surfaces of a scene, at the solver's own times.

The caller gives the Sun's directions at `SUN_STEPS` times of the day. Irradiance on each plane is computed at all of
them and then averaged over the solver's steps, so that sunrise on a wall keeps its energy whatever the step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.balance import Forcing
from skyshine.mat.surface.site import Site
from skyshine.mat.surface.weather import Weather
from skyshine.schemas.errors import InputError

SOLAR_CONSTANT = 1361.1  # W m^-2, Gueymard (2018), Solar Energy 168, 2-9
_MOST_BY_ALTITUDE = 3.0  # times that measured light may be stronger on a mountain: the Sun rises earlier there
_LEAST_ELEVATION = 1.0  # degree: bounds the circumsolar part of the diffuse light at the horizon, as pvlib does


@dataclass(frozen=True, eq=False)
class Sky:
    """What the clear atmosphere sends down, by altitude and elevation of the Sun.

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
    emissivity : ndarray, shape (L,)
        Longwave irradiance over that of a black body at the temperature of the air there.
    ground_albedo : float
        Of the surroundings, for sunlight.
    """

    altitude: np.ndarray
    pressure: np.ndarray
    solar_elevation: np.ndarray
    direct: np.ndarray
    diffuse: np.ndarray
    emissivity: np.ndarray
    ground_albedo: float

    def at(self, name: str, altitude: np.ndarray) -> np.ndarray:
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
        values = np.asarray(getattr(self, name), float)
        place = np.clip(np.searchsorted(self.altitude, altitude, side="right") - 1, 0, len(self.altitude) - 2)
        share = (altitude - self.altitude[place]) / np.diff(self.altitude)[place]
        share = share.reshape(-1, *[1] * (values.ndim - 1))
        return values[place] * (1 - share) + values[place + 1] * share

    def pressure_at(self, altitude: np.ndarray) -> np.ndarray:
        """Pressure [Pa] at any altitudes [m]: its logarithm is linear between the levels and beyond them."""
        step = np.clip(np.searchsorted(self.altitude, altitude) - 1, 0, len(self.altitude) - 2)
        logarithm = np.log(self.pressure)
        slope = np.diff(logarithm) / np.diff(self.altitude)
        return np.exp(logarithm[step] + slope[step] * (altitude - self.altitude[step]))

    def irradiance(self, site: Site, cloud_fraction, altitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Direct normal and diffuse horizontal irradiance [W m^-2] under cloud, each (altitudes, SUN_STEPS).

        Notes
        -----
        Monotone cubic between the elevations; no overshoot at sunrise.

        References
        ----------
        Cloud: global irradiance times 1 - 0.75 n^3.4 (Kasten and Czeplak 1980, Solar Energy 24, 177-189); the direct
        part is what the gaps of the cloud let through.
        """
        from scipy.interpolate import PchipInterpolator

        low, high = self.solar_elevation[[0, -1]]
        elevation = np.clip(site.solar_elevation, low, high)
        direct, diffuse = (
            PchipInterpolator(self.solar_elevation, self.at(name, altitude), axis=1)(elevation)
            for name in ("direct", "diffuse")
        )
        sine = np.maximum(np.sin(np.radians(site.solar_elevation)), 0.0)
        total = (direct * sine + diffuse) * (1 - 0.75 * cloud_fraction**3.4)
        direct = direct * (1 - cloud_fraction)
        return direct, np.maximum(total - direct * sine, 0.0)

    def longwave(self, air_temperature: np.ndarray, cloud_fraction, altitude: np.ndarray) -> np.ndarray:
        """Longwave irradiance of the whole sky on a level surface [W m^-2], (altitudes, SUN_STEPS).

        The emissivity of the clear sky meets the air temperature (altitudes, SUN_STEPS) [K] of the time.

        References
        ----------
        Cloud: emissivity (1 - 0.84 n) e + 0.84 n, Unsworth and Monteith (1975), Q. J. R. Meteorol. Soc. 101, 13-24.
        """
        emissivity = self.at("emissivity", altitude)[:, None]
        emissivity = (1 - 0.84 * cloud_fraction) * emissivity + 0.84 * cloud_fraction
        return emissivity * Stefan_Boltzmann * air_temperature**4


def plane_irradiance(
    slope, azimuth, solar_elevation, solar_azimuth, direct, diffuse, ground_albedo, extraterrestrial
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Direct, diffuse and ground-reflected irradiance on planes [W m^-2]; arguments broadcast against each other.

    Parameters
    ----------
    slope, azimuth : array_like
        Of the plane [degree]: 0 faces up, 180 down; azimuth it faces, from north eastward.
    solar_elevation, solar_azimuth : array_like
        [degree]
    direct, diffuse : array_like
        Direct normal and diffuse horizontal irradiance [W m^-2].
    ground_albedo : float
    extraterrestrial : float
        Normal irradiance above the atmosphere [W m^-2].

    References
    ----------
    Diffuse: Hay and Davies (1980), circumsolar part after the direct beam and an isotropic rest, as in pvlib. Ground:
    isotropic, Liu and Jordan (1963), Solar Energy 7, 53-74.
    """
    import pvlib

    zenith = 90.0 - np.asarray(solar_elevation)
    cosine = np.maximum(pvlib.irradiance.aoi_projection(slope, azimuth, zenith, solar_azimuth), 0.0)
    sine = np.maximum(np.sin(np.radians(solar_elevation)), 0.0)
    on_plane = pvlib.irradiance.haydavies(
        slope,
        azimuth,
        diffuse,
        direct,
        extraterrestrial,
        projection_ratio=cosine / np.maximum(sine, np.sin(np.radians(_LEAST_ELEVATION))),
    )
    level = direct * sine + diffuse
    reflected = pvlib.irradiance.get_ground_diffuse(slope, level, albedo=ground_albedo)
    return direct * cosine, on_plane, reflected


def step_means(values: np.ndarray, steps: int) -> np.ndarray:
    """Means (..., steps) of periodic samples (..., n), or of one constant (..., 1), over the steps centred on each
    solver time: trapezium rule.

    Raises
    ------
    InputError
        The number of samples is not a multiple of the number of steps.
    """
    samples = values.shape[-1]
    if samples == 1:
        return values
    if samples % steps:
        raise InputError(f"found {steps} solver steps; allowed: divisors of {samples}")
    ratio = samples // steps
    if ratio == 1:
        return values
    weights = np.zeros(samples)
    offsets = np.arange(-(ratio // 2), ratio // 2 + 1)
    ends = 0.5 if ratio % 2 == 0 else 1.0
    weights[offsets % samples] = np.where(np.abs(offsets) == ratio // 2, ends, 1.0) / ratio
    kernel = _circulant_rows(tuple(weights), ratio)
    return values @ kernel


@lru_cache(maxsize=8)
def _circulant_rows(weights: tuple, ratio: int) -> np.ndarray:
    """(samples, steps) matrix that applies a symmetric periodic kernel and keeps every `ratio`-th result."""
    samples = len(weights)
    rows, columns = np.arange(samples)[:, None], np.arange(0, samples, ratio)[None, :]
    return np.asarray(weights)[(rows - columns) % samples]


@dataclass(frozen=True, eq=False)
class Scene:
    """Planes under a sky: gives their `Forcing` at any number of steps.

    Attributes
    ----------
    site : Site
    weather : Weather
    sky : Sky
    altitude : ndarray, shape (A,)
        Of the surfaces [m].
    slope, azimuth : ndarray, shape (P,)
        Of the planes [degree].

    Notes
    -----
    Columns are altitudes x planes, planes fastest. A plane sees the sky by
    (1 + cos slope) / 2 and otherwise level ground, which radiates as a black body at air temperature, the usual
    assumption where the surroundings are not modelled (EnergyPlus Engineering Reference, exterior longwave radiation).
    """

    site: Site
    weather: Weather
    sky: Sky
    altitude: np.ndarray
    slope: np.ndarray
    azimuth: np.ndarray

    @cached_property
    def _air(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Air temperature, vapour pressure and pressure, each (A, SUN_STEPS), pressure (A, 1) where it does not
        change.
        """
        altitude = np.asarray(self.altitude, float)
        return self.weather.at(altitude, self.sky.pressure_at(np.append(altitude, self.weather.altitude)))

    @cached_property
    def _shortwave(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Direct, diffuse and reflected on the planes, each (A, P, SUN_STEPS)."""
        direct, diffuse = self._sunlight()
        return plane_irradiance(
            np.asarray(self.slope, float)[None, :, None],
            np.asarray(self.azimuth, float)[None, :, None],
            self.site.solar_elevation[None, None, :],
            self.site.solar_azimuth[None, None, :],
            direct[:, None, :],
            diffuse[:, None, :],
            self.sky.ground_albedo,
            SOLAR_CONSTANT / self.site.sun_distance**2,
        )

    @cached_property
    def _longwave(self) -> np.ndarray:
        """Of the whole sky on a level surface, (A, SUN_STEPS)."""
        altitude, measured = np.asarray(self.altitude, float), self.weather.radiation
        if measured is None or measured.longwave is None:
            return self.sky.longwave(self._air[0], self.weather.cloud_fraction, altitude)
        clear = self.sky.longwave(self._air[0], 0.0, altitude)
        there = self.sky.longwave(self.weather.air_temperature[None], 0.0, self._measured_at)
        return measured.sky_longwave() * clear / there

    def _sunlight(self) -> tuple[np.ndarray, np.ndarray]:
        """Direct normal and diffuse horizontal irradiance, each (A, SUN_STEPS); measured light changes with altitude as
        the clear sky's.
        """
        altitude, measured = np.asarray(self.altitude, float), self.weather.radiation
        if measured is None:
            return self.sky.irradiance(self.site, self.weather.cloud_fraction, altitude)
        clear = self.sky.irradiance(self.site, 0.0, altitude)
        there = [part[0] for part in self.sky.irradiance(self.site, 0.0, self._measured_at)]
        found = []
        for light, here, own in zip(measured.sunlight(self.site, *there), clear, there, strict=True):
            ratio = np.divide(here, own, out=np.ones_like(here), where=own > 0)
            found.append(light * np.clip(ratio, 0.0, _MOST_BY_ALTITUDE))
        return found[0], found[1]

    @property
    def _measured_at(self) -> np.ndarray:
        """Altitude of the weather within the levels of the sky [m], (1,)."""
        return np.clip([self.weather.altitude], *self.sky.altitude[[0, -1]])

    def forcing(self, steps: int) -> Forcing:
        """Forcing of all columns, (A * P, steps)."""
        planes = len(self.slope)
        air, vapour, pressure, longwave = (
            np.repeat(step_means(field, steps), planes, axis=0) for field in (*self._air, self._longwave)
        )
        shortwave = (step_means(part, steps).reshape(-1, steps) for part in self._shortwave)
        cosine = np.tile(np.cos(np.radians(self.slope)), len(self.altitude))[:, None]
        view = 0.5 * (1 + cosine)
        return Forcing(
            *shortwave,
            longwave_sky=view * longwave,
            longwave_ground=(1 - view) * Stefan_Boltzmann * air**4,
            air_temperature=air,
            vapour_pressure=vapour,
            pressure=pressure,
            wind_speed=step_means(self.weather.wind_speed[None, :], steps),
            cos_slope=cosine,
        )
