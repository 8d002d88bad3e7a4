"""The segments of a ray through the air: integrals along them, optical depths, thermal emission.

Thermal radiation has a source function linear in optical depth inside a segment (`thermal_source`). Without particles
it is the blackbody radiance of the air, and air of one temperature gives exactly (1 - transmittance) times that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Rays
from skyshine.schemas.arrays import Floats, Integers, Reals

# Below this optical depth the weight of a segment's far end is proportional to the depth, by type of number: a larger
# limit costs accuracy in thin segments (this fraction of that weight), a smaller one cancels digits.
_THIN = {np.dtype(np.float32): 1e-3, np.dtype(np.float64): 1e-6}
# From this many points on, adding row to row is quicker than numpy's running sum along the first axis.
_WIDE = 256


@dataclass(frozen=True, eq=False)
class Segments:
    """The K segments of one ray that contain air, or of several rays one after the other (`joined`).

    Attributes
    ----------
    index : (K,) int array
        Their place among the ray's segments.
    layer : (K,) int array
    lower, upper : (K,) arrays
        Air of the segments, as in `geometry.Rays`.
    altitude : (K+1,) array
        Altitude of the segment ends, m.
    central_angle, direction : (K+1,) arrays
        rad.
    distance : (K+1,) array
        Distance from the observer, m.
    """

    index: Integers
    layer: Integers
    lower: Floats
    upper: Floats
    altitude: Floats
    central_angle: Floats
    direction: Floats
    distance: Floats

    @classmethod
    def of(cls, rays: Rays, row: int) -> Segments:
        """The segments of one ray that are longer than 0."""
        index = np.flatnonzero(rays.lower[row] + rays.upper[row] > 0)
        rows: Integers | slice = index
        ends: Integers | slice = _ends(index)
        if index.size and index[-1] - index[0] < index.size:  # one after the other: no copies
            rows, ends = slice(index[0], index[-1] + 1), slice(index[0], index[-1] + 2)
        return cls(
            index,
            *(numbers[row][rows] for numbers in (rays.layer, rays.lower, rays.upper)),
            *(numbers[row][ends] for numbers in (rays.altitude, rays.central_angle, rays.direction, rays.distance)),
        )

    @classmethod
    def joined(cls, lines: Sequence[Segments]) -> tuple[Segments, Integers]:
        """The segments of L lines one after the other, a segment without air between neighbours, and the place of the
        first end of each line among their ends, (L,).
        """
        if len(lines) == 1:
            return lines[0], np.zeros(1, int)
        starts = np.concatenate([[0], np.cumsum([line.altitude.size for line in lines[:-1]])])

        def of_segments(name: str) -> Any:
            parts = [getattr(line, name) for line in lines]
            gap = np.zeros(1, parts[0].dtype)
            return np.concatenate([array for part in parts for array in (part, gap)][:-1])

        def of_ends(name: str) -> Floats:
            return np.concatenate([getattr(line, name) for line in lines])

        return cls(
            *(of_segments(name) for name in ("index", "layer", "lower", "upper")),
            *(of_ends(name) for name in ("altitude", "central_angle", "direction", "distance")),
        ), starts

    @property
    def ends(self) -> Integers:
        """Place of the segment ends among the ray's, (K+1,)."""
        return _ends(self.index)

    def first(self, count: int) -> Segments:
        """The `count` segments nearest the observer."""
        return Segments(
            self.index[:count],
            self.layer[:count],
            self.lower[:count],
            self.upper[:count],
            self.altitude[: count + 1],
            self.central_angle[: count + 1],
            self.direction[: count + 1],
            self.distance[: count + 1],
        )

    def within(self, distance: float) -> Segments:
        """The segments that end at most at a distance [m] that is a segment end of the ray."""
        return self.first(min(int(np.searchsorted(self.distance, distance)), self.index.size))

    def column(self, per_molecule: Reals) -> Reals:
        """Integral of a property (N, P) [m^2 per molecule] along each segment, (K, P), in the property's precision."""
        lower, upper = (air.astype(per_molecule.dtype, copy=False)[:, None] for air in (self.lower, self.upper))
        return lower * per_molecule[self.layer] + upper * per_molecule[self.layer + 1]

    @property
    def upper_share(self) -> Floats:
        """Share of each segment's air that counts with the upper level of its layer, (K,)."""
        air = self.lower + self.upper
        share: Floats = np.divide(self.upper, air, out=np.full(air.shape, 0.5), where=air > 0)
        return share

    def upper_part(self, per_molecule: Reals, column: Reals) -> Reals:
        """Part (K, P) of the integral `column` of a property (N, P) that counts with the upper level of each layer."""
        upper = self.upper.astype(per_molecule.dtype, copy=False)[:, None] * per_molecule[self.layer + 1]
        part: Reals = (upper / np.maximum(column, np.finfo(np.float32).tiny)).astype(column.dtype, copy=False)
        return part

    @property
    def upward_cosine(self) -> Floats:
        """Cosine of the angle from the vertical at which radiation travels towards the observer, (K,)."""
        zenith = self.direction - self.central_angle  # local, of the line of sight; radiation travels the other way
        cosine: Floats = -np.cos(0.5 * (zenith[1:] + zenith[:-1]))
        return cosine


