"""What the scenes of a job will ask for, and the nodes of its tables that none of them reads.

A table read linearly between two nodes needs these two and no other: a node that lies outside what is asked for, and is
not the first beyond it, changes no answer. So leaving it out has no error, and asking for more than was said is refused
by the reader.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from skyshine.mat.job.fields import Span, TimeOfDay, span
from skyshine.schemas.documents import StrictModel


class QueryLimits(StrictModel):
    """The least and most that a runtime will ask for; what is not named may be anything."""

    range_km: Annotated[Span, span(0, 100_000)] | None = None
    observer_altitude_km: Annotated[Span, span(-0.5, 100_000)] | None = None
    elevation_deg: Annotated[Span, span(-90, 90)] | None = Field(
        None, description="Of the line of sight, with all pixels of the frame."
    )
    surface_altitude_km: Annotated[Span, span(-0.5, 9)] | None = None
    slope_deg: Annotated[Span, span(0, 180)] | None = None
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
    shade: bool = Field(
        True,
        description=(
            "Whether surfaces will be asked for in the shade, beside a wall or under other heat; false leaves the"
            " response to it out of the temperature tables."
        ),
    )
