"""Light scattered more than once inside the forward peak of particles, near Sun or Moon.

Delta-M lets the fraction f of the scattering go straight forward. `scattered_light` gives that light the directions
of one scattering, with the scaled extinction from the source to the observer, however often the peak scattered it.
Light scattered n times has the directions of n convolutions of the peak. The peak has the moments f as far as the
discrete ordinates have moments, and chi_l of the phase function beyond: convolved with what the ordinates solve, it
gives that again. So orders of the peak alone are missing. Their sum is the small-angle solution, in moments
exp(-p (1 - chi_l / f)), with p the optical depth of peak scattering from the source through the place of a scattering
to the observer: order n has the share of Poisson's law. Nakajima and Tanaka's correction contains its first two orders.

Light of a core narrower than the first step of `PHASE_ANGLES` goes straight on in these convolutions: rain and crystals
diffract half of their light into less than a tenth of a degree. Light that cores alone have scattered stays spread over
that step, as a triangle: what a pixel sees that is wider than the core. Sharp pictures of the Sun through rain need the
core itself, which is not resolved.

Limits: one scattering has the peak of its own place, all others that of the mean particle of the state. The line of
sight and the rays of the source are taken as one line, which they nearly are close to the source: the correction ends
between 20 and 40 degrees from it. Of a path that ends inside a cloud, each segment has a part of the light by its part
of p, as in first order. Below a p of 0.01 the correction fades out: at 0.005, where it is 0.25 % of light scattered
once, it is none, and most lines of sight through clear air need none of it.

The change varies smoothly with wavelength. It is computed at a few of the spectral points, those next to the
wavelengths of the phase functions among them, and is linear in the logarithm of wavenumber between them.

References
----------
Nakajima and Tanaka 1988, J. Quant. Spectrosc. Radiat. Transfer 40, 51 (first and second order).
Goudsmit and Saunderson 1940, Phys. Rev. 57, 24 (all orders, in moments).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial.legendre import legvander

from skyshine.mat.atmosphere.particles.moments import moment_weights
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, SpectralOptics
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths, SourceRays
from skyshine.schemas.arrays import Floats, Integers, Singles

# As many moments as the angles of the phase functions resolve.
_ORDERS = PHASE_ANGLES.size
# Angles from the source, degree: those of the phase functions where the peak is steep. Whole within the first limit,
# none beyond the second: at 3.85 um the peak of cloud droplets is as wide.
_WHOLE, _NONE = 20.0, 40.0
_DEGREES = np.array([*np.arange(0, 6, 0.5), 6, 7, 8, 10, 12, 14, 16, 18, 20, 22, 24, 27, 30, 33, 36, 40])
# Depths of peak scattering: below the first, the change is proportional to the depth; it is held beyond the last.
_DEPTHS = np.geomspace(1e-3, 100.0, 81)
# Depths of peak scattering, of which its second order is at most half: none below the first, whole above the second.
_THIN = (5e-3, 1e-2)
# Ratio of neighbouring wavenumbers at which the change is computed, at most.
_STEP = 1.02
# Fraction of the scattering below which it is no forward peak.
_SMALLEST = 1e-4


@cache
def _moment_weights() -> Floats:
    """Weights (moments, angles) of a phase function at `PHASE_ANGLES` in its Legendre moments."""
    return moment_weights(PHASE_ANGLES, _ORDERS)


@dataclass(frozen=True, eq=False)
class ForwardPeak:
    """What repeated scattering in the forward peak of particles changes of light scattered once.

    Attributes
    ----------
    fraction : (N, P) array
        `diffuse_field.delta_fraction`.
    solved : (2 n, N, C) array
        `diffuse_field.solved_moments`.
    limit : (N, C) array
        The next moment: `fraction` at the wavelengths of the phase functions.
    air : (N,) array
        Air of the vertical column, by level, molecules m^-2.
    rays : SourceRays
        Rays of the source's light.
    """

    optics: SpectralOptics
    fraction: Floats
    solved: Floats
    limit: Floats
    air: Floats
    rays: SourceRays

    @cached_property
    def few(self) -> Integers:
        """Spectral points (Q,) at which the change is computed, by wavenumber."""
        number, unique = np.unique(self.optics.wavenumber, return_index=True)
        coordinate = np.log(number / number[0]) / np.log(_STEP)
        targets = np.linspace(0, coordinate[-1], min(int(np.ceil(coordinate[-1])) + 1, number.size))
        nearest = np.abs(coordinate[:, None] - targets).argmin(axis=0)
        few: Integers = unique[np.union1d(nearest, self.optics.phase_share[:, unique].argmax(axis=1))]
        return few

    @property
    def degrees(self) -> Floats:
        """Angles of `mixed` from the source, degree, increasing."""
        return _DEGREES

    @property
    def limits(self) -> tuple[float, ...]:
        """The least depth of `mixed`, the logarithm of the ratio of its depths, the depths below which there is no
        change and above which it is whole, and the cosine of the angle beyond which there is none.
        """
        return _DEPTHS[0], np.log(_DEPTHS[1] / _DEPTHS[0]), *_THIN, np.cos(np.radians(_NONE))

    @cached_property
    def spread(self) -> tuple[Integers, Floats]:
        """The first of two of `few` between which all points (P,) lie in the logarithm of wavenumber, and the share
        (P,) of the second.
        """
        nodes, number = np.log(self.optics.wavenumber[self.few]), np.log(self.optics.wavenumber)
        position = np.interp(number, nodes, np.arange(nodes.size))
        lower = np.minimum(position.astype(int), max(nodes.size - 2, 0))
        return lower, position - lower

    @cached_property
    def scattering(self) -> Floats:
        """Scattering by the peak, (N, P) m^2 per molecule."""
        peak: Floats = self.optics.aerosol_scattering * self.fraction
        return peak

    @cached_property
    def paths(self) -> SourcePaths:
        """Paths of the source's light, through peak scattering alone at `few`."""
        return SourcePaths.of(self.rays, self.scattering[:, self.few])

    @cached_property
    def mixed(self) -> Singles:
        """`table` of the mixture of particles at `few`, (N, angles, depths, Q)."""
        share = self.optics.phase_share[:, self.few].astype(np.float32)
        mixed: Singles = np.tensordot(self.table, share, axes=(0, 0))
        return mixed

    @cached_property
    def table(self) -> Singles:
        """Change of the peak's phase function, of a mean of 1 over the sphere, (C, N, angles, depths)."""
        fraction = np.maximum(self.limit, _SMALLEST)
        phase, core = _without_core(self.optics.phase)
        wide = np.clip(np.tensordot(_moment_weights(), phase, axes=1), 0.0, None) / fraction
        core = np.minimum(core / fraction, 1.0)
        wide[: len(self.solved)] = 1.0
        wide[: len(self.solved)] -= core
        wide = np.minimum(wide, 1.0 - core)
        cosine = np.cos(np.radians(_DEGREES))
        legendre = legvander(cosine, _ORDERS - 1) * (2 * np.arange(_ORDERS) + 1)  # (angles, L)
        at_angles = np.interp(np.radians(_DEGREES), PHASE_ANGLES, np.arange(PHASE_ANGLES.size)).round().astype(int)
        truncated = np.tensordot(legendre[:, : len(self.solved)], self.solved - self.limit, axes=1)
        once = (phase[at_angles] - truncated) / fraction  # (angles, N, C)
        triangle = (_DEGREES == 0) / _moment_weights()[0, 0]
        weight = self._particles()
        change = np.empty((fraction.shape[1], fraction.shape[0], _DEGREES.size, _DEPTHS.size))
        for c, table in enumerate(change):
            mean, mean_core = (np.tensordot(part[..., c], weight[:, c], axes=1) for part in (wide, core))
            straight, rise = _orders(mean_core), _rise(mean_core)  # (depths,)
            bent = _orders(mean + mean_core) - straight  # (L, depths)
            # By angle what is linear in the wide part of the peak, in moments the rest, of which few are enough.
            both = wide[:, :, c] + core[:, c]  # (L, N)
            table[:] = np.tensordot(both[..., None] * legendre.T[:, None], bent, axes=(0, 0))
            one_bend = once[..., c] @ weight[:, c] - legendre @ mean  # (angles,)
            table += (core[:, c, None] * one_bend)[..., None] * rise
            excess = once[..., c].T + core[:, c, None] * triangle  # (N, angles)
            table += excess[..., None] * (straight - 1)
            # Light is never negative, whatever the series leaves between its waves.
            table[:] = np.maximum(table, -(self.optics.phase[at_angles, :, c] / fraction[:, c]).T[..., None])
        change *= _taper(_DEGREES)[:, None]
        change[(self.limit <= _SMALLEST).T] = 0.0
        return change.astype(np.float32)

    def _particles(self) -> Floats:
        """Share of the levels in peak scattering, (N, C)."""
        peak = self.air[:, None] * (self.optics.aerosol_scattering @ self.optics.phase_share.T) * self.limit
        total = peak.sum(axis=0)
        share: Floats = peak / np.where(total > 0, total, 1.0)
        return share


