"""Pictures of another renderer as arrays of their stored numbers: EXR with many layers, PNG, TIFF, PFM, NPY."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.render.scene_file import MAX_RAYS
from skyshine.schemas.errors import InputError, nearest

_NUMBERS = "buif"  # kinds of numpy that are numbers
_PICTURE_CHANNELS = 4  # picture channels of a file without layers: red, green, blue, alpha
_ORDER = "rgbaxyz"  # order of the channels of a layer, whatever that of the file
_MANIFEST_BYTES = 1 << 24  # largest size of a manifest of object names: more is another kind of file


def read_layer(path: Path, layer: str | None) -> npt.NDArray[Any]:
    """A layer of a picture, (rows, columns, channels), of the type that the file stores.

    Parameters
    ----------
    layer : str or None
        Channels of an EXR with that name, or whose names begin with it and a dot.

    Raises
    ------
    InputError
        The file cannot be read, lacks the layer or contains several, or is too large.
    """
    if path.suffix.lower() == ".npy":
        return _numpy_array(path, layer)
    with _Image(path) as image:
        return image.read(image.part_of(layer))


def read_cryptomatte(path: Path, layer: str) -> tuple[npt.NDArray[np.uint32], npt.NDArray[np.float32], dict[int, str]]:
    """Ids and coverages of a layer of Cryptomatte.

    Parameters
    ----------
    layer : str
        Such as ``ViewLayer.CryptoMaterial``.

    Returns
    -------
    ids : (rows, columns, ranks) uint32 array
        MurmurHash3 of the names; 0 where there is nothing.
    coverage : (rows, columns, ranks) float32 array
    names : dict of int to str
        Those of the manifest in the file, by their ids; empty without one.

    Raises
    ------
    InputError
        The file is none, or has no such layer.
    """
    with _Image(path) as image:
        ranks = [image.part_of(f"{layer}{number:02d}") for number in range(image.ranks(layer))]
        if not ranks:
            raise image.lacks(layer, "Cryptomatte")
        values = np.concatenate([image.read(part) for part in ranks], axis=-1)
        names = image.manifest(layer)
    if values.dtype != np.float32 or values.shape[-1] % 2:
        raise InputError(f"has '{layer}' as {values.dtype}; allowed: 32-bit floats; save it with full depth", file=path)
    pairs = np.ascontiguousarray(values.reshape(*values.shape[:2], -1, 2))
    return pairs[..., 0].copy().view(np.uint32), pairs[..., 1], names


def cryptomatte_id(name: str) -> int:
    """The id of a name: MurmurHash3_32 of its UTF-8 bytes with an exponent that a 32-bit float keeps.

    Psyop, "Cryptomatte Specification", version 1.2.0; A. Appleby, MurmurHash3 (public domain).

    Examples
    --------
    >>> f"{cryptomatte_id('asphalt'):08x}"
    '62980026'
    """
    mask, data = 0xFFFFFFFF, name.encode("utf-8")
    value = 0

    def mixed(block: int) -> int:
        block = block * 0xCC9E2D51 & mask
        return (block << 15 | block >> 17) * 0x1B873593 & mask

    aligned = len(data) // 4 * 4
    for start in range(0, aligned, 4):
        value ^= mixed(int.from_bytes(data[start : start + 4], "little"))
        value = ((value << 13 | value >> 19) & mask) * 5 + 0xE6546B64 & mask
    value ^= mixed(int.from_bytes(data[aligned:], "little")) ^ len(data)
    value = (value ^ value >> 16) * 0x85EBCA6B & mask
    value = (value ^ value >> 13) * 0xC2B2AE35 & mask
    value ^= value >> 16
    # 0 and 255 are exponents of denormal, infinite and no numbers, which programs change.
    return value ^ 1 << 23 if value >> 23 & 255 in (0, 255) else value


@dataclass(frozen=True)
class _Part:
    """Channels of one part of a file, by their numbers, in the order of a layer."""

    number: int
    channels: tuple[int, ...]


class _Image:
    """An image file that OpenImageIO reads, with the names of all its channels."""

    def __init__(self, path: Path) -> None:
        import OpenImageIO as oiio

        self._path = path
        config = oiio.ImageSpec()
        config.attribute("oiio:UnassociatedAlpha", 1)  # colours as they are stored
        opened = oiio.ImageInput.open(str(path), config)
        if opened is None:
            raise InputError(f"cannot be read: {oiio.geterror()}; allowed: EXR, PNG, TIFF, PFM, NPY", file=path)
        self._input = opened
        self._specs: list[Any] = []
        while self._input.seek_subimage(len(self._specs), 0):
            self._specs.append(self._input.spec())
        for spec in self._specs:
            if spec.width * spec.height > MAX_RAYS or spec.depth > 1:
                self._input.close()
                raise _too_large(path, spec.width, spec.height)

    def __enter__(self) -> _Image:
        return self

    def __exit__(self, *_: object) -> None:
        self._input.close()

    def part_of(self, layer: str | None) -> _Part:
        """Location of a layer.

        Raises
        ------
        InputError
            There is none, or there are several and none is named.
        """
        if layer is None:
            if len(self._specs) == 1 and self._specs[0].nchannels <= _PICTURE_CHANNELS:
                return _Part(0, tuple(range(self._specs[0].nchannels)))
            raise InputError(
                f"has {len(self._layers())} layers; name one of them with 'layer': {', '.join(self._layers())}",
                file=self._path,
            )
        for number, spec in enumerate(self._specs):
            of_layer = [
                index for index, name in enumerate(spec.channelnames) if layer in (name, name.rpartition(".")[0])
            ]
            if of_layer:
                ending = {index: spec.channelnames[index].rpartition(".")[2].lower() for index in of_layer}
                return _Part(number, tuple(sorted(of_layer, key=lambda index: (_ORDER.find(ending[index]), index))))
        raise self.lacks(layer, "")

    def lacks(self, layer: str, what: str) -> InputError:
        """The error of a layer that is not there."""
        of_kind = f"layer of {what}" if what else "layer"
        return InputError(f"has no {of_kind} '{layer}'; {nearest(layer, self._layers())}", file=self._path)

    def read(self, part: _Part) -> npt.NDArray[Any]:
        """Channels of a part, (rows, columns, channels).

        Raises
        ------
        InputError
            The file is damaged, or shows a part of its picture alone.
        """
        spec = self._specs[part.number]
        if (spec.width, spec.height) != (spec.full_width, spec.full_height):
            raise InputError(
                f"has {spec.width} x {spec.height} of {spec.full_width} x {spec.full_height} pixels; allowed: whole"
                " pictures; render without a region",
                file=self._path,
            )
        kind = str(spec.format)
        kind = "float" if kind == "half" else kind
        start, stop = min(part.channels), max(part.channels) + 1
        values = self._input.read_image(part.number, 0, start, stop, kind)
        if values is None:
            raise InputError(f"is damaged: {self._input.geterror()}; render it again", file=self._path)
        picture = np.asarray(values).reshape(spec.height, spec.width, stop - start)
        order = [channel - start for channel in part.channels]
        return picture if order == list(range(stop - start)) else picture[..., order]

    def ranks(self, layer: str) -> int:
        """Number of pictures of a layer of Cryptomatte, each of two ids."""
        layers = set(self._layers())
        number = 0
        while f"{layer}{number:02d}" in layers:
            number += 1
        return number

    def manifest(self, layer: str) -> dict[int, str]:
        """Names of a layer of Cryptomatte by their ids, as the file's header gives them."""
        attributes = {entry.name: str(entry.value) for spec in self._specs for entry in spec.extra_attribs}
        for key, value in attributes.items():
            if key.startswith("cryptomatte/") and key.endswith("/name") and value == layer:
                text = attributes.get(key.removesuffix("name") + "manifest", "{}")
                try:
                    return {int(code, 16): str(name) for name, code in json.loads(text).items()}
                except (ValueError, TypeError, AttributeError):
                    raise InputError(f"has a manifest of '{layer}' that is no JSON of names", file=self._path) from None
        return {}

    def _layers(self) -> list[str]:
        """Names of layers, in the order of the file; a channel without a dot is its own layer."""
        names = (name for spec in self._specs for name in spec.channelnames)
        return list(dict.fromkeys(name.rpartition(".")[0] or name for name in names))


