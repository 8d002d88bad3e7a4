"""Colour as CIE L*a*b* (D65), computed once for each distinct colour of a texture."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.tmm.images.texture import Windowed

PIECE_TEXELS = 1 << 21  # looked at at a time
CACHED_TEXELS = 1 << 17  # texels of a block, for the processor's cache
TABLED = 1 << 21  # distinct colours of one table: beyond, its posteriors would not fit the memory aimed at


def to_lab(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float64]:
    """L*a*b* under D65 of colours as a file stores them.

    colours : (N, 3) uint8, uint16 or float; integers over their full range, floats with 1 as white.
    encoding : str; ``srgb`` (IEC 61966-2-1), ``linear`` (Rec. 709 primaries), or a colour space known to OpenImageIO.

    Returns
    -------
    (N, 3) float64
        L* is 0 to 100 for colours within white, and goes on beyond for high dynamic range.
    """
    from skimage.color import xyz2lab

    if not len(colours):
        return np.empty((0, 3))
    lab: npt.NDArray[np.float64] = xyz2lab(to_xyz(colours, encoding))
    return lab


def to_xyz(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float64]:
    """CIE XYZ (N, 3) float64, with Y of white 1, of colours (N, 3); parameters as for `to_lab`."""
    from skimage.color import colorconv

    # skimage's rgb2xyz is the same, but for its sRGB curve, which linear values do not have.
    xyz: npt.NDArray[np.float64] = to_linear(colours, encoding) @ colorconv.xyz_from_rgb.T
    return xyz


def to_linear(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float64]:
    """Linear light of Rec. 709 primaries (N, 3) float64, with 1 as white, of colours (N, 3); parameters as for
    `to_lab`.
    """
    if colours.dtype == np.uint8 and encoding == "srgb" and colours.size > 256:
        levels = to_linear(np.arange(256, dtype=np.uint8), encoding)
        return np.take(levels, colours)
    scale = np.iinfo(colours.dtype).max if colours.dtype.kind == "u" else 1.0
    values = colours / np.float64(scale)
    if encoding == "linear":
        return values
    if encoding == "srgb":  # IEC 61966-2-1
        with np.errstate(invalid="ignore"):
            return np.where(values > 0.04045, ((values + 0.055) / 1.055) ** 2.4, values / 12.92)
    import OpenImageIO as oiio

    image = oiio.ImageBuf(values[np.newaxis].astype(np.float32))
    converted = oiio.ImageBufAlgo.colorconvert(image, encoding, "lin_rec709_scene")
    if converted.has_error:
        raise ValueError(converted.geterror())
    linear: npt.NDArray[np.float64] = np.asarray(converted.get_pixels(oiio.FLOAT), np.float64)[0]
    return linear


def to_coordinates(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[np.float64]:
    """L*a*b* of colours (N, 3), or with near infrared (N, 4) also 100 times their normalised difference, NDVI."""
    lab = to_lab(colours[:, :3], encoding)
    return lab if colours.shape[1] == 3 else np.column_stack([lab, 100 * ndvi(colours)])


def ndvi(colours: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """(near infrared - red) / (near infrared + red) of colours (N, 4) as stored (Rouse et al. 1974); 0 where both
    are.
    """
    red, infrared = (colours[:, i].astype(np.float64) for i in (0, 3))
    total = infrared + red
    return np.divide(infrared - red, total, out=np.zeros_like(total), where=total != 0).clip(-1, 1)


class DistinctColours:
    """Finds the distinct colours of blocks of a texture, so that each is classified once.

    8 bit textures share one table of all their colours; in 16 bit ones, in those with near infrared and in those with
    more than `TABLED` colours, a block's colours are sorted; float texels are nearly all different and represent
    themselves. Texels without data may point at any colour.

    valid_texels : int; texels of the texture with data.
    number : int
        Number of distinct colours of an 8 bit texture without near infrared; 0 for others, where they are not counted.
    colours : (U, 3) uint8 or None; those of the shared table.
    """

    def __init__(self, texture: Windowed) -> None:
        """Reads the whole texture once."""
        self._table: npt.NDArray[np.int32] | None = None
        self.colours: npt.NDArray[np.uint8] | None = None
        self.valid_texels, self.number = 0, 0
        count = texture.dtype == np.uint8 and texture.channels == 3
        present = np.zeros(1 << 24 if count else 0, bool)
        step = max(PIECE_TEXELS // texture.width, 1)
        for top in range(0, texture.height, step):
            pixels, valid = texture.window(slice(top, min(top + step, texture.height)), slice(0, texture.width))
            complete = valid.all()
            self.valid_texels += valid.size if complete else int(valid.sum())
            # In parts that stay in a processor's cache, by the index type of numpy: half the time.
            rows = max(CACHED_TEXELS // texture.width, 1)
            for start in range(0, len(pixels) if count else 0, rows):
                part = _packed(pixels[start : start + rows])
                present[(part if complete else part[valid[start : start + rows]]).astype(np.intp)] = True
        if count:
            packed = np.flatnonzero(present)
            self.number = len(packed)
            if len(packed) <= TABLED:
                self._table = np.zeros(1 << 24, np.int32)
                self._table[packed] = np.arange(len(packed), dtype=np.int32)
                self.colours = _unpacked(packed, np.dtype(np.uint8), 3)

    def of(
        self, pixels: npt.NDArray[Any], valid: npt.NDArray[np.bool_]
    ) -> tuple[npt.NDArray[Any] | None, npt.NDArray[Any]]:
        """Colours of a window of the texture and, for each of its texels, which of them it has.
        None; None: the texture's own
                pixels, valid : (h, w, C), (h, w); as the texture's `window` gives them.

                Returns
                -------
                colours : (U, C) or
         `colours`, the same for every block.
                index : (h, w) integer
        """
        if self._table is not None:
            return None, np.take(self._table, _packed(pixels))
        if pixels.dtype.kind == "u":
            packed, index = np.unique(_packed(pixels), return_inverse=True)
            return _unpacked(packed, pixels.dtype, pixels.shape[2]), index.reshape(valid.shape)
        colours = np.where(valid[..., np.newaxis], pixels, 0)
        return colours.reshape(-1, pixels.shape[2]), np.arange(valid.size).reshape(valid.shape)

    def in_use(self, index: npt.NDArray[Any]) -> tuple[npt.NDArray[np.uint8], npt.NDArray[Any]]:
        """Colours of the shared table that a window has, (U, 3), and for each of its texels which of them, (h, w)."""
        if self.colours is None:
            raise ValueError("this texture has no shared table of colours")
        present, number = np.unique(index, return_inverse=True)
        return self.colours[present], number.reshape(index.shape)


def _packed(pixels: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """One integer for each colour: of three 8 bit channels as numpy indexes by, uint32 of four, uint64 of 16 bit
    channels.
    """
    bits = 8 * pixels.dtype.itemsize
    if bits == 8 and pixels.shape[2] == 3:
        # Four bytes from each texel's neighbour on, big-endian, contain it in the last three: half the time of shifts.
        octets = np.zeros(pixels.size + 1, np.uint8)
        octets[1:] = pixels.reshape(-1)
        index = np.ndarray((pixels.size // 3,), ">u4", octets.data, strides=(3,)).astype(np.intp)
        index &= 0xFFFFFF
        return index.reshape(pixels.shape[:2])
    kind = np.uint32 if bits == 8 else np.uint64
    packed: npt.NDArray[Any] = pixels[..., 0].astype(kind)
    for i in range(1, pixels.shape[2]):
        np.left_shift(packed, kind(bits), out=packed)
        np.bitwise_or(packed, pixels[..., i], out=packed)
    return packed


def _unpacked(packed: npt.NDArray[Any], dtype: np.dtype[Any], channels: int) -> npt.NDArray[Any]:
    """Colours (U, C) of the integers of `_packed`."""
    bits = 8 * dtype.itemsize
    shifts = np.arange(channels - 1, -1, -1, dtype=packed.dtype) * packed.dtype.type(bits)
    colours: npt.NDArray[Any] = ((packed[:, np.newaxis] >> shifts) & packed.dtype.type(2**bits - 1)).astype(dtype)
    return colours
