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
_HORIZON = 0.0  # degree; the Sun counts as up above it
_BIRD_ELEVATION = 5.2  # degree: air mass 10
_LEAST_ELEVATION = 1.0  # degree: bounds the circumsolar part of the diffuse light at the horizon, as pvlib does


@dataclass(frozen=True, eq=False)
class Sky:
    """The atmosphere above the surfaces, by altitude.

    Attributes
    ----------
    altitude : ndarray, shape (L,)
        Increasing [m].
    pressure : ndarray, shape (L,)
        [Pa]
    precipitable_water : ndarray, shape (L,)
        Above the altitude [kg m^-2].
    aerosol_optical_depth_380, aerosol_optical_depth_500 : ndarray, shape (L,)
        Above the altitude, at 380 and 500 nm.
    ozone : float
        [Dobson units]
    ground_albedo : float
        Of the surroundings, for sunlight.
    """

    altitude: np.ndarray
    pressure: np.ndarray
    precipitable_water: np.ndarray
    aerosol_optical_depth_380: np.ndarray
    aerosol_optical_depth_500: np.ndarray
    ozone: float
    ground_albedo: float

    def at(self, name: str, altitude: np.ndarray) -> np.ndarray:
        """A quantity at altitudes [m], linear between the levels.

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
        return np.interp(altitude, self.altitude, np.asarray(getattr(self, name), float))

    def pressure_at(self, altitude: np.ndarray) -> np.ndarray:
        """Pressure [Pa] at any altitudes [m]: its logarithm is linear between the levels and beyond them."""
        step = np.clip(np.searchsorted(self.altitude, altitude) - 1, 0, len(self.altitude) - 2)
        logarithm = np.log(self.pressure)
        slope = np.diff(logarithm) / np.diff(self.altitude)
        return np.exp(logarithm[step] + slope[step] * (altitude - self.altitude[step]))


def sky_irradiance(site: Site, sky: Sky, cloud_fraction: np.ndarray, altitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Direct normal and diffuse horizontal irradiance [W m^-2] with the sky's cloud, each (altitudes, SUN_STEPS).

    Notes
    -----
    Bird's Rayleigh transmittance rises again and passes 1 at large air masses, so that his formulae are used to air
    mass 10 (elevation 5.2 degrees). Beyond, the direct beam follows Beer's law with the mean optical depth per air mass
    reached there, and diffuse irradiance goes with the sine of the elevation. Refraction is neglected.

    References
    ----------
    Clear sky: Bird and Hulstrom (1981), SERI/TR-642-761, as in pvlib; air mass: Kasten and Young (1989), Appl. Opt. 28,
    4735-4738. Cloud: global irradiance times 1 - 0.75 n^3.4 (Kasten and Czeplak 1980, Solar Energy 24, 177-189); the
    direct part is what the gaps of the cloud let through.
    """
    import pvlib

    elevation = np.asarray(site.solar_elevation, float)[None, :]
    up = elevation > _HORIZON
    zenith = 90.0 - np.where(up, elevation, 30.0)
    high = np.minimum(zenith, 90.0 - _BIRD_ELEVATION)
    airmass = pvlib.atmosphere.get_relative_airmass(zenith, model="kastenyoung1989")
    airmass_high = pvlib.atmosphere.get_relative_airmass(high, model="kastenyoung1989")
    normal = SOLAR_CONSTANT / site.sun_distance**2
    aerosol = [sky.at(f"aerosol_optical_depth_{nm}", altitude)[:, None] for nm in (380, 500)]
    bird = pvlib.clearsky.bird(
        high,
        airmass_high,
        *aerosol,
        sky.at("precipitable_water", altitude)[:, None] / 10.0,  # kg m^-2 to cm
        ozone=sky.ozone / 1000.0,  # Dobson units to cm
        pressure=sky.pressure_at(altitude)[:, None],
        dni_extra=normal,
        albedo=sky.ground_albedo,
    )
    sine = np.where(up, np.cos(np.radians(zenith)), 0.0)
    direct = np.where(up, normal * (bird["dni"] / normal) ** (airmass / airmass_high), 0.0)
    diffuse = bird["dhi"] * sine / np.cos(np.radians(high))
    total = (direct * sine + diffuse) * (1 - 0.75 * cloud_fraction**3.4)
    direct = direct * (1 - cloud_fraction)
    return direct, np.maximum(total - direct * sine, 0.0)


def sky_longwave(temperature, precipitable_water, cloud_fraction) -> np.ndarray:
    """Longwave irradiance of the sky on a level surface [W m^-2].

    Parameters
    ----------
    temperature : array_like
        Of the air near the ground [K].
    precipitable_water : array_like
        [kg m^-2]
    cloud_fraction : float

    References
    ----------
    Clear sky: Prata (1996), Q. J. R. Meteorol. Soc. 122, 1127-1151. Cloud: emissivity (1 - 0.84 n) e + 0.84 n,
    Unsworth and Monteith (1975), Q. J. R. Meteorol. Soc. 101, 13-24.
    """
    centimetres = np.asarray(precipitable_water) / 10.0
    emissivity = 1 - (1 + centimetres) * np.exp(-np.sqrt(1.2 + 3.0 * centimetres))
    emissivity = (1 - 0.84 * cloud_fraction) * emissivity + 0.84 * cloud_fraction
    return emissivity * Stefan_Boltzmann * np.asarray(temperature) ** 4


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

    up = np.asarray(solar_elevation) > _HORIZON
    zenith = 90.0 - np.asarray(solar_elevation)
    cosine = np.maximum(pvlib.irradiance.aoi_projection(slope, azimuth, zenith, solar_azimuth), 0.0)
    sine = np.sin(np.radians(solar_elevation))
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
    return np.where(up, direct * cosine, 0.0), np.where(up, on_plane, 0.0), np.where(up, reflected, 0.0)


def step_means(values: np.ndarray, steps: int) -> np.ndarray:
    """Means (..., steps) of periodic samples (..., n) over the steps centred on each solver time: trapezium rule.

    Raises
    ------
    InputError
        The number of samples is not a multiple of the number of steps.
    """
    samples = values.shape[-1]
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
        """Air temperature, vapour pressure and pressure, each (A, SUN_STEPS)."""
        altitude = np.asarray(self.altitude, float)
        return self.weather.at(altitude, self.sky.pressure_at(np.append(altitude, self.weather.altitude)))

    @cached_property
    def _shortwave(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Direct, diffuse and reflected on the planes, each (A, P, SUN_STEPS)."""
        direct, diffuse = sky_irradiance(
            self.site, self.sky, self.weather.cloud_fraction, np.asarray(self.altitude, float)
        )
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
        water = self.sky.at("precipitable_water", np.asarray(self.altitude, float))[:, None]
        return sky_longwave(self._air[0], water, self.weather.cloud_fraction)

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
