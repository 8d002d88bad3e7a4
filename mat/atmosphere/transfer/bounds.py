"""Upper bounds of scattered radiance, from optical depths.

Path radiance is a weighted mean of the layers' source functions; the weights sum to at most 1, and each is at most the
absorptance of the layer along its longest chord. No line of sight is therefore brighter than the mean in which the
brightest source functions take their largest weights in turn until the sum is 1. A source function is at most the light
scattered once, at the largest value of the phase function, plus the single-scattering albedo times the radiance of the
brightest line of sight, which closes the bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import trace
from skyshine.schemas.arrays import Floats

_ENDS = np.s_[:-1], np.s_[1:]  # lower and upper level of each layer
_RAYLEIGH_PEAK = 1.5  # peak of `optics.rayleigh_phase`, straight forward and straight back, without depolarisation


@dataclass(frozen=True, eq=False)
class Scattering:
    """Largest scattered radiance of any line of sight through a state, at P points.

    Attributes
    ----------
    light : (P,) array
        Radiance of scattered light, of sky and path alike, per unit of the source's irradiance outside the atmosphere,
        sr^-1; infinite where no bound exists.
    """

    light: Floats

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
            field = _brightest(source, share, ground / np.pi) / (1 - _brightest(albedo, share, ground))
            return cls(_brightest(source + albedo * field, share))

    def radiance(self, irradiance: Floats, weight: Floats) -> Floats:
        """Bound (...) of a band's scattered light, W m^-2 sr^-1, for irradiances (..., P) and weights (P,)
        `BandPoints.radiance_weight`.
        """
        radiance: Floats = np.asarray(irradiance) * self.light @ weight
        return radiance


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
