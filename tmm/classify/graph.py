"""Materials from seeds, alone or with a library model: posteriors, spread over superpixels, at full resolution.

Seeds know the texture and a library knows the materials; what its classes represent is learned from the seeds too. The
product of their posteriors is pooled over superpixels, spread over their graph, and carried to the texels by a guided
filter (He, Sun and Tang 2013, IEEE TPAMI 35:1397-1409), whose coefficients are found on a coarse grid (He and Sun 2015,
arXiv:1505.00996).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.classify.mapper import Classified, without_data
from skyshine.tmm.classify.softmax import softmax_posterior
from skyshine.tmm.classify.superpixels import HOLD, Superpixels, find_superpixels
from skyshine.tmm.classify.trained import TYPICAL, TrainedModel
from skyshine.tmm.classify.translation import translated
from skyshine.tmm.classify.typicality import Everywhere, Typicality
from skyshine.tmm.features.colour import DistinctColours, to_coordinates, to_lab
from skyshine.tmm.features.light import guided_lines
from skyshine.tmm.features.textured import MARGIN, LightPlanes, features, names
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.job.materials import UNKNOWN

# Texels of the grid that superpixels are found on. On six aerial sheets four times as many change the accuracy by 0.001
# at most and take 2.5 times as long to survey, five times as long to solve.
GRID_TEXELS = 1 << 18
# Texels of the texture that features are computed of at a time; a strip as wide as a large texture would be mostly
# margin.
BAND_TEXELS, BAND_COLUMNS = 1 << 19, 1 << 11
BLOCK_TEXELS = 1 << 16  # block texels of the grid that a posterior is found of at a time
LEAST = 1e-4  # share that no material goes below
# What seeds may say least of a material: a normal distribution of one click is far surer than right. With one click a
# material on aerial sheets, 0.1 instead of LEAST took the mean IoU of superpixels from 0.56 to 0.59; with six it is
# alike.
DOUBT = 0.1
LEAST_OWN = 0.02  # that neither colour nor texture goes below, so that one does not overrule the other
# What seeds say, for each place of a material up to MANY, of what the library knows and none of them is. On twelve of
# those 25 aerial sheets 44 % of a material omitted are found with six clicks a class, beside 0.5 % of the others.
UNSEEN, MANY = 0.05, 6.0
# Weight of seeds of the class `unknown`, which may look like anything. On nine of those sheets six answers a class
# without it find 96 % of what is unknown and lose 5 % of the others; with it 88 and 1.4, without a library 71 and 1.1.
STRANGE = 0.1
LEAST_SPREAD = 1e-3  # smallest spread of a feature over a flat texture: far below any that is seen
# Share of the seeds in the product. The library learns from the seeds as well: with six clicks a material a share of
# 0.5 lowers the mean IoU on 46 aerial sheets, by which it was chosen, from 0.76 to 0.75, with two from 0.70 to 0.67.
SEEDS_SHARE = 0.3
# Power of the shares that makes them as sure as they are right: the product and the graph leave them too even. On those
# sheets the calibration error is 0.02, 0.03 and 0.03 with one, two and six clicks a material; without it 0.14, 0.16,
# 0.19.
SURER = 2.5
# Radius and spread of the guided filter: texels of the grid; CIELAB units below which L* is flat. On 25 aerial sheets a
# radius of 4 for 2 takes the mean IoU of six clicks a class from 0.572 to 0.583, with a library from 0.621 to 0.634; 6
# gains 0.005 more, but loses stems two texels wide: IoU of dead wood on the demo's photograph is 0.38, 0.22 and 0.1
# with 2, 4 and 6.
FILTER_RADIUS, FILTER_SPREAD = 4, 4.0
# The kinds of ground are not alike large. With n places of seeds a material their shares by a first estimate count as
# what is likely before (one damped step of Saerens, Latinne and Decaestecker 2002, Neural Computation 14:21-41), by the
# power (n - 1) / (n + EXTENT): on those sheets six clicks a class gain 0.016 of mean IoU, with a library 0.014.
EXTENT = 5.0
TYPICAL_RADIUS = 8  # texels of the box whose colour and contrast tell what is typical
REACH = 2 * FILTER_RADIUS  # reach of that filter: coefficients are means over means


@dataclass(frozen=True)
class Survey:
    """What is known of a texture before its seeds: features, superpixels and the library's posterior on a grid.

    step : int; the grid is every `step`-th row and column of the texture.
    stack : (F, h, w) float32; features, as of `features`.
    coordinates : (h, w, D) float32; as of `to_coordinates`.
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

    def posterior(self, model: GaussianModel) -> npt.NDArray[np.float64]:
        """Mean posterior (N, K) of a colour model over each superpixel."""

        def of(rows: slice) -> npt.NDArray[Any]:
            flat = self.coordinates[rows].reshape(-1, self.coordinates.shape[-1]).astype(np.float64)
            posterior: npt.NDArray[np.float64] = np.exp(model.log_posterior(model.squared_distance(flat)))
            return posterior

        return self.superpixels.mean(_planes(len(model.names), self.valid.shape, of))


