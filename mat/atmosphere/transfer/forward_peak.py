"""Light scattered more than once inside the forward peak of particles, near Sun or Moon.

Delta-M lets the fraction f of the scattering go straight forward. `single_scattering` gives that light the directions
of one scattering, with the scaled extinction from the source to the observer, however often the peak scattered it.
Light scattered n times has the directions of n convolutions of the peak. The peak has the moments f as far as the
discrete ordinates have moments, and chi_l of the phase function beyond: convolved with what the ordinates solve, it
gives that again. So orders of the peak alone are missing. Their sum is the small-angle solution, in moments
exp(-p (1 - chi_l / f)), with p the optical depth of peak scattering from the source through the place of a scattering
to the observer: order n has the share of Poisson's law. Nakajima and Tanaka's correction holds its first two orders.

Light of a core narrower than the first step of `PHASE_ANGLES` goes straight on in these convolutions: rain and crystals
diffract half of their light into less than a tenth of a degree. Light that cores alone have scattered stays spread over
that step, as a triangle: what a pixel sees that is wider than the core. Sharp pictures of the Sun through rain need the
core itself, which is not resolved.

Limits: one scattering has the peak of its own place, all others that of the mean particle of the state. The line of
sight and the rays of the source are taken as one line, which they nearly are close to the source: the correction ends
between 20 and 40 degrees from it. Of a path that ends inside a cloud, each segment has a part of the light by its part
of p, as in first order. Below a p of .01 the correction fades out: at .005, where it is .25 % of light scattered once,
it is none, and most lines of sight through clear air need none of it.

The change varies smoothly with wavelength. It is computed at a few of the spectral points, those next to the
wavelengths of the phase functions among them, and is linear in the logarithm of wavenumber between them.

References
----------
Nakajima and Tanaka 1988, J. Quant. Spectrosc. Radiat. Transfer 40, 51 (first and second order).
Goudsmit and Saunderson 1940, Phys. Rev. 57, 24 (all orders, in moments).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander

from skyshine.mat.atmosphere.particles.moments import moment_weights
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, SpectralOptics
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_paths import HIDDEN, SourcePaths, SourceRays
from skyshine.schemas.arrays import Booleans, Floats, Integers, Singles

# As many moments as the angles of the phase functions resolve.
_ORDERS = PHASE_ANGLES.size
_WEIGHTS = moment_weights(PHASE_ANGLES, _ORDERS)
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
_ONE_LINE = np.zeros(1, int)  # the first end of segments of one line alone


@dataclass(frozen=True, eq=False)
class ForwardPeak:
    """What repeated scattering in the forward peak of particles changes of light scattered once.

    Attributes
    ----------
    optics : SpectralOptics
    fraction : (N, P) array
        `diffuse_field.delta_fraction`.
    solved : (2 n, N, C) array
        `diffuse_field.solved_moments`.
    limit : (N, C) array
        The next moment: `fraction` at the wavelengths of the phase functions.
    air : (N,) array
        Of the vertical column, by level, molecules m^-2.
    rays : SourceRays
        Of the source's light.
    """

    optics: SpectralOptics
    fraction: Floats
    solved: Floats
    limit: Floats
    air: Floats
    rays: SourceRays

    def near(self, segments: Segments, to_source: Floats, deflection: Floats, first: Integers = _ONE_LINE) -> Booleans:
        """Which sources are so close to a line of sight, through so much peak scattering, that the peak matters: (L, S)
        of L joined lines whose first ends are (L,); other arguments as of `by_segment`.
        """
        near: Booleans = np.maximum.reduceat(deflection, first, axis=0) > np.cos(np.radians(_NONE))
        lines, sources = np.nonzero(near)
        if not lines.size or not np.any(self._peak):
            return np.zeros_like(near)
        last = np.append(first[1:], len(deflection)) - 1
        depth = np.maximum(
            *(
                self._source_depth(segments.altitude[end], to_source[end, sources][:, None])[:, 0]
                for end in (first[lines], last[lines])
            )
        )
        column = segments.column(self._peak[:, self._few])
        along = np.stack([column[start:stop].sum(axis=0) for start, stop in zip(first, last, strict=True)])
        near[lines, sources] = np.any(depth + along[lines] > _THIN[0], axis=1)
        return near

    def by_segment(
        self,
        segments: Segments,
        attenuation: Singles,
        to_source: Floats,
        deflection: Floats,
        first: Integers = _ONE_LINE,
    ) -> Singles:
        """Change of the light that each segment scatters to the observer.

        Parameters
        ----------
        segments : Segments
        attenuation : (K, S, P) array
            `single_scattering.segment_attenuation` without peak scattering.
        to_source, deflection : (K+1, S) arrays
            Cosines of the source's zenith angle and of the scattering angle at the segment ends.
        first : (L,) int array
            First end of each of L joined lines.

        Returns
        -------
        (K, S, P) array
            Per unit of the source's irradiance, sr^-1; single precision.
        """
        along = Depths(segments.column(self._peak[:, self._few]), first).cumulative.astype(np.float32)
        depth: Singles = along[:, None] + self._source_depth(segments.altitude, to_source)
        middle = (0.5 * (depth[1:] + depth[:-1])).astype(np.float32)
        light = self._scattered(segments, middle, 0.5 * (deflection[1:] + deflection[:-1]))
        light *= attenuation
        return light

    def at(self, point: Segments, altitude: float, to_source: Floats, deflection: Floats) -> Floats:
        """Change of the light that a short path at an altitude [m] scatters, (S, P) sr^-1, for cosines (S,).

        It is per unit of the source's light there that no more than the peak has scattered.
        """
        depth = self._source_depth(np.array([altitude]), to_source[None])
        change: Floats = self._scattered(point, depth, deflection[None])[0].astype(float)
        return change

    def _scattered(self, segments: Segments, depth: Singles, cosine: Floats) -> Singles:
        """Change of the light that segments scatter, without attenuation: of depths (K, S, Q) of peak scattering from
        source to observer and cosines (K, S) of the scattering angle, (K, S, P) sr^-1.
        """
        light = np.zeros((*cosine.shape, self._peak.shape[1]), np.float32)
        none, whole = (np.float32(bound) for bound in _THIN)
        share = np.clip((depth - none) / (whole - none), 0, 1) / np.float32(4 * np.pi)
        share *= np.minimum(depth / np.float32(_DEPTHS[0]), 1)
        place, turn, deep = self._places(segments.layer, depth, cosine)
        for air, step in ((segments.lower, 0), (segments.upper, 1)):
            amount: Singles = (air[:, None] * self._peak[segments.layer + step])[:, None].astype(np.float32)
            change = self._change(place + step * self._mixed[0].size, turn, deep)
            change *= share
            light += amount * (change @ self._spread)
        return light

    @cached_property
    def _few(self) -> Integers:
        """Spectral points (Q,) at which the change is computed, by wavenumber."""
        number, first = np.unique(self.optics.wavenumber, return_index=True)
        place = np.log(number / number[0]) / np.log(_STEP)
        wanted = np.linspace(0, place[-1], min(int(np.ceil(place[-1])) + 1, number.size))
        nearest = np.abs(place[:, None] - wanted).argmin(axis=0)
        few: Integers = first[np.union1d(nearest, self.optics.phase_share[:, first].argmax(axis=1))]
        return few

    @cached_property
    def _spread(self) -> Singles:
        """Weights (Q, P) of `_few` in all points: linear in the logarithm of wavenumber."""
        known, number = np.log(self.optics.wavenumber[self._few]), np.log(self.optics.wavenumber)
        place = np.interp(number, known, np.arange(known.size))
        spread: Singles = np.maximum(1 - np.abs(np.arange(known.size)[:, None] - place), 0.0).astype(np.float32)
        return spread

    @cached_property
    def _peak(self) -> Floats:
        """Scattering by the peak, (N, P) m^2 per molecule."""
        peak: Floats = self.optics.aerosol_scattering * self.fraction
        return peak

    @cached_property
    def _paths(self) -> SourcePaths:
        """Of the source's light, through peak scattering alone at `_few`."""
        return SourcePaths.of(self.rays, self._peak[:, self._few])

    def _source_depth(self, altitude: Floats, to_source: Floats) -> Singles:
        """Depth of peak scattering from the source to points (K,) [m], (K, S, Q); 0 where the Earth hides it."""
        depth = self._paths.optical_depth(altitude, to_source)
        depth[depth >= HIDDEN] = 0.0
        return depth

    def _places(self, level: Integers, depth: Singles, cosine: Floats) -> tuple[Integers, Singles, Singles]:
        """Where in `_mixed`, as numbers of its flat array, levels (K,), depths (K, S, Q) and scattering angles of
        cosines (K, S) lie: (K, S, Q), and shares of the next angle (K, S, 1) and of the next depth (K, S, Q).
        """
        angle = np.interp(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))), _DEGREES, np.arange(_DEGREES.size))
        direction = np.minimum(angle.astype(int), _DEGREES.size - 2)
        step = np.log(np.maximum(depth / np.float32(_DEPTHS[0]), 1))
        step /= np.float32(np.log(_DEPTHS[1] / _DEPTHS[0]))
        first = np.minimum(step.astype(int), _DEPTHS.size - 2)
        row = ((level[:, None] * _DEGREES.size + direction) * _DEPTHS.size)[..., None]
        place: Integers = (row + first) * depth.shape[2] + np.arange(depth.shape[2])
        return place, (angle - direction)[..., None].astype(np.float32), np.minimum(step - first, 1).astype(np.float32)

    def _change(self, place: Integers, turn: Singles, deep: Singles) -> Singles:
        """`_mixed` at places and shares of `_places`: (K, S, Q)."""
        points = deep.shape[2]
        at_angles = []
        for angle in (place, place + _DEPTHS.size * points):
            change = np.take(self._mixed, angle)
            change += (np.take(self._mixed, angle + points) - change) * deep
            at_angles.append(change)
        near, far = at_angles
        far -= near
        far *= turn
        near += far
        result: Singles = near
        return result

    @cached_property
    def _mixed(self) -> Singles:
        """`table` of the mixture of particles at `_few`, (N, angles, depths, Q)."""
        share = self.optics.phase_share[:, self._few].astype(np.float32)
        mixed: Singles = np.tensordot(self.table, share, axes=(0, 0))
        return mixed

    @cached_property
    def table(self) -> Singles:
        """Change of the peak's phase function, of a mean of 1 over the sphere, (C, N, angles, depths)."""
        fraction = np.maximum(self.limit, _SMALLEST)
        phase, core = _without_core(self.optics.phase)
        wide = np.clip(np.tensordot(_WEIGHTS, phase, axes=1), 0.0, None) / fraction
        core = np.minimum(core / fraction, 1.0)
        wide[: len(self.solved)] = 1.0
        wide[: len(self.solved)] -= core
        wide = np.minimum(wide, 1.0 - core)
        cosine = np.cos(np.radians(_DEGREES))
        legendre = legvander(cosine, _ORDERS - 1) * (2 * np.arange(_ORDERS) + 1)  # (angles, L)
        at_angles = np.interp(np.radians(_DEGREES), PHASE_ANGLES, np.arange(PHASE_ANGLES.size)).round().astype(int)
        known = np.tensordot(legendre[:, : len(self.solved)], self.solved - self.limit, axes=1)
        once = (phase[at_angles] - known) / fraction  # (angles, N, C)
        triangle = (_DEGREES == 0) / _WEIGHTS[0, 0]
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
            first = once[..., c].T + core[:, c, None] * triangle  # (N, angles)
            table += first[..., None] * (straight - 1)
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
    core = np.maximum(phase[0] - smooth, 0.0) * _WEIGHTS[0, 0]
    return np.concatenate([np.minimum(phase[0], smooth)[None], phase[1:]]), core


def _taper(angle: Floats) -> Floats:
    """Share of the correction at angles [degree] from the source."""
    share = np.clip((angle - _WHOLE) / (_NONE - _WHOLE), 0.0, 1.0)
    taper: Floats = np.where(share < 1, np.cos(0.5 * np.pi * share) ** 2, 0.0)
    return taper
