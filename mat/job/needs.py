"""What the scenes of a job will ask for, and the nodes of its tables that none of them reads.

A table read linearly between two nodes needs these two and no other: a node that lies outside what is asked for, and is
not the first beyond it, changes no answer. So leaving it out has no error, and asking for more than was said is refused
by the reader.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import pydantic
from pydantic import Field

from skyshine.mat.job.fields import TimeOfDay
from skyshine.schemas.documents import StrictModel

if TYPE_CHECKING:
    pass

Span = tuple[float, float]


def _ordered(span: Span) -> Span:
    if not span[0] <= span[1]:
        raise ValueError(f"found [{span[0]:g}, {span[1]:g}]; allowed: [least, most]; swap them")
    return span


def span(low: float, high: float) -> object:
    """Two numbers between limits, the lesser first."""
    number = Annotated[float, Field(ge=low, le=high)]
    return Annotated[tuple[number, number], pydantic.AfterValidator(_ordered)]


class Needs(StrictModel):
    """The least and most that a runtime will ask for; what is not named may be anything."""

    range_km: span(0, 100_000) | None = None
    observer_altitude_km: span(-0.5, 100_000) | None = None
    elevation_deg: span(-90, 90) | None = Field(None, description="Of the line of sight, with all pixels of the frame.")
    surface_altitude_km: span(-0.5, 9) | None = None
    slope_deg: span(0, 180) | None = None
    bands: Annotated[list[str], Field(min_length=1, max_length=99)] | None = Field(
        None, description="Names of bands, or b01, b02 ... by their order in the job; no file is built for the others."
    )
    hours: tuple[TimeOfDay, TimeOfDay] | None = Field(
        None,
        description=(
            "Local clock, first and last; over midnight where the first is later. Times of the temperature tables,"
            " elevations that a source never has then, and sources that are below all of their tables, are left out."
        ),
    )