def _planes(count: int, shape: tuple[int, int], of: Callable[[slice], npt.NDArray[Any]]) -> npt.NDArray[np.float32]:
    """Posterior (count, h, w) on a grid, made of blocks of rows (count, n) so that memory stays small."""
    planes = np.empty((count, *shape), np.float32)
    step = max(BLOCK_TEXELS // shape[1], 1)
    for top in range(0, shape[0], step):
        part = planes[:, top : top + step]
        part[...] = of(slice(top, top + step)).reshape(part.shape)
    return planes


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
    posterior = np.empty((len(superpixels.size), 0))
    if library is not None:
        network = library.network
        planes = _planes(
            len(library.names), valid.shape, lambda rows: network.posterior(stack[:, rows].reshape(len(stack), -1))
        )
        posterior = superpixels.mean(planes)
    return Survey(step, stack, coordinates, valid, superpixels, posterior)


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
    texels, inside = (part[::step, ::step] for part in texture.window(rows, columns))
    texels = np.where(inside[..., np.newaxis], texels, texels.dtype.type(0))
    coordinates = to_coordinates(texels.reshape(-1, texels.shape[2]), texture.encoding).astype(np.float32)
    return stack, coordinates.reshape(*texels.shape[:2], -1), inside


def clicks(label: npt.NDArray[Any], count: int) -> npt.NDArray[Any]:
    """Number (K,) of separate places with seeds of each of `count` materials; `label` (h, w) is -1 elsewhere."""
    from scipy.ndimage import label as connected

    eight = np.ones((3, 3), int)
    return np.array([connected(label == k, eight)[1] for k in range(count)])


class GraphMapper:
    """Seeds, alone or with a library, applied to a texture window by window."""

    def __init__(
        self,
        texture: Windowed,
        colours: DistinctColours,
        surveyed: Survey,
        model: GaussianModel,
        classes: npt.NDArray[np.float64],
        seeds: tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[np.bool_]],
        typicality: Typicality | Everywhere,
    ) -> None:
        """Solve for the superpixels' shares.

        surveyed : Survey
        model : GaussianModel; of the colours of the materials of the seeds.
        classes : (L, K) float64
            As of `and_unknown`: K are these materials, and `unknown` where a library knows others.
        seeds : (N,) arrays, four of them; as of `SeedTexels.drawn`.
        typicality : Typicality or Everywhere; of the boxes of the seeds.
        """
        self.names = (*model.names, UNKNOWN)[: classes.shape[1]]
        self._texture, self._colours = texture, colours
        self._typicality, self._step = typicality, surveyed.step
        palette = colours.colours
        self._lightness = None if palette is None else _lightness(palette, texture.encoding)
        shares = seed_shares(surveyed, model, classes, seeds)
        self._shares, self._label = np.ascontiguousarray(shares.T, np.float32), surveyed.superpixels.label
        self._guide = surveyed.stack[0].copy()  # so that the survey need not stay in memory

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        pixels, valid = self._texture.window(slice(top, bottom), slice(left, right))
        guide = self._guides(pixels, valid)
        best, total = np.full(valid.shape, -1, np.float32), np.zeros(valid.shape, np.float32)
        material = np.zeros(valid.shape, np.int16)
        for k, share in enumerate(self._filtered(guide, top, bottom, left, right)):
            total += share
            np.copyto(material, np.int16(k), where=share > best)
            np.maximum(best, share, out=best)
        typical = self._typicality.window(top, bottom, left, right)
        return without_data(Classified(material, np.divide(best, total, out=total), typical), valid)

    def _guides(self, pixels: npt.NDArray[Any], valid: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
        """L* (h, w) of the texels of a window."""
        colours, index = self._colours.of(pixels, valid)
        if colours is None and self._lightness is not None:
            return np.take(self._lightness, index)
        if colours is None:
            colours, index = self._colours.in_use(index)
        return np.take(_lightness(colours, self._texture.encoding), index)

    def _filtered(
        self, guide: npt.NDArray[np.float32], top: int, bottom: int, left: int, right: int
    ) -> Iterator[npt.NDArray[np.float32]]:
        """Share of each material in turn at the texels of a window, guided by their L*; they sum to about 1."""
        down = _between(top, bottom, self._step, self._guide.shape[0])
        across = _between(left, right, self._step, self._guide.shape[1])
        # The filter reaches two radii: the share of a texel depends on nothing beyond, whatever the window.
        rows, columns = (slice(max(line[0] - REACH, 0), line[-1] + 2 + REACH) for line, _ in (down, across))
        slopes, offsets = guided_lines(
            self._shares[:, self._label[rows, columns]], self._guide[rows, columns], FILTER_RADIUS, FILTER_SPREAD**2
        )
        down, across = (down[0] - rows.start, down[1]), (across[0] - columns.start, across[1])
        for slope, offset in zip(slopes, offsets, strict=True):
            share = _finer(slope, down, across)
            share *= guide
            share += _finer(offset, down, across)
            yield np.clip(share, LEAST, 1, out=share)


def _lightness(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float32]:
    return to_lab(colours[:, :3], encoding)[:, 0].astype(np.float32)


def seed_shares(
    surveyed: Survey,
    model: GaussianModel,
    classes: npt.NDArray[np.float64],
    seeds: tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[np.bool_]],
) -> npt.NDArray[np.float64]:
    """Share (N, K) of each material in each superpixel; K and the parameters as for `GraphMapper`."""
    superpixels, count = surveyed.superpixels, len(model.names)
    rows, columns, material, answered = seeds
    drawn = np.full(superpixels.label.shape, -1)
    drawn[rows // surveyed.step, columns // surveyed.step] = material
    areas = clicks(drawn, count)
    typical_areas = max(float(np.median(areas)), 1.0)
    likelihood = np.sqrt(
        np.maximum(surveyed.posterior(model), LEAST_OWN)
        * np.maximum(_textured(surveyed, drawn, model.log_prior, typical_areas), LEAST_OWN)
    )
    likelihood = np.maximum(
        likelihood / likelihood.sum(axis=1, keepdims=True), DOUBT if len(classes) else DOUBT / typical_areas
    )
    likelihood *= np.where(np.array(model.names) == UNKNOWN, STRANGE, 1.0)
    at, kind = superpixels.label[drawn >= 0], drawn[drawn >= 0]
    seeded = np.stack([np.bincount(at[kind == k], minlength=len(likelihood)) for k in range(count)], axis=1)
    # Places that were asked about lie where materials are contested, and a prior that the user states is theirs.
    power = 0.0 if answered.any() or np.ptp(model.log_prior) > 0 else (typical_areas - 1) / (typical_areas + EXTENT)
    shares = _spread(surveyed, likelihood, classes[:, :count], seeded, areas, power)
    if classes.shape[1] > count:
        # What no seed names is found beside the materials, but does not change which of them it is.
        likelihood = np.pad(likelihood, ((0, 0), (0, 1)), constant_values=UNSEEN * min(typical_areas, MANY))
        unseen = _spread(surveyed, likelihood, classes, np.pad(seeded, ((0, 0), (0, 1))), np.append(areas, 0), power)[
            :, -1:
        ]
        shares = np.column_stack([shares * (1 - unseen), unseen])
    return shares


def _spread(
    surveyed: Survey,
    likelihood: npt.NDArray[np.float64],
    classes: npt.NDArray[np.float64],
    seeded: npt.NDArray[Any],
    areas: npt.NDArray[Any],
    power: float,
) -> npt.NDArray[np.float64]:
    """Share (N, K) of each class by what seeds say (N, K), by the library's word and by the seeds' texels (N, K)."""
    superpixels, seed_texels = surveyed.superpixels, seeded.sum(axis=1)
    heard = seeded.T @ surveyed.library / np.maximum(seeded.sum(axis=0), 1)[:, np.newaxis]
    # Without a library the seeds say all.
    word = np.maximum(translated(surveyed.library, classes, heard, areas), LEAST) if len(classes) else likelihood
    unary = likelihood**SEEDS_SHARE * word ** (1 - SEEDS_SHARE)
    unary /= unary.sum(axis=1, keepdims=True)
    unary *= np.maximum(superpixels.size @ unary / superpixels.size.sum(), LEAST) ** power
    unary /= unary.sum(axis=1, keepdims=True)
    # A superpixel that seeds hardly touch may be of another material.
    hold = HOLD * np.minimum(2 * seed_texels / superpixels.size, 1)
    shares = superpixels.spread(unary, seeded / np.maximum(seed_texels, 1)[:, np.newaxis], hold)
    if len(classes):
        shares **= SURER
        shares /= shares.sum(axis=1, keepdims=True)
    return shares


def _textured(
    surveyed: Survey, drawn: npt.NDArray[Any], log_prior: npt.NDArray[np.float64], areas: float
) -> npt.NDArray[np.float64]:
    """Posterior (N, K) of each superpixel by colour and texture of the seeds, `drawn` (h, w) and -1 elsewhere."""
    mean = surveyed.superpixels.mean(surveyed.stack)
    spread = np.maximum(surveyed.stack.std(axis=(1, 2), dtype=np.float64), LEAST_SPREAD)
    middle = surveyed.superpixels.size @ mean / surveyed.superpixels.size.sum()
    seed_features = (surveyed.stack[:, drawn >= 0].T - middle) / spread
    return softmax_posterior(seed_features, drawn[drawn >= 0], log_prior, areas, (mean - middle) / spread)


def _between(start: int, stop: int, step: int, size: int) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Grid lines before the texels of a window, and how far each texel is on the way to the next."""
    position = np.minimum(np.arange(start, stop) / step, size - 1)
    line = np.minimum(position.astype(int), max(size - 2, 0))
    return line, (position - line).astype(np.float32)


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
