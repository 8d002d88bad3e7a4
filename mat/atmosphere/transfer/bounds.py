"""Upper bounds of what scattered light, and single kinds of particle, change in what is seen: from optical depths,
without transfer.

A line of sight is made of pieces, one a layer, and its radiance is the mean of their sources with shares that sum to at
most 1; no share is above what the layer absorbs and scatters along its longest chord. So no line is brighter than the
brightest sources filled in, share by share, until the sum is 1. A source is the light scattered once, at the largest
value of the phase function, and albedo times the brightest line, which that bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import trace
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, sections
from skyshine.mat.atmosphere.transfer.ordinate_light import straight_share
from skyshine.mat.atmosphere.transfer.two_stream_layers import vertical_column
from skyshine.mat.radiometry.blackbody import planck_wavenumber

_ENDS = np.s_[:-1], np.s_[1:]  # lower and upper level of each layer
_RAYLEIGH_PEAK = 1.5  # of `optics.rayleigh_phase`, straight on and straight back, without depolarisation
_PEAKS = 9  # wavelengths of a band at which the largest value of a phase function is looked for
_THIN = 1e-3  # mean vertical optical depth of particles that are worth a bound
REFERENCE = 300.0  # K, of what stands behind a line of sight


@dataclass(frozen=True, eq=False)
class Scattering:
    """What any line of sight through a state can gather, at P points.

    Attributes
    ----------
    light : (P,) array
        Radiance of scattered light, of sky and path alike, per unit of the source's irradiance outside the atmosphere,
        sr^-1; infinite where nothing bounds it.
    field : (P,) array
        The same with the ground, which reflects the source.
    gain : (P,) array
        Radiance of what is scattered into a line, per mean radiance over all directions.
    """

    light: np.ndarray
    field: np.ndarray
    gain: np.ndarray

    @classmethod
    def of(cls, air) -> Scattering:
        """Those of an `air.SpectralAir`."""
        optics, ground = air.optics, air.state.surface_albedo
        share = -np.expm1(-_chords(air) * _either(optics.extinction))
        whole = optics.rayleigh + optics.aerosol_scattering
        with np.errstate(divide="ignore", over="ignore"):
            scaled = optics.extinction - optics.aerosol_scattering * straight_share(optics)
            peak = _either(optics.phase.max(axis=0) @ optics.phase_share)
            single = np.maximum(
                *(
                    (_RAYLEIGH_PEAK * optics.rayleigh[end] + peak * optics.aerosol_scattering[end]) / scaled[end]
                    for end in _ENDS
                )
            )
            albedo = _either(whole / optics.extinction)
            once = single / (4 * np.pi)
            again = 1 / (1 - _brightest(albedo, share, ground))
            field = _brightest(once, share, ground / np.pi) * again
            light = _brightest(once + albedo * field, share)
        return cls(light, field, _brightest(single, share) * again)

    def radiance(self, irradiance, weight):
        """Bound of a band's scattered light, W m^-2 sr^-1, for irradiances (..., P) and weights (P,)
        `BandPoints.radiance_weight`.
        """
        return np.asarray(irradiance) * self.light @ weight


@dataclass(frozen=True, eq=False)
class Bounds:
    """Most that leaving something out changes in the radiance that is seen in a band, W m^-2 sr^-1.

    Attributes
    ----------
    scattered : (B,) array
        Light of each source that air, particles and ground scatter into paths and sky.
    particles : (K,) array
        Each of `AtmosphericState.particles`.
    """

    scattered: np.ndarray
    particles: np.ndarray

    @classmethod
    def of(cls, air, grid, irradiance, weight) -> Bounds:
        """Bounds of an `air.SpectralAir` on a `path_grid.PathGrid`, for the irradiance (B, P) of sources; `weight` as
        `Scattering.radiance`.
        """
        scattering = Scattering.of(air)
        return cls(
            scattering.radiance(irradiance, weight),
            particle_bounds(air, scattering, table_lines(air, grid), irradiance.sum(axis=0), weight),
        )


def particle_bounds(air, scattering, lines, irradiance, weight):
    """Most that leaving out each kind of particle changes in transmitted, path, sky and direct radiance of a band.

    What the particles take from a line of sight and add to it is at most their share of it times the brightest radiance
    there is; what others then scatter differently follows from the mean over all directions.

    Parameters
    ----------
    air : air.SpectralAir
    scattering : Scattering
        Of that air.
    lines : (M, N) array
        Air of the lines of sight of a table, molecules m^-2, by the level whose properties it counts with.
    irradiance : (P,) array
        Of all sources together, W m^-2 (cm^-1)^-1.
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


