"""Spectra as laboratories and libraries publish them: text of ECOSTRESS, ASTER and the USGS, CSV, and ENVI libraries.

Every reader gives wavelength [um] and reflectance [0 to 1]; what a file says of its units is believed where its values
agree, and asked for where it says nothing.
"""

from __future__ import annotations

import locale
import re
import tempfile
import warnings
from dataclasses import dataclass
from pathlib import Path
from statistics import mode
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import read_text
from skyshine.schemas.errors import InputError

LEAST_POINTS = 10  # wavelengths of a spectrum
DELETED = -1e30  # the USGS writes -1.23e34 in deleted channels
HIGHEST = 1.1  # highest reflectance: noise of a bright sample against a white standard
# Where a file says no scale and its largest value lies between both, it may be a bright fraction or a dark percentage.
DARKEST_PERCENT = 5.0
_IN_UM = {"um": 1.0, "nm": 1e-3, "angstrom": 1e-4, "m": 1e6}
UNITS, SCALES, QUANTITIES = (*_IN_UM, "cm-1"), ("fraction", "percent"), ("reflectance", "emissivity")
_SPECTRAL = re.compile(r"^(?!.*(std|dev|error|sigma|uncert)).*(refl|emi[st]|absorpt|absorbance|transmi)")
_DECIMAL_COMMA = re.compile(r"\s*[-+]?\d*(,\d+)?([eE][-+]?\d+)?\s*")
ENVI_UNITS = {
    "micrometers": "um",
    "microns": "um",
    "um": "um",
    "nanometers": "nm",
    "nm": "nm",
    "angstroms": "angstrom",
    "meters": "m",
    "wavenumber": "cm-1",
}


@dataclass(frozen=True)
class Said:
    """What the user says of a file, in place of what it says itself.

    Attributes
    ----------
    unit : str or None
        Unit among `UNITS`.
    scale : str or None
        Scale among `SCALES`.
    quantity : str or None
        Quantity among `QUANTITIES`.
    wavelengths : Path or None
        File of wavelengths of a USGS spectrum, which contains none.
    record : str or None
        Name of the spectrum in a library or of its column in a table.
    """

    unit: str | None = None
    scale: str | None = None
    quantity: str | None = None
    wavelengths: Path | None = None
    record: str | None = None


@dataclass(frozen=True, eq=False)
class FileSpectrum:
    """A spectrum of a file.

    Attributes
    ----------
    wavelength : (N,) array
        [um], increasing.
    reflectance : (N,) array
        0 to 1.
    title : str
        Name of the sample, as the file gives it.
    read_as : str
        Format, unit, scale and quantity in which it was read.
    """

    wavelength: Floats
    reflectance: Floats
    title: str
    read_as: str


@dataclass(frozen=True, eq=False)
class _Raw:
    """Columns of a file with what it says of them."""

    x: Floats
    y: Floats
    form: str
    title: str = ""
    unit: str | None = None
    scale: str | None = None
    quantity: str | None = None


def read_spectrum(file: Path, stated: Said) -> FileSpectrum:
    """The spectrum of a file of any of the formats.

    Parameters
    ----------
    file : Path
        An ENVI library is given by its header (.hdr) or data file (.sli, .slb).
    stated : Said

    Raises
    ------
    InputError
        The file cannot be read, does not say its unit, or its values contradict what it says.
    """
    raw = _envi(file, stated) if file.suffix.lower() in (".hdr", ".sli", ".slb") else _text(file, stated)
    keep = (raw.y > DELETED) & np.isfinite(raw.x) & np.isfinite(raw.y)
    if keep.sum() < LEAST_POINTS:
        raise InputError(f"found {keep.sum()} points; allowed: a spectrum of at least {LEAST_POINTS}", file=file)
    unit = stated.unit or raw.unit or _guessed_unit(file, raw.x[keep])
    quantity = stated.quantity or raw.quantity or "reflectance"
    value, scale = _as_fraction(file, raw.y[keep], stated.scale, raw.scale)
    x = raw.x[keep]
    wavelength = 1e4 / _positive(file, x) if unit == "cm-1" else x * _IN_UM[unit]
    if not np.all((wavelength > 0.05) & (wavelength < 1000.0)):
        raise InputError(
            f"found wavelengths of {wavelength.min():g} to {wavelength.max():g} um when read in {unit}; give --unit",
            file=file,
        )
    reflectance = 1.0 - value if quantity == "emissivity" else value
    wavelength, reflectance = _ordered(wavelength, np.clip(reflectance, 0.0, 1.0))
    return FileSpectrum(wavelength, reflectance, raw.title, f"{raw.form}, {unit}, {quantity} in {scale}")


