"""How typical a place of a texture is of the materials of its seeds, by the colour and the contrast of a box about it.

A material that has no seeds may have the mean colour of one that has; grass and a green roof differ by how much their
colours scatter. The box of a texel is described by the mean of L*a*b* and by its standard deviation; each material's
boxes are taken as normally distributed. A box on the border of two materials is like neither, so a texel takes the most
typical of the boxes that contain it, and of those one cell beyond (as Kuwahara et al. 1976 choose windows, in: Digital
Processing of Biomedical Images, Plenum).
"""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import Cells, at_texels
from skyshine.tmm.classify.gaussian import BLOCK_COLOURS, RELATIVE_FLOOR, GaussianModel
from skyshine.tmm.features.colour import DistinctColours, to_coordinates
from skyshine.tmm.features.textured import BRIGHT
from skyshine.tmm.images.texture import Windowed

# Within a material, over boxes of its seeds: standard deviation of the mean of L*, a*, b* (and of 100 NDVI, taken as
# b*), of the logarithm of 1 + their deviations, and the correlation of two of the latter. Roots of means over materials
# of aerial and drone photographs, those by which the threshold was chosen.
MEAN_SPREAD, CONTRAST_SPREAD, CONTRAST_CORRELATION = (8.4, 2.6, 4.0, 4.0), (0.46, 0.28, 0.29, 0.29), 0.55
PRIOR_REGIONS = 32.0  # that this prior counts as, of all materials together
OWN_REGIONS = 8.0  # at which a material's own covariance and the pooled one count alike
FINE = 256  # steps of a unit of CIELAB in the table of 8 bit colours, whose coordinates are all below 128
FLOOR = 0.01  # floor of the prior covariance, which no material's goes below, however many seeds are alike


