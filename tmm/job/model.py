"""Texture jobs: which image, how it is read, which texels are known, how the rest is assigned.

Paths in a job are relative to the folder of its YAML file. Pixel coordinates are (x, y) from the top left corner of the
image as it is stored: x to the right, y down, the texel of column c and row r spanning [c, c + 1) x [r, r + 1).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import pydantic
import yaml
from pydantic import Field

from skyshine.schemas.documents import StrictModel
from skyshine.schemas.errors import nearest
from skyshine.schemas.paths import job_path
from skyshine.tmm.job.images import find_images, texture_name
from skyshine.tmm.job.materials import UNKNOWN, MaterialName, MaterialOrMixture, SeedName, is_mixture, parts_of
from skyshine.tmm.job.shade import Polygon, Shade

MAX_RADIUS = 127  # texels


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


def _some_polygons(polygons: tuple[Polygon, ...]) -> tuple[Polygon, ...]:
    if not polygons:
        raise ValueError("found no polygon; draw at least one, a single [x, y] vertex names one texel")
    return polygons


def _within_folder(name: str, info: pydantic.ValidationInfo) -> str:
    """Refuse a path that leads out of the folder of the job that is read; a job from a database has none."""
    folder = (info.context or {}).get("folder")
    if folder is not None:
        job_path(folder, name)
    return name


JobPath = Annotated[str, Field(min_length=1), pydantic.AfterValidator(_within_folder)]
PaletteKey = Annotated[str, pydantic.BeforeValidator(_palette_key)]
Polygons = Annotated[tuple[Polygon, ...], pydantic.AfterValidator(_some_polygons)]
Probability = Annotated[float, Field(ge=0, le=1)]


class LabelImage(StrictModel):
    """An image of the texture's size whose colours name materials; colours outside the palette label nothing."""

    image: JobPath = Field(
        description="Label image, of the same width and height as the texture; {name} represents the texture's name."
    )
    palette: dict[PaletteKey, SeedName] = Field(
        min_length=1,
        description='Material of each label colour ("#RRGGBB") or grey level (0 to 65535), or `unknown`.',
    )


class MixedLabelImage(LabelImage):
    """A label image whose colours may name mixtures."""

    palette: dict[PaletteKey, MaterialOrMixture] = Field(
        min_length=1,
        description='Material of each label colour ("#RRGGBB") or grey level (0 to 65535), or a mixture of up to three '
        "by ratio, such as {asphalt_road: 60, grass_dry: 40}.",
    )


class Seeds(StrictModel):
    """Texels whose material is known, from any of four places."""

    polygons: dict[SeedName, Polygons] = Field(
        default={},
        description="Polygons of [x, y] pixel coordinates by material; one vertex alone names one texel. `unknown` is "
        "what is none of the library's materials: what looks like it becomes unknown too.",
    )
    file: JobPath | None = Field(
        default=None,
        description="GeoJSON; `properties.material` names the material. {name} represents the texture's name.",
    )
    coordinates: Literal["pixel", "map"] = Field(
        default="pixel",
        description="Coordinates of the GeoJSON file: those of pixels, or those of the map that the image lies on (its "
        "GeoTIFF tags or world file); what lies beyond the image is omitted then.",
    )
    labels: LabelImage | None = Field(None, description="Image of the texture's size whose colours name materials.")
    suggested: JobPath | None = Field(
        default=None,
        description="List of numbered places with their materials, which 'tmm suggest' writes to be filled in. {name} "
        "represents the texture's name.",
    )

    @pydantic.model_validator(mode="after")
    def _not_empty(self) -> Seeds:
        if not self.polygons and self.file is None and self.labels is None and self.suggested is None:
            raise ValueError("found no seeds; allowed: polygons, file, labels, suggested; give at least one of them")
        return self

    def files(self) -> dict[str, str | None]:
        """The files of polygons and places by their keys."""
        return {"file": self.file, "suggested": self.suggested}


class OverrideTexels(Seeds):
    """Texels whose material or mixture is given, whatever is found there."""

    labels: MixedLabelImage | None = Field(
        None, description="Image of the texture's size whose colours name materials or mixtures."
    )


