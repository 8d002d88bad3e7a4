"""What a texture job says of the cast shade of its photograph."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated

import pydantic
from pydantic import Field

from skyshine.schemas.documents import StrictModel

Polygon = Annotated[tuple[tuple[float, float], ...], Field(min_length=1)]


def _moment(value: object) -> object:
    """A time with its zone; pydantic would take numbers for seconds since 1970."""
    try:
        moment = datetime.fromisoformat(value) if isinstance(value, str) else value
    except ValueError:
        moment = None
    if isinstance(moment, datetime) and moment.tzinfo is not None:
        return moment
    raise ValueError(f"found '{value}'; allowed: a date and time with its zone, such as 2026-06-21T08:30:00Z")


class Shade(StrictModel):
    """Cast shade, found where it falls away from the Sun; polygons correct it."""

    sun_azimuth_deg: float | None = Field(
        default=None,
        ge=0,
        le=360,
        description="Azimuth of the Sun, clockwise from north, which is up in an image without a place on a map: "
        "shade is what ends, away from the Sun, in its own ground.",
    )
    sun_elevation_deg: float | None = Field(
        default=None,
        gt=0,
        le=90,
        description="Height of the Sun above the horizon, with sun_azimuth_deg; on a map it limits the length of "
        "shadows.",
    )
    time: Annotated[pydantic.AwareDatetime, pydantic.BeforeValidator(_moment)] | None = Field(
        default=None,
        description="Date and time of the photograph with its zone, such as 2026-06-21T08:30:00Z, instead of "
        "sun_azimuth_deg, for an image with a place on a map.",
    )
    shaded: tuple[Polygon, ...] = Field(
        default=(), description="Polygons of [x, y] pixel coordinates that lie in the shade, whatever is found there."
    )
    sunlit: tuple[Polygon, ...] = Field(
        default=(), description="Polygons that lie in sunlight, such as dark or blue things; they come after shaded."
    )

    @pydantic.model_validator(mode="after")
    def _one_sun(self) -> Shade:
        if self.time is not None and (self.sun_azimuth_deg is not None or self.sun_elevation_deg is not None):
            raise ValueError("found time and the Sun's angles; allowed: one of them; leave the other out")
        if self.time is None and self.sun_azimuth_deg is None and self.sun_elevation_deg is None:
            raise ValueError(
                "found shade without the Sun's direction; add sun_azimuth_deg, as a pole's shadow shows it, or time"
            )
        if self.sun_elevation_deg is not None and self.sun_azimuth_deg is None:
            raise ValueError("found sun_elevation_deg without sun_azimuth_deg; add it")
        return self
