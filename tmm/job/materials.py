"""Materials as jobs name them, and mixtures of them: a mapping such as ``{asphalt_road: 60, grass_dry: 40}``.

In a job that is read a mixture is a text, ``60 asphalt_road + 40 grass_dry``, written wherever a material's name
may: names of materials have no spaces. It is written back as the mapping that it came from.
"""

from __future__ import annotations

from typing import Annotated, Any

import pydantic
from pydantic.json_schema import WithJsonSchema

from skyshine.materials.library import unknown_material

UNKNOWN = "unknown"  # the class of seeds of what is none of the materials
MOST_PARTS = 3  # largest number of parts of a mixture, as `mix_code` stores them
MOST_WEIGHT = 65535  # largest value of 16 bits
_BETWEEN = " + "


def is_mixture(name: str) -> bool:
    """Whether a name represents several materials.

    >>> is_mixture("60 asphalt_road + 40 grass_dry"), is_mixture("asphalt_road")
    (True, False)
    """
    return " " in name


def parts_of(name: str) -> dict[str, int]:
    """The materials of a mixture with their weights, the heaviest first; of a material, itself with weight 1.

    >>> parts_of("60 asphalt_road + 40 grass_dry")
    {'asphalt_road': 60, 'grass_dry': 40}
    """
    if not is_mixture(name):
        return {name: 1}
    pairs = (part.partition(" ") for part in name.split(_BETWEEN))
    return {material: int(weight) for weight, _, material in pairs}


def _known(name: str, info: pydantic.ValidationInfo) -> str:
    names = (info.context or {}).get("materials")
    if names is not None and name not in names:
        raise ValueError(unknown_material(name, names))
    return name


def _known_seed(name: str, info: pydantic.ValidationInfo) -> str:
    return name if name == UNKNOWN else _known(name, info)


def _single(value: Any) -> Any:
    if isinstance(value, dict):
        raise ValueError(
            f"found the mapping {value!r}; allowed here: one material; mixtures are allowed in material, palette,"
            " rules, clusters and overrides.labels; a job of mat defines its own materials where materials is a"
            " mapping, without dashes"
        )
    return value


def _named(value: Any, info: pydantic.ValidationInfo) -> Any:
    if isinstance(value, str):
        if is_mixture(_known(value, info)):
            raise ValueError(f"found '{value}'; allowed: a name without spaces, or a mapping of names to weights")
        return value
    if not isinstance(value, dict):
        raise ValueError(f"found {value!r}; allowed: a material, or a mixture such as {{asphalt_road: 60, water: 40}}")
    if not 1 <= len(value) <= MOST_PARTS:
        raise ValueError(f"found a mixture of {len(value)} materials; allowed: 1 to {MOST_PARTS}")
    for material, weight in value.items():
        _known(str(material), info)
        if isinstance(weight, bool) or not isinstance(weight, int) or not 1 <= weight <= MOST_WEIGHT:
            raise ValueError(
                f"found the weight {weight!r} of {material}; allowed: whole numbers from 1 to {MOST_WEIGHT}, by whose"
                " ratio the materials share a texel"
            )
    if len(value) == 1:
        return str(next(iter(value)))
    heaviest = sorted(value.items(), key=lambda item: (-item[1], str(item[0])))
    return _BETWEEN.join(f"{weight} {material}" for material, weight in heaviest)


def _as_written(name: str) -> str | dict[str, int]:
    return parts_of(name) if is_mixture(name) else name


MaterialName = Annotated[str, pydantic.BeforeValidator(_single), pydantic.AfterValidator(_known)]
SeedName = Annotated[str, pydantic.BeforeValidator(_single), pydantic.AfterValidator(_known_seed)]
MaterialOrMixture = Annotated[
    str,
    pydantic.BeforeValidator(_named),
    pydantic.PlainSerializer(_as_written),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "string"},
                {
                    "type": "object",
                    "additionalProperties": {"type": "integer", "minimum": 1, "maximum": MOST_WEIGHT},
                    "minProperties": 1,
                    "maxProperties": MOST_PARTS,
                },
            ]
        }
    ),
]
