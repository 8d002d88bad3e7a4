"""Prints solar absorptance and thermal emissivity of the library beside the ranges of `materials/handbooks.yaml`:
`python -m mat.maintain.materials.handbooks > materials/HANDBOOKS.md`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Self

from pydantic import Field, model_validator

from skyshine import materials
from skyshine.mat.scene.material_summary import material_summary
from skyshine.materials.files import Fraction
from skyshine.materials.library import MaterialLibrary, load_library
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
    value : float
        Value of the library.
    lower, upper : float
        Range of all handbooks that list the material.
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


def compared(library: MaterialLibrary) -> list[Comparison]:
    """Numbers of the library beside all handbooks."""
    handbooks = load_handbooks()
    listed = {name for row in handbooks.rows for name in row.materials}
    return compare(handbooks, {name: material_summary(library[name]) for name in library.names if name in listed})


def _span(comparison: Comparison) -> str:
    return (
        f"{comparison.lower:.2f}"
        if comparison.lower == comparison.upper
        else f"{comparison.lower:.2f} to {comparison.upper:.2f}"
    )


def handbook_page(library: MaterialLibrary, comparisons: list[Comparison]) -> str:
    """The comparison as a page in Markdown."""
    within, twice = (
        sum(comparison.within for comparison in comparisons),
        sum(comparison.checked >= 2 for comparison in comparisons),
    )
    lines = [
        "# Materials beside handbooks",
        "",
        f"Written by `python -m mat.maintain.materials.handbooks`, library {library.version}.",
        "Solar absorptance is weighted by",
        "sunlight at the ground (ASTM G173), emissivity by blackbody radiation of 300 K. A range spans all handbooks",
        "that list the material; values within 0.05 of it count as within, because handbooks round and a sample is one",
        "of many. Numbers in parentheses are recalled and were not checked in the book.",
        f"{within} of {len(comparisons)} numbers lie within; {twice} are compared with two handbooks or more.",
        "",
        "| material | quantity | library | handbooks | | what they list |",
        "|---|---|---|---|---|---|",
    ]
    for comparison in comparisons:
        rows = "; ".join(
            f"[{row.handbook}] {row.row}" if row.checked else f"([{row.handbook}] {row.row})" for row in comparison.rows
        )
        mark = "" if comparison.within else f"**outside**: {comparison.reason}"
        name = comparison.quantity.replace("_", " ")
        lines.append(
            f"| `{comparison.material}` | {name} | {comparison.value:.2f} | {_span(comparison)} | {mark} | {rows} |"
        )
    cited = dict.fromkeys(row.handbook for comparison in comparisons for row in comparison.rows)
    lines += ["", "## References", "", *(f"- [{key}] {library.references[key]}" for key in cited)]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Print the page `materials/HANDBOOKS.md`."""
    library = load_library()
    print(handbook_page(library, compared(library)), end="")


if __name__ == "__main__":
    main()
