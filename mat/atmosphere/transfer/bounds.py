"""Upper bounds of scattered radiance, and of the changes in radiance by each kind of particle, from optical depths.

Path radiance is a weighted mean of the layers' source functions; the weights sum to at most 1, and each is at most the
absorptance of the layer along its longest chord. No line of sight is therefore brighter than the mean in which the
brightest source functions take their largest weights in turn until the sum is 1. A source function is at most the light
scattered once, at the largest value of the phase function, plus the single-scattering albedo times the radiance of the
brightest line of sight, which closes the bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.state.state import AerosolComponent
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import trace
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, particle_sections
from skyshine.mat.atmosphere.transfer.path_axes import PathAxes
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Floats, Integers

_ENDS = np.s_[:-1], np.s_[1:]  # lower and upper level of each layer
_RAYLEIGH_PEAK = 1.5  # of `optics.rayleigh_phase`, straight forward and straight back, without depolarisation
_PEAKS = 9  # wavelengths of a band at which the largest value of a phase function is looked for
_THIN = 1e-3  # mean vertical optical depth above which particles get no bound
REFERENCE = 300.0  # K, of the black body behind a line of sight


@dataclass(frozen=True, eq=False)
class Scattering:
    """Largest scattered radiance of any line of sight through a state, at P points.

    Attributes
    ----------
    light : (P,) array
        Radiance of scattered light, of sky and path alike, per unit of the source's irradiance outside the atmosphere,
        sr^-1; infinite where no bound exists.
    field : (P,) array
        The same with the ground, which reflects the source.
    gain : (P,) array
        Radiance scattered into a line of sight, per mean radiance over all directions.
    """

    light: Floats
    field: Floats
    gain: Floats

    @classmethod
    def of(cls, air: SpectralAir) -> Scattering:
        """The bounds of a state at the points of its air."""
        optics, ground = air.optics, air.state.albedo_at(air.optics.wavenumber)
        share = -np.expm1(-_chords(air) * _either(optics.extinction))
        scattering = optics.rayleigh + optics.aerosol_scattering
        with np.errstate(divide="ignore", over="ignore"):
            scaled = optics.extinction - optics.aerosol_scattering * air.delta_fraction
            peak = _either(optics.phase.max(axis=0) @ optics.phase_share)
            single = np.maximum(
                *(
                    (_RAYLEIGH_PEAK * optics.rayleigh[end] + peak * optics.aerosol_scattering[end]) / scaled[end]
                    for end in _ENDS
                )
            )
            albedo = _either(scattering / optics.extinction)
            source = single / (4 * np.pi)
            amplification = 1 / (1 - _brightest(albedo, share, ground))
            field = _brightest(source, share, ground / np.pi) * amplification
            light = _brightest(source + albedo * field, share)
        return cls(light, field, _brightest(single, share) * amplification)

    def radiance(self, irradiance: Floats, weight: Floats) -> Floats:
        """Bound (...) of a band's scattered light, W m^-2 sr^-1, for irradiances (..., P) and weights (P,)
        `BandPoints.radiance_weight`.
        """
        radiance: Floats = np.asarray(irradiance) * self.light @ weight
        return radiance


@dataclass(frozen=True, eq=False)
class Bounds:
    """Largest change of a band's radiance by an omission, W m^-2 sr^-1.

    Attributes
    ----------
    scattered : (B,) array
        Light of each source that air, particles and ground scatter into paths and sky.
    particles : (K,) array
        Each of `AtmosphericState.particles`.
    """

    scattered: Floats
    particles: Floats

    @classmethod
    def of(cls, air: SpectralAir, grid: PathAxes, irradiance: Floats, weight: Floats) -> Bounds:
        """Bounds for the lines of sight of a grid and the irradiance (B, P) of sources [W m^-2 (cm^-1)^-1]; `weight` as
        in `Scattering.radiance`.
        """
        scattering = Scattering.of(air)
        return cls(
            scattering.radiance(irradiance, weight),
            particle_bounds(air, scattering, table_lines(air, grid), irradiance.sum(axis=0), weight),
        )


def particle_bounds(
    air: SpectralAir, scattering: Scattering, lines: Floats, irradiance: Floats, weight: Floats
) -> Floats:
    """Largest change of a band's transmitted, path, sky and direct radiance if one kind of particle is omitted.

    Particles remove from a line of sight and add to it at most their absorptance along it times the brightest radiance;
    the change in scattering by everything else follows from the mean over all directions.

    Parameters
    ----------
    air : SpectralAir
    scattering : Scattering
        Scattering of that air.
    lines : (M, N) array
        Air of the lines of sight of a table, molecules m^-2, by the level whose properties apply to it.
    irradiance : (P,) array
        Irradiance of all sources together, W m^-2 (cm^-1)^-1.
    weight : (P,) array
        `BandPoints.radiance_weight`.

    Returns
    -------
    (K,) array
        By `AtmosphericState.particles`, W m^-2 sr^-1; of black bodies at 300 K behind the lines. 0 where there is no
        such particle, infinite where there are many.
    """
    return np.array(
        [
            _of_particle(air, component, scattering, lines, irradiance, weight)
            if np.any(component.extinction_550 > 0)
            else 0.0
            for component in air.state.particles
        ]
    )


def _of_particle(
    air: SpectralAir,
    component: AerosolComponent,
    scattering: Scattering,
    lines: Floats,
    irradiance: Floats,
    weight: Floats,
) -> float:
    """The bound of `particle_bounds` for one kind of particle."""
    state, optics = air.state, air.optics
    extinction, scattered, _ = particle_sections(state, component, optics.wavenumber)
    upright = np.sum(vertical_column(air.shells, extinction), axis=0)
    if upright @ weight > _THIN * weight.sum():
        return np.inf
    nodes = np.geomspace(optics.wavenumber.min(), optics.wavenumber.max(), _PEAKS)
    peaks = component.model.phase_function(np.cos(PHASE_ANGLES), nodes, state.relative_humidity).max(axis=(0, 2))
    peak = np.max(scattered / np.where(extinction > 0, extinction, 1.0) * peaks[:, None], axis=0)
    warmest = max(state.temperature.max(), state.surface_temperature, REFERENCE)
    brightest = planck_wavenumber(optics.wavenumber, warmest) + _times(
        irradiance, scattering.field + peak / (4 * np.pi)
    )
    if not np.isfinite(brightest).all():
        return np.inf
    longest = np.maximum(_longest(air, extinction), upright)
    rescattered = _times(
        brightest * mean_absorptance(upright, longest) - irradiance * np.expm1(-longest) / (4 * np.pi), scattering.gain
    )
    along = np.max(-np.expm1(-lines @ extinction) @ (weight * brightest), initial=0.0) if len(lines) else 0.0
    sky = np.minimum(2 * upright, 1.0) * brightest @ weight
    rays = air.source_rays.air
    transmittance = np.exp(-np.maximum(rays @ (optics.extinction - extinction), 0.0))
    direct = np.max((-np.expm1(-rays @ extinction) * transmittance) @ (weight * irradiance)) / np.pi
    return float(max(along + rescattered @ weight, sky + rescattered @ weight, direct))


def mean_absorptance(upright: Floats, longest: Floats) -> Floats:
    """Bound (P,) of the absorptance of a thin layer in the mean over the directions of a hemisphere.

    Parameters
    ----------
    upright, longest : (P,) array
        Optical depth of the layer along the vertical, and along the longest line through it, which is at least as large
        and ends the growth with the secant.
    """
    divisor = np.where(upright > 0, upright, 1.0)
    mean: Floats = np.minimum(upright * (1 + np.log(np.maximum(longest / divisor, 1.0))), 1.0)
    return mean


def _longest(air: SpectralAir, section: Floats) -> Floats:
    """Optical depth (P,) of the longest line through a cross section (N, P) [m^2 per molecule], level at some point."""
    levels = air.shells.altitude
    rays = trace(air.shells, levels[:-1], np.zeros(levels.size - 1))
    both_sides = 2 * (by_level(rays.layer, rays.lower, rays.upper, levels.size) @ section)
    above = np.concatenate([both_sides[1:], np.zeros((1, both_sides.shape[1]))])
    longest: Floats = np.max(_chords(air) * _either(section) + above, axis=0)
    return longest


def by_level(layer: Integers, lower: Floats, upper: Floats, count: int) -> Floats:
    """Air (M, count) of rays by level, from the layer (M, K) of each segment and its air by the layer's lower and upper
    level, (M, K) each.
    """
    air = np.zeros((len(layer), count))
    row = np.arange(len(layer))[:, None]
    np.add.at(air, (row, layer), lower)
    np.add.at(air, (row, layer + 1), upper)
    return air


def table_lines(air: SpectralAir, grid: PathAxes) -> Floats:
    """Air (M, N) [molecules m^-2] of the lines of sight of a table to the longest range, by level, for
    `particle_bounds`.
    """
    altitude, elevation = (
        a.ravel() for a in np.meshgrid(grid.altitude_km * 1e3, np.radians(grid.elevation_deg), indexing="ij")
    )
    rays = trace(air.shells, altitude, elevation, np.full((altitude.size, 1), grid.range_km[-1] * 1e3))
    before = rays.distance[:, 1:] <= grid.range_km[-1] * 1e3 * (1 + 1e-9)
    return by_level(rays.layer, rays.lower * before, rays.upper * before, air.shells.altitude.size)


def _either(values: Floats) -> Floats:
    """The larger of a property's (N, ...) values at the two levels of each layer."""
    larger: Floats = np.maximum(*(values[end] for end in _ENDS))
    return larger


