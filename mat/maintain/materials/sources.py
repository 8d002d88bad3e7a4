"""Counts the sources of the numbers of the library by kind: `python -m mat.maintain.materials.sources`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from typing import Literal, TypeAlias, get_args

from skyshine.materials.files import USER
from skyshine.materials.library import load_library
from skyshine.materials.records import Material
from skyshine.schemas.commands import echo_table
from skyshine.schemas.errors import InputError

SourceKind: TypeAlias = Literal["cited", "derived", "definition", "estimate", "user"]
KINDS: tuple[SourceKind, ...] = get_args(SourceKind)
SPECTRUM = "reflectance"  # its ranges have origins of their own
# Number or name of a layer, of a part of the light, of a back in operation.
_NUMBER_OR_NAME = re.compile(r"\.\d+|(?<=^operated)\.\w+")


def kind_of(source: str) -> SourceKind:
    """Kind of a source by how its text begins.

    Parameters
    ----------
    source : str
        ``[key] ...`` is cited; ``derived...``, ``definition: ...``, ``estimate: ...`` and ``user`` are themselves.

    Raises
    ------
    InputError
        The text begins otherwise.

    Examples
    --------
    >>> kind_of("[oke1987] table 2.1, peat")
    'cited'
    """
    if source.startswith("["):
        return "cited"
    for kind in KINDS[1:]:
        if re.match(rf"{kind}\b", source):
            return kind
    raise InputError(
        f"found the source '{source}'; allowed: [reference] and the place in it, derived:, definition:, estimate: or"
        f" {USER}; say which it is"
    )


def count_kinds(materials: Iterable[Material]) -> dict[str, Counter[SourceKind]]:
    """How many values have each kind of source, by field; layers count as one field, and so do backs in operation."""
    counts: dict[str, Counter[SourceKind]] = {}
    for material in materials:
        for field, source in material.sources.items():
            if field != SPECTRUM:
                counts.setdefault(_NUMBER_OR_NAME.sub("", field), Counter())[kind_of(source)] += 1
    return counts


def main() -> None:
    """Print the number of values by field and kind; spectra have origins by range and do not count."""
    counts = count_kinds(load_library())
    total = sum(counts.values(), Counter[SourceKind]())
    rows = [[field, *(str(count[kind]) for kind in KINDS)] for field, count in counts.items()]
    echo_table(["field", *KINDS], [*rows, ["all", *(str(total[kind]) for kind in KINDS)]])


if __name__ == "__main__":
    main()
