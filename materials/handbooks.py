"""Ranges of solar absorptance and thermal emissivity in handbooks: `materials/handbooks.yaml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Self

from pydantic import Field, model_validator

from skyshine import materials
from skyshine.materials.files import Fraction
from skyshine.schemas.documents import StrictModel, Text, load_model
from skyshine.schemas.paths import StrPath

QUANTITIES = ("solar_absorptance", "thermal_emissivity")
# Handbooks round to this, and a sample is one of many.
TOLERANCE = 0.05


class HandbookRow(StrictModel):
    """What one handbook says of a material, and whom of the library it speaks of."""

    handbook: Text
    row: Text
    solar_absorptance: tuple[Fraction, Fraction] | None = None
    thermal_emissivity: tuple[Fraction, Fraction] | None = None
    checked: bool = True
    materials: Annotated[list[str], Field(min_length=1)]

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        ranges = [getattr(self, quantity) for quantity in QUANTITIES]
        if not any(ranges) or any(pair and pair[0] > pair[1] for pair in ranges):
            raise ValueError("found no range, or one that falls; give a lower and an upper value of a quantity")
        return self


class Handbooks(StrictModel):
    """`materials/handbooks.yaml`."""

    rows: list[HandbookRow]
    reasons: dict[str, Text] = {}


@dataclass(frozen=True)
class Comparison:
    """One number of the library beside the handbooks.

    Attributes
    ----------
    material, quantity : str
    value : float
        Value of the library.
    lower, upper : float
        Range of all handbooks that list the material.
    rows : tuple of HandbookRow
    reason : str
        Why it lies outside, where it does; "" otherwise.
    """

    material: str
    quantity: str
    value: float
    lower: float
    upper: float
    rows: tuple[HandbookRow, ...]
    reason: str

    @property
    def within(self) -> bool:
        """Whether the value lies in the range, widened by `TOLERANCE`."""
        return self.lower - TOLERANCE <= self.value <= self.upper + TOLERANCE

    @property
    def checked(self) -> int:
        """How many of the handbooks were at hand when their rows were written down."""
        return len({row.handbook for row in self.rows if row.checked})


def load_handbooks(file: StrPath | None = None) -> Handbooks:
    """The packaged ranges, or those of a file of the same layout.

    Raises
    ------
    InputError
        The file cannot be read or does not fit.
    """
    return load_model(file or materials.path("handbooks.yaml"), Handbooks)


def compare(handbooks: Handbooks, values: Mapping[str, Mapping[str, float]]) -> list[Comparison]:
    """Numbers of materials beside the ranges of all handbooks that list them.

    Parameters
    ----------
    values : mapping of str to mapping of str to float
        `QUANTITIES` by material; materials without a row are omitted.
    """
    comparisons = []
    for name, numbers in values.items():
        for quantity in QUANTITIES:
            rows = tuple(r for r in handbooks.rows if name in r.materials and getattr(r, quantity) is not None)
            if rows:
                ranges = [getattr(row, quantity) for row in rows]
                low, high = min(pair[0] for pair in ranges), max(pair[1] for pair in ranges)
                reason = handbooks.reasons.get(f"{name}.{quantity}", "")
                comparisons.append(Comparison(name, quantity, numbers[quantity], low, high, rows, reason))
    return comparisons
