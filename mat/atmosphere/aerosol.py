"""Aerosol of LOWTRAN7: optical properties, phase functions and vertical profiles.

Models of Shettle and Fenn 1979 (AFGL-TR-79-0214) as tabulated in LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177). Extinction is
relative to that at 0.55 um; the vertical profile carries the amount. Phase functions are LOWTRAN7's own tables (34 angles,
27 wavelengths from 0.2 to 40 um), not Henyey-Greenstein; those of 40 um stand for all longer waves.
"""

from dataclasses import dataclass
from difflib import get_close_matches
from functools import lru_cache

import numpy as np

from skyshine import atmospheres
from skyshine.mat.atmosphere.datafiles import read_csv
from skyshine.mat.atmosphere.particles import HenyeyGreensteinModel, AerosolOptics
from skyshine.schemas.errors import InputError, nearest

MODELS = ("rural", "urban", "maritime", "tropospheric", "fog_advection", "fog_radiation")
MODELS += ("stratospheric_background", "volcanic_aged", "volcanic_fresh", "meteoric_dust")
# Of the lowest 2 km, with the visibility [km] that LOWTRAN7 gives each (IHAZE); that of the desert follows the wind.
BOUNDARY_MODELS = {
    "rural": 23.0, "urban": 5.0, "maritime": 23.0, "tropospheric": 50.0, "desert": None, "fog_advection": 0.2, "fog_radiation": 0.5
}  # fmt: skip
# Loading (aerosol/stratosphere.csv) and particles of the stratosphere: LOWTRAN7's IVULCN 1, 2, 5, 4, 3, 8.
STRATOSPHERES = {
    "background": ("background", "stratospheric_background"),
    "moderate_aged": ("moderate", "volcanic_aged"),
    "moderate_fresh": ("moderate", "volcanic_fresh"),
    "high_aged": ("high", "volcanic_aged"),
    "high_fresh": ("high", "volcanic_fresh"),
    "extreme_fresh": ("extreme", "volcanic_fresh"),
}
DEFAULT_WIND = 10.0  # m/s, which LOWTRAN7 takes for the desert where none is given (SUBROUTINE DESATT)
SEASONS = ("spring_summer", "fall_winter")

KOSCHMIEDER = 3.912  # -ln 0.02: optical depth at the visibility (Koschmieder 1924, contrast threshold 2 %)
RAYLEIGH_550 = 0.01159e-3  # m^-1, molecular extinction at 0.55 um at the ground (LOWTRAN7, SUBROUTINE AERTMP)
VISIBILITY_RANGE = (0.1, 300.0)  # km; above about 330 km the molecules alone would be too much
# Beyond 2 km the tropospheric model keeps this humidity whatever that of the air (LOWTRAN7, SUBROUTINE EXABIN).
TROPOSPHERIC_HUMIDITY = 70.0
# Aerosol follows the ground below this altitude (LOWTRAN7, GNDALT).
TERRAIN_ALTITUDE = 6e3
# Where one region's model gives way to the next, m: LOWTRAN7's levels about its limits of 2, 10 and 30 km.
TRANSITIONS = ((2e3, 3e3), (10e3, 11e3), (30e3, 35e3))