def _of_particle(air, component, scattering, lines, irradiance, weight):
    state, optics = air.state, air.optics
    dims, scatters, _ = sections(state, component, optics.wavenumber)
    upright = np.sum(vertical_column(air.shells, dims), axis=0)
    if upright @ weight > _THIN * weight.sum():
        return np.inf
    nodes = np.geomspace(optics.wavenumber.min(), optics.wavenumber.max(), _PEAKS)
    peaks = component.model.phase_function(np.cos(PHASE_ANGLES), nodes, state.relative_humidity).max(axis=(0, 2))
    peak = np.max(scatters / np.where(dims > 0, dims, 1.0) * peaks[:, None], axis=0)
    warmest = max(state.temperature.max(), state.surface_temperature, REFERENCE)
    bright = planck_wavenumber(optics.wavenumber, warmest) + irradiance * (scattering.field + peak / (4 * np.pi))
    longest = np.maximum(_longest(air, dims), upright)
    thin = np.where(upright > 0, upright, 1.0)
    mean = np.minimum(upright * (1 + np.log(np.maximum(longest / thin, 1.0))), 1.0)
    again = scattering.gain * (bright * mean - irradiance * np.expm1(-longest) / (4 * np.pi))
    along = np.max(-np.expm1(-lines @ dims) @ (weight * bright), initial=0.0) if len(lines) else 0.0
    sky = np.minimum(2 * upright, 1.0) * bright @ weight
    rays = air.source_rays.air
    through = np.exp(-np.maximum(rays @ (optics.extinction - dims), 0.0))
    direct = np.max((-np.expm1(-rays @ dims) * through) @ (weight * irradiance)) / np.pi
    return float(max(along + again @ weight, sky + again @ weight, direct))


def _longest(air, section):
    """Optical depth (P,) of the longest line through a section (N, P), level somewhere."""
    levels = air.shells.altitude
    rays = trace(air.shells, levels[:-1], np.zeros(levels.size - 1))
    through = 2 * (by_level(rays.layer, rays.lower, rays.upper, levels.size) @ section)
    above = np.concatenate([through[1:], np.zeros((1, through.shape[1]))])
    return np.max(_chords(air) * _either(section) + above, axis=0)


def by_level(layer, lower, upper, count):
    """Air (M, count) of rays by level, from the layer (M, K) of each segment and what counts with its two levels, (M,
    K) each.
    """
    air = np.zeros((len(layer), count))
    row = np.arange(len(layer))[:, None]
    np.add.at(air, (row, layer), lower)
    np.add.at(air, (row, layer + 1), upper)
    return air


def table_lines(air, grid):
    """Air (M, N) of the lines of sight of a table, to the longest range, as `particle_bounds` takes it; of a
    `path_grid.PathGrid`.
    """
    altitude, elevation = (
        a.ravel() for a in np.meshgrid(grid.altitude_km * 1e3, np.radians(grid.elevation_deg), indexing="ij")
    )
    rays = trace(air.shells, altitude, elevation, np.full((altitude.size, 1), grid.range_km[-1] * 1e3))
    before = rays.distance[:, 1:] <= grid.range_km[-1] * 1e3 * (1 + 1e-9)
    return by_level(rays.layer, rays.lower * before, rays.upper * before, air.shells.altitude.size)


def _either(values):
    """The larger of a property's (N, ...) values at the two levels of each layer."""
    return np.maximum(*(values[end] for end in _ENDS))


def _chords(air):
    """Air on the longest way through each layer, (N-1, 1) molecules m^-2: the ray that is level at its lower level, to
    both sides.
    """
    levels = air.shells.altitude
    rays = trace(air.shells, levels[:-1], np.zeros(levels.size - 1))
    inside = rays.layer == np.arange(levels.size - 1)[:, None]
    return 2 * np.sum((rays.lower + rays.upper) * inside, axis=1)[:, None]


def _brightest(source, share, ground=None):
    """Most that a line gathers from sources (L, P), none by more than its share (L, P) and all by 1; of a ground by
    what is left.
    """
    if ground is not None:
        source = np.concatenate([source, np.full((1, source.shape[1]), ground)])
        share = np.concatenate([share, np.ones((1, share.shape[1]))])
    order = np.argsort(-source, axis=0, kind="stable")
    filled = np.minimum(np.cumsum(np.take_along_axis(share, order, axis=0), axis=0), 1.0)
    taken = np.diff(filled, axis=0, prepend=0.0)
    return np.sum(taken * np.where(taken > 0, np.take_along_axis(source, order, axis=0), 0.0), axis=0)
