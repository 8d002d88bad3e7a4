"""Mip levels: the share of each material in every texel of every level, counted in level 0.

Level k has floor(n / 2^k) texels a side, one at least. A texel of it covers an equal part of the image, whose border
may cut texels of level 0 where the size is no power of two; the shares are still exact, in integers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

WEIGHT_TOTAL = 65535  # the weights of a texel sum to this: three shares right to 1e-5
PERCENT = 100  # confidence is stored in whole per cent
COMPONENTS = 3  # materials of a mixture at most, as the format has them
_MOST_BITS = 44  # largest number of bits of a count: three of them times WEIGHT_TOTAL stay below 2^63
PIECE_TEXELS = 1 << 17  # texels of a level worked out at a time


@dataclass(frozen=True)
class Level:
    """One mip level.

    code : (h, w) uint16; the material with the largest share; 0 where no texel below has a material.
    mix_code : (h, w, 3) uint16
        The three materials with the largest shares, largest first (the lower code first among equals); 0 where unused.
    mix_weight : (h, w, 3) uint16; their shares of the texels with a material, scaled to sum to `WEIGHT_TOTAL`.
    """

    code: npt.NDArray[np.uint16]
    mix_code: npt.NDArray[np.uint16]
    mix_weight: npt.NDArray[np.uint16]


def level_sizes(height: int, width: int) -> list[tuple[int, int]]:
    """Height and width of every level, from the image itself down to one texel."""
    number = max(height, width).bit_length()
    return [(max(height >> k, 1), max(width >> k, 1)) for k in range(number)]


class LevelStream:
    """Makes all levels of an image that comes in bands of rows, from the top to the bottom: of material codes, or of
    mixtures.
    """

    def __init__(self, height: int, width: int, codes: npt.NDArray[np.uint16]) -> None:
        """`codes` (K,) are the material codes that occur, in ascending order."""
        self._codes, self._sizes = codes, level_sizes(height, width)
        self._counters = [_Counter(self._sizes) for _ in codes]
        self._done = [0] * len(self._sizes)

    def add(self, code: npt.NDArray[np.uint16]) -> Iterator[tuple[int, int, Level]]:
        """Take the next rows of codes (n, W) uint16, 0 where there is none.

        Yields
        ------
        level, row : int; the level is 1 at least: `pure_level` is level 0.
        part : Level; rows of that level, from `row` on, that these rows of codes have completed.
        """
        return self._complete((code == number).view(np.uint8) for number in self._codes)

    def add_mixed(self, rows: Level) -> Iterator[tuple[int, int, Level]]:
        """Take the next rows of mixtures of level 0, as `add` takes codes; all rows come in one of these ways."""
        return self._complete(shares_of(rows, number) for number in self._codes)

    def _complete(self, planes: Iterable[npt.NDArray[Any]]) -> Iterator[tuple[int, int, Level]]:
        """Count planes (n, W), one for each material, and yield what they complete."""
        counted = [counter.add(plane) for plane, counter in zip(planes, self._counters, strict=True)]
        for level, parts in enumerate(zip(*counted, strict=True), start=1):
            height, width = parts[0].shape
            step = max(PIECE_TEXELS // width, 1)
            for top in range(0, height, step):
                yield level, self._done[level], ranked(self._codes, [counts[top : top + step] for counts in parts])
                self._done[level] += min(step, height - top)


def shares_of(level: Level, code: int) -> npt.NDArray[np.uint32]:
    """Share (h, w) of a material in each texel, of `WEIGHT_TOTAL`."""
    share: npt.NDArray[np.uint32] = np.where(level.mix_code == code, level.mix_weight, 0).sum(axis=-1, dtype=np.uint32)
    return share


def ranked(codes: npt.NDArray[np.uint16], counts: Iterable[npt.NDArray[Any]], total: int = WEIGHT_TOTAL) -> Level:
    """The mixtures of the three largest counts in each texel; where all are 0 there is no material.

    codes : (K,) uint16; ascending: the lower code comes first among equals.
    counts : iterable of (h, w) integer; for each material, not negative.
    total : int; shares are rounded to parts of it, by largest remainders; `WEIGHT_TOTAL` or a smaller number.
    """
    planes = [np.asarray(count) for count in counts]
    size = planes[0].shape
    flat = [plane.reshape(-1) for plane in planes]
    code, present = np.zeros(flat[0].size, np.uint16), np.zeros(flat[0].size, np.uint16)
    for number, count in zip(codes, flat, strict=True):
        has = (count > 0).view(np.uint8)
        present += has
        code += has * np.uint16(number)  # right where it is the only one
    mix_code, mix_weight = (np.zeros((code.size, COMPONENTS), np.uint16) for _ in range(2))
    mix_code[:, 0], mix_weight[:, 0] = code, WEIGHT_TOTAL
    # Most texels of a photograph have one material: the others alone are ranked.
    mixed = np.flatnonzero(present > 1)
    if len(mixed):
        # Shares of a level that cuts texels of a very large image are counted in units that times `total` pass 64 bits.
        wide = flat[0].dtype.itemsize == 8
        bits = max(int(count.max()) for count in flat).bit_length() - _MOST_BITS if wide else 0
        parts = (count[mixed].astype(np.int64) for count in flat)
        mix_code[mixed], mix_weight[mixed] = (part.T for part in _ranked(codes, parts, total, max(bits, 0)))
        code = mix_code[:, 0].copy()
    return Level(*(part.reshape(*size, *part.shape[1:]) for part in (code, mix_code, mix_weight)))


def _ranked(
    codes: npt.NDArray[np.uint16], counts: Iterable[npt.NDArray[np.int64]], total: int, shift: int
) -> tuple[npt.NDArray[np.uint16], npt.NDArray[np.uint16]]:
    """Codes (3, N) and weights (3, N) of the largest of counts (N,) that are not all 0 anywhere."""
    material_codes, ranks = np.empty(0, np.uint16), np.empty(0, np.int64)
    for number, count in zip(codes, counts, strict=True):
        if not ranks.size:
            ranks = np.zeros((COMPONENTS, count.size), np.int64)
            material_codes = np.zeros(ranks.shape, np.uint16)
        _insert(material_codes, ranks, number, count)
    ranks >>= shift
    weights = integer_weights(ranks, total)
    if total != WEIGHT_TOTAL:
        weights = integer_weights(weights, WEIGHT_TOTAL)
    material_codes[weights == 0] = 0
    return material_codes, weights.astype(np.uint16)


class _Counter:
    """Counts one material in the texels of ever coarser levels, as rows of level 0 come in.

    Where texels come together whole, the counts of a finer level serve for the coarser one; else borders of texels cut
    those of level 0, and running sums down the columns are read at these borders.
    """

    def __init__(self, sizes: list[tuple[int, int]]) -> None:
        height, width = sizes[0]
        self._steps: list[_Whole | _Cut] = []
        parent = sizes[0]
        for size in sizes[1:]:
            blocks = (parent[0] // size[0], parent[1] // size[1])
            if (blocks[0] * size[0], blocks[1] * size[1]) == parent:
                self._steps.append(_Whole(blocks, parent[1]))
                parent = size
            else:
                self._steps.append(_Cut(height, width, size))

    def add(self, plane: npt.NDArray[Any]) -> list[npt.NDArray[Any]]:
        """Counts of the completed rows of each level from 1, (n, w), in a unit that depends on the sizes alone.

        `plane` (n, W) contains uint8 that are 0 or 1, or uint32 shares.
        """
        counts, running, levels = plane, None, []
        for step in self._steps:
            if isinstance(step, _Whole):
                counts = step.add(counts)
                levels.append(counts)
            else:
                running = _running_sum(plane) if running is None else running
                levels.append(step.add(running))
        return levels


class _Whole:
    """Sums over blocks of whole texels."""

    def __init__(self, blocks: tuple[int, int], width: int) -> None:
        self._blocks = blocks
        self._pending: npt.NDArray[Any] = np.empty((0, width), np.uint8)  # takes the type of what follows

    def add(self, counts: npt.NDArray[Any]) -> npt.NDArray[Any]:
        high, wide = self._blocks
        if len(self._pending):
            counts = np.concatenate([self._pending, counts])
        complete = len(counts) // high * high
        self._pending = counts[complete:].copy()
        # A mask's sums fit 16 bits and sums of those 32, while a block has no more than 65,535 texels of its parent.
        small = high * wide < 1 << 16
        kind = np.dtype({1: np.uint16, 2: np.uint32}.get(counts.dtype.itemsize, np.int64) if small else np.int64)
        rows = reduce(np.add, (counts[start:complete:high].astype(kind) for start in range(high)))
        return reduce(np.add, (rows[:, start::wide] for start in range(wide)))


class _Cut:
    """Sums over equal parts of the image whose borders cut texels, in units of 1 / (h w) of a texel."""

    def __init__(self, height: int, width: int, size: tuple[int, int]) -> None:
        self._size = size
        self._border, self._cut = np.divmod(np.arange(1, size[0] + 1, dtype=np.int64) * height, size[0])
        self._next, self._rows = 0, 0
        self._sum, self._last = np.zeros(width, np.int64), np.zeros(width, np.int64)

    def add(self, running: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """`running` (n + 1, W) are the sums down the columns before each of the new rows and after them."""
        end = self._rows + len(running) - 1
        ready = int(np.searchsorted(self._border + (self._cut > 0), end, side="right"))
        border, cut = (part[self._next : ready] for part in (self._border, self._cut[:, np.newaxis]))
        at = running[border - self._rows].astype(np.int64) * (self._size[0] - cut)
        at += running[np.minimum(border + 1 - self._rows, len(running) - 1)] * cut
        at += self._sum * self._size[0]
        rows = np.diff(at, axis=0, prepend=self._last[np.newaxis])
        self._last = at[-1] if len(at) else self._last
        self._sum, self._rows, self._next = self._sum + running[-1], end, ready
        return _column_parts(rows, self._size[1])


def _running_sum(plane: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Sums down the columns before each row and after the last, (n + 1, W)."""
    total = np.zeros((len(plane) + 1, plane.shape[1]), np.int32 if plane.dtype == np.uint8 else np.int64)
    for row in range(len(plane)):  # many times faster than numpy's own cumsum down the columns
        np.add(total[row], plane[row], out=total[row + 1])
    return total