@dataclass(frozen=True, eq=False)
class AerosolModel:
    """One aerosol model: tables against humidity (H nodes), wavelength (W nodes) and angle.

    Attributes
    ----------
    name : str
    humidity : (H,) array
        Percent; one node for a model that does not depend on humidity.
    wavelength : (W,) array
        um.
    extinction, absorption, asymmetry : (H, W) arrays
    phase_angle : (A,) array
        Degree.
    phase_wavelength : (V,) array
        um.
    phase : (A, H, V) array
        Mean over the sphere 1.
    fixed_humidity : float or None
        Percent; replaces the humidity of the air.
    """

    name: str
    humidity: np.ndarray
    wavelength: np.ndarray
    extinction: np.ndarray
    absorption: np.ndarray
    asymmetry: np.ndarray
    phase_angle: np.ndarray
    phase_wavelength: np.ndarray
    phase: np.ndarray
    fixed_humidity: float | None = None

    @staticmethod
    def load(name, fixed_humidity=None):
        """Load a packaged model.

        Parameters
        ----------
        name : str
            One of `MODELS`.
        fixed_humidity : float, optional
            Percent; the model then ignores the humidity of the air.

        Raises
        ------
        InputError
            For an unknown name; the message holds the nearest one.
        """
        if name not in MODELS:
            nearest = get_close_matches(str(name), MODELS, n=1, cutoff=0.0)[0]
            raise InputError(f"no aerosol model '{name}'; did you mean '{nearest}'? Allowed: {', '.join(MODELS)}")
        return _load(name, fixed_humidity)

    def optics(self, wavenumber, relative_humidity):
        """Extinction, single-scattering albedo and asymmetry.

        Interpolation is LOWTRAN7's: logarithm of the property linear in log(100 - humidity), then linear in wavelength.
        Humidity above 99 % acts as 99 %. Beyond 200 um, the end of the tables, extinction falls as 1 / wavelength
        (absorption by small particles: Bohren and Huffman 1983, section 5.1), albedo and asymmetry stay.

        Parameters
        ----------
        wavenumber : (P,) array
            cm^-1, at most 50,000 (0.2 um).
        relative_humidity : (L,) array
            Percent.

        Returns
        -------
        AerosolOptics

        Raises
        ------
        InputError
            For a wavenumber outside the tables or a humidity that is negative or not a number.
        """
        wavelength = self._wavelength(wavenumber)
        weights = _linear_weights(self.wavelength, wavelength)
        humid = self._log_humidity_weights(relative_humidity)
        extinction, absorption, asymmetry = (
            _interpolate_humidity(humid, table) @ weights for table in (self.extinction, self.absorption, self.asymmetry)
        )
        beyond = np.minimum(1.0, self.wavelength[-1] / wavelength)
        return AerosolOptics(extinction * beyond, 1.0 - absorption / extinction, asymmetry)

    def phase_function(self, cos_angle, wavenumber, relative_humidity):
        """Scattering phase function.

        Logarithm linear in angle between the tabulated angles, then linear in wavelength and humidity, so that the mean
        over the sphere is exactly 1 everywhere.

        Parameters
        ----------
        cos_angle : (A,) array
            Cosine of the scattering angle.
        wavenumber : (P,) array
            cm^-1, at most 50,000 (0.2 um).
        relative_humidity : (L,) array
            Percent.

        Returns
        -------
        (A, L, P) array

        Raises
        ------
        InputError
            As `optics`, and for a cosine outside -1..1 by more than rounding.
        """
        cosine = np.atleast_1d(np.asarray(cos_angle, dtype=float))
        if not np.all(np.abs(cosine) <= 1 + 1e-9):
            raise InputError("the cosine of the scattering angle must lie between -1 and 1")
        angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        log_phase = np.log(self.phase).reshape(len(self.phase_angle), -1)
        at_angle = np.exp(_linear_weights(self.phase_angle, angle).T @ log_phase).reshape(-1, *self.phase.shape[1:])
        at_humidity = np.einsum("hl,ahv->alv", _linear_weights(self.humidity, self._humidity(relative_humidity)), at_angle)
        return at_humidity @ _linear_weights(self.phase_wavelength, self._wavelength(wavenumber))

    def _wavelength(self, wavenumber):
        wavenumber = np.atleast_1d(np.asarray(wavenumber, dtype=float))
        limit = 1e4 / self.wavelength[0]
        if not np.all((wavenumber > 0) & (wavenumber <= limit * (1 + 1e-9))):
            raise InputError(f"aerosol '{self.name}' is tabulated for wavenumbers above 0 and up to {limit:.0f} cm-1")
        return 1e4 / wavenumber

    def _humidity(self, relative_humidity):
        humidity = np.atleast_1d(np.asarray(relative_humidity, dtype=float))
        if not np.all(humidity >= 0):
            raise InputError("relative humidity must be at least 0 percent and a number")
        if self.fixed_humidity is not None:
            humidity = np.full_like(humidity, self.fixed_humidity)
        return humidity

    def _log_humidity_weights(self, relative_humidity):
        humidity = np.minimum(self._humidity(relative_humidity), self.humidity[-1])
        return _linear_weights(-np.log(100 - self.humidity), -np.log(100 - humidity))


