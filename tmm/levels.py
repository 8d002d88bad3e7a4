"""Mip levels: the share of each material in every texel of every level, counted in level 0.

Level k has floor(n / 2^k) texels a side, one at least. A texel of it covers an equal part of the image, whose border
may cut texels of level 0 where the size is no power of two; the shares are still exact, in integers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

WEIGHT_TOTAL = 65535  # the weights of a texel sum to this: three shares right to 1e-5
PERCENT = 100
COMPONENTS = 3


@dataclass(frozen=True)
class Level:
    """One mip level.

    Attributes
    ----------
    code : (h, w) uint16
        The material with the largest share; 0 where no texel below has a material.
    mix_code : (h, w, 3) uint16
        The three materials with the largest shares, largest first (the lower code first among equals); 0 where unused.
    mix_weight : (h, w, 3) uint16
        Their shares of the texels with a material, scaled to sum to `WEIGHT_TOTAL`.
    """

    code: np.ndarray
    mix_code: np.ndarray
    mix_weight: np.ndarray


def level_sizes(height: int, width: int) -> list[tuple[int, int]]:
    """Height and width of every level, from the image itself down to one texel."""
    number = max(height, width).bit_length()
    return [(max(height >> k, 1), max(width >> k, 1)) for k in range(number)]


def mip_levels(code: np.ndarray) -> list[Level]:
    """All levels of an image of material codes.

    Parameters
    ----------
    code : (H, W) uint16
        Material codes; 0 where there is none.
    """
    sizes = level_sizes(*code.shape)
    top = [(np.zeros((COMPONENTS, h * w), np.uint16), np.zeros((COMPONENTS, h * w), np.int64)) for h, w in sizes[1:]]
    for number in np.unique(code[code > 0]):
        counter = _Counter(code == number)
        for size, (codes, ranks) in zip(sizes[1:], top):
            _insert(codes, ranks, number, counter.coarser(size).ravel())
    return [_first_level(code)] + [_level(codes, ranks, size) for size, (codes, ranks) in zip(sizes[1:], top)]


class _Counter:
    """Counts one material in the texels of ever coarser levels."""

    def __init__(self, mask: np.ndarray):
        self._mask, self._columns = mask, None
        self._whole = mask.view(np.uint8)

    def coarser(self, size: tuple[int, int]) -> np.ndarray:
        """Counts in the texels of a level (h, w), in a unit that depends on the sizes alone.

        Where texels come together whole, the sums of a finer level serve as well as the image itself.
        """
        blocks = [length // parts for length, parts in zip(self._whole.shape, size)]
        if (blocks[0] * size[0], blocks[1] * size[1]) != self._whole.shape:
            return self._cut(size)
        counts = self._whole.astype(np.int32, copy=False)
        counts = sum(counts[start :: blocks[0]] for start in range(blocks[0]))
        self._whole = sum(counts[:, start :: blocks[1]] for start in range(blocks[1]))
        return self._whole

    def _cut(self, size: tuple[int, int]) -> np.ndarray:
        """Sums over equal parts of the image whose borders cut texels, int64, in units of 1 / (h w) of a texel."""
        if self._columns is None:
            self._columns = _running_sum(self._mask, 0)
        rows = _between(self._columns, 0, size[0])
        return _between(_running_sum(rows, 1), 1, size[1])


def _running_sum(counts: np.ndarray, axis: int) -> np.ndarray:
    """Sums before each border along an axis, one longer than `counts`, int64."""
    shape = [n + (i == axis) for i, n in enumerate(counts.shape)]
    total = np.zeros(shape, np.int64)
    if axis == 1:
        np.cumsum(counts, axis=1, out=total[:, 1:])
        return total
    for row in range(counts.shape[0]):  # many times faster than numpy's own cumsum down the columns
        np.add(total[row], counts[row], out=total[row + 1])
    return total


def _between(running: np.ndarray, axis: int, parts: int) -> np.ndarray:
    """Sums over equal parts of an axis, in units of 1 / parts; within a texel a running sum is linear."""
    length = running.shape[axis] - 1
    whole, rest = np.divmod(np.arange(parts + 1, dtype=np.int64) * length, parts)
    rest = rest.reshape((-1, 1) if axis == 0 else (1, -1))
    at = np.take(running, whole, axis) * (parts - rest)
    at += np.take(running, np.minimum(whole + 1, length), axis) * rest
    return np.diff(at, axis=axis)


def _insert(codes: np.ndarray, ranks: np.ndarray, code: int, counts: np.ndarray) -> None:
    """Put a material into the running ranks (3, N) where its count belongs; earlier materials win ties."""
    where = np.flatnonzero(counts)
    count = counts[where].astype(np.int64)
    code = np.full(count.shape, code, np.uint16)
    placed = np.zeros(count.shape, bool)
    for rank in range(COMPONENTS):
        old_count, old_code = ranks[rank][where], codes[rank][where]
        placed = placed | (count > old_count)  # below a material's place all others move down by one
        ranks[rank][where], codes[rank][where] = np.where(placed, count, old_count), np.where(placed, code, old_code)
        count, code = np.where(placed, old_count, count), np.where(placed, old_code, code)
        left = count > 0
        where, count, code, placed = where[left], count[left], code[left], placed[left]


def _first_level(code: np.ndarray) -> Level:
    mix_code, mix_weight = (np.zeros((*code.shape, COMPONENTS), np.uint16) for _ in range(2))
    mix_code[..., 0], mix_weight[..., 0] = code, WEIGHT_TOTAL
    return Level(code, mix_code, mix_weight)


def _level(codes: np.ndarray, ranks: np.ndarray, size: tuple[int, int]) -> Level:
    weights = integer_weights(ranks, WEIGHT_TOTAL).astype(np.uint16)
    codes[weights == 0] = 0
    mix_code, mix_weight = (np.ascontiguousarray(part.T).reshape(*size, COMPONENTS) for part in (codes, weights))
    return Level(mix_code[..., 0].copy(), mix_code, mix_weight)


def integer_weights(counts: np.ndarray, total: int) -> np.ndarray:
    """Shares in integers that sum to `total` exactly, by largest remainders (Hamilton's method).

    Parameters
    ----------
    counts : (3, N) int64
        Non-negative, in descending order; where all are 0 the first share takes everything.

    Returns
    -------
    (3, N) int64
    """
    weights = np.zeros_like(counts)
    weights[0] = total
    mixed = np.flatnonzero(counts[1])
    share, remainder = np.divmod(counts[:, mixed] * total, counts[:, mixed].sum(axis=0))
    missing = total - share.sum(axis=0)
    order = np.argsort(-remainder, axis=0, kind="stable")
    for rank in range(COMPONENTS - 1):
        receiver = order[rank : rank + 1]
        np.put_along_axis(share, receiver, np.take_along_axis(share, receiver, 0) + (missing > rank), 0)
    weights[:, mixed] = share
    return weights


def composites(levels: list[Level]) -> tuple[np.ndarray, np.ndarray]:
    """Distinct mixtures of all levels in whole percent, as exchange formats know them.

    Returns
    -------
    components : (N, 3) uint16
        Material codes, 0 where unused.
    weights : (N, 3) uint8
        They sum to 100.
    """
    packed = np.unique(np.concatenate([_packed_mixtures(level) for level in levels]))
    fields = [(packed >> np.uint64(shift)) & np.uint64(mask) for shift, mask in _FIELDS]
    components = np.stack(fields[:3], axis=1).astype(np.uint16)
    first, second = (field.astype(np.int64) for field in fields[3:])
    return components, np.stack([first, second, PERCENT - first - second], axis=1).astype(np.uint8)


_FIELDS = ((48, 0xFFFF), (32, 0xFFFF), (16, 0xFFFF), (8, 0xFF), (0, 0xFF))


def _packed_mixtures(level: Level) -> np.ndarray:
    """Distinct mixtures of a level, one integer each; the third weight follows from the others."""
    mixed = level.mix_weight[..., 1] > 0
    pure = np.unique(level.code[~mixed])
    codes = np.concatenate([level.mix_code[mixed], np.stack([pure, 0 * pure, 0 * pure], axis=1)]).T
    counts = np.concatenate([level.mix_weight[mixed], np.tile([[1, 0, 0]], (len(pure), 1))]).T.astype(np.int64)
    weights = integer_weights(counts, PERCENT)
    packed = np.zeros(codes.shape[1], np.uint64)
    for (shift, _), part in zip(_FIELDS, (*np.where(weights > 0, codes, 0), *weights[:2])):
        packed |= part.astype(np.uint64) << np.uint64(shift)
    return np.unique(packed)
