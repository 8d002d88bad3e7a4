"""Boundary condition at the back of a stack: a deep or interior temperature or heat from inside, steady or hourly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.conduction import Conduction
from skyshine.mat.surface.ground_year import GroundSeason, damping_depths
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.penetrating_light import penetrating_light_flux
from skyshine.materials.records import Back
from skyshine.schemas.arrays import Floats, Integers

SEASON = 30 * 24.0  # h: longest record with one deep temperature; chosen: a month, as climates and EPW give the ground


def at_hours(values: npt.ArrayLike, hours: Floats) -> Floats:
    """Values of the day, one or 24 at the clock hours 0 to 23, at other hours: linear and periodic."""
    series = np.asarray(values, float)
    if series.ndim == 0:
        return np.full(np.shape(hours), float(series))
    result: Floats = np.interp(hours, np.arange(24.0), series, period=24.0)
    return result


def back_drive(material: SurfaceMaterial, forcing: Forcing, hours: Floats, air: Floats | None = None) -> Floats:
    """Temperature or heat flux that drives the back of each column.

    Parameters
    ----------
    forcing : Forcing
        The season of its ground, or else its mean air temperature, represents a temperature that the material does not
        give: the mean over all of a day or of some weeks, over the `SEASON` around each time of a longer record, whose
        ground follows the year.
    hours : (N,) ndarray
        Hours of the clock.
    air : (rows or columns, 1) ndarray, optional
        Mean air temperature of more days than the forcing's, which replaces the forcing's [K].

    Returns
    -------
    (columns, N or 1) ndarray
        [K], or [W m^-2] of a heated back.
    """
    boundary = material.thermal.back
    if boundary.kind in ("open", "cavity"):
        return _outdoor(boundary, forcing, hours)
    value = boundary.heat_flux if boundary.kind == "heated" else boundary.temperature
    if value is None and forcing.ground_mean is not None:
        return _ground(material, forcing)
    if value is None:
        mean = _of_season(np.atleast_2d(forcing.air_temperature), hours) if air is None else air
        return np.repeat(mean, forcing.shape[0] // len(mean), axis=0)
    series = at_hours(value, hours if np.ndim(value) else np.zeros(1))
    return np.repeat(series[None, :], forcing.shape[0], axis=0)


def _outdoor(boundary: Back, forcing: Forcing, hours: Floats) -> Floats:
    """Air temperature of the hour (columns, N) [K], warmer by the heat of a cavity."""
    air = np.atleast_2d(forcing.air_temperature)
    if boundary.heat_flux is not None and boundary.exchange is not None:
        air = air + at_hours(boundary.heat_flux, hours) / boundary.exchange
    return np.repeat(air, forcing.shape[0] // len(air), axis=0)


def _ground(material: SurfaceMaterial, forcing: Forcing) -> Floats:
    """Temperature (columns, 1) [K] of the ground at the depth where the stack ends."""
    assert forcing.ground_mean is not None
    assert forcing.ground_amplitude is not None
    assert forcing.ground_day is not None
    season = GroundSeason(forcing.ground_mean, forcing.ground_amplitude, forcing.ground_day)
    kelvin = season.below(damping_depths(material.thermal))
    return np.broadcast_to(kelvin, (forcing.shape[0], 1))


def _of_season(air: Floats, hours: Floats) -> Floats:
    """Mean air temperature (rows, 1), or (rows, N) around each of N equally spaced hours of more than a season."""
    steps = air.shape[1]
    length = steps * float(hours[1] - hours[0]) if min(steps, len(hours)) > 1 else 0.0
    if length <= SEASON:
        mean: Floats = air.mean(axis=1, keepdims=True)
        return mean
    half = round(0.5 * SEASON / length * steps)
    padded = np.concatenate([air[:, -half:], air, air[:, :half]], axis=1)
    total = np.cumsum(np.pad(padded, ((0, 0), (1, 0))), axis=1)
    moving_mean: Floats = (total[:, 2 * half + 1 :] - total[:, : -2 * half - 1]) / (2 * half + 1)
    return moving_mean


@dataclass(frozen=True, eq=False)
class BackFlux:
    """Heat flux from the back to the surfaces of some columns, and the bounds that the back sets.

    Attributes
    ----------
    source : ndarray, shape (columns, N or 1)
        Heat flux that the drive brings to a surface at 0 K [W m^-2].
    lowest, highest : ndarray, shape (columns, 1)
        Bounds of the temperature behind [K]; unbounded where heat drives it.
    heat : tuple of float
        Least and most heat from inside at any time [W m^-2], what the depth of absorbed sunlight changes with it; 0
        where a temperature drives it and no light comes in.
    """

    source: Floats
    lowest: Floats
    highest: Floats
    heat: tuple[float, float]

    @classmethod
    def of(
        cls,
        material: SurfaceMaterial,
        forcing: Forcing,
        conduction: Conduction,
        hours: Floats,
        air: Floats | None = None,
    ) -> BackFlux:
        """The flux of a material's back at clock hours (N,); `air` as `back_drive` takes it."""
        drive = back_drive(material, forcing, hours, air)
        lowest, highest = drive.min(axis=1, keepdims=True), drive.max(axis=1, keepdims=True)
        source = drive * conduction.steady_transfer if drive.shape[1] == 1 else conduction.from_back(drive)
        coldest, hottest = 0.0, 0.0
        if material.thermal.light:
            light = penetrating_light_flux(material, forcing, conduction)
            source, coldest, hottest = source + light, float(light.min()), float(light.max())
        if material.thermal.back.kind != "heated":
            return cls(source, lowest, highest, (coldest, hottest))
        unbounded = np.full_like(lowest, np.inf)
        return cls(source, unbounded, -unbounded, (float(lowest.min()) + coldest, float(highest.max()) + hottest))

    def after(self, source: Floats, lowest: Floats, highest: Floats) -> BackFlux:
        """That of columns to which days before, between these temperatures (columns, 1) [K], leave another source."""
        return BackFlux(source, np.minimum(self.lowest, lowest), np.maximum(self.highest, highest), self.heat)

    def with_heat(self, heat: Floats) -> BackFlux:
        """That of columns with more heat from inside (columns, N) [W m^-2], within whose limits it may lie too."""
        limits = min(self.heat[0], float(heat.min())), max(self.heat[1], float(heat.max()))
        return BackFlux(self.source, self.lowest, self.highest, limits)

    def columns(self, chosen: slice | Integers) -> BackFlux:
        """The flux of a slice or index array of columns."""
        return BackFlux(self.source[chosen], self.lowest[chosen], self.highest[chosen], self.heat)
