"""The part of a job that surface temperatures are computed from: weather and grid."""

from __future__ import annotations

from typing import Annotated

import pydantic
from pydantic import Field

from skyshine.mat.jobs.fields import Celsius, Fraction, TimeOfDay, Tolerance, ascending, axis, tolerance_parts
from skyshine.schemas.documents import StrictModel

SURFACE_HEIGHTS_KM = (0, 0.25, 0.5, 0.75, 1, 1.5, 2, 3)


class Weather(StrictModel):
    """Air near the ground through the day, at the altitude of the site."""

    air_temperature_c: tuple[Celsius, Celsius] = Field(description="Lowest and highest of the day.")
    relative_humidity_percent: float = Field(50.0, ge=0, le=100, description="Daily mean; the vapour is constant.")
    wind_speed_m_s: float = Field(2.0, ge=0, le=60)
    cloud_fraction: Fraction = 0.0
    ground_albedo: Fraction = 0.2

    @pydantic.model_validator(mode="after")
    def _ordered(self):
        low, high = self.air_temperature_c
        if low > high:
            raise ValueError(f"found air_temperature_c [{low:g}, {high:g}]; allowed: [lowest, highest]; swap them")
        return self


class SurfaceGrid(StrictModel):
    """Nodes of the temperature table."""

    altitude_km: axis(-0.5, 9) | None = Field(
        None, description="Of the surface above sea level; by default from the site's ground to 3 km above it."
    )
    azimuth_deg: axis(0, 359.999) = [15.0 * i for i in range(24)]
    slope_deg: axis(0, 180) = [0, 10, 20, 30, 45, 60, 75, 90, 135, 180]
    time: Annotated[list[TimeOfDay], Field(min_length=1, max_length=512), pydantic.AfterValidator(ascending)] = Field(
        [f"{i // 2:02d}:{i % 2 * 30:02d}" for i in range(48)], validate_default=True
    )
    tolerance: Tolerance | None = Field(
        None, description="In K: places the nodes, between the ends of the axes, where the error is; 99 % of all reads are within it."
    )
    most_nodes: int = Field(20_000_000, ge=16, le=200_000_000, description="Of a table whose nodes a tolerance places.")

    @pydantic.field_validator("tolerance")
    @classmethod
    def _in_kelvin(cls, value):
        if value is not None and tolerance_parts(value)[1] != "K":
            raise ValueError(f"found '{value}'; allowed: kelvin, such as 0.1 K, for temperatures; write it so")
        return value
