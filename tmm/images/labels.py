"""Label images: images whose colours name materials."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.raster import Raster
from skyshine.tmm.job.model import LabelImage

NONE = -1  # no label


class Labels:
    """A label image, read by rows.

    path : Path
    height, width : int
    """

    def __init__(self, labels: LabelImage, base_folder: Path, names: tuple[str, ...]) -> None:
        """Open the image; `names` are the materials that its palette's are counted among.

        Raises InputError: the image cannot be read, or cannot store a colour of the palette.
        """
        self.path = base_folder / labels.image
        self._raster = Raster(self.path, indices=all(key.isdecimal() for key in labels.palette))
        self.height, self.width = self._raster.height, self._raster.width
        grey, dtype = self._raster.channels < 3, self._raster.dtype
        if dtype.kind != "u" or (not grey and dtype != np.uint8):
            raise InputError(
                "the label image contains floats or 16 bit colours; allowed: 8 bit colours or a grey level",
                file=self.path,
            )
        self._channels = 1 if grey else 3
        self._colours = [(self._colour(key, grey), names.index(name)) for key, name in labels.palette.items()]

    def _colour(self, key: str, grey: bool) -> list[int]:
        if not key.startswith("#"):
            return [int(key)] * self._channels
        components = [int(key[i : i + 2], 16) for i in (1, 3, 5)]
        if grey and len(set(components)) > 1:
            raise InputError(
                f"the label image is grey and cannot store {key}; give grey levels in the palette", file=self.path
            )
        return components[: self._channels]

    def fits(self, height: int, width: int) -> Labels:
        """Itself, where the label image has the texture's size; else an InputError."""
        if (self.height, self.width) != (height, width):
            raise InputError(
                f"the label image is {self.width} x {self.height}; allowed: the texture's {width} x {height}",
                file=self.path,
            )
        return self

    def rows(self, start: int, stop: int) -> npt.NDArray[Any]:
        """Index of the material of each texel, (stop - start, width) int16; NONE where none is labelled."""
        values = self._raster.rows(start, stop)
        material = np.full(values.shape[:2], NONE, np.int16)
        for colour, number in self._colours:
            matches = values[..., 0] == colour[0]
            for i in range(1, self._channels):
                matches &= values[..., i] == colour[i]
            material[matches] = number
        return material
