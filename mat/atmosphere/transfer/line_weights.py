"""Weights of tabulated source functions in the light that the segments of a ray send to its observer.

Between the last scattering and the observer all extinction applies. Light that particles scatter straight forward into
the line of sight is what comes from the far end of a segment, less what all extinction leaves of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.directions import direction_weights
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts, through_three
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments, source_weights
from skyshine.schemas.arrays import Floats, Integers, Reals

# Below this optical depth a weight is summed as a series.
_THIN = 0.1
# Share of a layer's height below which a segment is level.
_LEVEL = 1e-9


@dataclass(frozen=True, eq=False)
class LineWeights:
    """Weights of a table in the light of a ray's segments, E of them, in the order of the table's places.

    Attributes
    ----------
    segment, place : (E,) int arrays
    weight : (E, P) array
    factor : (E, B) array
        Of the table's B functions of direction.
    """

    segment: Integers
    place: Integers
    weight: Reals
    factor: Floats

    def summed(self, values: Reals, segments: int) -> Reals:
        """Sum over the weights of each of so many segments, of values (E, ...)."""
        order = np.argsort(self.segment, kind="stable")
        found, start = np.unique(self.segment[order], return_index=True)
        result = np.zeros((segments, *values.shape[1:]), values.dtype)
        if found.size:
            result[found] = np.add.reduceat(values[order], start, axis=0)
        return result

    @classmethod
    def of(cls, segment: Integers, place: Integers, weight: Reals, factor: Floats) -> LineWeights:
        """Weights in any order."""
        order = np.argsort(place, kind="stable")
        return cls(segment[order], place[order], weight[order], factor[order])

    def by_place(self) -> Iterator[tuple[int, slice]]:
        """Each place with the part of the weights that is its own."""
        first = np.flatnonzero(np.diff(self.place, prepend=-1))
        for start, stop in zip(first, np.append(first[1:], self.place.size), strict=True):
            yield int(self.place[start]), slice(int(start), int(stop))


def source_weights_along(
    segments: Segments,
    depths: Depths,
    scaled: Depths,
    levels: Floats,
    extinction: Floats,
    parts: LayerParts,
    functions: Floats,
) -> LineWeights:
    """Weights of the source function of delta-scaled layers.

    Parameters
    ----------
    segments : Segments
    depths, scaled : Depths
        Of all extinction, and delta-scaled.
    levels : (N,) array
        Altitude, m.
    extinction : (N, P) array
        Delta-scaled, m^2 per molecule.
    parts : LayerParts
    functions : (K, B) array
        Functions of direction in the table, at each segment's.
    """
    cut = parts.count[segments.layer] > 1
    whole = np.flatnonzero(~cut)
    weight = np.concatenate(end_weights(segments, depths, scaled, levels, extinction, whole))
    segment, layer = np.tile(whole, 2), segments.layer[whole]
    places = np.concatenate([layer, layer + 1])
    if np.any(cut):
        inside = part_weights(segments, depths, scaled, levels, parts, np.flatnonzero(cut))
        both = zip((segment, places, weight), inside, strict=True)
        segment, places, weight = (np.concatenate(pair) for pair in both)
    return LineWeights.of(segment, places, weight, functions[segment])


def end_weights(
    segments: Segments, depths: Depths, scaled: Depths, levels: Floats, extinction: Floats, which: Integers
) -> tuple[Reals, Reals]:
    """Weights (T, P) of the source function at the lower and at the upper level of the layers of some segments (T,), of
    layers that are not cut; other arguments as of `source_weights_along`.
    """
    near, far = scaled.source_weights
    share = segments.upper_part(extinction, scaled.per_segment)
    transmittance = depths.transmittance
    climb = (0.5 * np.diff(segments.altitude) / np.diff(levels)[segments.layer]).astype(near.dtype)[:, None]
    if which.size < segments.index.size:
        near, far, share, transmittance, climb = (part[which] for part in (near, far, share, transmittance, climb))
    total = near + far
    # The source's mean counts each level by its extinction; its slope is limited so that no weight is negative.
    above = np.minimum(np.maximum(total * share + (far - near) * climb, 0), total)
    return (total - above) * transmittance, above * transmittance


def part_weights(
    segments: Segments, depths: Depths, scaled: Depths, levels: Floats, parts: LayerParts, which: Integers
) -> tuple[Integers, Integers, Reals]:
    """Segment (E,), place (E,) and weight (E, P) of the places inside the layers of some segments (T,), of cut layers;
    arguments as of `source_weights_along`.
    """
    segment, place, weight = _inside_parts(segments, scaled.per_segment, levels, parts, which)
    weight *= depths.transmittance[segment]
    return segment, place, weight


def _inside_parts(
    segments: Segments, depth: Reals, levels: Floats, parts: LayerParts, which: Integers
) -> tuple[Integers, Integers, Reals]:
    """Segment, place and weight of the places inside the layers of some segments (T,), at their near ends; `depth`
    (K, P) is the segments' optical depth.
    """
    layer = segments.layer[which]
    bottom, height = levels[layer], np.diff(levels)[layer]
    nearer, farther = (
        np.clip((part[which] - bottom) / height, 0.0, 1.0) for part in (segments.altitude[:-1], segments.altitude[1:])
    )
    edges, pair_places, pair_shares = parts.pairs
    low, high = layer + np.minimum(nearer, farther), layer + np.maximum(nearer, farther)
    first = np.searchsorted(edges, np.minimum(low, layer + 1 - _LEVEL) + _LEVEL, side="right") - 1
    count = np.maximum(np.searchsorted(edges, high - _LEVEL, side="left") - first, 1)
    row = np.repeat(np.arange(which.size), count)
    pair = first[row] + np.arange(row.size) - np.repeat(np.cumsum(count) - count, count)
    ends = np.maximum(low[row], edges[pair]) - layer[row], np.minimum(high[row], edges[pair + 1]) - layer[row]
    rises = (farther >= nearer)[row]
    begin, step = np.where(rises, *ends), np.where(rises, 1, -1) * (ends[1] - ends[0])
    whole = (farther - nearer)[row]
    level = np.abs(whole) < _LEVEL
    divisor = np.where(level, 1.0, whole)
    share = np.where(level, 1.0, step / divisor)[:, None]
    before = np.where(level, 0.0, (begin - nearer[row]) / divisor)[:, None]
    segment = which[row]
    along = depth[segment].astype(float)
    powers = np.stack(_power_weights(share * along), axis=1)  # (T, 3, P)
    weight = (through_three(pair_shares[pair], begin, step) @ powers) * np.exp(-before * along)[:, None]
    weight = weight.astype(depth.dtype, copy=False).reshape(-1, depth.shape[1])
    return np.repeat(segment, 3), pair_places[pair].ravel(), weight


def _power_weights(depth: Floats) -> tuple[Reals, Reals, Reals]:
    """What sources 1, u and u^2 send out of the near end, with u from 0 there to 1 at an optical depth."""
    near, far = source_weights(depth)
    thick = np.maximum(depth, _THIN)
    square = 2 * far / thick - np.exp(-depth)
    series = depth * (1 / 3 - depth * (1 / 4 - depth * (1 / 10 - depth * (1 / 36 - depth / 168))))
    return near + far, far, np.where(depth < _THIN, series, square)


def straight_weights(segments: Segments, depths: Depths, scaled: Depths, levels: Floats, angles: Floats) -> LineWeights:
    """Weights of the radiance at levels and directions, of light scattered straight forward. A place is a level times
    the number of directions plus the first of some neighbouring directions, the B functions. Arguments as
    `source_weights_along`; `angles` (X,) as in `directions.direction_weights`.
    """
    share, first, of_direction = straight_places(segments, levels, angles)
    some = [np.flatnonzero(part > _LEVEL) for part in (1 - share, share)]
    segment = np.concatenate(some)
    factor = of_direction[segment] * np.concatenate([(1 - share)[some[0]], share[some[1]]])[:, None]
    level = np.concatenate([segments.layer[some[0]], segments.layer[some[1]] + 1])
    return LineWeights.of(
        segment, level * angles.size + first[segment], straight_share(depths, scaled)[segment], factor
    )


def straight_share(depths: Depths, scaled: Depths) -> Reals:
    """Share (K, P) of the light at the far end of each segment that reaches the observer scattered straight forward."""
    left = scaled.per_segment
    share: Reals = np.exp(-left)
    share *= np.expm1(np.minimum(left - depths.per_segment, 0))
    share *= depths.transmittance
    return np.negative(share, out=share)


def straight_places(segments: Segments, levels: Floats, angles: Floats) -> tuple[Floats, Integers, Floats]:
    """Where in a table by level and direction the far ends of segments are: the share (K,) of the upper level, the
    first (K,) of some neighbouring directions and their weights (K, W); arguments as of `straight_weights`.
    """
    bottom, height = levels[segments.layer], np.diff(levels)[segments.layer]
    share = np.minimum(np.maximum((segments.altitude[1:] - bottom) / height, 0.0), 1.0)
    return share, *direction_weights(segments.upward_cosine, angles)