@lru_cache(maxsize=None)
def _load(name, fixed_humidity):
    table = read_csv(atmospheres.path(f"aerosol/{name}.csv"))
    humidity = np.unique(table["relative_humidity[percent]"])
    extinction, absorption, asymmetry = (
        table[column].reshape(len(humidity), -1) for column in ("extinction", "absorption", "asymmetry")
    )
    functions = read_csv(atmospheres.path("aerosol/phase_functions.csv"))
    index = read_csv(atmospheres.path("aerosol/phase_index.csv"))
    rows = np.flatnonzero(index["model"] == name)
    phase_columns = list(index)[2:]
    number = np.array([index[column][rows] for column in phase_columns], dtype=int).T
    values = np.array([functions[f"p{n}"] for n in range(1, len(functions))])
    return AerosolModel(
        name=name,
        humidity=humidity,
        wavelength=table["wavelength[um]"].reshape(len(humidity), -1)[0],
        extinction=extinction,
        absorption=absorption,
        asymmetry=asymmetry,
        phase_angle=functions["angle[degree]"],
        phase_wavelength=np.array([float(column) for column in phase_columns]),
        phase=np.moveaxis(values[number - 1], -1, 0),
        fixed_humidity=fixed_humidity,
    )


def _interpolate_humidity(weights, table):
    """Interpolate the logarithm of a (H, W) table with (H, L) weights; a model of one humidity may hold zeros."""
    if len(table) == 1:
        return np.broadcast_to(table, (weights.shape[1], table.shape[1]))
    return np.exp(weights.T @ np.log(table))


def _linear_weights(nodes, points):
    """Weights (N, M) of linear interpolation from N increasing nodes to M points, the end values held outside."""
    if len(nodes) == 1:
        return np.ones((1, len(points)))
    upper = np.clip(np.searchsorted(nodes, points, side="right"), 1, len(nodes) - 1)
    fraction = np.clip((points - nodes[upper - 1]) / (nodes[upper] - nodes[upper - 1]), 0.0, 1.0)
    weights = np.zeros((len(nodes), len(points)))
    column = np.arange(len(points))
    weights[upper - 1, column] = 1.0 - fraction
    weights[upper, column] = fraction
    return weights


def default_visibility(model, wind_speed=DEFAULT_WIND):
    """Visibility [km] that belongs to a boundary-layer model; in the desert, by the wind speed [m/s] (LOWTRAN7, SUBROUTINE DESATT)."""
    if model == "desert":
        return KOSCHMIEDER / (_desert(wind_speed)[1] + RAYLEIGH_550 * 1e3)
    return BOUNDARY_MODELS.get(model, BOUNDARY_MODELS["rural"])


