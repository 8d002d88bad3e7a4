"""Results of a classifier for each texel, and a colour model applied to a texture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from skyshine.tmm.classify.box import POSTERIOR_ONE, averaged, pairs_of, strongest
from skyshine.tmm.classify.typicality import Typicality
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.images.texture import Windowed

TABLE_ENTRIES = 1 << 24  # posteriors of all distinct colours that are kept at hand: 170 MB


@dataclass(frozen=True)
class Classified:
    """What a classifier says of each texel.

    Attributes
    ----------
    material : (h, w) int16
        Index into the names of the materials, -1 where there is no data or no material.
    confidence : (h, w) float32
        Posterior of that material averaged over the box; 0 without data.
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
        typicality: Typicality | None = None,
    ) -> None:
        self._typicality = typicality
        self.texture, self.model, self.names, self.radius = texture, model, model.names, radius
        self._colours, shared = colours, colours.colours
        self._shared: tuple[npt.NDArray[Any], npt.NDArray[np.float32]] | None = None
        if tabulate and shared is not None and len(shared) * len(model.names) <= TABLE_ENTRIES:
            self._shared = self._prepared(shared)

    def _prepared(self, colours: npt.NDArray[Any]) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Posterior of colours, in pairs where it is to be averaged, and their typicality; of boxes, none."""
        posterior, typicality = self.model.tables(colours, self.texture.encoding)
        if self._typicality is not None:
            typicality = typicality[:0]
        return (pairs_of(posterior) if self.radius else posterior), typicality

    def window(self, top: int, bottom: int, left: int, right: int) -> Classified:
        """Classify a window; see `Mapper`."""
        posterior, typicality, index, valid, inner = self._looked_up(top, bottom, left, right)
        index = index.astype(np.intp, copy=False)  # numpy gathers faster by its own index type
        if self.radius == 0:
            material, confidence = _strongest_colour(posterior, index)
        else:
            gathered = (np.take(pair, index) for pair in posterior)
            material, confidence = strongest(gathered, len(posterior), valid, self.radius, inner)
        if self._typicality is None:
            typical = averaged(np.take(typicality, index), valid, self.radius, inner)
        else:
            typical = self._typicality.window(top, bottom, left, right)
        return without_data(Classified(material, confidence, typical), valid[inner])

    def _looked_up(self, top: int, bottom: int, left: int, right: int) -> tuple[Any, ...]:
        """Tables of posterior and typicality, and of a window with its margin the colours' numbers in them, validity,
        and where the window lies in it.
        """
        rows, columns, inner = with_margin(self.texture, top, bottom, left, right, self.radius)
        pixels, valid = self.texture.window(rows, columns)
        colours, index = self._colours.of(pixels, valid)
        if self._shared is None:
            if colours is None:
                colours, index = self._colours.in_use(index)
            posterior, typicality = self._prepared(colours)
        else:
            posterior, typicality = self._shared
        return posterior, typicality, index, valid, inner


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
        none = ~valid | (classified.confidence == 0)
        for array, nothing in ((classified.material, -1), (classified.confidence, 0), (classified.typicality, 0)):
            np.copyto(array, array.dtype.type(nothing), where=none)
    return classified


def _strongest_colour(
    posterior: npt.NDArray[np.uint16], index: npt.NDArray[Any]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """Material of the largest posterior of each texel's own colour, and that posterior as float32."""
    material = posterior.argmax(axis=0).astype(np.int16)
    confidence = posterior.max(axis=0).astype(np.float32) / np.float32(POSTERIOR_ONE)
    return np.take(material, index), np.take(confidence, index)