class Classifier(StrictModel):
    """Settings of the classifiers that give a posterior probability of each material."""

    speed: Literal["best", "fast"] = Field(
        default="best",
        description="Classifier for seeds. best: colour and texture, spread over a graph of superpixels, "
        "with the job's model "
        "where it names one; fast: colours averaged over a box, many times faster and less accurate.",
    )
    radius: int = Field(
        default=8,
        ge=0,
        le=MAX_RADIUS,
        description="Radius of the box over which posteriors are averaged, in texels: of speed fast, of clusters and "
        "of a model alone.",
    )
    prior: Literal["equal", "seeds"] | dict[MaterialName, Annotated[float, Field(gt=0)]] = Field(
        default="equal",
        description="Prior of the materials: equal, as the seeds' texels, or a number for each material. With seeds of "
        "several places, not asked for, equal is the start of an estimate by how much of the texture each covers.",
    )
    confidence_threshold: Probability = Field(
        default=0.0, description="Texels of lower confidence become unknown (code 0)."
    )
    typicality_threshold: Probability | None = Field(
        default=None,
        description="Texels less typical of all materials than this become unknown (code 0): with seeds by the colour "
        "and the contrast of the box about them, else by colour alone. By default what one in twenty of the seeds' own "
        "places lies below, 0.2 at most, where 19 separate places or more were drawn, three a material, none of them "
        "is of the class 'unknown' and none is an answer to what "
        "'tmm suggest' asked; else 0, which leaves none out.",
    )


class Palette(StrictModel):
    """Materials by the colours of the texture itself."""

    colours: dict[PaletteKey, MaterialOrMixture] = Field(
        min_length=1,
        description='Material of each colour ("#RRGGBB") or grey level (0 to 65535) of the texture, or a mixture of up '
        "to three by ratio, such as {asphalt_road: 60, grass_dry: 40}.",
    )
    match: Literal["exact", "nearest"] = Field(
        default="exact", description="exact: other colours are unknown; nearest: the nearest colour in CIELAB."
    )
    spread: float = Field(
        default=6.0, gt=0, description="nearest: standard deviation of a material's colours, in units of CIELAB."
    )


QUANTITIES = {
    "lightness": "CIE L*, 0 to 100",
    "a": "CIE a*, red against green",
    "b": "CIE b*, yellow against blue",
    "chroma": "CIE C*, sqrt(a^2 + b^2)",
    "hue": "CIE h, degree, 0 to 360: red about 40, yellow 100, green 140, blue 300",
    "red": "0 to 1 as stored",
    "green": "0 to 1 as stored",
    "blue": "0 to 1 as stored",
    "near_infrared": "0 to 1 as stored",
    "excess_green": "2 g - r - b of the chromaticities r, g, b (Woebbecke et al. 1995)",
    "ndvi": "(near_infrared - red) / (near_infrared + red)",
}


class Range(StrictModel):
    """An interval; a missing end is open."""

    at_least: float | None = Field(None, description="Smallest value that lies in the range.")
    below: float | None = Field(None, description="Value below which the range ends.")

    @pydantic.model_validator(mode="after")
    def _not_empty(self) -> Range:
        if self.at_least is None and self.below is None:
            raise ValueError("found neither at_least nor below; give at least one of them")
        if self.at_least is not None and self.below is not None and self.at_least >= self.below:
            raise ValueError(f"found at_least {self.at_least:g} and below {self.below:g}; allowed: at_least < below")
        return self


class Rule(StrictModel):
    """A material for the texels whose quantities all lie in the ranges; without ranges, for all texels."""

    material: MaterialOrMixture = Field(description="Material or mixture of the texels that match the rule.")
    when: dict[str, Range] = Field(default={}, description=f"Ranges of: {', '.join(QUANTITIES)}, or names of layers.")


class Rules(StrictModel):
    """Rules, of which the first that matches gives the material; where none matches it is unknown."""

    rules: tuple[Rule, ...] = Field(min_length=1, description="Rules in the order of trial.")
    layers: dict[str, JobPath] = Field(
        default={}, description="Further images of the texture's size, such as height, whose first channel rules name."
    )

    @pydantic.model_validator(mode="after")
    def _known_quantities(self) -> Rules:
        allowed = [*QUANTITIES, *self.layers]
        for name in self.layers:
            if name in QUANTITIES:
                raise ValueError(f"found a layer named '{name}', which is a quantity already; name it otherwise")
        for rule in self.rules:
            for name in rule.when:
                if name not in allowed:
                    raise ValueError(f"unknown quantity '{name}'; {nearest(name, allowed)}")
        return self


class Clusters(StrictModel):
    """Clusters of colours, found without seeds; those that are named become materials, the others stay unknown."""

    count: int = Field(ge=1, le=64, description="Number of clusters; they are numbered from 1, the darkest.")
    names: dict[int, MaterialOrMixture] = Field(
        default={}, description="Material or mixture of a cluster by its number."
    )
    random_seed: int = Field(default=0, ge=0, description="Seed of the sample of texels and of the first centres.")

    @pydantic.model_validator(mode="after")
    def _known_numbers(self) -> Clusters:
        for number in self.names:
            if not 1 <= number <= self.count:
                raise ValueError(f"found a name for cluster {number}; allowed: 1 to {self.count}")
        return self


