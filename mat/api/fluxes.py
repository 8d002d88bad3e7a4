"""Fluxes on all levels of the air: spectral between two wavenumbers, or of the whole spectrum."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from skyshine.mat.api.air import described_air, on_the_day, source_on_the_day, state_air, with_air_keys
from skyshine.mat.api.arguments import numbers, wavenumber_limits
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable, default_water_continuum
from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.spectra.fluxes import LONGWAVE, SHORTWAVE, packaged_points
from skyshine.mat.atmosphere.spectra.level_fluxes import LevelFluxes
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.scene.sources import source_irradiance
from skyshine.mat.tables.dataset import dataset
from skyshine.mat.tables.result import Panel, Result
from skyshine.mat.tables.spectrum_file import IRRADIANCE
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

if TYPE_CHECKING:
    import xarray

_CHUNK = 600  # points computed together: bounds memory
_THERMAL, _LIGHT = ("thermal_up", "thermal_down"), ("direct", "diffuse_down", "diffuse_up")


@dataclass(frozen=True, eq=False)
class Fluxes(Result):
    """Fluxes through horizontal surfaces at N levels, under a source at S elevations, in B spectral bins.

    Attributes
    ----------
    altitude : (N,) array
        Altitudes above sea level, from the ground up, m.
    source_elevation : (S,) array
        Geometric elevations of the source at each level, degree.
    wavenumber : (B,) array
        Middle of each bin, cm^-1; empty for the whole spectrum.
    thermal_up, thermal_down : (N, B) arrays
        Emission of ground and air, W m^-2 (cm^-1)^-1; (N,) arrays in W m^-2 for the whole spectrum.
    direct, diffuse_down, diffuse_up : (N, S, B) arrays
        Light of the source: not scattered, scattered downward, scattered or reflected upward, in the same units; (N, S)
        arrays for the whole spectrum.
    in_band : dict of str to (N,) or (N, S) array
        The same five, summed over the bins, W m^-2.
    """

    altitude: Floats
    source_elevation: Floats
    wavenumber: Floats
    thermal_up: Floats
    thermal_down: Floats
    direct: Floats
    diffuse_down: Floats
    diffuse_up: Floats
    in_band: dict[str, Floats]

    def to_xarray(self) -> xarray.Dataset:
        """The fluxes as an `xarray.Dataset` over altitude, source_elevation and, between two limits, wavenumber."""
        bins = ("wavenumber",) if self.wavenumber.size else ()
        units = IRRADIANCE if bins else "W m^-2"
        axes = {"altitude": ("m", self.altitude), "source_elevation": ("degree", self.source_elevation)}
        return dataset(
            axes | ({"wavenumber": ("cm^-1", self.wavenumber)} if bins else {}),
            {name: (("altitude", *bins), units, getattr(self, name)) for name in _THERMAL}
            | {name: (("altitude", "source_elevation", *bins), units, getattr(self, name)) for name in _LIGHT},
            {},
        )

    def _panels(self) -> list[Panel]:
        thermal = {name.replace("_", " "): self.in_band[name] for name in _THERMAL}
        light = {
            f"{name.replace('_', ' ')}, source at {elevation:g}°": self.in_band[name][:, number]
            for number, elevation in enumerate(self.source_elevation)
            for name in _LIGHT
        }
        above = self.altitude / 1e3
        parts = [values for values in (thermal, light) if values]
        return [Panel(above, "altitude, km", "flux, W m$^{-2}$", values, upright=True) for values in parts]

    def __repr__(self) -> str:
        bins = f"{self.wavenumber.size} bins" if self.wavenumber.size else "the whole spectrum"
        return f"<Fluxes on {self.altitude.size} levels, {self.source_elevation.size} source elevations, {bins}>"


@with_air_keys
def fluxes(
    *,
    wavenumber: tuple[float, float] | None = None,
    wavelength: tuple[float, float] | None = None,
    job: str | os.PathLike[str] | Mapping[str, Any] | None = None,
    state: int = 1,
    source: Literal["sun", "moon", "none"] = "sun",
    source_elevation: npt.ArrayLike = 45.0,
    water_continuum: str | None = None,
    **air: Any,
) -> Fluxes:
    """Upward, downward and direct fluxes on all levels of the air.

    Parameters
    ----------
    wavenumber, wavelength : (low, high), optional
        Limits in cm^-1 or in um; without them fluxes of the whole spectrum: thermal from 10 to 3,400 cm^-1, sunlight
        from 800 to 33,400 cm^-1.
    job, state, source, water_continuum
        As for `spectrum`; a job's state gives temperature and reflectance of the ground too.
    source_elevation : float or (S,) array
        Geometric elevation of the source [degree].
    **air
        Keys of a job's state that describe its air, as for `spectrum`: profile, aerosol, visibility_km, clouds, rain
        and others; the ground has the temperature of the lowest air. Its `surface_albedo` is that of all wavelengths:
        it emits as a black body times 1 less it, and the default of 0.1 takes 2 to 7 W m^-2 from the clear sky's
        `thermal_up` at the top.

    Returns
    -------
    Fluxes

    Raises
    ------
    InputError
        As `spectrum`; or the whole spectrum of another source than the Sun.

    References
    ----------
    Stamnes, Tsay, Wiscombe and Jayaweera 1988, Appl. Opt. 27, 2502 (discrete ordinates).

    Examples
    --------
    >>> import skyshine.mat
    >>> whole = skyshine.mat.fluxes(profile="tropical", source_elevation=[30, 60])
    >>> whole.thermal_down.shape == whole.altitude.shape, whole.direct.shape[1]
    (True, 2)
    >>> bool(350 < whole.thermal_down[0] < 450)
    True
    """
    elevation = np.atleast_1d(numbers("source_elevation", source_elevation))
    if np.any(np.abs(elevation) > 90):
        raise InputError(f"found source_elevation {elevation[np.abs(elevation) > 90][0]:g}; allowed: -90 to 90 degree")
    if source not in ("sun", "moon", "none"):
        raise InputError(f"found the source {source!r}; allowed: 'sun', 'moon' or 'none'")
    elevation = np.zeros(0) if source == "none" else elevation
    air = {name: value for name, value in air.items() if value is not None}
    if job is None and state != 1:
        raise InputError(f"found state {state} without a job; allowed: a state of a job; give the job")
    loaded = None if job is None else on_the_day(job, state, air)
    whole = wavenumber is None and wavelength is None
    low, high = (LONGWAVE[0], SHORTWAVE[1]) if whole else wavenumber_limits(wavenumber, wavelength)
    column = described_air(air) if loaded is None else state_air(loaded, state, low, high)
    if water_continuum is None:
        water_continuum = default_water_continuum() if loaded is None else loaded.trimmed.water_continuum
    if whole:
        if source == "moon":
            raise InputError("found the Moon as source of the whole spectrum; allowed: the Sun, or limits of a band")
        near = 1.0
        if loaded is not None:
            at = np.array([20000.0]), np.array([10.0])
            near = float((source_irradiance(loaded.trimmed, "sun", *at) / solar_irradiance(*at))[0])
        return _whole(column, water_continuum, elevation, near)
    points = AbsorptionTable.open(water_continuum=water_continuum).points(low, high)
    irradiance = source_on_the_day(source, points, None if loaded is None else loaded.trimmed)
    return _spectral(column, points, irradiance, elevation)


def _whole(state: AtmosphericState, water_continuum: str, elevation: Floats, near: float) -> Fluxes:
    """Fluxes of the whole spectrum; `near` is the sunlight over that at 1 au."""
    points = packaged_points(water_continuum)
    thermal = LevelFluxes.of(state, points.longwave_levels, [])
    light = LevelFluxes.of(state, points.shortwave, elevation)
    sums = {name: getattr(thermal, name) @ points.longwave_levels.weight for name in _THERMAL}
    sums |= {name: getattr(light, name) @ points.shortwave.weight * near for name in _LIGHT}
    return Fluxes(state.altitude, elevation, np.zeros(0), **sums, in_band=sums)


def _spectral(state: AtmosphericState, points: SpectralPoints, irradiance: Floats, elevation: Floats) -> Fluxes:
    """Means over the intervals of points, of a source of an irradiance (P,) [W m^-2 (cm^-1)^-1]."""
    count, size = len(points.interval_edges), points.wavenumber.size
    width = np.bincount(points.interval, points.weight, count)
    shapes = dict.fromkeys(_THERMAL, (state.altitude.size,)) | dict.fromkeys(
        _LIGHT, (state.altitude.size, elevation.size)
    )
    means: dict[str, Floats] = {name: np.zeros((*shape, count)) for name, shape in shapes.items()}
    for start in range(0, size, _CHUNK):
        part = np.arange(start, min(start + _CHUNK, size))
        levels = LevelFluxes.of(state, points.subset(part), elevation)
        share = np.zeros((part.size, count))
        share[np.arange(part.size), points.interval[part]] = points.weight[part] / width[points.interval[part]]
        for name in means:
            arriving = irradiance[part, None] if name in _LIGHT else 1.0
            means[name] += getattr(levels, name) @ (share * arriving)
    middle = points.interval_edges.mean(axis=1)
    in_band = {name: values @ width for name, values in means.items()}
    return Fluxes(state.altitude, elevation, middle, **means, in_band=in_band)
