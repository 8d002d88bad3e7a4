"""Features of an image encoder of the user's, an ONNX file: tokens of tiles, reduced by PCA, brought to each texel.

The encoder takes colours (1, 3, h, w), sRGB from 0 to 1 standardised by the means and deviations of ImageNet, as
encoders trained on photographs expect them; it gives a map (1, C, rows, columns), or tokens (1, N, C) whose last are a
square map, after some that stand for the whole image. The texture is divided into tiles that overlap, so that memory is
that of a few tiles whatever its size, and a texel has the same features in whatever window it is asked for.
"""

from __future__ import annotations

import itertools
import os
from collections import OrderedDict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.tmm.features.colour import to_linear
from skyshine.tmm.features.token_basis import EncoderIdentity, TokenBasis, common_basis
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.images.texture import Windowed

TILE = 448  # texels a side of what an encoder of any size is given: patches of 14 and of 16 divide it
MOST_SIDE = 4096  # texels of a side that an encoder may ask for
_BORDER = 8  # a tile overlaps its neighbours by one such part of its side
_LEADING = 8  # tokens before those of the map that an encoder may have: of the class, registers
_SAMPLE_TILES = 12  # that the components are found in, spread evenly over the texture
_SAMPLE_TOKENS = 2048  # of each of these tiles
_CACHE_BYTES = 1 << 26
# Of ImageNet, in red, green and blue.
_MEAN, _DEVIATION = np.array((0.485, 0.456, 0.406), np.float32), np.array((0.229, 0.224, 0.225), np.float32)


