"""The part of a job that the atmosphere is computed from: state, bands, grid."""

from __future__ import annotations

from typing import Annotated, Literal

import pydantic
from pydantic import Field

from skyshine.mat.atmosphere.profiles import PROFILES
from skyshine.mat.jobs.fields import Fraction, Tolerance, axis
from skyshine.mat.jobs.surface import Weather
from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import nearest

def _profile(name: str) -> str:
    if name not in PROFILES:
        raise ValueError(f"found '{name}'; {nearest(name, PROFILES)}")
    return name


ProfileName = Annotated[
    str, pydantic.AfterValidator(_profile), pydantic.WithJsonSchema({"type": "string", "enum": list(PROFILES)})
]


class State(StrictModel):
    """One atmospheric state: profile, aerosol, weather."""

    profile: ProfileName
    humidity_scale: float = Field(1.0, ge=0, le=10, description="Factor on the profile's water vapour.")
    co2_ppm: float = Field(420.0, ge=0, le=5000)
    aerosol: Literal["rural", "none"] = "rural"
    visibility_km: float = Field(23.0, ge=0.1, le=300)
    surface_albedo: Fraction = Field(0.1, description="Of the ground below the paths, in the sensor bands.")
    weather: Weather


class Band(StrictModel):
    """One spectral band of the sensor."""

    wavelength_um: tuple[float, float] = Field(description="Lower and upper edge; the response is 1 between them.")

    @pydantic.model_validator(mode="after")
    def _ordered(self):
        low, high = self.wavelength_um
        if not 0 < low < high:
            raise ValueError(f"found wavelength_um [{low:g}, {high:g}]; allowed: 0 < lower < upper; swap or mend them")
        return self


OBSERVER_HEIGHTS_KM = (0.002, 0.05, 0.2, 0.5, 1, 2, 3, 5, 8, 12, 20, 40)


class AtmosphereGrid(StrictModel):
    """Nodes of the atmospheric tables."""

    range_km: axis(0, 100_000) = [
        0.001, 0.1, 0.2, 0.35, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 7, 10, 14, 20, 28, 40, 60, 90, 130, 200, 300, 1000,
    ]  # fmt: skip
    altitude_km: axis(-0.5, 100_000) | None = Field(
        None, description="Of the observer above sea level; by default from 2 m to 40 km above the site's ground."
    )
    elevation_deg: axis(-90, 90) = [
        -90, -60, -40, -30, -20, -15, -10, -7, -5, -3, -2, -1, 0, 1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 60, 90,
    ]  # fmt: skip
    tolerance: Tolerance | None = Field(
        None,
        description="Places the nodes, between the ends of the axes, where the error is: 99 % of all reads are within it, in kelvin or "
        "radiance of a scene at 300 K.",
    )
    most_nodes: int = Field(20_000_000, ge=32, le=200_000_000, description="Of a table whose nodes a tolerance places.")
    source_elevation_deg: axis(-90, 90) = [-10, -5, -2, 0, 2, 5, 10, 20, 30, 45, 60, 75, 90]
    source_azimuth_deg: axis(0, 180) = [0, 5, 10, 20, 30, 45, 60, 75, 90, 110, 130, 155, 180]