def read_labels(path: Path) -> dict[str, tuple[str, ...]]:
    """Names of ids, or of colours such as ``(140, 25, 255, 255)``, as Isaac writes them.

    Raises
    ------
    InputError
        The file is no such JSON.
    """
    try:
        if path.stat().st_size > _MANIFEST_BYTES:
            raise ValueError(f"more than {_MANIFEST_BYTES} bytes")
        labels = json.loads(path.read_text(encoding="utf-8"))
        return {
            str(key): (names,) if isinstance(names, str) else tuple(str(name) for name in names.values())
            for key, names in labels.items()
        }
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(f"is no JSON of labels ({error}); allowed: that of Isaac's BasicWriter", file=path) from None


def _numpy_array(path: Path, layer: str | None) -> npt.NDArray[Any]:
    if layer is not None:
        raise InputError(f"has no layers; remove 'layer: {layer}'", file=path)
    try:
        values = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError, OverflowError) as error:
        raise InputError(f"is no array of numpy ({error}); save it with numpy.save", file=path) from None
    if values.ndim not in (2, 3) or values.dtype.kind not in _NUMBERS or values.size == 0:
        raise InputError(
            f"has an array of shape {values.shape} of {values.dtype}; allowed: numbers (rows, columns) or (rows,"
            " columns, channels)",
            file=path,
        )
    if values.shape[0] * values.shape[1] > MAX_RAYS or values[0, 0].size > _PICTURE_CHANNELS:
        raise _too_large(path, values.shape[1], values.shape[0])
    return np.array(values if values.ndim == 3 else values[..., None])


def _too_large(path: Path, columns: int, rows: int) -> InputError:
    return InputError(
        f"has {columns} x {rows} pixels; allowed: {MAX_RAYS} pixels of {_PICTURE_CHANNELS} channels; render smaller",
        file=path,
    )