class Boxes:
    """Mean and contrast of colour in boxes about the cells of a texture, squares of a few texels.

    cell : int; side of a cell in texels.
    reach : int; a box is its cell and as many cells to each side.
    around : int; a texel takes the most typical of the boxes of as many cells to each side of its own.
    rows, columns : int; of cells; those on the far edges may be cut.
    """

    def __init__(self, texture: Windowed, colours: DistinctColours, radius: int) -> None:
        self._texture, self._colours = texture, colours
        # A box has 100 cells of 2 x 2 samples or more, which tell its contrast to a tenth or better.
        self._step = max(radius // 4, 1)
        self.cell = 2 * self._step if radius >= 4 else 1
        self.reach = radius // self.cell
        self.around = self.reach + 1 if self.reach else 0
        self.height, self.width = texture.height, texture.width
        self.rows, self.columns = -(-texture.height // self.cell), -(-texture.width // self.cell)
        self._table = None if colours.colours is None else _tabulated(colours.colours, texture.encoding)

    @property
    def dimensions(self) -> int:
        """Number of features of a box."""
        return 2 * self._texture.channels

    def features(self, rows: slice, columns: slice) -> tuple[npt.NDArray[Any], npt.NDArray[np.bool_]]:
        """Features (2 D, h, w) float64 of the boxes about cells, and which of them have data, (h, w) bool."""
        wide = [
            slice(max(part.start - self.reach, 0), min(part.stop + self.reach, end))
            for part, end in ((rows, self.rows), (columns, self.columns))
        ]
        pad = [
            (self.reach - part.start + cells.start, self.reach + part.stop - cells.stop)
            for part, cells in zip((rows, columns), wide, strict=True)
        ]
        texels = [
            slice(cells.start * self.cell, min(cells.stop * self.cell, size))
            for cells, size in zip(wide, (self._texture.height, self._texture.width), strict=True)
        ]
        pixels, valid = self._texture.window(texels[0], texels[1])
        pixels, valid = pixels[:: self._step, :: self._step], valid[:: self._step, :: self._step]
        channels = self._texture.channels
        planes = np.empty((1 + self.dimensions, *valid.shape), np.float32)
        planes[0] = valid
        self._coordinates(pixels, valid, planes[1 : 1 + channels])
        np.square(planes[1 : 1 + channels], out=planes[1 + channels :])
        number, *sums = _box_sums(_cell_sums(planes, self.cell // self._step), pad, self.reach)
        filled = number > 0
        means = np.stack(sums) / np.maximum(number, 1)
        variance = np.maximum(means[channels:] - means[:channels] ** 2, 0)
        means[channels:] = np.log1p(np.sqrt(variance))
        return means, filled

    def _coordinates(
        self, pixels: npt.NDArray[Any], valid: npt.NDArray[np.bool_], into: npt.NDArray[np.float32]
    ) -> None:
        """Put the coordinates of texels into planes (D, h, w); 0 without data."""
        colours, index = self._colours.of(pixels, valid)
        index = index.astype(np.intp, copy=False)
        table: npt.NDArray[Any] | None = self._table
        scale = 1 / FINE
        if colours is not None:
            if colours.dtype.kind == "f":
                colours = np.clip(colours, -BRIGHT, BRIGHT)
            table, scale = to_coordinates(colours, self._texture.encoding).T, 1.0
        if table is None:
            raise ValueError("a texture without a table of its colours has none in common")
        for plane, column in zip(into, table, strict=True):
            np.multiply(np.take(column, index), scale, out=plane, casting="unsafe")
        if not valid.all():
            into *= valid


def _tabulated(colours: npt.NDArray[np.uint8], encoding: str) -> npt.NDArray[np.int16]:
    """Coordinates (D, U) of 8 bit colours (U, C), in units of 1 / FINE."""
    table = np.empty((colours.shape[1], len(colours)), np.int16)
    for start in range(0, len(colours), BLOCK_COLOURS):
        block = slice(start, start + BLOCK_COLOURS)
        table[:, block] = np.rint(FINE * to_coordinates(colours[block], encoding)).T
    return table


def _cell_sums(planes: npt.NDArray[np.float32], side: int) -> npt.NDArray[np.float64]:
    """Sums (P, h, w) over squares of `side` samples; those on the far edges may be cut."""
    if side > 1:
        if any(size % side for size in planes.shape[1:]):
            planes = np.pad(planes, ((0, 0), *((0, -size % side) for size in planes.shape[1:])))
        planes = reduce(np.add, (planes[:, k::side] for k in range(side)))
        planes = reduce(np.add, (planes[..., k::side] for k in range(side)))
    return planes.astype(np.float64)


def _box_sums(cells: npt.NDArray[np.float64], pad: list[tuple[int, int]], reach: int) -> npt.NDArray[np.float64]:
    """Sums over `reach` cells to each side, of cells (P, h, w) padded with nothing; not running, so that no window
    shows.
    """
    sums = np.pad(cells, ((0, 0), *pad))
    height, width = (size - 2 * reach for size in sums.shape[1:])
    sums = reduce(np.add, (sums[:, k : k + height] for k in range(2 * reach + 1)))
    sums = reduce(np.add, (sums[..., k : k + width] for k in range(2 * reach + 1)))
    return sums


def fit_boxes(features: npt.NDArray[np.float64], material: npt.NDArray[Any], region: npt.NDArray[Any]) -> GaussianModel:
    """A normal distribution of the features (M, F) of each material's boxes.

    Boxes of one region are alike: what is sure of a material grows with its regions, not with its boxes. Covariances
    are shrunk as those of colours are, see `skyshine.tmm.classify.gaussian.fit`, and spread by what the mean of few
    regions is off.
    """
    present, material = np.unique(material, return_inverse=True)
    count = len(present)
    boxes = np.bincount(material).astype(float)
    pairs = np.unique(np.stack([material, region]), axis=1)
    regions = np.bincount(pairs[0]).astype(float)[:, np.newaxis, np.newaxis]
    means = np.stack([np.bincount(material, column) / boxes for column in features.T], axis=1)
    residual = features - means[material]
    by_class = np.stack([residual[material == k].T @ residual[material == k] / boxes[k] for k in range(count)])
    prior = prior_covariance(features.shape[1] // 2)
    pooled = ((regions * by_class).sum(axis=0) + PRIOR_REGIONS * prior) / (regions.sum() - count + PRIOR_REGIONS)
    covariances = (regions * by_class + OWN_REGIONS * pooled) / (regions - 1 + OWN_REGIONS) * (1 + 1 / regions)
    # The second floor is as in `fit` of colours.
    covariances += FLOOR * prior
    trace = np.trace(covariances, axis1=1, axis2=2)[:, np.newaxis, np.newaxis]
    covariances += RELATIVE_FLOOR * trace * np.eye(features.shape[1])
    return GaussianModel(tuple(map(str, present)), means, covariances, np.full(count, -np.log(count)))


def prior_covariance(channels: int) -> npt.NDArray[np.float64]:
    """Covariance (2 D, 2 D) of the features of boxes within a material, before there are seeds, of D coordinates."""
    spread = np.diag((*MEAN_SPREAD[:channels], *CONTRAST_SPREAD[:channels]))
    correlation = np.eye(2 * channels)
    contrast = np.full((channels, channels), CONTRAST_CORRELATION)
    np.fill_diagonal(contrast, 1)
    correlation[channels:, channels:] = contrast
    covariance: npt.NDArray[np.float64] = spread @ correlation @ spread
    return covariance


class Typicality:
    """Typicality of the texels of a texture, window by window.

    Of the material that a box is most typical of, it is the share of the material's boxes that lie farther from their
    mean (upper tail of chi-squared), at the most typical box about the texel.
    """

    def __init__(self, boxes: Boxes, model: GaussianModel) -> None:
        self._boxes, self._model = boxes, model

    def window(self, top: int, bottom: int, left: int, right: int) -> npt.NDArray[np.float32]:
        """Typicality (bottom - top, right - left) of a window; 0 where no box has data."""
        from scipy.ndimage import minimum_filter1d
        from scipy.special import chdtrc

        boxes = self._boxes
        rows = Cells(top, bottom, boxes.height, boxes.cell, boxes.around)
        columns = Cells(left, right, boxes.width, boxes.cell, boxes.around)
        features, filled = boxes.features(rows.wide, columns.wide)
        nearest = self._model.squared_distance(features.reshape(len(features), -1).T).min(axis=0).reshape(filled.shape)
        nearest[~filled] = np.inf
        for axis in (0, 1):
            nearest = minimum_filter1d(nearest, 2 * boxes.around + 1, axis=axis, mode="nearest")
        share = chdtrc(boxes.dimensions, nearest[rows.inner, columns.inner]).astype(np.float32)
        return at_texels(share, boxes.cell, rows, columns)


class Everywhere:
    """Typicality where nothing becomes unknown by it: 1."""

    def window(self, top: int, bottom: int, left: int, right: int) -> npt.NDArray[np.float32]:
        """As of `Typicality`."""
        return np.ones((bottom - top, right - left), np.float32)