def aerosol_extinction_550(altitude, visibility_km, season, ground_altitude=0.0, loading="background"):
    """Aerosol extinction at 0.55 um against altitude.

    At the ground extinction is 3.912 / visibility (Koschmieder) less that of the molecules. Above it follows LOWTRAN7
    (SUBROUTINE AERPRF): linear in 1 / visibility between its profiles to 2 km (and beyond them), likewise between 23 and 50 km
    visibility and beyond to 10 km; background stratosphere by season; upper atmosphere to 100 km; none above. The logarithm is
    linear in altitude between levels.

    Parameters
    ----------
    altitude : (N,) array
        Above sea level, m; below the ground the value of the ground is returned.
    visibility_km : float
        0.1 to 300 km.
    season : str
        One of `SEASONS`.
    ground_altitude : float
        Above sea level, m, below 6 km: the profile below 6 km is squeezed to stand on the ground, as in LOWTRAN7.
    loading : str
        Of the stratosphere: background, moderate, high or extreme.

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
    table = read_csv(atmospheres.path("aerosol/vertical.csv"))
    levels = table["altitude[km]"] * 1e3
    columns = {float(name.rpartition("_")[2]): values * 1e-3 for name, values in table.items() if name.startswith(season)}
    extinction = _interpolate_visibility(columns, visibility_km)
    if loading != "background":
        laden = read_csv(atmospheres.path("aerosol/stratosphere.csv"))
        extinction[-laden["altitude[km]"].size :] = laden[f"{season}_{loading}"] * 1e-3
    extinction[0] = KOSCHMIEDER / (visibility_km * 1e3) - RAYLEIGH_550
    profile = np.exp(np.interp(altitude, levels, np.log(extinction)))
    return np.where(altitude > levels[-1], 0.0, profile)


def _interpolate_visibility(columns, visibility):
    """Linear in 1 / visibility between (and beyond) the tabulated profiles; a dict of visibility [km] to (N,) profiles."""
    nodes = np.array(sorted(columns, reverse=True))
    upper = int(np.clip(np.searchsorted(1 / nodes, 1 / visibility), 1, len(nodes) - 1))
    first, second = nodes[upper - 1], nodes[upper]
    fraction = (1 / visibility - 1 / first) / (1 / second - 1 / first)
    return columns[first] + fraction * (columns[second] - columns[first])


def _model_altitude(altitude, ground_altitude):
    """Altitude in a profile that begins at sea level."""
    altitude = np.atleast_1d(np.asarray(altitude, dtype=float))
    if np.any(np.isnan(altitude)):
        raise InputError("altitude must be a number")
    if not ground_altitude < TERRAIN_ALTITUDE:
        raise InputError(f"ground altitude {ground_altitude} m is not below {TERRAIN_ALTITUDE:.0f} m, where aerosol profiles end")
    squeezed = TERRAIN_ALTITUDE * (altitude - ground_altitude) / (TERRAIN_ALTITUDE - ground_altitude)
    return np.where(altitude < TERRAIN_ALTITUDE, np.maximum(squeezed, 0.0), altitude)


def desert_model(wind_speed):
    """The desert aerosol at a wind speed [m/s] at 10 m.

    Logarithms of extinction and absorption, and asymmetry, are linear in wind speed (LOWTRAN7, SUBROUTINE DESATT).

    Raises
    ------
    InputError
        For a wind speed outside the tables, 0 to 30 m/s.

    References
    ----------
    Longtin et al. 1988, AFGL-TR-88-0112.
    """
    return _desert(float(wind_speed))[0]


@lru_cache(maxsize=8)
def _desert(wind_speed):
    """The model, and its extinction at 0.55 um in km^-1."""
    table = read_csv(atmospheres.path("aerosol/desert.csv"))
    winds = np.unique(table["wind_speed[m/s]"])
    if not winds[0] <= wind_speed <= winds[-1]:
        raise InputError(f"wind speed {wind_speed:g} m/s is outside {winds[0]:g} to {winds[-1]:g} m/s, which the desert aerosol covers")
    weights = _linear_weights(winds, np.array([wind_speed]))[:, 0]
    wavelength, extinction, absorption, asymmetry = (table[name].reshape(len(winds), -1) for name in list(table)[1:])
    extinction, absorption = (np.exp(weights @ np.log(values)) for values in (extinction, absorption))
    return HenyeyGreensteinModel.of_table("desert", wavelength[0], extinction, absorption, weights @ asymmetry)


def aerosol_layers(
    altitude, visibility_km, season, boundary_model, ground_altitude=0.0, stratosphere="background", wind_speed=DEFAULT_WIND
):
    """The aerosol models of a column and how much of each there is.

    Parameters
    ----------
    altitude : (N,) array
        Above sea level, m.
    visibility_km : float
    season : str
        One of `SEASONS`.
    boundary_model : str
        Model of the lowest 2 km, one of `BOUNDARY_MODELS`; ``"none"`` for a column without any aerosol.
    ground_altitude : float
        Above sea level, m.
    stratosphere : str
        One of `STRATOSPHERES`.
    wind_speed : float
        At 10 m, m s^-1: of the desert aerosol.

    Returns
    -------
    list of (AerosolModel, (N,) array)
        Model and its extinction at 0.55 um, m^-1: boundary layer, troposphere (at 70 % humidity), stratosphere and meteoric
        dust. The arrays add up to `aerosol_extinction_550`; models change over linearly between 2 and 3, 10 and 11,
        30 and 35 km.

    Raises
    ------
    InputError
        As `aerosol_extinction_550` and `AerosolModel.load`.
    """
    if boundary_model == "none":
        return []
    for name, allowed in ((boundary_model, (*BOUNDARY_MODELS, "none")), (stratosphere, STRATOSPHERES)):
        if name not in allowed:
            raise InputError(f"no aerosol '{name}'; {nearest(name, allowed)}")
    loading, particles = STRATOSPHERES[stratosphere]
    models = (
        desert_model(wind_speed) if boundary_model == "desert" else AerosolModel.load(boundary_model),
        AerosolModel.load("tropospheric", fixed_humidity=TROPOSPHERIC_HUMIDITY),
        AerosolModel.load(particles),
        AerosolModel.load("meteoric_dust"),
    )
    extinction = aerosol_extinction_550(altitude, visibility_km, season, ground_altitude, loading)
    position = _model_altitude(altitude, ground_altitude)
    above = [np.clip((position - lower) / (upper - lower), 0.0, 1.0) for lower, upper in TRANSITIONS]
    shares = [1.0 - above[0], above[0] - above[1], above[1] - above[2], above[2]]
    return [(model, extinction * share) for model, share in zip(models, shares, strict=True)]
