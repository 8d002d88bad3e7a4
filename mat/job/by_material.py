"""Values that a job gives for all of its materials, or for each by its name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


def kind_of(value: object) -> str:
    """By which of its models pydantic reads a value: ``by_material``, ``word`` or ``number``."""
    if isinstance(value, Mapping):
        return "by_material"
    return "word" if isinstance(value, str) else "number"


def value_for(values: Any, name: str) -> float | str | None:
    """What a value for all materials, or for some by name, says of one; None where it says nothing."""
    value: float | str | None = values.get(name) if isinstance(values, Mapping) else values
    return value