def _chords(air: SpectralAir) -> Floats:
    """Air on the longest path through each layer, (N-1, 1) molecules m^-2: that of the ray which is level at the
    layer's lower level, to both sides.
    """
    levels = air.shells.altitude
    rays = trace(air.shells, levels[:-1], np.zeros(levels.size - 1))
    inside = rays.layer == np.arange(levels.size - 1)[:, None]
    chords: Floats = 2 * np.sum((rays.lower + rays.upper) * inside, axis=1)[:, None]
    return chords


def _brightest(source: Floats, share: Floats, ground: float | Floats | None = None) -> Floats:
    """Largest weighted mean (P,) of sources (L, P) with weights of at most their shares (L, P) and a sum of at most 1;
    a ground may take all of the weight.
    """
    if ground is not None:
        source = np.concatenate([source, np.broadcast_to(ground, (1, source.shape[1]))])
        share = np.concatenate([share, np.ones((1, share.shape[1]))])
    order = np.argsort(-source, axis=0, kind="stable")
    filled = np.minimum(np.cumsum(np.take_along_axis(share, order, axis=0), axis=0), 1.0)
    weight = np.diff(filled, axis=0, prepend=0.0)
    brightest: Floats = np.sum(weight * np.where(weight > 0, np.take_along_axis(source, order, axis=0), 0.0), axis=0)
    return brightest


def _times(amount: Floats, bound: Floats) -> Floats:
    """A product with a bound that may be infinite: of no light there is none, whatever the bound."""
    with np.errstate(invalid="ignore"):
        return np.where(amount == 0, 0.0, amount * bound)