def _positive(file: Path, x: Floats) -> Floats:
    if np.any(x <= 0.0):
        raise InputError(f"found the wavenumber {x.min():g}; allowed: above 0; check the column and --unit", file=file)
    return x


def _guessed_unit(file: Path, x: Floats) -> str:
    """um or nm, where only one of them gives wavelengths of light and heat."""
    if x.min() >= 0.15 and x.max() <= 100.0:
        return "um"
    if 150.0 <= x.min() < 400.0 and x.max() <= 3000.0:
        return "nm"
    raise InputError(
        f"says no unit of its first column, {x.min():g} to {x.max():g}; give --unit, one of {', '.join(UNITS)}",
        file=file,
    )


def _as_fraction(file: Path, value: Floats, stated: str | None, recorded: str | None) -> tuple[Floats, str]:
    """Values as fractions, and the scale in which they were read."""
    top = float(value.max())
    looks = "fraction" if top <= HIGHEST else "percent"
    scale = stated or recorded or looks
    if stated is None and recorded is not None and recorded != looks:
        raise InputError(
            f"says that its values are {recorded}, but they reach {top:g}; give --scale fraction or percent",
            file=file,
        )
    if stated is None and recorded is None and HIGHEST < top < DARKEST_PERCENT:
        raise InputError(
            f"does not say whether its values, up to {top:g}, are fractions or percent; give --scale",
            file=file,
        )
    value = value / 100.0 if scale == "percent" else value
    if value.max() > HIGHEST or value.min() < -0.05:
        raise InputError(
            f"found values from {value.min():g} to {value.max():g} when read as {scale}; allowed: 0 to 1", file=file
        )
    return value, scale


def _ordered(wavelength: Floats, reflectance: Floats) -> tuple[Floats, Floats]:
    """By increasing wavelength, repeated wavelengths averaged."""
    nodes, inverse = np.unique(wavelength, return_inverse=True)
    return nodes, np.bincount(inverse, weights=reflectance) / np.bincount(inverse)


def _text(file: Path, stated: Said) -> _Raw:
    lines = read_text(file).splitlines()
    rows = [numbers for numbers in map(_numbers, lines) if numbers]
    if stated.wavelengths is not None or (rows and sum(len(row) == 1 for row in rows) > len(rows) / 2):
        return _usgs(file, lines, stated)
    head = "\n".join(line for line in lines if not _numbers(line))
    wavelength_head, *heads = _column_heads(head)
    column = _column(file, heads, mode(map(len, rows)) - 1 if rows else 0, stated.record)
    pairs = np.array([(row[0], row[column]) for row in rows if len(row) > column], dtype=float).reshape(-1, 2)
    match = re.search(r"^\s*Name\s*:\s*(.+)$", head, re.MULTILINE)
    form = (
        "ECOSTRESS or ASTER text" if re.search(r"^\s*[XY] Units\s*:", head, re.MULTILINE | re.IGNORECASE) else "columns"
    )
    value = heads[column - 1].lower() if len(heads) >= column else ""
    title = match.group(1).strip() if match else stated.record or ""
    return _Raw(
        pairs[:, 0], pairs[:, 1], form, title, _unit(wavelength_head.lower()), _scale(value), _quantity(file, value)
    )


