"""Read numeric DATA statements of fixed-form Fortran 77, as LOWTRAN7 stores its tables."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np

from skyshine.schemas.arrays import Floats

_STATEMENT = re.compile(
    r"(?P<names>[A-Z][A-Z0-9]*(?:\([0-9,]+\))?(?:,[A-Z][A-Z0-9]*(?:\([0-9,]+\))?)*)/(?P<values>[^/]*)/"
)
_ELEMENT = re.compile(r"[A-Z][A-Z0-9]*(?:\([0-9,]+\))?")


def block_data(source: str | os.PathLike[str], name: str) -> dict[str, Floats]:
    """Collect the numeric DATA statements of one BLOCK DATA unit.

    Parameters
    ----------
    source : path
        Fixed-form Fortran source.
    name : str
        Name of the BLOCK DATA unit.

    Returns
    -------
    dict
        Variable name (an array element keeps its subscript, ``"A(1,2)"``) to a float array in the order written.

    Raises
    ------
    ValueError
        When the unit is not in the source.
    """
    statements = _statements(Path(source).read_text(encoding="latin-1"), name)
    values = {}
    for statement in statements:
        if not statement.startswith("DATA") or "'" in statement:
            continue
        for match in _STATEMENT.finditer(statement[4:]):
            names = _ELEMENT.findall(match["names"])
            numbers = _numbers(match["values"])
            if len(names) == 1:
                values[names[0]] = numbers
            else:
                values.update(zip(names, numbers.reshape(len(names), 1), strict=True))
    return values


def _statements(text: str, name: str) -> list[str]:
    """Statements of a BLOCK DATA unit, continuation lines joined and blanks removed."""
    statements: list[str] = []
    inside = False
    for line in text.splitlines():
        if not line.strip() or line[0] in "Cc*!":
            continue
        code = line[6:72].split("!")[0].replace(" ", "").upper()
        if not inside:
            inside = code == f"BLOCKDATA{name}"
            continue
        if code.startswith("END"):
            return statements
        if len(line) > 5 and line[5] not in " 0":
            statements[-1] += code
        else:
            statements.append(code)
    raise ValueError(f"BLOCK DATA {name} not found; the source must be LOWTRAN7's lowtran7.f")


def _numbers(text: str) -> Floats:
    """Expand a DATA value list with its repeat counts (``3*0.``)."""
    values: list[float] = []
    for item in text.split(","):
        count, _, value = item.rpartition("*")
        values += [float(value)] * int(count or 1)
    return np.array(values)