def _column_parts(rows: npt.NDArray[Any], parts: int) -> npt.NDArray[Any]:
    """Sums (n, parts) over equal parts of rows (n, W), in units of 1 / parts; within a texel a running sum is
    linear.
    """
    length = rows.shape[1]
    running = np.zeros((len(rows), length + 1), np.int64)
    np.cumsum(rows, axis=1, out=running[:, 1:])
    column, cut = np.divmod(np.arange(parts + 1, dtype=np.int64) * length, parts)
    at = np.take(running, column, 1) * (parts - cut)
    at += np.take(running, np.minimum(column + 1, length), 1) * cut
    return np.diff(at, axis=1)


def _insert(
    codes: npt.NDArray[np.uint16], ranks: npt.NDArray[np.int64], code: int, counts: npt.NDArray[np.int64]
) -> None:
    """Put a material into the running ranks (3, N) where its count belongs; earlier materials win ties."""
    where = np.flatnonzero(counts)
    count = counts[where].astype(np.int64)
    incoming = np.full(count.shape, code, np.uint16)
    shifted = np.zeros(count.shape, bool)
    for rank in range(COMPONENTS):
        old_count, old_code = ranks[rank][where], codes[rank][where]
        shifted = shifted | (count > old_count)  # below a material's place all others move down by one
        ranks[rank][where], codes[rank][where] = (
            np.where(shifted, count, old_count),
            np.where(shifted, incoming, old_code),
        )
        count, incoming = np.where(shifted, old_count, count), np.where(shifted, old_code, incoming)
        present = count > 0
        where, count, incoming, shifted = where[present], count[present], incoming[present], shifted[present]


