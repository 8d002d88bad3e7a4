"""Colour as CIE L*a*b* (D65), computed once for each distinct colour of a texture."""

from __future__ import annotations

import numpy as np

from skyshine.tmm.texture import Texture


def to_lab(colours: np.ndarray, encoding: str) -> np.ndarray:
    """L*a*b* under D65 of colours as a file holds them.

    Parameters
    ----------
    colours : (N, 3) uint8, uint16 or float
        Integers over their full range, floats with 1 as white.
    encoding : str
        ``srgb`` (IEC 61966-2-1), ``linear`` (Rec. 709 primaries), or a colour space known to OpenImageIO.

    Returns
    -------
    (N, 3) float64
        L* is 0 to 100 for colours within white, and goes on beyond for high dynamic range.
    """
    from skimage.color import colorconv, rgb2xyz, xyz2lab

    if not len(colours):
        return np.empty((0, 3))
    scale = np.iinfo(colours.dtype).max if colours.dtype.kind == "u" else 1.0
    values = colours / np.float64(scale)
    if encoding == "srgb":
        return xyz2lab(rgb2xyz(values))
    if encoding != "linear":
        values = _to_linear(values, encoding)
    # rgb2xyz would undo an sRGB curve that linear values do not have, so its matrix is applied alone.
    return xyz2lab(values @ colorconv.xyz_from_rgb.T)


def _to_linear(values: np.ndarray, encoding: str) -> np.ndarray:
    import OpenImageIO as oiio

    image = oiio.ImageBuf(values[np.newaxis].astype(np.float32))
    linear = oiio.ImageBufAlgo.colorconvert(image, encoding, "lin_rec709_scene")
    if linear.has_error:
        raise ValueError(linear.geterror())
    return linear.get_pixels(oiio.FLOAT)[0].astype(np.float64)


class DistinctColours:
    """Finds the distinct colours of blocks of a texture, so that each is classified once.

    8 bit textures share one table of all their colours; in 16 bit ones a block's colours are sorted; float texels are
    nearly all different and stand for themselves. Texels without data may point at any colour.
    """

    def __init__(self, texture: Texture):
        self._texture = texture
        self._table, self.colours = None, None
        if texture.pixels.dtype == np.uint8:
            self._table, self.colours = _table_of(texture)

    def of(self, rows: slice, columns: slice) -> tuple[np.ndarray | None, np.ndarray]:
        """Colours of a window and, for each of its texels, which of them it has.

        Returns
        -------
        colours : (U, 3) or None
            None: the texture's own `colours`, the same for every block.
        index : (h, W) integer
        """
        pixels = self._texture.pixels[rows, columns]
        if self._table is not None:
            return None, self._table[_packed(pixels)]
        if pixels.dtype == np.uint16:
            packed, index = np.unique(_packed(pixels), return_inverse=True)
            bits = np.array([32, 16, 0], np.uint64)
            colours = ((packed[:, np.newaxis] >> bits) & np.uint64(0xFFFF)).astype(np.uint16)
            return colours, index.reshape(pixels.shape[:2])
        valid = self._texture.valid[rows, columns]
        return np.where(valid[..., np.newaxis], pixels, 0).reshape(-1, 3), np.arange(valid.size).reshape(valid.shape)


def _packed(pixels: np.ndarray) -> np.ndarray:
    """One integer for each colour: uint32 of 8 bit channels, uint64 of 16 bit channels."""
    bits = 8 * pixels.dtype.itemsize
    red, green, blue = (pixels[..., i].astype(np.uint32 if bits == 8 else np.uint64) for i in range(3))
    return red << red.dtype.type(2 * bits) | green << red.dtype.type(bits) | blue


def _table_of(texture: Texture) -> tuple[np.ndarray, np.ndarray]:
    """Index of each possible 8 bit colour (2^24,) and the distinct colours (U, 3) that index them."""
    present = np.zeros(1 << 24, bool)
    for row in range(0, texture.height, 256):
        block = slice(row, row + 256)
        present[_packed(texture.pixels[block])[texture.valid[block]]] = True
    packed = np.flatnonzero(present)
    table = np.zeros(1 << 24, np.int32)
    table[packed] = np.arange(len(packed), dtype=np.int32)
    colours = (packed[:, np.newaxis] >> np.array([16, 8, 0])) & 0xFF
    return table, colours.astype(np.uint8)