def _column(file: Path, heads: list[str], columns: int, record: str | None) -> int:
    """Number of the column of values, from 1: the one of this name; without a name the only one, or the only one that
    says it is of a spectrum (others may be its scatter).
    """
    names = [head.strip() for head in heads[: max(columns, 0)]]
    names_text = ", ".join(names[:8]) + (" ..." if len(names) > 8 else "")
    if record is not None:
        if record not in names:
            raise InputError(f"contains no column '{record}'; it has {names_text or 'no names of columns'}", file=file)
        return names.index(record) + 1
    spectra = [number for number, name in enumerate(names, 1) if _SPECTRAL.search(name.lower())]
    if columns <= 1 or len(spectra) == 1:
        return spectra[0] if columns > 1 else 1
    if not names:
        raise InputError(f"found {columns + 1} columns without names; allowed: 2, or names in a line above", file=file)
    raise InputError(f"contains {columns} columns of values; name one with --record: {names_text}", file=file)


def _numbers(line: str) -> list[float]:
    """Numbers of a line that has nothing else, separated by commas, semicolons or blanks; after semicolons and tabs a
    comma is decimal.
    """
    parts = re.split(r"[;\t]", line)
    if len(parts) < 2 or not all(map(_DECIMAL_COMMA.fullmatch, parts)):
        parts = re.split(r"[,;\s]+", line.strip())
    try:
        return [float(part.replace(",", ".")) for part in parts if part.strip()]
    except ValueError:
        return []


def _column_heads(head: str) -> list[str]:
    """What a file says of its columns; at least one."""
    x = re.search(r"^\s*X Units\s*:(.*)$", head, re.MULTILINE | re.IGNORECASE)
    y = re.search(r"^\s*Y Units\s*:(.*)$", head, re.MULTILINE | re.IGNORECASE)
    if x and y:
        return [x.group(1), y.group(1)]
    lines = [line for line in head.splitlines() if line.strip() and re.search(r"[,;\t]", line)]
    parts = re.split(r"[,;\t]", lines[-1]) if lines else []
    return [part.strip().strip("\"'") for part in parts] if len(parts) >= 2 else [""]


def _unit(text: str) -> str | None:
    if re.search(r"cm\s*\^?-\s*1|1/cm|wavenumber", text):
        return "cm-1"
    if re.search(r"nano|\bnm\b|_nm", text):
        return "nm"
    if re.search(r"micro|\bum\b|_um|\u00b5m|\u03bcm", text):
        return "um"
    if re.search(r"angstrom|\u00e5", text):
        return "angstrom"
    return "m" if re.search(r"[(\[_,]\s*m\b|\bmet(er|re)s?\b", text) else None


def _scale(text: str) -> str | None:
    if "percent" in text or "%" in text:
        return "percent"
    return "fraction" if "fraction" in text else None


def _quantity(file: Path, text: str) -> str | None:
    """What a head of values names; absorptance of an opaque sample is its emissivity."""
    if wrong := re.search(r"transmi\w*|absorbance", text):
        raise InputError(f"contains {wrong.group()}; allowed: reflectance, emissivity or absorptance", file=file)
    return "emissivity" if re.search("emi[st]|absorpt", text) else "reflectance" if re.search("refl", text) else None


def _usgs(file: Path, lines: list[str], stated: Said) -> _Raw:
    """A spectrum of the USGS library 7 as text: a title, then one value a channel."""
    if stated.wavelengths is None:
        raise InputError(
            "contains one column; a spectrum of the USGS needs its file of wavelengths: give --wavelengths FILE",
            file=file,
        )
    value = _one_column(lines)
    wavelength = _one_column(read_text(stated.wavelengths).splitlines())
    if len(value) != len(wavelength):
        raise InputError(
            f"contains {len(value)} values and {stated.wavelengths.name} {len(wavelength)} wavelengths; give the file "
            "of the same spectrometer",
            file=file,
        )
    title = re.sub(r"^\s*splib\w+\s+Record=\d+:\s*", "", lines[0]).strip() if lines else ""
    return _Raw(
        np.where(value > DELETED, wavelength, np.nan), value, "USGS text", title, None, "fraction", "reflectance"
    )