class Encoder:
    """An ONNX model.

    Attributes
    ----------
    path : Path
    side : int
        Texels of a side of the images that it is given.
    """

    def __init__(self, path: Path) -> None:
        """Open a file.

        Raises
        ------
        InputError
            onnxruntime is missing, the file is no ONNX model, or its input is no image.
        """
        self.path = path
        if not path.is_file():
            raise InputError("is no file that can be read; name an ONNX model in classifier.features", file=path)
        try:
            import onnxruntime
        except ImportError:
            raise InputError('needs onnxruntime; run: pip install "skyshine[onnx]"', file=path) from None
        options = onnxruntime.SessionOptions()
        options.log_severity_level = 4  # its problems are told here, in one line
        options.intra_op_num_threads = int(os.environ.get("SKYSHINE_THREADS", "0"))
        try:
            self._session = onnxruntime.InferenceSession(os.fspath(path), options, ["CPUExecutionProvider"])
        except Exception as error:  # onnxruntime's own classes share no base below it
            raise InputError(
                f"is no ONNX model that can be run: {_first_line(error)}; export it again", file=path
            ) from None
        inputs = self._session.get_inputs()
        shape = inputs[0].shape if len(inputs) == 1 else []
        fixed = [size for size in shape[2:] if isinstance(size, int)]
        one_image = len(shape) == 4 and shape[0] in (1, None, str(shape[0])) and shape[1] in (3, None, str(shape[1]))
        if not one_image or inputs[0].type != "tensor(float)" or len(set(fixed)) > 1:
            given = ", ".join(f"{one.name} {one.type} {one.shape}" for one in inputs)
            raise InputError(
                f"takes {given or 'no input'}; allowed: one input of float images (1, 3, h, w), h and w alike or free",
                file=path,
            )
        self.side = fixed[0] if fixed else TILE
        if not _BORDER <= self.side <= MOST_SIDE:
            raise InputError(f"takes images {shape}; allowed: {_BORDER} to {MOST_SIDE} texels a side", file=path)
        self._name, self._output = inputs[0].name, self._session.get_outputs()[0].name

    def tokens(self, colours: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Map of tokens (C, rows, columns) of sRGB colours (side, side, 3) from 0 to 1.

        Raises
        ------
        InputError
            The model fails on it, gives no map, or values that are not finite.
        """
        image = ((colours - _MEAN) / _DEVIATION).transpose(2, 0, 1)[np.newaxis]
        try:
            found = self._session.run(None, {self._name: np.ascontiguousarray(image, np.float32)})[0]
        except Exception as error:
            raise InputError(
                f"fails on an image of {self.side} x {self.side} texels: {_first_line(error)}; export it for images of"
                f" {self.side} texels",
                file=self.path,
            ) from None
        shape = tuple(np.shape(found))
        tokens = self._map(np.asarray(found), shape)
        if not np.isfinite(tokens).all():
            raise InputError("gives values that are not finite; check the model", file=self.path)
        return tokens

    def tile(self, texture: Windowed, down: int, across: int) -> npt.NDArray[np.float32]:
        """Tokens of a tile; beyond the texture its texels are mirrored, those without data have the mean colour."""
        border = self.side // _BORDER
        core = self.side - 2 * border
        rows = _mirrored(down * core - border, self.side, texture.height)
        columns = _mirrored(across * core - border, self.side, texture.width)
        top, left = rows.min(), columns.min()
        pixels, valid = texture.window(slice(top, rows.max() + 1), slice(left, columns.max() + 1))
        colours = np.broadcast_to(_MEAN, (*valid.shape, 3)).copy()
        if valid.any():
            linear = np.clip(to_linear(pixels[valid][:, :3], texture.encoding), 0, 1)
            # IEC 61966-2-1, whatever the texture is encoded in.
            colours[valid] = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
        return self.tokens(colours[np.ix_(rows - top, columns - left)])

    def sample(self, texture: Windowed) -> npt.NDArray[np.float64]:
        """Tokens (N, C) of some of a texture's tiles, spread evenly over it.

        Raises
        ------
        InputError
            See `tokens`.
        """
        core = self.side - 2 * (self.side // _BORDER)
        down, across = (-(-length // core) for length in (texture.height, texture.width))
        chosen = np.unique(np.linspace(0, down * across - 1, min(_SAMPLE_TILES, down * across)).round().astype(int))
        samples = []
        for number in chosen:
            tokens = self.tile(texture, *divmod(int(number), across))
            flat = tokens.reshape(len(tokens), -1).T.astype(np.float64)
            samples.append(flat[:: -(-len(flat) // _SAMPLE_TOKENS)])
        return np.concatenate(samples)

    def basis(self, textures: Iterable[Windowed]) -> TokenBasis:
        """The principal components of the tokens of all textures together, each read when its turn comes.

        Raises
        ------
        InputError
            See `tokens`.
        """
        samples = (self.sample(texture) for texture in textures)
        first = next(samples)
        return common_basis(itertools.chain([first], samples), self.identity())

    def identity(self) -> EncoderIdentity:
        """What tells this encoder from others.

        Raises
        ------
        InputError
            See `tokens`.
        """
        rows, columns = self.tokens(np.broadcast_to(_MEAN, (self.side, self.side, 3)).copy()).shape[1:]
        mean, deviation = (tuple(float(value) for value in part) for part in (_MEAN, _DEVIATION))
        return EncoderIdentity(file_sha256(self.path), self.side, rows, columns, self._output, mean, deviation)

    def _map(self, found: npt.NDArray[Any], shape: tuple[int, ...]) -> npt.NDArray[np.float32]:
        if found.dtype.kind == "f" and 0 not in shape and shape[:1] == (1,):
            if len(shape) == 4 and max(shape[2:]) <= self.side:
                whole: npt.NDArray[np.float32] = found[0].astype(np.float32)
                return whole
            rows = int(np.sqrt(shape[1])) if len(shape) == 3 else 0
            if rows and shape[1] - rows**2 <= _LEADING:
                last: npt.NDArray[np.float32] = found[0, shape[1] - rows**2 :].T.astype(np.float32)
                return last.reshape(-1, rows, rows)
        raise InputError(
            f"gives {found.dtype} {shape} as its first output; allowed: a map of floats (1, C, rows, columns) no larger"
            f" than the image, or tokens (1, N, C) of a square map with {_LEADING} others before it at most",
            file=self.path,
        )


def _first_line(error: Exception) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0][:200]


class TokenFeatures:
    """The features of the texels of a texture.

    Attributes
    ----------
    basis : TokenBasis
    count : int
        Features of a texel.
    """

    def __init__(self, texture: Windowed, encoder: Encoder, basis: TokenBasis | None = None) -> None:
        """Without a basis, find that of the texture's own tokens.

        Raises
        ------
        InputError
            See `Encoder.tokens`.
        """
        self._texture, self._encoder = texture, encoder
        self._border = encoder.side // _BORDER
        self._core = encoder.side - 2 * self._border
        self._kept: OrderedDict[tuple[int, int], npt.NDArray[np.float32]] = OrderedDict()
        self.basis = encoder.basis([texture]) if basis is None else basis
        self.count = self.basis.count

    def window(self, rows: slice, columns: slice) -> npt.NDArray[np.float32]:
        """Features (count, h, w) of a window, linear between the middles of tokens."""
        found = np.empty((self.count, rows.stop - rows.start, columns.stop - columns.start), np.float32)
        for down in range(rows.start // self._core, (rows.stop - 1) // self._core + 1):
            for across in range(columns.start // self._core, (columns.stop - 1) // self._core + 1):
                own = self._reduced(down, across)
                top, left = down * self._core, across * self._core
                part = (
                    slice(max(rows.start, top), min(rows.stop, top + self._core)),
                    slice(max(columns.start, left), min(columns.stop, left + self._core)),
                )
                lower = self._between(part[0], top, own.shape[1])
                right = self._between(part[1], left, own.shape[2])
                inside = (
                    slice(part[0].start - rows.start, part[0].stop - rows.start),
                    slice(part[1].start - columns.start, part[1].stop - columns.start),
                )
                found[(slice(None), *inside)] = lower @ own @ right.T
        return found

    def _between(self, texels: slice, first: int, count: int) -> npt.NDArray[np.float32]:
        """Weights (n, count) of the tokens along an axis of the tile whose core begins with the texel `first`."""
        middle = np.arange(texels.start, texels.stop) - first + self._border + 0.5
        place = np.clip(middle * (count / self._encoder.side) - 0.5, 0, count - 1)
        weights: npt.NDArray[np.float32] = np.maximum(1 - np.abs(place[:, np.newaxis] - np.arange(count)), 0)
        return weights.astype(np.float32)

    def _reduced(self, down: int, across: int) -> npt.NDArray[np.float32]:
        """Components (count, rows, columns) of the tokens of a tile."""
        tile = (down, across)
        if tile not in self._kept:
            self._kept[tile] = self.basis.features(self._encoder.tile(self._texture, down, across))
            while len(self._kept) > 1 and sum(part.nbytes for part in self._kept.values()) > _CACHE_BYTES:
                self._kept.popitem(last=False)
        self._kept.move_to_end(tile)
        return self._kept[tile]


def _mirrored(first: int, count: int, length: int) -> npt.NDArray[np.int64]:
    """Rows or columns from `first` on, mirrored at the edges of a texture of `length`."""
    at = np.arange(first, first + count) % (2 * length)
    return np.where(at < length, at, 2 * length - 1 - at)
