"""Buffers of a frame decoded: depth in metres, normals, materials by id, share of direct light."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.render.buffer_files import cryptomatte_id, read_cryptomatte, read_labels, read_layer
from skyshine.mat.render.buffer_geometry import AXES, CARLA_FAR, lengths
from skyshine.mat.render.frame_file import SKY, IdLayer, LoadedFrame, OwnTemperature
from skyshine.mat.render.surface import PARTS
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError

_BYTE = 255  # largest value of 8 bits
_WHOLE_24 = (1 << 24) - 1  # CARLA's farthest depth: R + 256 G + 65536 B
_ID_LIMIT = 1 << 32  # ids have 32 bits
_SHOWN = 5  # unknown ids in a message
_LEAST_NORMAL = 1e-3  # length below which a stored normal has no direction


@dataclass(frozen=True)
class Stored:
    """The numbers of a buffer with where they come from, for messages."""

    values: npt.NDArray[Any]
    path: Path

    @property
    def is_integer(self) -> bool:
        return self.values.dtype.kind in "bui"

    def channels(self, count: int, what: str) -> npt.NDArray[Any]:
        """The first channels (rows, columns, count).

        Raises
        ------
        InputError
            There are fewer.
        """
        if self.values.shape[-1] < count:
            raise InputError(
                f"has {self.values.shape[-1]} channels; allowed: {count} at least, for {what}; save them all",
                file=self.path,
            )
        return self.values[..., :count]

    def refuse(self, wrong: Booleans, what: str, allowed: str) -> None:
        """Refuse a buffer with wrong pixels (rows, columns).

        Raises
        ------
        InputError
        """
        if wrong.any():
            row, column = np.argwhere(wrong)[0]
            raise InputError(
                f"found {what} in {int(wrong.sum())} pixels, the first in row {row}, column {column}, counted from 0;"
                f" allowed: {allowed}",
                file=self.path,
            )


def stored(frame: LoadedFrame, name: str, mark: str) -> Stored:
    """A buffer of a frame by its name.

    Raises
    ------
    InputError
        The file is none, or lacks the layer.
    """
    layer = getattr(frame.model.buffers, name)
    path = frame.path(("buffers", name, "file"), mark)
    return Stored(read_layer(path, layer.layer), path)


def depth_of(frame: LoadedFrame, buffer: Stored) -> Floats:
    """Depth (rows, columns) [m]; infinite where a pixel shows the sky.

    Raises
    ------
    InputError
        A depth is not a number, 0 or less, or the channels are none of a depth.
    """
    layer, renderer = frame.model.buffers.depth, frame.model.renderer
    if renderer == "airsim" and buffer.path.suffix.lower() == ".pfm":
        raise InputError(
            "is a PFM file, whose rows AirSim's client writes from the top, other programs from the bottom; allowed:"
            " NPY; save the depth with numpy.save",
            file=buffer.path,
        )
    if buffer.values.shape[-1] == 1:
        metres = buffer.values[..., 0].astype(float) * layer.metres_per_value
    elif renderer == "carla" and buffer.values.dtype == np.uint8 and buffer.values.shape[-1] >= 3:
        metres = carla_depth(buffer)
    else:
        raise InputError(
            f"has {buffer.values.shape[-1]} channels of {buffer.values.dtype}; allowed: one of depth, or red, green"
            " and blue of the renderer carla; name the layer of depth",
            file=buffer.path,
        )
    buffer.refuse(np.isnan(metres), "a depth that is not a number", "metres; infinite for the sky")
    if renderer == "mitsuba":
        metres = np.where(metres == 0, np.inf, metres)
    buffer.refuse(metres <= 0, "a depth of 0 or less", "metres ahead of the camera; infinite for the sky")
    return np.where(metres >= AXES[renderer].sky, np.inf, metres)


def carla_depth(buffer: Stored) -> Floats:
    """Depth (rows, columns) [m] of CARLA's 24 bits in red, green and blue, red the lowest.

    Raises
    ------
    InputError
        The picture is grey, as that of a colour converter is.
    """
    red, green, blue = (buffer.values[..., channel].astype(np.int32) for channel in range(3))
    if np.array_equal(red, green) and np.array_equal(green, blue) and np.any((red > 0) & (red < _BYTE)):
        raise InputError(
            "is grey, as CARLA's ColorConverter makes it; allowed: the raw depth in red, green and blue; save it with"
            " ColorConverter.Raw",
            file=buffer.path,
        )
    return np.asarray((red + 256 * green + 65536 * blue) * (CARLA_FAR / _WHOLE_24))


def normals_of(buffer: Stored, hit: Booleans) -> Floats:
    """Unit normals (rows, columns, 3) in the axes of the file; not a number where no surface is met.

    Raises
    ------
    InputError
        A pixel that meets a surface has none.
    """
    values = buffer.channels(3, "x, y and z of a normal")
    normal = values.astype(float)
    if buffer.is_integer:
        normal = normal * (2.0 / np.iinfo(values.dtype).max) - 1.0
    length = lengths(normal)
    buffer.refuse(
        hit & ~(np.isfinite(length) & (length > _LEAST_NORMAL)),
        "a normal without a direction",
        "x, y and z of any length",
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(hit[..., None], normal / length[..., None], np.nan)


def sunlit_of(buffer: Stored) -> Floats:
    """Share of the direct light (rows, columns), 0 to 1.

    Raises
    ------
    InputError
        A value lies outside.
    """
    values = buffer.channels(1, "the share of light")[..., 0]
    share = values.astype(float)
    if buffer.is_integer:
        share = share / (1.0 if values.dtype == bool else np.iinfo(values.dtype).max)
    buffer.refuse(~((share >= 0) & (share <= 1)), "a share of light beyond 0 to 1", "0 in the shade to 1 in the light")
    return share


@dataclass(frozen=True, eq=False)
class PixelMaterials:
    """What the pixels show.

    Attributes
    ----------
    number : (rows, columns, M) int array
        Number of the entry of `MaterialTable`; 0 where unused.
    share : (rows, columns, M) array
        They sum to 1; 0 where a pixel shows the sky.
    unknown : dict of str to int
        Ids without an entry, with their pixels.
    """

    number: Integers
    share: Floats
    unknown: dict[str, int]


class MaterialTable:
    """The table of a frame file: a material, and a temperature of one's own, for each id or name.

    Attributes
    ----------
    names : tuple of str
        Material of each entry; the sky is not among them.
    places : dict of str to tuple
        Key of the frame file that each material comes from.
    temperature : (K,) array
        Temperature that the frame file states [K]; NaN where that of the databases applies.
    """

    _SKY, _UNKNOWN = -1, -2

    def __init__(self, frame: LoadedFrame) -> None:
        """Read the keys of the table.

        Raises
        ------
        InputError
            A key is none of the encoding.
        """
        model = frame.model
        self._frame, self._layer = frame, model.buffers.ids
        self._numbers: dict[int, int] = {}
        self._by_name: dict[str, int] = {}
        names: list[str] = []
        temperatures: list[float] = []
        self.places: dict[str, tuple[str | int, ...]] = {}
        for key, entry in model.materials.items():
            override = entry if isinstance(entry, OwnTemperature) else OwnTemperature(material=entry)
            number = self._SKY if override.material == SKY and override.temperature_k is None else len(names)
            if number >= 0:
                names.append(override.material)
                temperatures.append(np.nan if override.temperature_k is None else override.temperature_k)
                self.places.setdefault(override.material, ("materials", key))
            self._add(key, number)
        if model.default_material is not None:
            self._default = len(names)
            names.append(model.default_material)
            temperatures.append(np.nan)
            self.places.setdefault(model.default_material, ("default_material",))
        else:
            self._default = self._UNKNOWN
        self.names, self.temperature = tuple(names), np.array(temperatures, float)

    def _add(self, key: str | int, number: int) -> None:
        layer, text = self._layer, str(key)
        if layer.encoding == "cryptomatte":
            self._numbers[cryptomatte_id(text)] = number
        elif layer.encoding == "colour" and _is_colour(text):
            self._numbers[int(text[1:], 16)] = number
        elif layer.encoding == "number" and text.isdecimal() and int(text) < _ID_LIMIT:
            self._numbers[int(text)] = number
        elif layer.labels is not None:
            self._by_name[text] = number
        else:
            kind = "#RRGGBB" if layer.encoding == "colour" else f"whole numbers from 0 to {_ID_LIMIT - 1}"
            raise self._frame.error(
                ("materials", key), f"found the key '{key}'; allowed: {kind}; give buffers.ids.labels to use names"
            )

    def pixels(self, mark: str, hit: Booleans) -> PixelMaterials:
        """Entries of the pixels of a frame.

        Parameters
        ----------
        hit : (rows, columns) bool array
            Pixels that meet a surface by their depth.

        Raises
        ------
        InputError
            The file is wrong, its size differs, or an id has no entry and the frame no default.
        """
        ids, share, names = self._ids(mark)
        if ids.shape[:2] != hit.shape:
            raise _other_size(self._frame, "ids", ids.shape, hit.shape)
        share = np.where(hit[..., None], share, 0.0)
        present = share > 0
        number, unknown = self._looked_up(ids, present, names)
        self._check_known(unknown, names, int(np.prod(hit.shape)))
        number[number == self._UNKNOWN] = self._default
        share = np.where(number == self._SKY, 0.0, share)
        number = np.maximum(number, 0)
        if number.shape[-1] > PARTS:  # the greatest shares
            largest = np.argsort(-share, axis=-1, kind="stable")[..., :PARTS]
            number, share = np.take_along_axis(number, largest, axis=-1), np.take_along_axis(share, largest, axis=-1)
        if share.shape[-1] > 1:
            total = share.sum(axis=-1, keepdims=True)
            share = np.divide(share, total, out=np.zeros_like(share), where=total > 0)
        return PixelMaterials(number, share, {self._label(code, names): count for code, count in unknown.items()})

    def _ids(self, mark: str) -> tuple[Integers, Floats, dict[int, str]]:
        """Ids and shares (rows, columns, M), and the names that the files give to ids."""
        layer = self._layer
        path = self._frame.path(("buffers", "ids", "file"), mark)
        if layer.encoding == "cryptomatte":
            if layer.layer is None:
                raise self._frame.error(
                    ("buffers", "ids"), "found no layer; allowed: that of Cryptomatte, such as ViewLayer.CryptoMaterial"
                )
            codes, coverage, names = read_cryptomatte(path, layer.layer)
            return codes.astype(np.int64), np.where(codes > 0, np.maximum(coverage, 0), 0.0).astype(float), names
        buffer = Stored(read_layer(path, layer.layer), path)
        ids = _colours(buffer) if layer.encoding == "colour" else _whole_numbers(buffer)
        return ids[..., None], np.ones((*ids.shape, 1)), self._labels(layer, mark)

    def _labels(self, layer: IdLayer, mark: str) -> dict[int, str]:
        """Names of ids by the file of labels: of several, the one that the table names."""
        if layer.labels is None:
            return {}
        path = self._frame.path(("buffers", "ids", "labels"), mark)
        names = {}
        for text, labels in read_labels(path).items():
            digits = [part.strip() for part in text.strip("()").split(",")]
            if not all(digit.isdecimal() for digit in digits) or len(digits) not in (1, 3, 4):
                raise InputError(f"names '{text}'; allowed: a number, or (red, green, blue, alpha)", file=path)
            red, *green_blue = map(int, digits)
            code = red if not green_blue else red << 16 | green_blue[0] << 8 | green_blue[1]
            names[code] = next((name for name in labels if name in self._by_name), next(iter(labels), ""))
        return names

    def _looked_up(self, ids: Integers, present: Booleans, names: dict[int, str]) -> tuple[Integers, dict[int, int]]:
        """Entries of ids, and the pixels of those that have none."""
        codes, kind = _distinct(np.where(present, ids, ids[present][0] if present.any() else 0))
        entries = np.array([self._entry(int(code), names) for code in codes], np.int64)
        number: Integers = entries[kind].reshape(ids.shape)
        lacking = present & (number == self._UNKNOWN)
        if not lacking.any():
            return number, {}
        strangers, counts = np.unique(ids[lacking], return_counts=True)
        return number, {int(code): int(count) for code, count in zip(strangers, counts, strict=True)}

    def _entry(self, code: int, names: dict[int, str]) -> int:
        if code in self._numbers:
            return self._numbers[code]
        return self._by_name.get(names.get(code, ""), self._UNKNOWN)

    def _check_known(self, unknown: dict[int, int], names: dict[int, str], pixels: int) -> None:
        if unknown and self._default == self._UNKNOWN:
            by_count = sorted(unknown, key=lambda code: -unknown[code])
            listed = ", ".join(
                f"{self._label(code, names)} ({unknown[code] / pixels:.2%})" for code in by_count[:_SHOWN]
            )
            more = f" and {len(by_count) - _SHOWN} more" if len(by_count) > _SHOWN else ""
            raise self._frame.error(
                ("materials",),
                f"found the ids {listed}{more} of the pixels, which are not named here; add them, or give"
                " default_material",
            )

    def _label(self, code: int, names: dict[int, str]) -> str:
        """An id in the words of the file."""
        if self._layer.encoding == "colour":
            text = f"#{code:06X}"
        else:
            text = f"{code:08x}" if self._layer.encoding == "cryptomatte" else str(code)
        return f"{text} '{names[code]}'" if names.get(code) else text


def check_size(frame: LoadedFrame, name: str, buffer: Stored, shape: tuple[int, ...]) -> None:
    """Refuse a buffer of another size than the depth.

    Raises
    ------
    InputError
    """
    if buffer.values.shape[:2] != shape:
        raise _other_size(frame, name, buffer.values.shape, shape)


def _other_size(frame: LoadedFrame, name: str, size: tuple[int, ...], shape: tuple[int, ...]) -> InputError:
    return frame.error(
        ("buffers", name, "file"),
        f"found {size[1]} x {size[0]} pixels; allowed: those of the depth, {shape[1]} x {shape[0]}; render alike",
    )


def _whole_numbers(buffer: Stored) -> Integers:
    values = buffer.values[..., 0]
    if not buffer.is_integer:
        with np.errstate(invalid="ignore"):
            integral = (values == np.rint(values)) & (values >= 0) & (values < _ID_LIMIT)
        buffer.refuse(~integral, "an id that is no whole number", "whole numbers; render ids without filter or samples")
    elif values.dtype.kind == "i":
        buffer.refuse(values < 0, "an id below 0", "whole numbers from 0")
    return values.astype(np.int64)


def _colours(buffer: Stored) -> Integers:
    values = buffer.channels(3, "red, green and blue")
    if values.dtype != np.uint8:
        raise InputError(f"has colours as {values.dtype}; allowed: 8 bits a channel; save it as PNG", file=buffer.path)
    red, green, blue = (values[..., channel].astype(np.int64) for channel in range(3))
    colour: Integers = red << 16 | green << 8 | blue
    return colour


def _is_colour(text: str) -> bool:
    digits = text.removeprefix("#")
    return len(text) == 7 and len(digits) == 6 and all(digit in "0123456789abcdefABCDEF" for digit in digits)


def _distinct(ids: Integers) -> tuple[Integers, Integers]:
    """Different ids, and the place of each pixel's among them."""
    if ids.max(initial=0) < 1 << 16:  # a table of them takes a tenth of the time of sorting
        present = np.bincount(ids.ravel(), minlength=1) > 0
        return np.flatnonzero(present), (np.cumsum(present) - 1)[ids.ravel()]
    codes, kind = np.unique(ids, return_inverse=True)
    return codes, kind.ravel()
