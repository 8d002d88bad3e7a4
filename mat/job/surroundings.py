"""Surroundings of the surfaces of a state: horizon, open sky, walls."""

from __future__ import annotations

import itertools
from typing import Annotated, Any, Self

import pydantic
from pydantic import Field

from skyshine.mat.job.fields import Fraction, by_hour
from skyshine.mat.job.surface import OperatedCelsius
from skyshine.schemas.documents import StrictModel
from skyshine.tmm.job.materials import MaterialName

WALL_EMISSIVITY, WALL_ALBEDO = 0.95, 0.2  # masonry and foliage; Oke (1987), Boundary Layer Climates, table 8.1
_OF_MATERIAL = ("temperature_c", "emissivity", "albedo")

Elevation = Annotated[float, Field(ge=0, le=90)]
Node = tuple[Annotated[float, Field(ge=0, lt=360)], Elevation]


def _ascending(nodes: list[Node]) -> list[Node]:
    for (before, _), (after, _) in itertools.pairwise(nodes):
        if not after > before:
            raise ValueError(f"found azimuth {after:g} after {before:g}; allowed: strictly ascending ones; sort them")
    return nodes


def _one_or_many(value: object) -> str:
    return "by_azimuth" if isinstance(value, list | tuple) else "constant"


_ByAzimuth = Annotated[list[Node], Field(min_length=1, max_length=720), pydantic.AfterValidator(_ascending)]
HorizonElevation = Annotated[
    Annotated[Elevation, pydantic.Tag("constant")] | Annotated[_ByAzimuth, pydantic.Tag("by_azimuth")],
    pydantic.Discriminator(_one_or_many),
]


class Wall(StrictModel):
    """What hides the sky: house fronts, rock, the edge of a forest."""

    material: MaterialName | None = Field(
        None,
        description="Material of the walls, solved first for all aspects; emissivity and albedo are its own.",
    )
    temperature_c: Annotated[float | list[float], by_hour(OperatedCelsius)] | None = Field(
        None, description="One, or 24 at the hours 0 to 23; by default that of the air."
    )
    emissivity: float = Field(WALL_EMISSIVITY, ge=0.01, le=1, description="Emissivity of the wall, longwave.")
    albedo: float = Field(WALL_ALBEDO, ge=0, le=0.99, description="Albedo of the wall for sunlight.")

    @pydantic.model_validator(mode="after")
    def _one_kind(self) -> Self:
        for key in _OF_MATERIAL:
            if self.material is not None and key in self.model_fields_set:
                raise ValueError(f"found material and {key}; allowed: a material, which has its own; remove {key}")
        return self


class StateSurroundings(StrictModel):
    """Surroundings of all surfaces of a state, seen from among them: a street, a court, the edge of a forest."""

    horizon_deg: HorizonElevation = Field(
        0.0,
        description=(
            "Elevation of the tops of walls: one all around, or [azimuth, elevation] pairs, linear between them."
            " Walls hide the Sun."
        ),
    )
    sky_view: Fraction = Field(
        1.0,
        description="Open share of the sky above the horizon; walls hide the rest, but not the Sun.",
    )
    wall: Wall = Field(Wall(), description="Wall in front of surfaces; by default none.")

    @pydantic.model_validator(mode="after")
    def _has_walls(self) -> Self:
        if self.open and "wall" in self.model_fields_set:
            raise ValueError(
                "found wall with a horizon_deg of 0 and a sky_view of 1, which leave none; allowed: a horizon above 0"
                " or a sky_view below 1; give one, or remove wall"
            )
        return self

    @property
    def horizon(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Azimuths and elevations of the horizon [degree]."""
        if not isinstance(self.horizon_deg, list):
            return (0.0,), (self.horizon_deg,)
        azimuth, elevation = zip(*self.horizon_deg, strict=True)
        return azimuth, elevation

    @property
    def open(self) -> bool:
        """Whether nothing is hidden."""
        return not any(self.horizon[1]) and self.sky_view == 1

    def content(self) -> dict[str, Any]:
        """As plain data."""
        return self.model_dump(mode="json")
