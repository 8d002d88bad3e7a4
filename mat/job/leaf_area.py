"""Leaf area of a job's stands: one for all of them, or one by material."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field

from skyshine.mat.job.by_material import kind_of, value_for
from skyshine.materials.files import MOST_LEAVES
from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Material
from skyshine.schemas.errors import nearest
from skyshine.tmm.job.materials import MaterialName

LeafArea = Annotated[
    Annotated[Literal["library"], pydantic.Tag("word")]
    | Annotated[Annotated[float, Field(ge=0, le=MOST_LEAVES)], pydantic.Tag("number")],
    pydantic.Discriminator(kind_of),
]
LeafAreaIndex = Annotated[
    Annotated[Literal["library"], pydantic.Tag("word")]
    | Annotated[Annotated[float, Field(ge=0, le=MOST_LEAVES)], pydantic.Tag("number")]
    | Annotated[Annotated[dict[MaterialName, LeafArea], Field(min_length=1)], pydantic.Tag("by_material")],
    pydantic.Discriminator(kind_of),
]


def refuse_no_soil(material: Material, library: MaterialLibrary) -> None:
    """ValueError where the soil below a material's leaves is not in the library, or is no soil that can lie below."""
    stand = material.stand
    if stand is None or stand.soil not in library:
        ground = None if stand is None else stand.soil
        raise ValueError(f"found {material.name} on '{ground}', which the library has not; name another in its stand")
    soil = library[stand.soil]
    if soil.surface.snow or soil.surface.canopy or soil.thermal.light or soil.transmits:
        raise ValueError(
            f"found {material.name} on '{soil.name}'; allowed: on ground without leaves that neither melts nor lets"
            " light in; name another in its stand"
        )


def open_stands(leaf_area_index: Any, stands: Iterable[str]) -> tuple[str, ...]:
    """The materials that a `leaf_area_index` opens.

    Parameters
    ----------
    leaf_area_index : as the job has it
    stands : iterable of str
        Names of all materials with a stand that it may name.

    Raises
    ------
    ValueError
        A material has no stand of leaves, or none has.
    """
    names = tuple(stands)
    if isinstance(leaf_area_index, Mapping):
        for name in leaf_area_index:
            if name not in names:
                raise ValueError(f"found '{name}', which has no stand of leaves; {nearest(name, names)}")
    names_with_value = tuple(name for name in names if value_for(leaf_area_index, name) is not None)
    if not names_with_value:
        raise ValueError("found it for materials of which none has a stand of leaves; allowed: with such as shrub")
    return names_with_value
