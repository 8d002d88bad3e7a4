"""What the scenes of a job will ask for, and the nodes of its tables that none of them reads.

A table read linearly between two nodes needs these two and no other: a node that lies outside what is asked for, and is
not the first beyond it, changes no answer. Where a tolerance places the nodes, they end where the reads end. The
spectral points of a band are chosen on the paths that are read. Asking for more than was said is refused by the reader.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

import pydantic
from pydantic import Field

from skyshine.mat.job.fields import Span, TimeOfDay, span
from skyshine.schemas.documents import StrictModel
from skyshine.tmm.job.materials import MaterialName

# Orientation of a face: slope, and azimuth from north over east, degree.
Face = tuple[Annotated[float, Field(ge=0, le=180)], Annotated[float, Field(ge=0, le=360)]]
MOST_ORIENTATIONS = 4096
_ROUND_DEG = 6  # decimals of a slope and an azimuth


class QueryLimits(StrictModel):
    """The least and most that a runtime will ask for; what is not named may be anything."""

    range_km: Annotated[Span, span(0, 100_000)] | None = Field(
        None, description="Distances from the observer to the surfaces."
    )
    observer_altitude_km: Annotated[Span, span(-0.5, 100_000)] | None = Field(
        None, description="Altitudes of the observer above sea level."
    )
    elevation_deg: Annotated[Span, span(-90, 90)] | None = Field(
        None, description="Elevations of the line of sight, with all pixels of the frame."
    )
    surface_altitude_km: Annotated[Span, span(-0.5, 9)] | None = Field(
        None, description="Altitudes of the surfaces above sea level."
    )
    slope_deg: Annotated[Span, span(0, 180)] | None = Field(None, description="Slopes of the surfaces.")
    faces_deg: Annotated[list[Face], Field(min_length=1, max_length=1024)] | None = Field(
        None,
        description=(
            "[slope, azimuth] of all faces, in place of slope_deg: temperatures are tabulated for these slopes and"
            " azimuths, and read without interpolation; those of a face between them are not known."
        ),
    )
    source_elevation_deg: Annotated[Span, span(-90, 90)] | None = Field(
        None, description="Elevations of Sun and Moon; by default all that they have in the hours."
    )
    source_azimuth_deg: Annotated[Span, span(0, 180)] | None = Field(
        None, description="Azimuths of Sun and Moon relative to that of the line of sight."
    )
    sources: Annotated[list[Literal["sun", "moon"]], Field(min_length=1, max_length=2)] | None = Field(
        None, description="Sources of the job whose tables are built, also where all of them is dark."
    )
    materials: Annotated[list[MaterialName], Field(min_length=1)] | None = Field(
        None, description="Materials among those that the job builds; tables without the others refuse them."
    )
    bands: Annotated[list[str], Field(min_length=1, max_length=99)] | None = Field(
        None, description="Names of bands, or b01, b02 ... by their order in the job; no file is built for the others."
    )
    hours: tuple[TimeOfDay, TimeOfDay] | None = Field(
        None,
        description=(
            "Local clock, first and last; over midnight where the first is later. Times of the temperature tables,"
            " elevations that a source never has then, and sources that are below all of their tables, are omitted."
        ),
    )
    shade: bool = Field(
        True,
        description=(
            "Whether surfaces will be asked for in the shade, beside a wall or under other heat; false leaves the"
            " response to it out of the temperature tables."
        ),
    )

    @property
    def face_axes_deg(self) -> tuple[list[float], list[float]]:
        """Slopes of all faces, and azimuths of those that are not level; without any, north alone."""
        faces = [
            (round(slope, _ROUND_DEG), round(azimuth, _ROUND_DEG) % 360.0) for slope, azimuth in self.faces_deg or ()
        ]
        azimuths = {azimuth for slope, azimuth in faces if 0 < slope < 180}
        return sorted({slope for slope, _ in faces}), sorted(azimuths or {0.0})

    @pydantic.model_validator(mode="after")
    def _faces(self) -> Self:
        if self.faces_deg is None:
            return self
        if self.slope_deg is not None:
            raise ValueError("found faces_deg and slope_deg; allowed: one of them; remove slope_deg")
        slopes, azimuths = self.face_axes_deg
        count = len(slopes) * len(azimuths)
        if count > MOST_ORIENTATIONS:
            raise ValueError(
                f"found {len(slopes)} slopes and {len(azimuths)} azimuths, {count} orientations; allowed: at most"
                f" {MOST_ORIENTATIONS}; write slope_deg"
            )
        return self
