"""Headers of tables as people write them: ``name[unit]``, ``name (unit)``, ``name_unit``, in any case and spelling."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping

_BRACKETS = re.compile(r"([^\[(]*)[\[(]([^\])]*)[\])]?\s*")


def folded(name: str) -> str:
    """A name in lower case, with one underscore in place of blanks, hyphens and dots.

    Examples
    --------
    >>> folded("Dew-Point  Temperature")
    'dew_point_temperature'
    """
    return re.sub(r"[\s_.-]+", "_", name.strip().lower()).strip("_")


def column_of(head: str, names: Mapping[str, str], units: Mapping[str, Collection[str]]) -> tuple[str | None, str]:
    """The quantity that a header names, None where it is none of ours, and its unit, empty where it names none.

    Parameters
    ----------
    head : str
        Head of the column as written.
    names : mapping
        Folded spelling to the name of a quantity.
    units : mapping
        Units by quantity that may follow its name after an underscore or blank.

    Examples
    --------
    >>> column_of("Temp (C)", {"temp": "temperature"}, {"temperature": ["C"]})
    ('temperature', 'C')
    >>> column_of("temp_C", {"temp": "temperature"}, {"temperature": ["C"]})
    ('temperature', 'C')
    """
    brackets = _BRACKETS.fullmatch(head)
    if brackets is not None:
        return names.get(folded(brackets[1])), brackets[2].strip()
    recognised = names.get(folded(head))
    if recognised is not None:
        return recognised, ""
    for separator in "_ ":
        stem, _, suffix = head.strip().rpartition(separator)
        quantity = names.get(folded(stem)) if stem else None
        if quantity is not None and unit_of(suffix, units[quantity]) is not None:
            return quantity, suffix
    return None, ""


def unit_of(text: str, units: Collection[str]) -> str | None:
    """The unit among `units` that is written, in the same letters or else in any case; None where it is none."""
    if text in units:
        return text
    plain = text.replace("\u00b5", "u").replace("\u03bc", "u")
    return next((unit for unit in units if unit.casefold() == plain.casefold()), None)
