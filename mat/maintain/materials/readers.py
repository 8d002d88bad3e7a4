"""Source spectra as published: one reader a collection, each giving wavelength [um] and reflectance [0-1]."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
import yaml

from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


def read_ecostress(file: Path, unit: str) -> tuple[Floats, Floats]:
    """An ECOSTRESS or ASTER text file: header, blank line, two columns in either order of wavelength.

    Parameters
    ----------
    unit : str
        "percent" or "fraction". Some files of the library have fractions under a header that says percent, so the
        unit is stated by the recipe and checked against the values here.

    Raises
    ------
    InputError
        The file cannot be read, or its values contradict the unit.
    """
    rows = []
    for line in _text(file).splitlines():
        parts = line.split()
        if len(parts) == 2 and ":" not in line:
            try:
                rows.append((float(parts[0]), float(parts[1])))
            except ValueError:
                continue
    if len(rows) < 10:
        raise InputError(f"found {len(rows)} rows of numbers; allowed: a library spectrum of at least 10", file=file)
    wavelength, value = _ordered(np.array(rows))
    # A material that reflects at most 1.05 % everywhere does not occur among the samples used.
    looks = "fraction" if value.max() <= 1.05 else "percent"
    if looks != unit:
        raise InputError(f"found values up to {value.max():g}, which are {looks}; the recipe says {unit}", file=file)
    return wavelength, value / 100.0 if unit == "percent" else value


def read_slum(folder: Path, sample: str) -> tuple[Floats, Floats]:
    """Short-wave reflectance and 1 - long-wave emissivity of one SLUM sample, 0.35-2.51 and 8.0-14.0 um."""
    short = _column(folder / "LUMA_SLUM_SW.csv", sample)
    long = _column(folder / "LUMA_SLUM_IR.csv", sample)
    wavelength = np.concatenate([short[0] / 1000.0, long[0]])
    return wavelength, np.concatenate([short[1] / 100.0, 1.0 - long[1]])


def read_usgs(file: Path) -> tuple[Floats, Floats]:
    """A spectrum of the USGS library 7 kept as JSON; deleted channels are null and skipped."""
    content = json.loads(_text(file))
    pairs = [
        (x, y)
        for x, y in zip(content["wavelengths"], content["reflectance"], strict=True)
        if x is not None and y is not None
    ]
    wavelength, value = _ordered(np.array(pairs, dtype=float))
    good = np.isfinite(value) & (value >= 0.0)
    return wavelength[good], value[good]


def read_nist_skin(file: Path, sample: str = "") -> tuple[Floats, Floats]:
    """Mean reflectance factor of the forearms of all subjects, or of some of them, 0.25-2.5 um.

    Parameters
    ----------
    sample : str
        "lightest" or "darkest": the tenth of the subjects that reflect most or least of 0.4 to 0.7 um; "" for all.
    """
    rows = [[_number(cell) for cell in row] for row in csv.reader(_text(file, "latin-1").splitlines())]
    table = np.array([row for row in rows if row and row[0] is not None and 200.0 <= row[0] <= 3000.0], float)
    wavelength, subjects = table[:, 0] / 1000.0, table[:, 4::4]  # three readings and their mean for each subject
    if not np.isfinite(subjects[:1]).any():
        raise InputError(
            "found no means of subjects; allowed: the table of NIST, the mean in every fourth column", file=file
        )
    subjects = subjects[:, np.isfinite(subjects).all(axis=0)]
    if sample:
        visible = subjects[(wavelength >= 0.4) & (wavelength <= 0.7)].mean(axis=0)
        order = np.argsort(visible if sample == "darkest" else -visible)
        subjects = subjects[:, order[: max(1, len(order) // 10)]]
    return _ordered(np.column_stack([wavelength, subjects.mean(axis=1)]))


def read_constants(file: Path) -> tuple[Floats, npt.NDArray[np.complex128]]:
    """Wavelength [um] and complex refractive index n + ik of a refractiveindex.info file.

    Understands tabulated n and k, and dispersion formula 5 (n = c1 + sum of c_i lambda^c_(i+1)) with tabulated k.
    """
    blocks = yaml.safe_load(_text(file))["DATA"]
    kinds = {block["type"]: block for block in blocks}
    if "tabulated nk" in kinds:
        table = np.array([line.split() for line in kinds["tabulated nk"]["data"].strip().splitlines()], dtype=float)
        return table[:, 0], table[:, 1] + 1j * table[:, 2]
    if set(kinds) == {"formula 5", "tabulated k"}:
        table = np.array([line.split() for line in kinds["tabulated k"]["data"].strip().splitlines()], dtype=float)
        coefficients = [float(part) for part in kinds["formula 5"]["coefficients"].split()]
        index = np.full(len(table), coefficients[0])
        for factor, power in zip(coefficients[1::2], coefficients[2::2], strict=True):
            index += factor * table[:, 0] ** power
        return table[:, 0], index + 1j * table[:, 1]
    raise InputError(f"found data of type {', '.join(kinds)}; allowed: tabulated nk, or formula 5 with k", file=file)


def _text(file: Path, encoding: str = "utf-8") -> str:
    try:
        return file.read_text(encoding=encoding, errors="replace")
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; give the folder of the spectra", file=file) from None


def _column(file: Path, sample: str) -> tuple[Floats, Floats]:
    rows = list(csv.reader(_text(file).splitlines()))
    if sample not in rows[0]:
        raise InputError(f"contains no sample {sample}", file=file)
    position = rows[0].index(sample)
    pairs = [(_number(row[0]), _number(row[position])) for row in rows[1:] if row]
    return _ordered(np.array([pair for pair in pairs if None not in pair]))


def _number(cell: str) -> float | None:
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if np.isfinite(value) else None


def _ordered(table: Floats) -> tuple[Floats, Floats]:
    """Columns by increasing wavelength, repeated wavelengths averaged."""
    wavelength, inverse = np.unique(table[:, 0], return_inverse=True)
    total = np.bincount(inverse, weights=table[:, 1])
    return wavelength, total / np.bincount(inverse)
