"""Results of a classifier for each texel, and a colour model applied to a texture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import POSTERIOR_ONE, Cells, at_texels, averaged, strongest
from skyshine.tmm.classify.typicality import Everywhere, Typicality
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.images.texture import Windowed

TABLE_ENTRIES = 1 << 24  # posteriors of all distinct colours that are kept at hand: 170 MB
SAMPLES = 4  # samples of a box, on each side of its middle, at least


@dataclass(frozen=True)
class Classified:
    """What a classifier says of each texel.

    material : (h, w) int16; index into the names of the materials, -1 where there is no data or no material.
    confidence : (h, w) float32; posterior of that material averaged over the box; 0 without data.
    typicality : (h, w) float32
        With seeds, see `skyshine.tmm.classify.typicality.Typicality`. Else, of the material that a texel's colour is
        the most typical of, the share of its texels that would lie farther from its mean (upper tail of chi-squared),
        averaged over the box. 0 without data.
    """

    material: npt.NDArray[Any]
    confidence: npt.NDArray[np.float32]
    typicality: npt.NDArray[np.float32]


class Mapper(Protocol):
    """A way to find the material of the texels of one texture."""

    @property
    def names(self) -> tuple[str, ...]:
        """The materials; `Classified.material` counts among them."""

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify the texels of rows `top` to `bottom` and columns `left` to `right` (the ends excluded)."""


class ColourModel(Protocol):
    """What tells materials by colour alone."""

    @property
    def names(self) -> tuple[str, ...]:
        """The materials."""

    def tables(self, colours: npt.NDArray[Any], encoding: str) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Posterior and typicality of distinct colours; see `GaussianModel.tables`."""


class ColourMapper:
    """A colour model applied to a texture, window by window; each distinct colour is classified once.

    A box of many texels is averaged over a sample of them, every second row and column of radius 8, and found for as
    many: nine samples a side tell its mean as well as seventeen texels do.

    Without `tabulate` the colours of a window are classified for it alone: for a few small windows. Without
    `typicality`, of the boxes of seeds, it is that of the texels' colours by themselves, averaged over the box.
    """

    def __init__(
        self,
        texture: Windowed,
        colours: DistinctColours,
        model: ColourModel,
        radius: int,
        tabulate: bool = True,
        typicality: Typicality | Everywhere | None = None,
    ) -> None:
        self._typicality = typicality
        self.texture, self.model, self.names, self.radius = texture, model, model.names, radius
        self._step = max(radius // SAMPLES, 1)
        self._colours, palette = colours, colours.colours
        self._shared: tuple[npt.NDArray[Any], npt.NDArray[np.float32]] | None = None
        if tabulate and palette is not None and len(palette) * len(model.names) <= TABLE_ENTRIES:
            self._shared = model.tables(palette, texture.encoding)

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        step, reach = self._step, self.radius // self._step
        rows = Cells(top, bottom, self.texture.height, step, reach)
        columns = Cells(left, right, self.texture.width, step, reach)
        posterior, typicality, index, valid = self._sampled(rows.wide, columns.wide)
        inner = rows.inner, columns.inner
        if reach == 0:
            material, confidence = _strongest_colour(posterior, index)
        else:
            material, confidence = strongest((np.take(plane, index) for plane in posterior), valid, reach, inner)
        material, confidence = (at_texels(part, step, rows, columns) for part in (material, confidence))
        if self._typicality is not None:
            typical = self._typicality.window(top, bottom, left, right)
        else:
            typical = at_texels(averaged(np.take(typicality, index), valid, reach, inner), step, rows, columns)
        has_data = valid[inner] if step == 1 else self.texture.window(slice(top, bottom), slice(left, right))[1]
        return without_data(Classified(material, confidence, typical), has_data)

    def _sampled(
        self, rows: slice, columns: slice
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[np.bool_]]:
        """Tables of posterior and typicality, and of samples the colours' numbers in them, and validity."""
        step = self._step
        down, across = (
            slice(part.start * step, min(part.stop * step, size))
            for part, size in ((rows, self.texture.height), (columns, self.texture.width))
        )
        pixels, valid = (part[::step, ::step] for part in self.texture.window(down, across))
        colours, index = self._colours.of(pixels, valid)
        tables = self._shared
        if tables is None:
            if colours is None:
                colours, index = self._colours.in_use(index)
            tables = self.model.tables(colours, self.texture.encoding)
        return *tables, index.astype(np.intp, copy=False), valid  # numpy gathers faster by its own index type


def with_margin(
    texture: Windowed, top: int, bottom: int, left: int, right: int, margin: int
) -> tuple[slice, slice, tuple[slice, slice]]:
    """Rows and columns of a window with a margin, as far as the texture goes, and the window within them."""
    y, x = max(top - margin, 0), max(left - margin, 0)
    rows, columns = slice(y, min(bottom + margin, texture.height)), slice(x, min(right + margin, texture.width))
    return rows, columns, np.s_[top - y : bottom - y, left - x : right - x]


def without_data(classified: Classified, valid: npt.NDArray[np.bool_]) -> Classified:
    """Take the answer away, in place, from texels without data and from those that no material claims."""
    if not (classified.confidence.all() and valid.all()):
        empty = ~valid | (classified.confidence == 0)
        for array, nothing in ((classified.material, -1), (classified.confidence, 0), (classified.typicality, 0)):
            np.copyto(array, array.dtype.type(nothing), where=empty)
    return classified


def _strongest_colour(
    posterior: npt.NDArray[np.uint16], index: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Material of the largest posterior of each texel's own colour, and that posterior as float32."""
    material = posterior.argmax(axis=0).astype(np.int16)
    confidence = posterior.max(axis=0).astype(np.float32) / np.float32(POSTERIOR_ONE)
    return np.take(material, index), np.take(confidence, index)