def pure_level(code: npt.NDArray[np.uint16]) -> Level:
    """A level whose texels have one material each, of codes (h, w) uint16."""
    mix_code, mix_weight = (np.zeros((*code.shape, COMPONENTS), np.uint16) for _ in range(2))
    mix_code[..., 0], mix_weight[..., 0] = code, WEIGHT_TOTAL
    return Level(code, mix_code, mix_weight)


def integer_weights(counts: npt.NDArray[np.int64], total: int) -> npt.NDArray[Any]:
    """Shares in integers that sum to `total` exactly, by largest remainders (Hamilton's method).

    counts : (3, N) int64; non-negative, in descending order; where all are 0 the first share takes everything.
    """
    weights = np.zeros_like(counts)
    weights[0] = total
    mixed = np.flatnonzero(counts[1])
    share, remainder = np.divmod(counts[:, mixed] * total, counts[:, mixed].sum(axis=0))
    missing = total - share.sum(axis=0)
    # The rank of each remainder, the first largest; of equal ones the earlier comes first.
    upper, outer, lower = (remainder[i] >= remainder[j] for i, j in ((0, 1), (0, 2), (1, 2)))
    ranks = (~upper).astype(np.int8) + ~outer, upper.astype(np.int8) + ~lower, outer.astype(np.int8) + lower
    for part, rank in zip(share, ranks, strict=True):
        part += rank < missing
    weights[:, mixed] = share
    return weights


