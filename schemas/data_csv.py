"""CSV data files with a commented header that says where the numbers came from."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt


def read_csv(path: str | os.PathLike[str]) -> dict[str, npt.NDArray[Any]]:
    """Read a numeric CSV data file.

    Parameters
    ----------
    path : path
        Lines that begin with ``#`` are provenance, the first other line names the columns.

    Returns
    -------
    dict
        Column name to array; a column with text in it is an array of text.
    """
    lines = [line for line in Path(path).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    names = lines[0].split(",")
    columns = np.array([line.split(",") for line in lines[1:]]).T
    return {name: _as_numbers(column) for name, column in zip(names, columns, strict=True)}


def write_csv(
    path: str | os.PathLike[str],
    header: Sequence[str],
    columns: Sequence[str],
    rows: Iterable[Iterable[float | str]],
) -> None:
    """Write rows under commented header lines.

    Parameters
    ----------
    path : path
    header : sequence of str
        Lines of provenance; each is prefixed with ``#``.
    columns : sequence of str
        Column names, units in brackets.
    rows : iterable of sequences
        Text is written as it is, numbers with nine significant digits.
    """
    lines = [f"# {line}" for line in header]
    lines.append(",".join(columns))
    lines += [",".join(item if isinstance(item, str) else f"{float(item):.9g}" for item in row) for row in rows]
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _as_numbers(column: npt.NDArray[Any]) -> npt.NDArray[Any]:
    try:
        return column.astype(float)
    except ValueError:
        return column
