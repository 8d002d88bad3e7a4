"""Materials of the library as composite materials of a CDB, and composites of a CDB as mixtures of materials.

The assignment of base materials to ours is data: ``materials/exchange/cdb.yaml``, or a file of the same layout.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import pydantic

from skyshine import materials
from skyshine.materials.library import MaterialLibrary, unknown_material
from skyshine.schemas.documents import Document, StrictModel, parse_model, read_yaml
from skyshine.schemas.errors import InputError
from skyshine.tmm.database.levels import COMPONENTS
from skyshine.tmm.exchange.cdb_table import BASE_NAME, PERCENT, Composite, Substrate

Weights = dict[str, int]


class CompositeRecipe(StrictModel):
    """How one of our materials is written: one base material, or several with weights in percent, a substrate."""

    primary: str | Weights
    surface: str | Weights | None = None

    @pydantic.field_validator("primary", "surface")
    @classmethod
    def _whole(cls, value: str | Weights | None) -> str | Weights | None:
        parts: Weights | None = {value: PERCENT} if isinstance(value, str) else value
        for name, weight in (parts or {}).items():
            if not BASE_NAME.fullmatch(name) or not 1 <= weight <= PERCENT:
                raise ValueError(f"found '{name}: {weight}'; allowed: BM_NAME with a weight of 1 to 100")
        if parts is not None and sum(parts.values()) != PERCENT:
            raise ValueError(f"found weights that sum to {sum(parts.values())}; allowed: 100")
        return value


class CdbMap(StrictModel):
    """The layout of ``cdb.yaml``."""

    composites: dict[str, CompositeRecipe]
    bases: dict[str, str | None]


@dataclass(frozen=True)
class CdbMaterials:
    """A map between our materials and those of CDB; see `load_map`."""

    document: Document
    recipes: CdbMap
    library: MaterialLibrary

    def composite(self, name: str, index: int) -> Composite:
        """Our material as a composite material.

        Raises InputError: the map has none for it.
        """
        if name not in self.recipes.composites:
            raise InputError(
                f"has no composite material for '{name}'; add it under 'composites', or name a map of your own",
                file=self.document.file,
            )
        recipe = self.recipes.composites[name]
        surface = _substrate(recipe.surface) if recipe.surface else None
        return Composite(index, name, _substrate(recipe.primary), surface)

    def mixture(self, composite: Composite) -> dict[int, float]:
        """Codes of our materials in a composite with their shares, three at most, largest first; shares sum to 1.

        A composite of the name of one of ours is that one. Else one that is made as one of ours is made, if there is
        just one such. Else the base materials of its topmost substrate count by their weights.
        Raises InputError: a base material has no counterpart in the map, or only counterparts without weight.
        """
        if composite.name in self.library:
            return {self.library.code(composite.name): 1.0}
        alike = [
            name
            for name in self.recipes.composites
            if name in self.library
            and _structure(self.composite(name, 0)) == _structure(composite)
            and (composite.surface or len(composite.primary.materials) > 1)
        ]
        if len(alike) == 1:
            return {self.library.code(alike[0]): 1.0}
        shares: dict[int, float] = {}
        for base, weight in (composite.surface or composite.primary).materials:
            name = self._counterpart(base, composite)
            if name is not None:
                code = self.library.code(name)
                shares[code] = shares.get(code, 0.0) + weight
        if not shares:
            raise InputError(f"'{composite.name}' consists only of base materials without weight; map one of them")
        ranked = sorted(shares.items(), key=lambda item: (-item[1], item[0]))[:COMPONENTS]
        total = sum(share for _, share in ranked)
        return {code: share / total for code, share in ranked}

    def _counterpart(self, base: str, composite: Composite) -> str | None:
        if base not in self.recipes.bases:
            raise InputError(
                f"has no material for the base material '{base}' of the composite '{composite.name}'; add it under "
                "'bases' to a map of your own",
                file=self.document.file,
            )
        return self.recipes.bases[base]


def _substrate(parts: str | Weights) -> Substrate:
    weights = {parts: PERCENT} if isinstance(parts, str) else parts
    return Substrate(tuple(sorted(weights.items(), key=lambda item: -item[1])))


def _structure(composite: Composite) -> tuple[object, object]:
    return (composite.surface and composite.surface.materials, composite.primary.materials)


def load_map(library: MaterialLibrary, path: str | os.PathLike[str] | None = None) -> CdbMaterials:
    """Read a map; by default the packaged one.

    Raises InputError: the file is wrong, or names a material that the library has not.
    """
    document = read_yaml(path or materials.path("exchange/cdb.yaml"))
    recipes = parse_model(document, CdbMap)
    for base, name in recipes.bases.items():
        if name is not None and name not in library:
            raise document.error(("bases", base), unknown_material(name, library.names))
    return CdbMaterials(document, recipes, library)
