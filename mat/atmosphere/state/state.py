"""One atmospheric state: what is in the air at each level, from the ground to space.

Between levels pressure, number density and gases are exponential in altitude, temperature is linear. Above the highest
level (100 km) there is nothing: the air left there has a vertical optical depth below 1e-6 in every band.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.aerosol_column import Aerosol, aerosol_layers, default_visibility
from skyshine.mat.atmosphere.particles.aerosol_layer import AerosolLayer
from skyshine.mat.atmosphere.particles.angstrom import ParticleModel
from skyshine.mat.atmosphere.particles.cloud import CloudLayer, check_phase
from skyshine.mat.atmosphere.particles.rain import RainLayer
from skyshine.mat.atmosphere.particles.sea_spray import MARITIME, sea_spray
from skyshine.mat.atmosphere.state.gas_amounts import (
    DOBSON_UNIT,
    GasAmounts,
    columns_above,
    layer_columns,
    mean_exponential,
    scaled_gases,
)
from skyshine.mat.atmosphere.state.ground_air import GroundAir, with_ground_air
from skyshine.mat.atmosphere.state.ground_albedo import SpectralAlbedo
from skyshine.mat.atmosphere.state.humidity import WATER_MOLAR_MASS
from skyshine.mat.atmosphere.state.levels import exponential, level_altitudes, linear, with_particles
from skyshine.mat.atmosphere.state.profiles import Profile, load_profile
from skyshine.mat.atmosphere.state.sea_air import HEIGHTS, SeaAir, with_sea_air
from skyshine.mat.radiometry.constants import AVOGADRO, BOLTZMANN
from skyshine.mat.surface.convection import WIND_HEIGHT
from skyshine.mat.surface.sea_surface import SeaSurface
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

SURFACE_RANGE = (-500.0, 5900.0)  # m; below the Dead Sea, and below the 6 km where aerosol profiles meet the ground

# A profile that begins higher than this above the ground says nothing of the air there, m.
LARGEST_GAP = 500.0

_AS_IN_PROFILE, _RURAL = GasAmounts(), Aerosol()


@dataclass(frozen=True, eq=False)
class AerosolComponent:
    """One kind of particle in the air and how much of it there is.

    Attributes
    ----------
    extinction_550 : (N,) array
        Extinction at 0.55 um, m^-1, at the levels of the state.
    """

    model: ParticleModel
    extinction_550: Floats


MOST_AIRGLOW = 100.0  # times its mean, as bright as aurora


@dataclass(frozen=True, eq=False)
class AtmosphericState:
    """Air, gases and particles at N levels, and the ground below.

    Attributes
    ----------
    altitude : (N,) array
        Above sea level, m, increasing; the first is the ground, the last the top of the atmosphere.
    pressure, temperature : (N,) arrays
        Pa, K.
    mole_fraction : dict of (N,) arrays
    surface_temperature : float
        K, of the ground below the paths.
    surface_albedo : float or SpectralAlbedo
        0 to 1, of the ground below the paths.
    hydrometeors : tuple of AerosolComponent
        Cloud and rain.
    night_sky : float
        Airglow over its mean, with starlight; 0 for none of both.
    """

    name: str
    altitude: Floats
    pressure: Floats
    temperature: Floats
    mole_fraction: dict[str, Floats]
    aerosols: tuple[AerosolComponent, ...]
    surface_temperature: float
    surface_albedo: float | SpectralAlbedo
    hydrometeors: tuple[AerosolComponent, ...] = ()
    night_sky: float = 0.0

    def __post_init__(self) -> None:
        for label, values in (
            ("altitude", self.altitude),
            ("pressure", self.pressure),
            ("temperature", self.temperature),
        ):
            if values.shape != self.altitude.shape or not np.all(np.isfinite(values)):
                raise InputError(f"atmospheric state '{self.name}': {label} must be finite at every level")
        if self.altitude.size < 2 or np.any(np.diff(self.altitude) <= 0):
            raise InputError(
                f"atmospheric state '{self.name}': altitudes must increase, without repetition; sort the levels"
            )
        if np.any(self.pressure <= 0) or np.any(self.temperature <= 0):
            raise InputError(f"atmospheric state '{self.name}': pressure and temperature must be above 0")
        if not (isinstance(self.surface_albedo, SpectralAlbedo) or 0.0 <= self.surface_albedo <= 1.0):
            raise InputError(f"surface albedo {self.surface_albedo} is outside 0 to 1")
        if not 0.0 <= self.night_sky <= MOST_AIRGLOW:
            raise InputError(f"night sky {self.night_sky} is outside 0 to {MOST_AIRGLOW:g} times mean airglow")
        if not 100.0 <= self.surface_temperature <= 500.0:
            raise InputError(f"surface temperature {self.surface_temperature} K is outside 100 to 500 K")

    @classmethod
    def from_profile(
        cls,
        profile: str | Profile,
        *,
        surface_altitude: float = 0.0,
        ground_air: GroundAir | None = None,
        sea: SeaAir | None = None,
        gas_amounts: GasAmounts = _AS_IN_PROFILE,
        aerosol: Aerosol = _RURAL,
        aerosol_layers: Sequence[AerosolLayer] = (),
        clouds: Sequence[CloudLayer] = (),
        rain: RainLayer | None = None,
        surface_temperature: float | None = None,
        surface_albedo: float = 0.1,
    ) -> AtmosphericState:
        """The state of a profile over a ground.

        Parameters
        ----------
        profile : str or Profile
            A name of `profiles.PROFILES`, or a profile.
        surface_altitude : float
            Above sea level, m. The profile is cut there; below its lowest level it is continued.
        ground_air : GroundAir, optional
            Air near the ground from the weather, which replaces the profile's lowest part.
        sea : SeaAir, optional
            Sea below, by which the lowest air is a surface layer over water; with a maritime aerosol it has large drops
            of spray, and the ground below the paths has the sea's temperature unless another is given.
        gas_amounts : GasAmounts
            Amounts of gases; by default those of the profile.
        aerosol : Aerosol
            Aerosol; by default rural, of 23 km visibility.
        aerosol_layers : sequence of AerosolLayer
            Layers in addition to that aerosol; its optical depth and Angstrom exponent exclude them.
        surface_temperature : float, optional
            K; that of the lowest air by default.
        surface_albedo : float
            0 to 1.

        Raises
        ------
        InputError
            For anything outside its range.
        """
        profile = load_profile(profile) if isinstance(profile, str) else profile
        _check_surface_altitude(surface_altitude, profile)
        if ground_air is not None:
            profile = with_ground_air(profile, surface_altitude, ground_air)
        near_water: list[float] = []
        if sea is not None:
            profile, water = with_sea_air(profile, surface_altitude, sea)
            near_water = [*HEIGHTS]
            if surface_temperature is None:
                surface_temperature = sea.temperature
            if aerosol.model in MARITIME:
                aerosol_layers = [*aerosol_layers, _spray(profile, water)]
        hydrometeors: list[CloudLayer | RainLayer] = [*clouds, *([] if rain is None else [rain])]
        edges = [surface_altitude + height for layer in (*hydrometeors, *aerosol_layers) for height in layer.edges]
        edges += [surface_altitude + height for height in near_water]
        altitude = level_altitudes(surface_altitude, profile, edges)
        for layer in hydrometeors:
            altitude = with_particles(altitude, layer.extinction_550(altitude - surface_altitude))

        def at_levels(altitude: Floats) -> AtmosphericState:
            temperature = linear(altitude, profile.altitude, profile.temperature)
            pressure = np.exp(linear(altitude, profile.altitude, np.log(profile.pressure)))
            in_water_cloud = np.zeros(altitude.shape, dtype=bool)
            for cloud in clouds:
                heights = np.linspace(cloud.base, cloud.top, 20) + surface_altitude
                check_phase(cloud, np.interp(heights, altitude, temperature))
                if cloud.phase == "water":
                    in_water_cloud |= cloud.extinction_550(altitude - surface_altitude) > 0
            fractions = {gas: exponential(altitude, profile.altitude, x) for gas, x in profile.mole_fraction.items()}
            gases = scaled_gases(fractions, gas_amounts, altitude, pressure, temperature, in_water_cloud)
            vapour_pressure = gases["H2O"][0] * pressure[0]
            humidity = float(100 * vapour_pressure / saturation_pressure(temperature[0]))
            number_density = pressure / (BOLTZMANN * temperature)
            return cls(
                name=profile.name,
                altitude=altitude,
                pressure=pressure,
                temperature=temperature,
                mole_fraction=gases,
                aerosols=_aerosol_components(aerosol, altitude, number_density, profile.name, humidity)
                + _layer_components(aerosol_layers, altitude, number_density),
                surface_temperature=float(temperature[0] if surface_temperature is None else surface_temperature),
                surface_albedo=float(surface_albedo),
                hydrometeors=tuple(
                    AerosolComponent(layer.model, layer.extinction_550(altitude - surface_altitude))
                    for layer in hydrometeors
                ),
            )

        state = at_levels(altitude)
        extinction = sum((part.extinction_550 for part in state.aerosols), start=np.zeros(altitude.size))
        finer = with_particles(altitude, extinction)
        return state if finer.size == altitude.size else at_levels(finer)

    @property
    def particles(self) -> tuple[AerosolComponent, ...]:
        """All kinds of particle: aerosols and hydrometeors."""
        return self.aerosols + self.hydrometeors

    @property
    def surface_altitude(self) -> float:
        """m above sea level."""
        return float(self.altitude[0])

    def albedo_at(self, wavenumber: Floats) -> float | Floats:
        """Reflectance of the ground at wavenumbers (P,) [cm^-1]: one number, or (P,) where it depends on them."""
        albedo = self.surface_albedo
        return albedo.at(wavenumber) if isinstance(albedo, SpectralAlbedo) else albedo

    @property
    def mean_albedo(self) -> float:
        """Reflectance of the ground, mean over the band where it depends on wavelength."""
        albedo = self.surface_albedo
        return albedo.mean if isinstance(albedo, SpectralAlbedo) else albedo

    @cached_property
    def number_density(self) -> Floats:
        """Molecules of air, (N,) m^-3, by the ideal gas law."""
        density: Floats = self.pressure / (BOLTZMANN * self.temperature)
        return density

    @cached_property
    def relative_humidity(self) -> Floats:
        """Over liquid water, (N,) percent, at most 100: what particles grow with."""
        return np.minimum(
            100.0 * self.mole_fraction["H2O"] * self.pressure / saturation_pressure(self.temperature), 100.0
        )

    def temperature_at(self, altitude: npt.ArrayLike) -> Floats:
        """Air temperature [K] at altitudes [m], any shape."""
        temperature: Floats = np.interp(np.asarray(altitude, dtype=float), self.altitude, self.temperature)
        return temperature

    def pressure_at(self, altitude: npt.ArrayLike) -> Floats:
        """Air pressure [Pa] at altitudes [m], any shape."""
        pressure: Floats = np.exp(np.interp(np.asarray(altitude, dtype=float), self.altitude, np.log(self.pressure)))
        return pressure

    def mole_fraction_at(self, gas: str, altitude: npt.ArrayLike) -> Floats:
        """Mole fraction of a gas at altitudes [m], any shape."""
        return exponential(np.asarray(altitude, dtype=float), self.altitude, self.mole_fraction[gas])

    def precipitable_water(self, altitude: npt.ArrayLike) -> Floats:
        """Water vapour above altitudes [m], kg m^-2."""
        density = self.number_density * self.mole_fraction["H2O"]
        column: Floats = self._column(density, altitude) * WATER_MOLAR_MASS / AVOGADRO
        return column

    def ozone_column(self, altitude: npt.ArrayLike) -> Floats:
        """Ozone above altitudes [m], Dobson units."""
        column: Floats = self._column(self.number_density * self.mole_fraction["O3"], altitude) / DOBSON_UNIT
        return column

    def aerosol_optical_depth(self, wavelength_nm: float, altitude: npt.ArrayLike) -> Floats:
        """Vertical aerosol optical depth above altitudes [m] at one wavelength [nm]."""
        extinction = np.zeros(self.altitude.size)
        wavenumber = np.array([1e7 / wavelength_nm])
        for component in self.aerosols:
            relative = component.model.optics(wavenumber, self.relative_humidity).extinction[:, 0]
            extinction = extinction + component.extinction_550 * relative
        return columns_above(self.altitude, self.number_density, extinction / self.number_density, altitude)

    def _column(self, density: Floats, altitude: npt.ArrayLike) -> Floats:
        """Integral of a density [x m^-3], exponential between levels, from altitudes to the top: [x m^-2]."""
        layer = layer_columns(self.altitude, density)
        above = np.append(np.cumsum(layer[::-1])[::-1], 0.0)
        altitude = np.clip(altitude, self.altitude[0], self.altitude[-1])
        lower = np.clip(np.searchsorted(self.altitude, altitude, side="right") - 1, 0, self.altitude.size - 2)
        upper = self.altitude[lower + 1]
        at_altitude = exponential(altitude, self.altitude, density)
        column: Floats = above[lower + 1] + mean_exponential(at_altitude, density[lower + 1]) * (upper - altitude)
        return column


def _spray(profile: Profile, water: SeaSurface) -> AerosolLayer:
    """Large drops over a sea, for the humidity at 10 m of a profile that begins at the water."""
    altitude = profile.altitude[0] + WIND_HEIGHT
    temperature = float(linear(altitude, profile.altitude, profile.temperature))
    pressure = float(np.exp(linear(altitude, profile.altitude, np.log(profile.pressure))))
    fraction = float(exponential(altitude, profile.altitude, profile.mole_fraction["H2O"]))
    humidity = 100.0 * fraction * pressure / float(saturation_pressure(temperature))
    return sea_spray(water.wind_at(WIND_HEIGHT), water.friction_velocity, humidity)


def _check_surface_altitude(surface_altitude: float, profile: Profile) -> None:
    low, high = SURFACE_RANGE
    if not low <= surface_altitude <= high:
        raise InputError(f"surface altitude {surface_altitude:g} m is outside {low:g} to {high:g} m")
    if surface_altitude < profile.altitude[0] - LARGEST_GAP:
        raise InputError(
            f"surface altitude {surface_altitude:g} m lies more than {LARGEST_GAP:g} m below the lowest level of"
            f" '{profile.name}', {profile.altitude[0]:g} m; raise the ground, or begin the profile lower"
        )


def _aerosol_components(
    aerosol: Aerosol, altitude: Floats, number_density: Floats, profile_name: str, humidity: float
) -> tuple[AerosolComponent, ...]:
    """Those of an aerosol that are there at some level; its humidity [percent] is that at the ground."""
    season = aerosol.season
    if season is None:
        season = "fall_winter" if profile_name.endswith("winter") else "spring_summer"
    visibility_km = aerosol.visibility_km
    if visibility_km is None:
        visibility_km = default_visibility(aerosol.model, aerosol.wind_speed, humidity, aerosol.air_mass)
    layers = aerosol_layers(altitude, aerosol, visibility_km, season, float(altitude[0]))
    factor = 1.0
    if aerosol.optical_depth is not None and layers:
        total = sum(extinction for _, extinction in layers)
        factor = aerosol.optical_depth / float(
            columns_above(altitude, number_density, total / number_density, altitude[0])
        )
    return tuple(
        AerosolComponent(model, factor * extinction) for model, extinction in layers if factor * np.max(extinction) > 0
    )


def _layer_components(
    layers: Sequence[AerosolLayer], altitude: Floats, number_density: Floats
) -> tuple[AerosolComponent, ...]:
    components = []
    for layer in layers:
        extinction = layer.extinction_550(altitude - altitude[0])
        if layer.optical_depth is not None:
            column = columns_above(altitude, number_density, extinction / number_density, altitude[0])
            extinction = extinction * (layer.optical_depth / float(column))
        if np.max(extinction) > 0:
            components.append(AerosolComponent(layer.model, extinction))
    return tuple(components)
