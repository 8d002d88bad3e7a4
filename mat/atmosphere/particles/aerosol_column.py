"""How much aerosol there is at each altitude, and of which models: LOWTRAN7's vertical profiles.

References
----------
Kneizys et al. 1988, AFGL-TR-88-0177 (SUBROUTINES AERPRF and EXABIN, BLOCK DATA PRFDTA).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles import tables
from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.angstrom import AngstromModel, ParticleModel
from skyshine.mat.atmosphere.particles.opac import TYPES, opac_extinction, opac_model
from skyshine.mat.atmosphere.particles.particles import SpectralModel
from skyshine.mat.atmosphere.particles.windblown import (
    DEFAULT_AIR_MASS,
    DEFAULT_WIND,
    HUMIDITY,
    desert_model,
    desert_with_amount,
    navy_maritime_model,
    navy_maritime_with_amount,
)
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError, nearest

# Models of the lowest 2 km, with the visibility [km] that LOWTRAN7 gives each (IHAZE); those of desert and Navy follow
# the wind, those of OPAC the humidity.
BOUNDARY_MODELS: dict[str, float | None] = {
    "rural": 23.0,
    "urban": 5.0,
    "maritime": 23.0,
    "navy_maritime": None,
    "tropospheric": 50.0,
    "desert": None,
    "fog_advection": 0.2,
    "fog_radiation": 0.5,
    **dict.fromkeys(TYPES),
}
WINDBLOWN = ("navy_maritime", "desert")
_FIXED_VISIBILITY = {name: visibility for name, visibility in BOUNDARY_MODELS.items() if visibility is not None}
# Loading (aerosol/stratosphere.csv) and particles of the stratosphere: LOWTRAN7's IVULCN 1, 2, 5, 4, 3, 8.
STRATOSPHERES = {
    "background": ("background", "stratospheric_background"),
    "moderate_aged": ("moderate", "volcanic_aged"),
    "moderate_fresh": ("moderate", "volcanic_fresh"),
    "high_aged": ("high", "volcanic_aged"),
    "high_fresh": ("high", "volcanic_fresh"),
    "extreme_fresh": ("extreme", "volcanic_fresh"),
}
SEASONS = ("spring_summer", "fall_winter")

KOSCHMIEDER = 3.912  # -ln 0.02: optical depth at the visibility (Koschmieder 1924, contrast threshold 2 %)
RAYLEIGH_550 = 0.01159e-3  # m^-1, molecular extinction at 0.55 um at the ground (LOWTRAN7, SUBROUTINE AERTMP)
VISIBILITY_RANGE = (0.1, 300.0)  # km; above about 330 km the molecules alone would be too much
LARGEST_OPTICAL_DEPTH = 100.0  # vertical; a visibility of 0.1 km has 46
# Beyond 2 km the tropospheric model keeps this humidity whatever that of the air (LOWTRAN7, SUBROUTINE EXABIN).
TROPOSPHERIC_HUMIDITY = 70.0
# Aerosol follows the ground below this altitude (LOWTRAN7, GNDALT).
TERRAIN_ALTITUDE = 6e3
# Where one region's model gives way to the next, m: LOWTRAN7's levels about its limits of 2, 10 and 30 km.
TRANSITIONS = ((2e3, 3e3), (10e3, 11e3), (30e3, 35e3))


@dataclass(frozen=True)
class Aerosol:
    """The aerosol over a place, by the models of LOWTRAN7 and OPAC.

    Attributes
    ----------
    model : str
        Model of the lowest 2 km, one of `BOUNDARY_MODELS`, or "none" for air without particles at any height.
    visibility_km : float, optional
        0.1 to 300; by default that of the model (`default_visibility`).
    wind_speed : float
        Wind speed at 10 m, m s^-1, which raises the desert and Navy maritime aerosols.
    air_mass : int
        1 (open ocean) to 10 (continental): of the Navy maritime aerosol.
    stratosphere : str
        One of `STRATOSPHERES`.
    season : str, optional
        One of `SEASONS`; by default that of the profile's name, spring_summer unless it is a winter's.
    optical_depth : float, optional
        Vertical, at 0.55 um, from the ground to space: 0 to 100. The whole profile, which keeps the shape that it has
        at the model's visibility, is scaled to it.
    angstrom_exponent : float, optional
        Angstrom exponent of extinction in sunlight; by default that of the models. It applies to all particles of the
        column.
    optics : SpectralModel, optional
        Optical properties of the particles of the lowest 2 km, which replace the model's; the model then gives the
        amount by height alone.
    """

    model: str = "rural"
    visibility_km: float | None = None
    wind_speed: float = DEFAULT_WIND
    air_mass: int = DEFAULT_AIR_MASS
    stratosphere: str = "background"
    season: str | None = None
    optical_depth: float | None = None
    angstrom_exponent: float | None = None
    optics: SpectralModel | None = None

    def __post_init__(self) -> None:
        if self.model == "none" and self.optics is not None:
            raise InputError("found no aerosol and optical properties of one; name the model of its amount by height")
        depth = self.optical_depth
        if depth is None:
            return
        if not 0 <= depth <= LARGEST_OPTICAL_DEPTH:
            raise InputError(f"aerosol optical depth {depth:g} is outside 0 to {LARGEST_OPTICAL_DEPTH:g}")
        if self.visibility_km is not None:
            raise InputError(
                f"found a visibility of {self.visibility_km:g} km and an aerosol optical depth of {depth:g}; allowed:"
                " one of them; remove the other"
            )
        if self.model == "none" and depth > 0:
            raise InputError(f"found no aerosol and an aerosol optical depth of {depth:g}; name a model, or remove it")


def default_visibility(
    model: str,
    wind_speed: float = DEFAULT_WIND,
    relative_humidity: float = 80.0,
    air_mass: int = DEFAULT_AIR_MASS,
) -> float:
    """Visibility [km] that belongs to a boundary-layer model.

    Parameters
    ----------
    model : str
        One of `BOUNDARY_MODELS`.
    wind_speed : float
        m s^-1: of the desert and Navy maritime aerosols, whose amount it sets (LOWTRAN7, SUBROUTINES DESATT and
        MARINE).
    relative_humidity, air_mass : float, int
        Percent at the ground, of the Navy maritime aerosol and those of OPAC; 1 to 10, of the Navy maritime one.
    """
    if model == "desert":
        at_550 = desert_with_amount(wind_speed)[1]
    elif model == "navy_maritime":
        at_550 = float(np.interp(relative_humidity, HUMIDITY, navy_maritime_with_amount(wind_speed, air_mass)[1]))
    elif model in TYPES:
        at_550 = opac_extinction(model, relative_humidity)
    else:
        return _FIXED_VISIBILITY.get(model, _FIXED_VISIBILITY["rural"])
    return float(np.clip(KOSCHMIEDER / (at_550 + RAYLEIGH_550 * 1e3), *VISIBILITY_RANGE))


def aerosol_extinction_550(
    altitude: npt.ArrayLike,
    visibility_km: float,
    season: str,
    ground_altitude: float = 0.0,
    loading: str = "background",
) -> Floats:
    """Aerosol extinction at 0.55 um against altitude.

    At the ground extinction is 3.912 / visibility (Koschmieder) less that of the molecules. Above it follows LOWTRAN7
    (SUBROUTINE AERPRF): linear in 1 / visibility between its profiles to 2 km (and beyond them), likewise between 23
    and 50 km visibility and beyond to 10 km; background stratosphere by season; upper atmosphere to 100 km; none above.
    The logarithm is linear in altitude between levels.

    Parameters
    ----------
    altitude : (N,) array
        Above sea level, m; below the ground the value of the ground is returned.
    visibility_km : float
        0.1 to 300 km.
    season : str
        One of `SEASONS`.
    ground_altitude : float
        Above sea level, m, below 6 km: the profile below 6 km is squeezed to begin at the ground, as in LOWTRAN7.
    loading : str
        Loading of the stratosphere: background, moderate, high or extreme.

    Returns
    -------
    (N,) array
        m^-1.

    Raises
    ------
    InputError
        For a visibility, season, altitude or ground altitude that is not allowed.
    """
    low, high = VISIBILITY_RANGE
    if not low <= visibility_km <= high:
        raise InputError(f"visibility {visibility_km} km is outside {low:g} to {high:g} km")
    if season not in SEASONS:
        raise InputError(f"no aerosol season '{season}'; allowed: {', '.join(SEASONS)}")
    altitude = _model_altitude(altitude, ground_altitude)
    table = tables.vertical_table()
    levels = table["altitude[km]"] * 1e3
    columns = {
        float(name.rpartition("_")[2]): values * 1e-3 for name, values in table.items() if name.startswith(season)
    }
    extinction = _interpolate_visibility(columns, visibility_km)
    if loading != "background":
        stratosphere = tables.stratosphere_table()
        extinction[-stratosphere["altitude[km]"].size :] = stratosphere[f"{season}_{loading}"] * 1e-3
    extinction[0] = KOSCHMIEDER / (visibility_km * 1e3) - RAYLEIGH_550
    profile = np.exp(np.interp(altitude, levels, np.log(extinction)))
    return np.where(altitude > levels[-1], 0.0, profile)


def _interpolate_visibility(columns: dict[float, Floats], visibility: float) -> Floats:
    """Profile (N,) of a visibility [km], linear in 1 / visibility between (and beyond) the tabulated ones."""
    nodes = np.array(sorted(columns, reverse=True))
    upper = int(np.clip(np.searchsorted(1 / nodes, 1 / visibility), 1, len(nodes) - 1))
    near, far = nodes[upper - 1], nodes[upper]
    fraction = (1 / visibility - 1 / near) / (1 / far - 1 / near)
    profile: Floats = columns[near] + fraction * (columns[far] - columns[near])
    return profile


def _model_altitude(altitude: npt.ArrayLike, ground_altitude: float) -> Floats:
    """Altitude in a profile that begins at sea level."""
    altitude = np.atleast_1d(np.asarray(altitude, dtype=float))
    if np.any(np.isnan(altitude)):
        raise InputError("altitude must be a number")
    if not ground_altitude < TERRAIN_ALTITUDE:
        raise InputError(
            f"ground altitude {ground_altitude} m is not below {TERRAIN_ALTITUDE:.0f} m, where aerosol profiles end"
        )
    squeezed = TERRAIN_ALTITUDE * (altitude - ground_altitude) / (TERRAIN_ALTITUDE - ground_altitude)
    position: Floats = np.where(altitude < TERRAIN_ALTITUDE, np.maximum(squeezed, 0.0), altitude)
    return position


def aerosol_layers(
    altitude: Floats,
    aerosol: Aerosol,
    visibility_km: float,
    season: str,
    ground_altitude: float = 0.0,
) -> list[tuple[ParticleModel, Floats]]:
    """The aerosol models of a column and how much of each there is.

    Parameters
    ----------
    altitude : (N,) array
        Above sea level, m.
    aerosol : Aerosol
        Its models; visibility and season, which it may leave open, are those that follow.
    season : str
        One of `SEASONS`.
    ground_altitude : float
        Above sea level, m.

    Returns
    -------
    list of (ParticleModel, (N,) array)
        Model and its extinction at 0.55 um, m^-1: boundary layer, troposphere (at 70 % humidity), stratosphere and
        meteoric dust. The arrays add up to `aerosol_extinction_550`; models change over linearly between 2 and 3, 10
        and 11, 30 and 35 km. The aerosol's optical depth is not yet in them.

    Raises
    ------
    InputError
        As `aerosol_extinction_550` and `AerosolModel.load`.
    """
    if aerosol.model == "none":
        return []
    for name, allowed in ((aerosol.model, (*BOUNDARY_MODELS, "none")), (aerosol.stratosphere, STRATOSPHERES)):
        if name not in allowed:
            raise InputError(f"no aerosol '{name}'; {nearest(name, allowed)}")
    loading, particles = STRATOSPHERES[aerosol.stratosphere]
    models: tuple[AerosolModel | SpectralModel, ...] = (
        aerosol.optics or boundary_model(aerosol.model, aerosol.wind_speed, aerosol.air_mass),
        AerosolModel.load("tropospheric", fixed_humidity=TROPOSPHERIC_HUMIDITY),
        AerosolModel.load(particles),
        AerosolModel.load("meteoric_dust"),
    )
    extinction = aerosol_extinction_550(altitude, visibility_km, season, ground_altitude, loading)
    position = _model_altitude(altitude, ground_altitude)
    above = [np.clip((position - lower) / (upper - lower), 0.0, 1.0) for lower, upper in TRANSITIONS]
    shares = [1.0 - above[0], above[0] - above[1], above[1] - above[2], above[2]]
    exponent = aerosol.angstrom_exponent
    return [
        (model if exponent is None else AngstromModel(model, exponent), extinction * share)
        for model, share in zip(models, shares, strict=True)
    ]


def boundary_model(
    name: str, wind_speed: float = DEFAULT_WIND, air_mass: int = DEFAULT_AIR_MASS
) -> AerosolModel | SpectralModel:
    """A packaged aerosol by name, of a wind [m s^-1] and air mass where it depends on them; errors as those of the
    models.
    """
    if name == "desert":
        return desert_model(wind_speed)
    if name == "navy_maritime":
        return navy_maritime_model(wind_speed, air_mass)
    if name in TYPES:
        return opac_model(name)
    return AerosolModel.load(name)
