"""Seeds and a library model together: the product of their posteriors, spread over superpixels, at full resolution.

Seeds know the texture and a library knows the materials; what its classes stand for is learned from the seeds too. What
they say together is pooled over superpixels, spread over their graph, and carried to the texels by a guided filter (He,
Sun and Tang 2013, IEEE TPAMI 35:1397-1409), whose coefficients are found on a coarse grid (He and Sun 2015,
arXiv:1505.00996).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import averaged
from skyshine.tmm.classify.mapper import TABLE_ENTRIES, Classified, with_margin, without_data
from skyshine.tmm.classify.superpixels import HOLD, Superpixels, find_superpixels
from skyshine.tmm.classify.trained import TYPICAL, TrainedModel
from skyshine.tmm.classify.translation import translated
from skyshine.tmm.classify.typicality import Typicality
from skyshine.tmm.features.colour import DistinctColours, to_coordinates, to_lab
from skyshine.tmm.features.textured import MARGIN, LightPlanes, features, names
from skyshine.tmm.images.texture import Windowed

GRID_TEXELS = 1 << 20  # of the grid that superpixels are found on
# Of the texture that features are computed of at a time; a strip as wide as a large texture would be mostly margin.
BAND_TEXELS, BAND_COLUMNS = 1 << 19, 1 << 11
BLOCK_TEXELS = 1 << 16  # of the grid that a posterior is found of at a time
LEAST = 1e-4  # share that no material goes below
# What seeds may say least of a material: a normal distribution of one click is far surer than right. With one click a
# material on aerial sheets, .1 instead of LEAST took the mean IoU of superpixels from .56 to .59; with six it is alike.
DOUBT = 0.1
# Share of the seeds in the product. The library learns from the seeds as well: with six clicks a material a share of .5
# lowers the mean IoU on 46 aerial sheets, by which it was chosen, from .76 to .75, with two from .70 to .67.
SEEDS_SHARE = 0.3
# Power of the shares that makes them as sure as they are right: the product and the graph leave them too even. On those
# sheets the calibration error is .02, .03 and .03 with one, two and six clicks a material; without it .14, .16, .19.
SURER = 2.5
FILTER_RADIUS, FILTER_SPREAD = 4, 4.0  # of the guided filter: texels of the grid; CIELAB units below which L* is flat
TYPICAL_RADIUS = 8  # texels of the box that typicality is averaged over, as the classifier's radius by default
REACH = 2 * FILTER_RADIUS  # of that filter: coefficients are means over means


@dataclass(frozen=True)
class Survey:
    """What is known of a texture before its seeds: features, superpixels and the library's posterior on a grid.

    Attributes
    ----------
    step : int
        The grid is every `step`-th row and column of the texture.
    stack : (F, h, w) float32
        Features, as of `features`.
    coordinates : (h, w, D) float32
        As of `to_coordinates`.
    valid : (h, w) bool
    superpixels : Superpixels
    library : (N, L) float64
        Mean posterior over each superpixel of the L classes of the library model; L is 0 without one.
    """

    step: int
    stack: npt.NDArray[np.float32]
    coordinates: npt.NDArray[np.float32]
    valid: npt.NDArray[np.bool_]
    superpixels: Superpixels
    library: npt.NDArray[np.float64]

    def posterior(self, model: TrainedModel) -> npt.NDArray[np.float64]:
        """Mean posterior (N, K) of a model over each superpixel."""
        return self.superpixels.mean(_posterior(model, self.stack, self.coordinates))


def _posterior(
    model: TrainedModel, stack: npt.NDArray[np.float32], coordinates: npt.NDArray[np.float32]
) -> npt.NDArray[Any]:
    """Posterior (K, h, w) float32 on a grid, in blocks so that memory stays small."""
    planes = np.empty((len(model.names), *stack.shape[1:]), np.float32)
    step = max(BLOCK_TEXELS // stack.shape[2], 1)
    for top in range(0, stack.shape[1], step):
        rows = slice(top, top + step)
        part = planes[:, rows]
        part[...] = model.posterior(stack[:, rows].reshape(len(stack), -1), _flat(coordinates[rows])).reshape(
            part.shape
        )
    return planes


def _flat(coordinates: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    return coordinates.reshape(-1, coordinates.shape[-1]).astype(np.float64)


def grid_step(texture: Windowed) -> int:
    """Rows and columns from one line of the grid of a survey to the next."""
    return int(np.ceil(np.sqrt(texture.height * texture.width / GRID_TEXELS)))


def survey(texture: Windowed, colours: DistinctColours, library: TrainedModel | None) -> Survey:
    """Read a texture once and find its superpixels and what a library model, if there is one, says of them."""
    step = grid_step(texture)
    shape, light = (-(-texture.height // step), -(-texture.width // step)), LightPlanes(texture, colours)
    stack, valid = np.empty((len(names()), *shape), np.float32), np.empty(shape, bool)
    coordinates = np.empty((*shape, texture.channels), np.float32)
    across = min(texture.width, BAND_COLUMNS // step * step)
    down = max(BAND_TEXELS // across // step, 1) * step
    for top, left in itertools.product(range(0, texture.height, down), range(0, texture.width, across)):
        rows, columns = slice(top, min(top + down, texture.height)), slice(left, min(left + across, texture.width))
        part = slice(top // step, (top + down) // step), slice(left // step, (left + across - 1) // step + 1)
        stack[(slice(None), *part)], coordinates[part], valid[part] = _surveyed(texture, light, rows, columns, step)
    superpixels = find_superpixels(stack[TYPICAL], stack)
    known = np.empty((len(superpixels.size), 0))
    if library is not None:
        known = superpixels.mean(_posterior(library, stack, coordinates))
    return Survey(step, stack, coordinates, valid, superpixels, known)


def _surveyed(
    texture: Windowed, light: LightPlanes, rows: slice, columns: slice, step: int
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]:
    """Features, coordinates and validity on the grid in a window, which begins on the grid."""
    wide, inner = [], []
    for part, size in ((rows, texture.height), (columns, texture.width)):
        before = min(-(-MARGIN // step) * step, part.start)  # whole steps, so that the grid goes on
        wide.append(slice(part.start - before, min(part.stop + MARGIN, size)))
        inner.append(slice(before // step, before // step + -(-(part.stop - part.start) // step)))
    stack = features(*light.window(wide[0], wide[1]), step)[(slice(None), *inner)]
    own, inside = (part[::step, ::step] for part in texture.window(rows, columns))
    own = np.where(inside[..., np.newaxis], own, own.dtype.type(0))
    coordinates = to_coordinates(own.reshape(-1, own.shape[2]), texture.encoding).astype(np.float32)
    return stack, coordinates.reshape(*own.shape[:2], -1), inside


def clicks(label: npt.NDArray[Any], count: int) -> npt.NDArray[Any]:
    """Number (K,) of separate places with seeds of each of `count` materials; `label` (h, w) is -1 elsewhere."""
    from scipy.ndimage import label as connected

    eight = np.ones((3, 3), int)
    return np.array([connected(label == k, eight)[1] for k in range(count)])


class CombinedMapper:
    """Seeds and a library together, applied to a texture window by window."""

    def __init__(
        self,
        texture: Windowed,
        colours: DistinctColours,
        surveyed: Survey,
        model: TrainedModel,
        classes: npt.NDArray[np.float64],
        seeds: tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]],
        tabulate: bool = True,
        typicality: Typicality | None = None,
    ) -> None:
        """Solve for the superpixels' shares.

        Parameters
        ----------
        surveyed : Survey
        model : TrainedModel
            Of the K materials of the seeds.
        classes : (L, K) float64
            As of `library_classes`.
        seeds : (N,) int, three of them
            Rows, columns and material of the seeds.
        typicality : Typicality or None
            Of the boxes of the seeds; None: that of the texels' colours by themselves, averaged over a box.
        """
        self._typicality = typicality
        self.names, self._texture, self._colours, self._step = model.names, texture, colours, surveyed.step
        self._model = model.colour
        self._shared: tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]] | None = None
        shared = colours.colours
        if tabulate and shared is not None and len(shared) * len(model.names) <= TABLE_ENTRIES:
            self._shared = self._tables(shared)
        shares = seed_shares(surveyed, model, classes, seeds)
        self._shares, self._label = np.ascontiguousarray(shares.T, np.float32), surveyed.superpixels.label
        self._guide = surveyed.stack[0].copy()  # so that the survey need not stay in memory

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        guide, typicality, valid, inner = self._looked_up(top, bottom, left, right)
        if self._typicality is None:
            typical = averaged(typicality, valid, TYPICAL_RADIUS, inner)
        else:
            typical = self._typicality.window(top, bottom, left, right)
        valid = valid[inner]
        best, total = np.full(valid.shape, -1, np.float32), np.zeros(valid.shape, np.float32)
        material = np.zeros(valid.shape, np.int16)
        for k, share in enumerate(self._filtered(guide, top, bottom, left, right)):
            total += share
            np.copyto(material, np.int16(k), where=share > best)
            np.maximum(best, share, out=best)
        return without_data(Classified(material, np.divide(best, total, out=total), typical), valid)

    def posterior(self, top: int, bottom: int, left: int, right: int) -> npt.NDArray[np.float32]:
        """Posterior of each material; see `Mapper`."""
        guide = self._looked_up(top, bottom, left, right)[0]
        share: npt.NDArray[np.float32] = np.stack(list(self._filtered(guide, top, bottom, left, right)))
        share /= share.sum(axis=0)
        return share

    def _looked_up(self, top: int, bottom: int, left: int, right: int) -> tuple[Any, ...]:
        """L* of a window; typicality (of colours) and validity of it with a margin, and where it lies in that."""
        rows, columns, inner = with_margin(self._texture, top, bottom, left, right, TYPICAL_RADIUS)
        pixels, valid = self._texture.window(rows, columns)
        colours, index = self._colours.of(pixels, valid)
        if colours is None and self._shared is not None:
            lightness, typicality = self._shared
        else:
            if colours is None:
                colours, index = self._colours.in_use(index)
            lightness, typicality = self._tables(colours)
        typical = np.take(typicality, index) if self._typicality is None else typicality
        return np.take(lightness, index[inner]), typical, valid, inner

    def _filtered(
        self, guide: npt.NDArray[np.float32], top: int, bottom: int, left: int, right: int
    ) -> Iterator[npt.NDArray[np.float32]]:
        """Share of each material in turn at the texels of a window, guided by their L*; they sum to about 1."""
        down = _between(top, bottom, self._step, self._guide.shape[0])
        across = _between(left, right, self._step, self._guide.shape[1])
        # The filter reaches two radii: the share of a texel depends on nothing beyond, whatever the window.
        rows, columns = (slice(max(line[0] - REACH, 0), line[-1] + 2 + REACH) for line, _ in (down, across))
        slopes, offsets = _guided(self._shares[:, self._label[rows, columns]], self._guide[rows, columns])
        down, across = (down[0] - rows.start, down[1]), (across[0] - columns.start, across[1])
        for slope, offset in zip(slopes, offsets, strict=True):
            share = _finer(slope, down, across)
            share *= guide
            share += _finer(offset, down, across)
            yield np.clip(share, LEAST, 1, out=share)

    def _tables(self, colours: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """L* (U,) of colours, and their typicality (U,); none where it is of boxes."""
        lightness = to_lab(colours[:, :3], self._texture.encoding)[:, 0].astype(np.float32)
        if self._typicality is not None:
            return lightness, np.empty(0, np.float32)
        return lightness, self._model.tables(colours, self._texture.encoding)[1]


def seed_shares(
    surveyed: Survey,
    model: TrainedModel,
    classes: npt.NDArray[np.float64],
    seeds: tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]],
) -> npt.NDArray[np.float64]:
    """Share (N, K) of each material in each superpixel."""
    superpixels, count = surveyed.superpixels, len(model.names)
    rows, columns, material = (seeds[0] // surveyed.step, seeds[1] // surveyed.step, seeds[2])
    drawn = np.full(superpixels.label.shape, -1)
    drawn[rows, columns] = material
    at, kind = superpixels.label[drawn >= 0], drawn[drawn >= 0]
    number = len(superpixels.size)
    known = np.stack([np.bincount(at[kind == k], minlength=number) for k in range(count)], axis=1)
    held, places = known.sum(axis=1), clicks(drawn, count)
    own = surveyed.posterior(model)
    if len(classes):
        heard = known.T @ surveyed.library / np.maximum(known.sum(axis=0), 1)[:, np.newaxis]
        word = np.maximum(translated(surveyed.library, classes, heard, places), LEAST)
        first = np.maximum(own, DOUBT) ** SEEDS_SHARE * word ** (1 - SEEDS_SHARE)
    else:  # without a library the seeds say all
        first = np.maximum(own, DOUBT / max(np.median(places), 1))
    first /= first.sum(axis=1, keepdims=True)
    # A superpixel that seeds hardly touch may be of another material.
    hold = HOLD * np.minimum(2 * held / superpixels.size, 1)
    shares = superpixels.spread(first, known / np.maximum(held, 1)[:, np.newaxis], hold)
    if len(classes):
        shares **= SURER
        shares /= shares.sum(axis=1, keepdims=True)
    return shares


def _guided(
    planes: npt.NDArray[np.float32], guide: npt.NDArray[np.float32]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Slopes and offsets (K, h, w) by which planes follow the guide (h, w)."""
    from scipy.ndimage import uniform_filter

    def mean(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        averaged: npt.NDArray[Any] = uniform_filter(values, 2 * FILTER_RADIUS + 1, mode="reflect", axes=(-2, -1))
        return averaged

    average, level = mean(guide), mean(planes)
    variance = np.maximum(mean(guide * guide) - average**2, 0) + np.float32(FILTER_SPREAD**2)
    slope = (mean(guide * planes) - average * level) / variance
    return mean(slope), mean(level - slope * average)


def _between(start: int, stop: int, step: int, size: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Grid lines before the texels of a window, and how far each texel is on the way to the next."""
    place = np.minimum(np.arange(start, stop) / step, size - 1)
    line = np.minimum(place.astype(int), max(size - 2, 0))
    return line, (place - line).astype(np.float32)


def _finer(
    plane: npt.NDArray[np.float32],
    down: tuple[npt.NDArray[Any], npt.NDArray[Any]],
    across: tuple[npt.NDArray[Any], npt.NDArray[Any]],
) -> npt.NDArray[np.float32]:
    """A plane of the grid at the texels of a window, linear between grid lines."""
    (row, lower), (column, right) = down, across
    cut = plane[row[0] : row[-1] + 2, column[0] : column[-1] + 2]
    above = row - row[0]
    below = np.minimum(above + 1, len(cut) - 1)
    rows = cut[above] + lower[:, np.newaxis] * (cut[below] - cut[above])
    before = column - column[0]
    after = np.minimum(before + 1, cut.shape[1] - 1)
    finer: npt.NDArray[np.float32] = rows[:, before] + right * (rows[:, after] - rows[:, before])
    return finer
