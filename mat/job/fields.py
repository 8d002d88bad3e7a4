"""Kinds of field that several parts of a job have."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field
from pydantic_core import CoreSchema

_CLOCK = re.compile(r"^([0-9]{1,2}):([0-5][0-9])(?::([0-5][0-9]))?$")


def hours_of(value: object) -> float:
    """Hours of a time of day such as 08:30; ValueError says what was found and what is allowed."""
    match = _CLOCK.match(value) if isinstance(value, str) else None
    if match is None:
        raise ValueError(f"found {value!r}; allowed: a time of day such as 08:30; write hours:minutes")
    hours = int(match[1]) + int(match[2]) / 60 + int(match[3] or 0) / 3600
    if hours >= 24:
        raise ValueError(f"found {value!r}; allowed: 00:00 to 23:59; the day is periodic, so 24:00 is 00:00")
    return hours


def clock_interval(text: str) -> tuple[float, float]:
    """Hours of an interval such as 22:00-06:00, the last up to 24:00; ValueError says what is allowed."""
    start, dash, stop = text.partition("-")
    if not dash:
        raise ValueError(f"found {text!r}; allowed: an interval such as 10:00-14:00; write first-last")
    begin, end = hours_of(start.strip()), 24.0 if stop.strip() == "24:00" else hours_of(stop.strip())
    if begin == end:
        raise ValueError(f"found {text!r}, which is empty; allowed: two different times; 00:00-24:00 is the whole day")
    return begin, end


def clock_text(hours: float) -> str:
    """A time of day as it is written in a job, such as 08:30."""
    seconds = round(hours * 3600)
    text = f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}"
    return text + (f":{seconds % 60:02d}" if seconds % 60 else "")


def ascending(values: list[float]) -> list[float]:
    for before, after in itertools.pairwise(values):
        if not after > before:
            raise ValueError(f"found {after:g} after {before:g}; allowed: strictly ascending values; sort them")
    return values


@dataclass(frozen=True)
class ReadAs:
    """Lets a field be validated as a type that is made at run time; type checkers read the annotated type.

    Attributes
    ----------
    kind : type
        An annotated type with the limits of the field.
    """

    kind: Any

    def __get_pydantic_core_schema__(self, source: Any, handler: pydantic.GetCoreSchemaHandler) -> CoreSchema:
        return handler.generate_schema(self.kind)


def axis(low: float, high: float) -> ReadAs:
    """A list of 1 to 512 strictly ascending numbers between two limits; for ``Annotated[list[float], ...]``."""
    number = Annotated[float, Field(ge=low, le=high)]
    return ReadAs(Annotated[list[number], Field(min_length=1, max_length=512), pydantic.AfterValidator(ascending)])


def one_of(names: tuple[str, ...]) -> ReadAs:
    """One of some names; for ``Annotated[str, ...]``."""
    return ReadAs(Literal[names])


Span = tuple[float, float]


def _ordered(span: Span) -> Span:
    if not span[0] <= span[1]:
        raise ValueError(f"found [{span[0]:g}, {span[1]:g}]; allowed: [least, most]; swap them")
    return span


def span(low: float, high: float) -> ReadAs:
    """Two numbers between limits, the lesser first; for ``Annotated[Span, ...]``."""
    number = Annotated[float, Field(ge=low, le=high)]
    return ReadAs(Annotated[tuple[number, number], pydantic.AfterValidator(_ordered)])


def _one_or_24(value: object) -> str:
    return "by_hour" if isinstance(value, list | tuple) else "constant"


def by_hour(number: Any) -> ReadAs:
    """One number for the day, or 24 at the local clock hours 0 to 23, linear between them; for
    ``Annotated[float | list[float], ...]``.
    """
    hours = Annotated[list[number], Field(min_length=24, max_length=24)]
    return ReadAs(
        Annotated[
            Annotated[number, pydantic.Tag("constant")] | Annotated[hours, pydantic.Tag("by_hour")],
            pydantic.Discriminator(_one_or_24),
        ]
    )


_TOLERANCE = re.compile(r"^([0-9]+(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?) (K|%|W m\^-2 sr\^-1)$")
SMALLEST_TOLERANCE = 1e-6


def tolerance_parts(text: str) -> tuple[float, str]:
    """Value and unit of a tolerance such as '0.1 K'."""
    number, unit = text.split(" ", 1)
    return float(number), unit


def tolerance(value: str) -> str:
    """A tolerance with its unit, as it is written.

    Raises
    ------
    ValueError
        It is none.
    """
    if not _TOLERANCE.match(value) or not SMALLEST_TOLERANCE <= tolerance_parts(value)[0] <= 1e3:
        raise ValueError(
            f"found '{value}'; allowed: a number and its unit, 0.1 K, 1 % or 0.01 W m^-2 sr^-1; write it so"
        )
    return value


def _as_text(value: object) -> object:
    """A number without its unit as text, which `tolerance` refuses by what is missing."""
    return f"{value:g}" if isinstance(value, int | float) and not isinstance(value, bool) else value


Tolerance = Annotated[
    str,
    pydantic.BeforeValidator(_as_text),
    pydantic.AfterValidator(tolerance),
    pydantic.WithJsonSchema({"type": "string", "pattern": _TOLERANCE.pattern}),
]
TimeOfDay = Annotated[
    float,
    pydantic.BeforeValidator(hours_of),
    pydantic.PlainSerializer(clock_text, return_type=str),
    pydantic.WithJsonSchema({"type": "string", "pattern": _CLOCK.pattern}),
]
Fraction = Annotated[float, Field(ge=0, le=1)]
Celsius = Annotated[float, Field(ge=-120, le=80)]
