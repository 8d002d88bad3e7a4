"""Spectral lines from HITRAN 160-column records."""

from __future__ import annotations

import gzip
import lzma
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError

RECORD_WIDTH = 160  # characters, since HITRAN 2004
UNPACKING_LIMIT = 100  # times the size of a packed file; line lists pack about tenfold
# Columns of the 160-character record, Rothman et al. 2005, JQSRT 96, 139, Table 1: name, first, last (exclusive).
_COLUMNS = {
    "wavenumber": (3, 15),
    "strength": (15, 25),
    "air_width": (35, 40),
    "self_width": (40, 45),
    "lower_energy": (45, 55),
    "temperature_exponent": (55, 59),
    "shift": (59, 67),
}
_ISOTOPOLOGUES = {ord(c): n for n, c in enumerate("1234567890AB", start=1)}


@dataclass(frozen=True)
class LineList:
    """Lines of one molecule, in the units of the HITRAN records, ordered by wavenumber.

    Attributes
    ----------
    molecule : int
        HITRAN molecule number.
    isotopologue : (N,) int array
    wavenumber : (N,) array
        cm^-1, in vacuum, at zero pressure.
    strength : (N,) array
        cm^-1 / (molecule cm^-2) at 296 K, natural abundance included.
    air_width, self_width : (N,) arrays
        Half widths at half maximum, cm^-1 atm^-1 at 296 K.
    lower_energy : (N,) array
        cm^-1.
    temperature_exponent : (N,) array
    shift : (N,) array
        Pressure shift in air, cm^-1 atm^-1.
    """

    molecule: int
    isotopologue: Integers
    wavenumber: Floats
    strength: Floats
    air_width: Floats
    self_width: Floats
    lower_energy: Floats
    temperature_exponent: Floats
    shift: Floats

    def __len__(self) -> int:
        return self.wavenumber.size

    def select(self, which: Integers | Booleans | slice) -> LineList:
        """The lines of an index, a mask or a slice."""
        arrays = {f.name: getattr(self, f.name)[which] for f in fields(self) if f.name != "molecule"}
        return LineList(molecule=self.molecule, **arrays)

    def between(self, low: float, high: float) -> LineList:
        """The lines with ``low <= wavenumber <= high`` (cm^-1)."""
        start, stop = np.searchsorted(self.wavenumber, [low, np.nextafter(high, np.inf)])
        return self.select(slice(start, stop))


def read_lines(paths: str | Path | Sequence[str | Path]) -> LineList:
    """Read HITRAN records of one molecule from one or several files, plain, ``.gz`` or ``.xz``.

    Raises
    ------
    InputError
        A file is missing, is not made of 160-column records, contains a field that is not a number, or another
        molecule.
    """
    return merge_lines([parse_records(Path(path)) for path in ([paths] if isinstance(paths, (str, Path)) else paths)])


def merge_lines(parts: Sequence[LineList]) -> LineList:
    """One list from several of the same molecule, ordered by wavenumber; an InputError where molecules differ."""
    molecules = {part.molecule for part in parts}
    if len(molecules) != 1:
        raise InputError(f"line lists of molecules {sorted(molecules)} given together; give the files of one molecule")
    arrays = {
        f.name: np.concatenate([getattr(part, f.name) for part in parts])
        for f in fields(LineList)
        if f.name != "molecule"
    }
    merged = LineList(molecule=molecules.pop(), **arrays)
    return merged.select(np.argsort(merged.wavenumber, kind="stable"))


def parse_records(path: Path) -> LineList:
    records = read_records(path)
    try:
        values = {name: column(records, start, stop).astype(float) for name, (start, stop) in _COLUMNS.items()}
        molecules = np.unique(column(records, 0, 2).astype(int))
        isotopologue = np.array([_ISOTOPOLOGUES[code] for code in records[:, 2]], dtype=np.int16)
    except (ValueError, KeyError) as error:
        raise InputError(
            f"a field of a record is not what HITRAN's 160-column format says ({error})", file=path
        ) from None
    if molecules.size != 1:
        raise InputError(f"contains molecules {molecules.tolist()}; give one molecule a file", file=path)
    return LineList(molecule=int(molecules[0]), isotopologue=isotopologue, **values)


def read_records(path: Path) -> npt.NDArray[np.uint8]:
    """Characters of a file's records, shape (N, 160), as bytes."""
    openers: dict[str, Callable[..., Any]] = {".gz": gzip.open, ".xz": lzma.open}
    try:
        max_bytes = UNPACKING_LIMIT * path.stat().st_size
        with openers.get(path.suffix, open)(path, "rb") as file:
            data: bytes = file.read(max_bytes + 1)
    except (OSError, EOFError, lzma.LZMAError, zlib.error) as error:
        raise InputError(f"cannot be read: {error}; give a file of HITRAN records", file=path) from None
    if len(data) > max_bytes:
        raise InputError(
            f"unpacks to over {UNPACKING_LIMIT} times its size; line lists do not pack so well: give another file",
            file=path,
        )
    end = data.find(b"\n")
    stride = end + 1 if end >= 0 else len(data)
    width = len(data[:stride].rstrip(b"\r\n"))
    if width != RECORD_WIDTH:
        raise InputError(
            f"its first line has {width} characters; HITRAN records have {RECORD_WIDTH}", file=path, line=1
        )
    if not data.endswith(b"\n"):
        data += data[RECORD_WIDTH:stride] if end >= 0 else b""
    if len(data) % stride:
        raise InputError(f"not every record has {RECORD_WIDTH} characters; the file is damaged", file=path)
    return np.frombuffer(data, dtype=np.uint8).reshape(-1, stride)[:, :RECORD_WIDTH]


def column(records: npt.NDArray[np.uint8], start: int, stop: int) -> npt.NDArray[np.bytes_]:
    return np.ascontiguousarray(records[:, start:stop]).view(f"S{stop - start}").ravel()