def _orders(moment: Floats) -> Floats:
    """Sum over n of Poisson's share of order n, over depth, times the power n - 1 of a moment of the peak: moments
    (...) of what follows one scattering, (..., depths).
    """
    moment = np.maximum(np.asarray(moment)[..., None], 1e-12)
    exponent = _DEPTHS * moment
    orders: Floats = np.exp(exponent - _DEPTHS) * -np.expm1(-exponent) / exponent
    return orders


def _rise(moment: Floats) -> Floats:
    """Derivative of `_orders` by the moment."""
    moment = np.maximum(np.asarray(moment)[..., None], 1e-6)
    rise: Floats = (np.exp(_DEPTHS * (moment - 1)) - _orders(moment[..., 0])) / moment
    return rise


def _without_core(phase: Floats) -> tuple[Floats, Floats]:
    """Phase functions (A, ...) at `PHASE_ANGLES` without their core, and the fraction of scattering (...) in it.

    A smooth peak is a parabola in the logarithm; what exceeds it at 0 is light of a narrower one.
    """
    smooth = phase[1] * np.clip(phase[1] / np.maximum(phase[2], 1e-30), 1.0, 1e3) ** (1 / 3)
    core = np.maximum(phase[0] - smooth, 0.0) * _moment_weights()[0, 0]
    return np.concatenate([np.minimum(phase[0], smooth)[None], phase[1:]]), core


def _taper(angle: Floats) -> Floats:
    """Share of the correction at angles [degree] from the source."""
    share = np.clip((angle - _WHOLE) / (_NONE - _WHOLE), 0.0, 1.0)
    taper: Floats = np.where(share < 1, np.cos(0.5 * np.pi * share) ** 2, 0.0)
    return taper
