"""Texture jobs: which image, how it is read, which texels are known, how the rest is assigned.

Paths in a job are relative to the folder of its YAML file. Pixel coordinates are (x, y) from the top left corner of the
image as it is stored: x to the right, y down, the texel of column c and row r spanning [c, c + 1) x [r, r + 1).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import PurePath
from typing import Annotated, Any, Literal

import pydantic
from pydantic import Field

from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import nearest

MAX_RADIUS = 127


def _known_material(name: str, info: pydantic.ValidationInfo) -> str:
    names = (info.context or {}).get("materials")
    if names is not None and name not in names:
        raise ValueError(f"unknown material '{name}'; {nearest(name, names)}")
    return name


def _palette_key(key: object) -> str:
    text = str(key)
    digits = text.removeprefix("#")
    if text.startswith("#") and len(digits) == 6 and all(c in "0123456789abcdefABCDEF" for c in digits):
        return text.upper()
    if text.isdecimal() and int(text) <= 65535:
        return text
    raise ValueError(
        f"found the palette colour '{text}'; allowed: \"#RRGGBB\" (in quotes) for a colour, 0 to 65535 for a grey level"
    )


def _some_polygons(polygons: tuple) -> tuple:
    if not polygons:
        raise ValueError("found no polygon; draw at least one, a single [x, y] vertex names one texel")
    return polygons


MaterialName = Annotated[str, pydantic.AfterValidator(_known_material)]
PaletteKey = Annotated[str, pydantic.BeforeValidator(_palette_key)]
Polygon = Annotated[tuple[tuple[float, float], ...], Field(min_length=1)]
Polygons = Annotated[tuple[Polygon, ...], pydantic.AfterValidator(_some_polygons)]
Probability = Annotated[float, Field(ge=0, le=1)]


class LabelImage(StrictModel):
    """An image of the texture's size whose colours name materials; colours outside the palette label nothing."""

    image: str = Field(min_length=1, description="Label image, of the same width and height as the texture.")
    palette: dict[PaletteKey, MaterialName] = Field(
        min_length=1, description='Material of each label colour ("#RRGGBB") or grey level (0 to 65535).'
    )


class Seeds(StrictModel):
    """Texels whose material is known, from any of three places."""

    polygons: dict[MaterialName, Polygons] = Field(
        default={}, description="Polygons of [x, y] pixel coordinates by material; one vertex alone names one texel."
    )
    file: str | None = Field(
        default=None,
        min_length=1,
        description="GeoJSON in pixel coordinates; `properties.material` names the material.",
    )
    labels: LabelImage | None = None

    @pydantic.model_validator(mode="after")
    def _not_empty(self) -> Seeds:
        if not self.polygons and self.file is None and self.labels is None:
            raise ValueError("found no seeds; allowed: polygons, file, labels; give at least one of them")
        return self


class Classifier(StrictModel):
    """Settings of the Gaussian maximum likelihood classifier."""

    radius: int = Field(
        default=8, ge=0, le=MAX_RADIUS, description="Radius of the box over which posteriors are averaged, in texels."
    )
    prior: Literal["equal", "seeds"] | dict[MaterialName, Annotated[float, Field(gt=0)]] = Field(
        default="equal",
        description="Prior of the materials: equal, as the seeds' texels, or a number for each material.",
    )
    confidence_threshold: Probability = Field(
        default=0.0, description="Texels of lower confidence become unknown (code 0)."
    )
    typicality_threshold: Probability = Field(
        default=0.0, description="Texels less typical of their material than this become unknown (code 0)."
    )


class HeldOut(StrictModel):
    """How the quality is measured: each seed region is classified by a model trained without it."""

    folds: int = Field(default=4, ge=2, le=20, description="Number of parts into which the seed regions are divided.")
    random_seed: int = Field(default=0, ge=0, description="Seed of the division into parts.")


class TextureJob(StrictModel):
    """One texture and what is known of it."""

    image: str = Field(min_length=1, description="Image file, relative to the job file.")
    name: str = Field(
        default="",
        pattern=r"^([A-Za-z0-9_][A-Za-z0-9_.-]*)?$",
        description="Name of the database (NAME.tmm.h5); by default the image's name without its ending.",
    )
    alpha: Literal["no-data", "ignore"] = Field(
        default="no-data", description="Whether texels with alpha below one half are left without a material."
    )
    colour_space: Literal["auto", "srgb", "linear"] = Field(
        default="auto",
        description="Encoding of the colours; auto: by the file, else sRGB for integers, linear for floats.",
    )
    classifier: Classifier = Classifier()
    held_out: HeldOut = HeldOut()
    seeds: Seeds

    @pydantic.model_validator(mode="before")
    @classmethod
    def _name_by_image(cls, data: Any) -> Any:
        if isinstance(data, dict) and not data.get("name") and isinstance(data.get("image"), str):
            return {**data, "name": re.sub(r"[^A-Za-z0-9_.-]", "_", PurePath(data["image"]).stem).lstrip(".-")}
        return data

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials that the job itself names; those of a GeoJSON file are in that file."""
        labels = self.seeds.labels.palette.values() if self.seeds.labels else ()
        return tuple(sorted({*self.seeds.polygons, *labels}))


class TmmJob(StrictModel):
    """A job of the command `tmm`."""

    textures: tuple[TextureJob, ...] = Field(min_length=1)
    output: str = Field(default="build", min_length=1, description="Folder of the databases, relative to the job file.")

    @pydantic.model_validator(mode="after")
    def _distinct_names(self) -> TmmJob:
        check_distinct_names(self.textures)
        return self


def check_distinct_names(textures: Sequence[TextureJob]) -> None:
    """Refuse two textures that would be written to one file.

    Raises
    ------
    ValueError
    """
    names = [texture.name for texture in textures]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"found two textures named '{name}'; allowed: each name once; give one another 'name'")