class HeldOut(StrictModel):
    """How the quality is measured: each seed region is classified by a model trained without it."""

    folds: int = Field(default=4, ge=2, le=20, description="Number of parts into which the seed regions are divided.")
    random_seed: int = Field(default=0, ge=0, description="Seed of the division into parts.")


class TextureJob(StrictModel):
    """One texture and what is known of it."""

    image: JobPath = Field(
        description="Image file, relative to the job file; or a folder of images, a pattern such as photos/*.png, or a "
        "name with <UDIM>, which give one texture per image."
    )
    name: str = Field(
        default="",
        pattern=r"^([A-Za-z0-9_][A-Za-z0-9_.-]*)?$",
        description="Name of the database (NAME.tmm.h5); by default the image's name without its ending.",
    )
    alpha: Literal["auto", "no-data", "ignore"] = Field(
        default="auto",
        description="auto: texels with alpha below one half, masked ones (in a TIFF, or in a .msk file beside the "
        "image) and those of a TIFF's no-data value have no material; what a file calls alpha and has few texels that "
        "are clear or opaque is none. no-data: it is. ignore: all texels are used.",
    )
    colour_space: Literal["auto", "srgb", "linear"] = Field(
        default="auto",
        description="Encoding of the colours; auto: by the file, else sRGB for integers, linear for floats.",
    )
    near_infrared: str | None = Field(
        default=None,
        min_length=1,
        description="Name or number, from 1, of the channel of near infrared, or 'none'; by default the fourth of a "
        "TIFF of four that is no alpha.",
    )
    white: float | None = Field(
        default=None,
        gt=0,
        description="Stored value that is white, of 16 bit images that fill a part of their range, such as 4095 of 12 "
        "bits or 10000 of reflectance times 10,000; by default by the data.",
    )
    shade: Shade | None = Field(
        None,
        description="Find the cast shade of a photograph by the Sun's direction, take it away before materials are "
        "found, and store it as a layer; polygons correct it.",
    )
    classifier: Classifier = Field(
        Classifier(), description="Classification of texels from seeds, clusters or a model."
    )
    held_out: HeldOut = Field(HeldOut(), description="Measurement of the quality.")
    material: MaterialOrMixture | None = Field(
        default=None, description="One material, or one mixture, for the whole texture."
    )
    palette: Palette | None = Field(None, description="Materials by the colours of the image itself.")
    rules: Rules | None = Field(None, description="Materials by thresholds of colour and of further layers.")
    seeds: Seeds | None = Field(None, description="Texels whose material is known, from which the others follow.")
    model: JobPath | None = Field(
        default=None,
        description="File of a classifier trained by 'tmm train', relative to the job file, or 'library' for the one "
        "that comes with the package; beside seeds, both together find the materials that the seeds name, and what the "
        "model knows and no seed names becomes unknown.",
    )
    scene_materials: tuple[MaterialName, ...] = Field(
        default=(),
        description="Materials of the scene, for a model without seeds: each class of the model represents the "
        "material of its name, else for one of its group, and classes that represent none are omitted. By default "
        "the classes themselves.",
    )
    clusters: Clusters | None = Field(
        None, description="Clusters of colours, found without seeds and named afterwards."
    )
    overrides: OverrideTexels | None = Field(
        default=None, description="Polygons and label images whose texels have their material whatever is found there."
    )

    @pydantic.model_validator(mode="before")
    @classmethod
    def _name_by_image(cls, data: Any) -> Any:
        if isinstance(data, dict) and not data.get("name") and isinstance(data.get("image"), str):
            return {**data, "name": texture_name(data["image"])}
        return data

    @pydantic.model_validator(mode="after")
    def _one_way(self) -> TextureJob:
        sources = [way for way in WAYS if getattr(self, way) is not None]
        if len(sources) != 1 and sources != ["seeds", "model"]:
            ways = " and ".join(sources) if sources else "none"
            raise ValueError(
                f"found {ways} of the ways to assign materials; allowed: one of {', '.join(WAYS)}, or seeds and model"
            )
        if self.classifier.speed == "fast" and sources != ["seeds"]:
            raise ValueError(
                f"found classifier.speed fast beside {' and '.join(sources)}; allowed: with seeds alone; remove it"
            )
        if self.scene_materials and sources != ["model"]:
            raise ValueError(
                f"found scene_materials beside {' and '.join(sources)}; allowed: beside a model alone; remove it, "
                "because seeds and the other ways name the materials themselves"
            )
        return self

    @property
    def way(self) -> str:
        """Which of `WAYS` assigns the materials; ``seeds`` where a model is beside them."""
        return next(way for way in WAYS if getattr(self, way) is not None)

    @property
    def classes(self) -> tuple[str, ...]:
        """Materials and mixtures that the job itself names; see `is_mixture`."""
        names = {*self.scene_materials, *([self.material] if self.material else [])}
        names |= set(self.palette.colours.values()) if self.palette else set()
        names |= {rule.material for rule in self.rules.rules} if self.rules else set()
        names |= set(self.clusters.names.values()) if self.clusters else set()
        for seeds in (self.seeds, self.overrides):
            if seeds is not None:
                names |= {*seeds.polygons, *(seeds.labels.palette.values() if seeds.labels else ())}
        return tuple(sorted(names - {UNKNOWN}))

    @property
    def mixtures(self) -> tuple[str, ...]:
        """Those of the classes that are mixtures."""
        return tuple(filter(is_mixture, self.classes))

    @property
    def materials(self) -> tuple[str, ...]:
        """Names of the materials that the job itself names, those in mixtures included; those of a GeoJSON or model
        file are in that file.
        """
        return tuple(sorted({name for entry in self.classes for name in parts_of(entry)}))


