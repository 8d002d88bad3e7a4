"""What stands behind the numbers of the library: kinds of source, and how many numbers have each."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from typing import Literal, TypeAlias, get_args

from skyshine.materials.files import USER
from skyshine.materials.records import Material
from skyshine.schemas.errors import InputError

SourceKind: TypeAlias = Literal["cited", "derived", "definition", "estimate", "user"]
KINDS: tuple[SourceKind, ...] = get_args(SourceKind)
SPECTRUM = "reflectance"  # its ranges have origins of their own
# The values that a definition may stand behind: those with which the file would be of another object, in another place
# or state, and which no sample of the substance has.
_OBJECT = re.compile(
    r"(skin|layers\.\d)\.thickness|back\.\w+|operated\.\w+\.\w+|surface\.(exposure|canopy|snow)|soil\.layers|stand\.soil"
)
# Of a layer, of a part of the light, of a back in operation.
_NUMBER_OR_NAME = re.compile(r"\.\d+|(?<=^operated)\.\w+")


def kind_of(source: str) -> SourceKind:
    """Kind of a source by how its text begins.

    Parameters
    ----------
    source : str
        ``[key] ...`` is cited; ``derived...``, ``definition: ...``, ``estimate: ...`` and ``user`` are themselves.

    Raises
    ------
    InputError
        The text begins otherwise.

    Examples
    --------
    >>> kind_of("[oke1987] table 2.1, peat")
    'cited'
    """
    if source.startswith("["):
        return "cited"
    for kind in KINDS[1:]:
        if re.match(rf"{kind}\b", source):
            return kind
    raise InputError(
        f"found the source '{source}'; allowed: [reference] and the place in it, derived:, definition:, estimate: or"
        f" {USER}; say which it is"
    )


def may_be_defined(material: Material, field: str) -> bool:
    """Whether a definition may stand behind a field of a material, as `materials/README.md` says.

    Of an object or its state: thicknesses, what lies behind, exposure, whether leaves or snow, what leaves stand on;
    wetness, and a resistance that is without effect; the roughness of a plate, roof or wall, which is a class; a lobe's
    width where nothing is in the lobe. All else is a property of the substance, which somebody can measure.
    """
    surface = material.surface
    if field == "surface.roughness_length":
        return surface.exposure != "field"
    if field == "surface.surface_resistance":
        return surface.wetness == 0 or surface.surface_resistance == 0
    if field == "lobe_fwhm":
        return material.specular_fraction == 0
    return field == "surface.wetness" or _OBJECT.fullmatch(field) is not None


def count_kinds(materials: Iterable[Material]) -> dict[str, Counter[SourceKind]]:
    """How many values have each kind of source, by field; layers count as one field, and so do backs in operation."""
    counts: dict[str, Counter[SourceKind]] = {}
    for material in materials:
        for field, source in material.sources.items():
            if field != SPECTRUM:
                counts.setdefault(_NUMBER_OR_NAME.sub("", field), Counter())[kind_of(source)] += 1
    return counts
