"""Seeds and a library model together: the product of their posteriors, spread over superpixels, at full resolution.

Seeds know the texture and a library knows the materials; the share of the seeds grows with their number. What they say
together is pooled over superpixels, spread over their graph, and carried to the texels by a guided filter (He, Sun and
Tang 2013, IEEE TPAMI 35:1397-1409), whose coefficients are found on a coarse grid (He and Sun 2015, arXiv:1505.00996).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import averaged
from skyshine.tmm.classify.mapper import TABLE_ENTRIES, Classified, with_margin, without_data
from skyshine.tmm.classify.superpixels import HOLD, Superpixels, find_superpixels
from skyshine.tmm.classify.trained import TYPICAL, TrainedModel
from skyshine.tmm.classify.typicality import Typicality
from skyshine.tmm.features.colour import DistinctColours, to_coordinates, to_lab
from skyshine.tmm.features.textured import MARGIN, LightPlanes, features, names
from skyshine.tmm.images.texture import Windowed

GRID_TEXELS = 1 << 20  # of the grid that superpixels are found on
# Of the texture that features are computed of at a time; a strip as wide as a large texture would be mostly margin.
BAND_TEXELS, BAND_COLUMNS = 1 << 19, 1 << 11
BLOCK_TEXELS = 1 << 16  # of the grid that a posterior is found of at a time
LEAST = 1e-4  # share that no material goes below
# What a library may say least of a material, so that it rules none out, as lakes where its photographs have none. On
# sheets by which it was chosen .03 instead of LEAST is alike (.1 is worse); on others two clicks a class reach a mean
# IoU of .661 for .577, six .769 for .687 (of superpixels).
RULED_OUT = 0.03
# What seeds may say least of a material: a normal distribution of one click is far surer than right. With one click a
# material on aerial sheets, .1 instead of LEAST took the mean IoU of superpixels from .56 to .59; with six it is alike.
DOUBT = 0.1
# Share of the seeds in the product with one click a material, and with more. Less (.15 and .3) is better on the aerial
# sheets that it was chosen on (mean IoU .68 against .67 with one click) and worse on others (.58 against .59).
FEW, MORE = 0.3, 0.5
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


def library_classes(
    classes: Sequence[str], materials: Sequence[str], groups: dict[str, str]
) -> npt.NDArray[np.float64]:
    """What share (L, K) of each class of a library model stands for each of the materials of seeds.

    A class stands for the material of its name; without one, for the materials of its group, alike: those that no class
    is named by, where there are any; else for none.

    Parameters
    ----------
    groups : dict of str to str
        Group of each material by name.
    """
    shares = np.zeros((len(classes), len(materials)))
    for i, name in enumerate(classes):
        if name in materials:
            shares[i, materials.index(name)] = 1
            continue
        group = [k for k, other in enumerate(materials) if groups[other] == groups.get(name)]
        alike = [k for k in group if materials[k] not in classes] or group
        shares[i, alike] = 1 / max(len(alike), 1)
    return shares


def clicks(label: npt.NDArray[Any], count: int) -> float:
    """Median over `count` materials of the number of separate places with seeds; `label` (h, w) is -1 elsewhere."""
    from scipy.ndimage import label as connected

    eight = np.ones((3, 3), int)
    return float(np.median([connected(label == k, eight)[1] for k in range(count)]))


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
        """L* of a window; typicality and validity of it with a margin, and where it lies in that."""
        rows, columns, inner = with_margin(self._texture, top, bottom, left, right, TYPICAL_RADIUS)
        pixels, valid = self._texture.window(rows, columns)
        colours, index = self._colours.of(pixels, valid)
        if colours is None and self._shared is not None:
            lightness, typicality = self._shared
        else:
            if colours is None:
                colours, index = self._colours.in_use(index)
            lightness, typicality = self._tables(colours)
        return np.take(lightness, index[inner]), np.take(typicality, index), valid, inner

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
        """L* (U,) of colours and their typicality (U,)."""
        lightness = to_lab(colours[:, :3], self._texture.encoding)[:, 0].astype(np.float32)
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
    places = clicks(drawn, count)
    weight, least = FEW if places < 1.5 else MORE, DOUBT
    if not classes.any():  # the library says nothing, the seeds say all
        weight, least = 1.0, DOUBT / max(places, 1)
    own = np.maximum(surveyed.posterior(model), least)
    first = own**weight * np.maximum(_named(surveyed.library, classes), RULED_OUT) ** (1 - weight)
    first /= first.sum(axis=1, keepdims=True)
    at, kind = superpixels.label[drawn >= 0], drawn[drawn >= 0]
    number = len(superpixels.size)
    known = np.stack([np.bincount(at[kind == k], minlength=number) for k in range(count)], axis=1)
    held = known.sum(axis=1)
    # A superpixel that seeds hardly touch may be of another material.
    hold = HOLD * np.minimum(2 * held / superpixels.size, 1)
    return superpixels.spread(first, known / np.maximum(held, 1)[:, np.newaxis], hold)


def _named(library: npt.NDArray[np.float64], classes: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The library's posterior (N, L) among the materials of the seeds, (N, K).

    Of materials that it does not know it says nothing: they have the mean share.
    """
    among = library @ classes
    known = classes.max(axis=0, initial=0) > 0
    among /= np.maximum(among.sum(axis=1, keepdims=True), LEAST)
    among *= known.mean()
    among[:, ~known] = 1 / len(known)
    return among


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