def _single_images(texture: TextureJob, folder: Path) -> list[TextureJob]:
    """The textures that an entry of a job represents."""
    images = find_images(folder, texture.image) or {texture.name: texture.image}
    if texture.name != texture_name(texture.image):
        if len(images) > 1:
            raise ValueError(
                f"found the name '{texture.name}' for the {len(images)} images of '{texture.image}'; leave 'name' out,"
                " they are named as their files"
            )
        images = dict(zip([texture.name], images.values(), strict=True))
    return [
        texture.model_copy(
            update={
                "image": image,
                "name": name,
                "seeds": _own_files(texture.seeds, name, folder),
                "overrides": _own_files(texture.overrides, name, folder),
            }
        )
        for name, image in images.items()
    ]


AnySeeds = TypeVar("AnySeeds", bound=Seeds)


def _own_files(seeds: AnySeeds | None, name: str, folder: Path) -> AnySeeds | None:
    """Seeds whose files are those of one texture: {name} in their paths is its name."""
    if seeds is None:
        return None

    def own(path: str) -> str:
        if "{name}" in path:
            path = path.replace("{name}", name)
            job_path(folder, path)
        return path

    labels = seeds.labels and seeds.labels.model_copy(update={"image": own(seeds.labels.image)})
    files = {key: None if path is None else own(path) for key, path in seeds.files().items()}
    return seeds.model_copy(update={**files, "labels": labels})


PACKAGED = "library"  # a job's name for the classifier that comes with the package
WAYS = ("material", "palette", "rules", "seeds", "model", "clusters")


def stored_job(text: str) -> TextureJob:
    """The job that a database was made from, out of its attribute `job`."""
    return TextureJob.model_validate(yaml.safe_load(text))


class TmmOutput(StrictModel):
    """Where the databases go."""

    folder: str = Field("build", min_length=1, description="Relative to the job file.")


class TmmJob(StrictModel):
    """A job of the command `tmm`; `skyshine` and `output` are those of a job of `mat`."""

    skyshine: Literal[1] = Field(1, description="Version of the job format; 1 where it is not written.")
    textures: tuple[TextureJob, ...] = Field(min_length=1, description="Each becomes a database.")
    output: TmmOutput = Field(TmmOutput(), description="Folder of the databases.")

    @pydantic.field_validator("textures")
    @classmethod
    def _every_image(cls, textures: tuple[TextureJob, ...], info: pydantic.ValidationInfo) -> tuple[TextureJob, ...]:
        """One texture an image; a job from elsewhere than a file has no folder, and its images stay as they are."""
        folder = (info.context or {}).get("folder")
        if folder is None:
            return textures
        return tuple(single for texture in textures for single in _single_images(texture, folder))

    @pydantic.model_validator(mode="after")
    def _distinct_names(self) -> TmmJob:
        check_distinct_names(self.textures)
        return self


def check_distinct_names(textures: Sequence[TextureJob]) -> None:
    """Refuse two textures that would be written to one file.

    Raises ValueError.
    """
    for name, count in Counter(texture.name for texture in textures).items():
        if count > 1:
            raise ValueError(f"found two textures named '{name}'; allowed: each name once; give one another 'name'")
