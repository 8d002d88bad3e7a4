"""The tables beyond the classic ones that a job may ask for."""

from __future__ import annotations

from typing import Annotated

import pydantic

from skyshine.schemas.errors import nearest

WEIGHTED_TRANSMITTANCE, NORMALISATION_BY_ANGLE = "weighted_transmittance", "normalisation_by_angle"
EXTRA_TABLES = (WEIGHTED_TRANSMITTANCE, NORMALISATION_BY_ANGLE)


def _name(value: str) -> str:
    if value not in EXTRA_TABLES:
        raise ValueError(f"found '{value}'; {nearest(value, EXTRA_TABLES)}")
    return value


def _once(names: list[str]) -> list[str]:
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"found '{name}' twice; allowed: each table once; remove one")
    return names


ExtraTable = Annotated[
    str, pydantic.AfterValidator(_name), pydantic.WithJsonSchema({"type": "string", "enum": list(EXTRA_TABLES)})
]
ExtraTables = Annotated[list[ExtraTable], pydantic.AfterValidator(_once)]
