"""Moisture of a job's soils: one for all of them, or one by material."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field

from skyshine.mat.job.by_material import kind_of, value_for
from skyshine.mat.surface.soil_moisture import drying_moisture
from skyshine.mat.surface.weather_readings import MOST_MOISTURE
from skyshine.materials.records import Soil
from skyshine.schemas.errors import nearest
from skyshine.tmm.job.materials import MaterialName

Moisture = Annotated[
    Annotated[Literal["dry", "moist", "wet"], pydantic.Tag("word")]
    | Annotated[Annotated[float, Field(ge=0, le=MOST_MOISTURE)], pydantic.Tag("number")],
    pydantic.Discriminator(kind_of),
]
SoilMoisture = Annotated[
    Annotated[Literal["dry", "moist", "wet"], pydantic.Tag("word")]
    | Annotated[Annotated[float, Field(ge=0, le=MOST_MOISTURE)], pydantic.Tag("number")]
    | Annotated[Annotated[dict[MaterialName, Moisture], Field(min_length=1)], pydantic.Tag("by_material")],
    pydantic.Discriminator(kind_of),
]


def water_fraction(value: float | str, name: str, soil: Soil) -> float:
    """Volume fraction of water [m3/m3] of a material's soil.

    Raises
    ------
    ValueError
        It exceeds the porosity.
    """
    if isinstance(value, str):
        # Dry and wet are those of Oke (1987), table 2.1; moist is chosen: ground some days after rain, the driest that
        # is moist to its surface.
        moist = min(drying_moisture(soil.texture), soil.porosity)
        return {"dry": 0.0, "moist": moist, "wet": soil.porosity}[value]
    if value > soil.porosity:
        raise ValueError(
            f"found {value:g}; allowed: 0 to {soil.porosity:g}, the porosity of {name}; lower it, or give each material"
            f" its own, such as {{{name}: wet}}"
        )
    return value


def check_moisture(soil_moisture: Any, soils: Mapping[str, Soil]) -> tuple[str, ...]:
    """The soils that a `soil_moisture` speaks of.

    Parameters
    ----------
    soil_moisture : as the job has it
    soils : mapping
        Soils of all materials that the job may name.

    Raises
    ------
    ValueError
        A material does not answer, or its pores contain less.
    """
    if isinstance(soil_moisture, Mapping):
        for name in soil_moisture:
            if name not in soils:
                raise ValueError(f"found '{name}', which does not answer to soil moisture; {nearest(name, soils)}")
    answering = tuple(name for name in soils if value_for(soil_moisture, name) is not None)
    for name in answering:
        water_fraction(value_for(soil_moisture, name) or 0.0, name, soils[name])
    return answering
