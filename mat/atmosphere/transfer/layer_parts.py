"""Layers cut into parts, in which the source function of scattered light is quadratic in optical depth, and the places
at which it is tabulated.

A layer that scatters little stays whole: its source function lies between those at its two levels. Parts come in pairs,
and have the mean properties of their layer; a quadratic goes through the ends of each pair.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.schemas.arrays import Floats, Integers

# A layer that scatters more than the first of these optical depths is cut into an even number of parts, about as thin
# as the second, or into the most; those at its ends are the thinnest.
_EVEN, _PART, _MOST_PARTS = 0.01, 0.25, 16


@dataclass(frozen=True, eq=False)
class LayerParts:
    """How N-1 layers are cut.

    The parts have K+1 ends, from the ground up. A source function is tabulated at Q places: the N levels, then the ends
    of the parts of each layer that is cut.

    Attributes
    ----------
    count : (N-1,) int array
        Parts of each layer.
    """

    count: Integers

    @classmethod
    def of(cls, scattering: Floats, depth: Floats) -> LayerParts:
        """The parts of layers with these optical depths (N-1, P) of scattering and of extinction."""
        needed = np.max(np.where(scattering > _EVEN, np.sqrt(scattering * depth), 0.0), axis=1)
        return cls(np.clip(2 * np.ceil(needed / (2 * _PART)), 1, _MOST_PARTS).astype(int))

    @classmethod
    def whole(cls, layers: int) -> LayerParts:
        """So many layers that are not cut."""
        return cls(np.ones(layers, int))

    @cached_property
    def levels(self) -> Integers:
        """Places of the levels (N,) among the ends of the parts."""
        return np.append(0, np.cumsum(self.count))

    @cached_property
    def layer(self) -> Integers:
        """The layer of each part, (K,)."""
        return np.repeat(np.arange(self.count.size), self.count)

    @property
    def is_cut(self) -> bool:
        """Any layer is cut."""
        return self.layer.size > self.count.size

    def shares(self, layer: int) -> Floats:
        """Ends of a layer's parts, as shares of its optical depth from below."""
        count = self.count[layer]
        shares: Floats = 0.5 - 0.5 * np.cos(np.pi * np.arange(count + 1) / count)
        return shares

    @cached_property
    def edges(self) -> tuple[Floats, Floats]:
        """Lower and upper end of each part (K,), as shares of its layer's optical depth."""
        shares = [self.shares(layer) for layer in range(self.count.size)]
        return np.concatenate([part[:-1] for part in shares]), np.concatenate([part[1:] for part in shares])

    def between(self, at_levels: Floats) -> Floats:
        """A property (N, ...) at the ends of the parts (K+1, ...), linear in the optical depth of each layer."""
        if not self.is_cut:
            return at_levels
        low = self.edges[0].reshape(-1, *(1,) * (at_levels.ndim - 1))
        inside = at_levels[self.layer] * (1 - low) + at_levels[self.layer + 1] * low
        return np.concatenate([inside, at_levels[-1:]])

    @cached_property
    def inside(self) -> tuple[Integers, Integers]:
        """Of the places beyond the levels: the layer, and the end of a part."""
        layers = np.flatnonzero(self.count > 1)
        number = self.count[layers] + 1
        layer = np.repeat(layers, number)
        return layer, self.levels[layer] + np.arange(layer.size) - np.repeat(np.cumsum(number) - number, number)

    @cached_property
    def first_place(self) -> Integers:
        """Place of the lowest end inside each layer (N-1,); -1 in layers that are not cut."""
        result = np.full(self.count.size, -1)
        layer = self.inside[0]
        result[layer[::-1]] = self.count.size + 1 + np.arange(layer.size)[::-1]
        return result

    @property
    def places(self) -> int:
        """Q."""
        return self.count.size + 1 + self.inside[0].size

    @cached_property
    def pairs(self) -> tuple[Floats, Integers, Floats]:
        """Pairs of parts, from the ground up; a layer that is not cut counts as one.

        Returns
        -------
        edges : (J+1,) array
            Number of the layer plus share of its optical depth.
        places : (J, 3) int array
        shares : (J, 3) array
            Of the layer's optical depth, at these places.
        """
        edges, positions, shares = [], [], []
        for layer, (count, first_position) in enumerate(zip(self.count, self.first_place, strict=True)):
            ends = self.shares(layer) if count > 1 else np.array([0.0, 0.5, 1.0])
            start = np.arange(0, ends.size - 1, 2)
            edges.append(layer + ends[start])
            positions.append((first_position + start)[:, None] + np.arange(3))
            shares.append(ends[start[:, None] + np.arange(3)])
        return np.append(np.concatenate(edges), self.count.size), np.concatenate(positions), np.concatenate(shares)

    def at(self, layer: int, share: float) -> tuple[Integers, Floats]:
        """Places and their weights in a source function inside a layer, at a share of it from below."""
        if self.count[layer] == 1:
            return np.array([layer, layer + 1]), np.array([1 - share, share])
        edges, positions, shares = self.pairs
        pair = int(np.searchsorted(edges, layer + min(share, 1 - 1e-9), side="right")) - 1
        return positions[pair], through_three(shares[pair : pair + 1], np.array([share]), np.zeros(1))[0, :, 0]


def through_three(nodes: Floats, start: Floats, step: Floats) -> Floats:
    """Coefficients (T, 3, 3) of the powers 0 to 2 of u in each of three values' weights, of a quadratic through them.

    Parameters
    ----------
    nodes : (T, 3) array
        Points at which the values are known.
    start, step : (T,) arrays
        The quadratic is taken at start + u step.
    """
    result = np.empty((*nodes.shape, 3))
    for i in range(3):
        a, b = (nodes[:, (i + offset) % 3] for offset in (1, 2))
        divisor = (nodes[:, i] - a) * (nodes[:, i] - b)
        result[:, i] = np.stack([(start - a) * (start - b), step * (2 * start - a - b), step**2], axis=1)
        result[:, i] /= divisor[:, None]
    return result