def _ends(index: Integers) -> Integers:
    """Place of the ends of segments (K,) among those of their ray, (K+1,)."""
    return np.append(index, index[-1] + 1 if index.size else 0)


@dataclass(frozen=True, eq=False)
class Depths:
    """Optical depth along the segments of a ray; transmittance and source weights are computed from it once.

    Attributes
    ----------
    per_segment : (K, P) array
        Single or double precision.
    starts : (L,) int array
        First segment end of each line, of `Segments.joined`.
    """

    per_segment: Reals
    starts: Integers = field(default_factory=lambda: np.zeros(1, int))

    @cached_property
    def cumulative(self) -> Reals:
        """From the observer of each line to each segment end, (K+1, P)."""
        return self.summed(self.per_segment)

    def summed(self, by_segment: Reals) -> Reals:
        """Sum over the segments (K, P) from the observer of each line to each segment end, (K+1, P)."""
        result = np.zeros((len(by_segment) + 1, by_segment.shape[1]), dtype=by_segment.dtype)
        for start, stop in zip(self.starts, np.append(self.starts[1:], len(result)), strict=True):
            part, line = by_segment[start : stop - 1], result[start:stop]
            if by_segment.shape[1] < _WIDE:
                np.cumsum(part, axis=0, out=line[1:])
                continue
            for sum_before, segment, sum_after in zip(line[:-1], part, line[1:], strict=True):
                np.add(sum_before, segment, out=sum_after)
        return result

    def by_line(self, by_segment: Reals) -> Reals:
        """Sum over the segments (K, ...) of each line, (L, ...)."""
        stops = np.append(self.starts[1:], len(by_segment) + 1) - 1
        result: Reals = np.stack(
            [by_segment[start:stop].sum(axis=0) for start, stop in zip(self.starts, stops, strict=True)]
        )
        return result

    @cached_property
    def transmittance(self) -> Reals:
        """From the observer to the near end of each segment, (K, P)."""
        transmittance: Reals = np.exp(-self.cumulative[:-1])
        return transmittance

    @cached_property
    def source_weights(self) -> tuple[Reals, Reals]:
        """`source_weights` of the segments."""
        return source_weights(self.per_segment)


def source_weights(optical_depth: Reals) -> tuple[Reals, Reals]:
    """Weights of the source functions at the near and far end of segments, for a source linear in optical depth.

    Parameters
    ----------
    optical_depth : array
        0 to infinity; single or double precision.

    Returns
    -------
    near, far : arrays
        Their sum is 1 - exp(-optical_depth).
    """
    t = np.asarray(optical_depth)
    thin = t.dtype.type(_THIN[t.dtype])
    absorbed = np.expm1(-t)
    np.negative(absorbed, out=absorbed)
    far = np.maximum(absorbed, -np.expm1(-thin))  # at `thin` or more, where both terms below are safe
    far *= 1 + 1 / np.maximum(t, thin)
    far -= 1
    far *= np.minimum(t * (1 / thin), 1)
    return absorbed - far, far


def mean_attenuation(start: Floats, stop: Floats) -> Floats:
    """Mean of exp(-x) over segments in which x runs linearly from `start` to `stop`; same shapes.

    It is exp(-smaller) (1 - exp(-d)) / d with the difference d, exact to rounding at any d; the tiny number added to d
    makes it 1 at d = 0.
    """
    difference: Floats = np.subtract(stop, start)
    np.abs(difference, out=difference)
    difference += 1e-20
    mean: Floats = np.minimum(start, stop)
    np.exp(np.negative(mean, out=mean), out=mean)
    share = np.negative(difference)
    np.expm1(share, out=share)
    mean *= np.divide(share, difference, out=share)
    return np.negative(mean, out=mean)
