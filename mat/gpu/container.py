"""Files of the export for graphics processors: a JSON header and its textures in one little-endian file beside it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.errors import InputError
from skyshine.schemas.format_versions import FORMAT_VERSION
from skyshine.schemas.paths import StrPath
from skyshine.schemas.whole_files import part_file

FORMAT = "skyshine-gpu"
ENDING = ".gpu.json"
_WIDTH = 1024  # texels in a row of numbers, which every graphics processor takes
ALIGNMENT = 16  # bytes; a row of RGBA32F texels
# Texel formats by numpy type and number of channels.
FORMATS = {
    "R16F": ("<f2", 1),
    "RGBA16F": ("<f2", 4),
    "R32F": ("<f4", 1),
    "RGBA32F": ("<f4", 4),
    "R16UI": ("<u2", 1),
    "RGBA16UI": ("<u2", 4),
    "R8": ("|u1", 1),
    "RGBA8": ("|u1", 4),
}


@dataclass(frozen=True, eq=False)
class Texture:
    """One texture.

    Attributes
    ----------
    format : str
        One of `FORMATS`.
    texels : (depth, height, width, channels) array
    what : str
        Content of a texel, with its unit.
    """

    format: str
    texels: npt.NDArray[Any]
    what: str

    @property
    def size(self) -> tuple[int, int, int]:
        """Width, height and depth."""
        depth, height, width = self.texels.shape[:3]
        return width, height, depth


@dataclass(frozen=True, eq=False)
class GpuFile:
    """One exported database.

    Attributes
    ----------
    kind : str
        ``atmosphere``, ``band``, ``surface`` or ``texture``.
    source : dict
        Name and digest of the database.
    numbers : dict
        What a reader needs beside the textures: axes, counts, constants.
    stated_error : dict
        Difference from the library in double precision.
    """

    kind: str
    source: dict[str, Any]
    textures: dict[str, Texture]
    numbers: dict[str, Any] = field(default_factory=dict)
    stated_error: dict[str, Any] = field(default_factory=dict)


def texture(kind: str, values: npt.ArrayLike, what: str) -> Texture:
    """A texture of values (..., channels), (..., ) for one channel; missing axes are put in front.

    Raises
    ------
    InputError
        A value does not fit the format: it is not finite, or beyond its largest number.
    """
    dtype, channels = FORMATS[kind]
    array = np.asarray(values)
    array = array[..., None] if channels == 1 else array
    array = array.reshape((1,) * (4 - array.ndim) + array.shape)
    limit = float(np.finfo(dtype).max if "f" in dtype else np.iinfo(dtype).max)
    if array.size and (not np.all(np.isfinite(array)) or np.abs(array).max() > limit):
        raise InputError(f"{what}: found a value that is not finite or beyond {limit:g}; allowed: a number of {kind}")
    return Texture(kind, np.ascontiguousarray(array, dtype), what)


def rows_of_four(values: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Numbers (n,) as texels (rows, width) of one channel, the last row filled up with the last number."""
    flat = np.asarray(values, np.float32).ravel()
    width = min(_WIDTH, flat.size)
    rows = -(-flat.size // width)
    return np.pad(flat, (0, rows * width - flat.size), mode="edge").reshape(rows, width)


def header_of(content: GpuFile, data: str) -> tuple[dict[str, Any], list[bytes]]:
    """The header of a file, and the pieces of its data in order."""
    described: dict[str, Any] = {}
    pieces: list[bytes] = []
    offset = 0
    for name, part in content.textures.items():
        bytes_ = part.texels.tobytes()
        described[name] = {
            "format": part.format,
            "size": list(part.size),
            "offset": offset,
            "bytes": len(bytes_),
            "what": part.what,
        }
        pieces.append(bytes_ + b"\0" * (-len(bytes_) % ALIGNMENT))
        offset += len(pieces[-1])
    header = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "kind": content.kind,
        "source": content.source,
        "data": data,
        "bytes": offset,
        "stated_error": content.stated_error,
        "textures": described,
        "numbers": content.numbers,
    }
    return header, pieces


def write_gpu(content: GpuFile, folder: StrPath, name: str) -> Path:
    """Write ``NAME.gpu.json`` and ``NAME.gpu.bin``; the header is written last.

    Raises
    ------
    InputError
        The folder cannot be written.
    """
    target = Path(folder) / f"{name}{ENDING}"
    header, pieces = header_of(content, f"{name}.gpu.bin")
    data = target.with_name(str(header["data"]))
    parts = [part_file(path) for path in (data, target)]
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        parts[0].write_bytes(b"".join(pieces))
        parts[1].write_text(_text(header), encoding="utf-8")
        os.replace(parts[0], data)
        os.replace(parts[1], target)
    except OSError as error:
        raise InputError(
            f"cannot be written: {error.strerror or error}; check free space and permissions", file=target
        ) from None
    finally:
        for part in parts:
            part.unlink(missing_ok=True)
    return target


def _text(header: Mapping[str, Any]) -> str:
    """The header, with a line for each of its keys and of the entries under them."""
    lines = []
    for key, value in header.items():
        text = json.dumps(value, allow_nan=False, separators=(",", ":"))
        if isinstance(value, dict) and value:
            entries = [
                f"  {json.dumps(name)}: {json.dumps(entry, allow_nan=False, separators=(',', ':'))}"
                for name, entry in value.items()
            ]
            text = "{\n" + ",\n".join(entries) + "\n }"
        lines.append(f" {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"