class Composites:
    """Collects the distinct mixtures of all levels in whole percent, as exchange formats know them."""

    def __init__(self) -> None:
        self._packed = np.empty(0, np.uint64)
        self._pending: list[npt.NDArray[np.uint64]] = []

    def add(self, level: Level, *, pure: bool = True) -> None:
        """Take the mixtures of rows of a level; without `pure`, those of two materials or three alone."""
        self._pending.append(_packed_mixtures(level, pure))
        if sum(map(len, self._pending)) > PIECE_TEXELS:
            self._merge()

    def _merge(self) -> None:
        self._packed = np.unique(np.concatenate([self._packed, *self._pending]))
        self._pending.clear()

    def mixtures(self) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Material codes (N, 3) uint16, 0 where unused, and their weights (N, 3) uint8, which sum to 100."""
        self._merge()
        fields = [(self._packed >> np.uint64(shift)) & np.uint64(mask) for shift, mask in _FIELDS]
        components = np.stack(fields[:3], axis=1).astype(np.uint16)
        largest, second = (field.astype(np.int64) for field in fields[3:])
        return components, np.stack([largest, second, PERCENT - largest - second], axis=1).astype(np.uint8)


_FIELDS = ((48, 0xFFFF), (32, 0xFFFF), (16, 0xFFFF), (8, 0xFF), (0, 0xFF))


def _packed_mixtures(level: Level, pure: bool) -> npt.NDArray[np.uint64]:
    """Mixtures of a level, one integer each; the third weight follows from the others."""
    mix_code, mix_weight = (part.reshape(-1, COMPONENTS) for part in (level.mix_code, level.mix_weight))
    two = mix_weight[:, 1] > 0
    mixed = np.flatnonzero(two)
    codes, counts = mix_code[mixed].T, mix_weight[mixed].T.astype(np.int64)
    if pure:
        single = np.unique(level.code.reshape(-1)[~two])
        codes = np.concatenate([codes, np.stack([single, 0 * single, 0 * single])], axis=1)
        counts = np.concatenate([counts, np.tile([[1], [0], [0]], len(single))], axis=1)
    weights = integer_weights(counts, PERCENT)
    packed = np.zeros(codes.shape[1], np.uint64)
    for (shift, _), part in zip(_FIELDS, (*np.where(weights > 0, codes, 0), *weights[:2]), strict=True):
        packed |= part.astype(np.uint64) << np.uint64(shift)
    return packed