def _one_column(lines: list[str]) -> Floats:
    return np.array([row[0] for row in map(_numbers, lines) if len(row) == 1], dtype=float)


def _envi(file: Path, stated: Said) -> _Raw:
    """A spectrum of an ENVI spectral library, by the header reader of Spectral Python."""
    header = file if file.suffix.lower() == ".hdr" else _header(file)
    fields, values = _envi_library(header, file)
    named = fields.get("spectra names") or range(1, len(values) + 1)
    names = [named] if isinstance(named, str) else [str(name) for name in named]  # one needs no braces
    if stated.record is None and len(names) > 1:
        raise InputError(
            f"contains {len(names)} spectra; name one with --record: {', '.join(names[:8])} ...", file=file
        )
    if stated.record is not None and stated.record not in names:
        raise InputError(f"contains no spectrum '{stated.record}'; it has {', '.join(names[:8])} ...", file=file)
    index = names.index(stated.record) if stated.record is not None else 0
    try:
        wavelength, value = np.array(fields["wavelength"], float), values[index].astype(float)
        value[value == float(fields.get("data ignore value", "nan"))] = np.nan
        good = np.array(fields.get("bbl", np.ones(len(value))), float)
        value[good == 0] = np.nan  # the bad bands list
        factor = float(fields.get("reflectance scale factor", "1"))
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise InputError(f"is no ENVI spectral library: {error}; check its header", file=header) from None
    if len(wavelength) != len(value) or not factor > 0:
        raise InputError(
            f"has {len(wavelength)} wavelengths for {len(value)} values, and the reflectance scale factor {factor:g};"
            " allowed: as many, and above 0; check its header",
            file=header,
        )
    unit = str(fields.get("wavelength units", "")).strip().lower()
    scale = None if factor == 1 else "fraction"
    with np.errstate(over="ignore"):  # values beyond all limits are refused as such
        value = value / factor
    return _Raw(wavelength, value, "ENVI library", names[index], ENVI_UNITS.get(unit) or _unit(unit), scale)


def _envi_library(header: Path, file: Path) -> tuple[dict[str, Any], npt.NDArray[Any]]:
    """Fields of the header, and values (spectra, bands) as they are stored."""
    try:
        from spectral.io import envi
    except ImportError:
        raise InputError("an ENVI library needs Spectral Python: pip install 'skyshine[envi]'", file=file) from None
    data = file if file != header else _data_file(header)
    try:
        with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings of names of fields in capitals
            plain = Path(folder, "header.hdr")  # Spectral Python reads the encoding of the system alone
            plain.write_text(read_text(header), encoding=locale.getencoding(), errors="replace")
            fields = dict(envi.read_envi_header(str(plain)))
            layout = envi.gen_params(fields)
        if "spectral library" not in str(fields.get("file type", "")).lower():
            raise InputError("is no ENVI spectral library but another file of ENVI; give a library", file=header)
        offset = int(fields.get("header offset", 0))
        values = np.fromfile(data, layout.dtype, layout.ncols * layout.nrows, offset=offset)
        return fields, values.reshape(layout.nrows, layout.ncols)
    except InputError:
        raise
    except Exception as error:  # a reader of another project: whatever it raises, the file is at fault
        raise InputError(f"is no ENVI spectral library: {error}; give its .hdr file", file=header) from None


def _data_file(header: Path) -> Path:
    stem = header.with_suffix("")
    for candidate in (stem, *(Path(f"{stem}{ending}") for ending in (".sli", ".slb", ".dat", ".img", ".lib"))):
        if candidate.is_file():
            return candidate
    raise InputError(f"has no data file {stem.name}.sli beside it; give both files", file=header)


def _header(file: Path) -> Path:
    for candidate in (file.with_suffix(".hdr"), Path(f"{file}.hdr")):
        if candidate.is_file():
            return candidate
    raise InputError(f"has no header {file.with_suffix('.hdr').name} beside it; give both files", file=file)
