"""From a texture job to a map of the texture: the choice of the classifier, the map and its quality."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary
from skyshine.tmm.classify.graph import TYPICAL_RADIUS, GraphMapper, survey
from skyshine.tmm.classify.mapper import Classified, ColourMapper, Mapper
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.classify.trained import ModelMapper, TrainedModel
from skyshine.tmm.classify.translation import and_unknown, class_groups, library_classes
from skyshine.tmm.classify.typicality import Boxes, Everywhere, Typicality
from skyshine.tmm.database.levels import Level, pure_level, ranked
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.images.georeference import GeoReference, read_georeference
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.load import job_files, load_texture, narrowed
from skyshine.tmm.inputs.named_materials import refuse_without_materials
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.materials import UNKNOWN, parts_of
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.ways import (
    ExactPalette,
    Overrides,
    Renamed,
    RuleMapper,
    WholeTexture,
    find_clusters,
    nearest_palette,
)
from skyshine.tmm.quality.held_out import HeldOut, measure, untested, with_unknown
from skyshine.tmm.training.seed_boxes import SeedBoxes, seed_boxes
from skyshine.tmm.training.train import fit_seeds

# The threshold of typicality is at most this. A box of few texels scatters too much.
UNTYPICAL, UNTYPICAL_RADIUS = 0.2, 4
# Separate places of a material, the median over them: with fewer the threshold takes more of what is known than it is
# worth (5 % with two places a material, 7 % with one).
TYPICAL_PLACES = 3
BAND, STRIP = 256, 512  # texels of a window, whole chunks of the file: what stays in a processor's cache


class ClassMixtures:
    """The materials of the classes of a mapper."""

    def __init__(self, names: tuple[str, ...], code_of: dict[str, int]) -> None:
        """`names` are the C classes: materials, mixtures or `unknown`; `code_of` has the codes of all materials."""
        self._codes = np.array(sorted(code_of.values()), np.uint16)
        # Weights of the K materials in the classes; the last row, which -1 means, is that of no material.
        weights = np.zeros((len(self._codes), len(names) + 1), np.int64)
        for number, name in enumerate(names):
            for material, weight in parts_of(name).items() if name != UNKNOWN else ():
                weights[np.searchsorted(self._codes, code_of[material]), number] = weight
        self._table = ranked(self._codes, weights)
        self._pure = bool((np.count_nonzero(weights, axis=0) <= 1).all())

    def of(self, number: npt.NDArray[Any]) -> Level:
        """The materials of classes by number (h, w), -1 for none."""
        if self._pure:
            return pure_level(self._table.code[number])
        return Level(self._table.code[number], self._table.mix_code[number], self._table.mix_weight[number])


@dataclass(frozen=True)
class TextureMap:
    """A texture and what finds the material of its texels.

    Attributes
    ----------
    job : TextureJob
    library_version : str
        Version of the material library that gave the codes.
    texture : TextureFile
    colours : DistinctColours
    names : tuple of str
        K materials in the order of their codes.
    codes : (K,) uint16
        Ascending.
    seeds : SeedTexels or None
    quality : HeldOut
    georeference : GeoReference or None
    files : dict of str to str
        SHA-256 of the files besides the image that the map depends on, by their path in the job.
    thresholds : (float, float)
        Confidence and typicality below which a texel is unknown.
    mapper : Mapper
    """

    job: TextureJob
    library_version: str
    texture: TextureFile
    colours: DistinctColours
    names: tuple[str, ...]
    codes: npt.NDArray[np.uint16]
    seeds: SeedTexels | None
    quality: HeldOut
    georeference: GeoReference | None
    files: dict[str, str]
    thresholds: tuple[float, float]
    mapper: Mapper

    @property
    def mixed(self) -> bool:
        """Whether texels of the first level may have several materials."""
        return bool(self.job.mixtures)

    def windows(self) -> Iterator[tuple[slice, slice, Level, Classified]]:
        """Classify the texture from the top to the bottom.

        Yields
        ------
        rows, columns : slice
        level : Level; materials of the window (h, w); code 0 for unknown and no data.
        classified : Classified; with calibrated confidence.
        """
        classes = ClassMixtures(self.mapper.names, dict(zip(self.names, self.codes.tolist(), strict=True)))
        for top in range(0, self.texture.height, BAND):
            for left in range(0, self.texture.width, STRIP):
                bottom, right = min(top + BAND, self.texture.height), min(left + STRIP, self.texture.width)
                raw = self.mapper.window(top, bottom, left, right)
                classified = Classified(raw.material, self.quality.calibration(raw.confidence), raw.typicality)
                level = classes.of(with_unknown(classified, self.thresholds))
                yield slice(top, bottom), slice(left, right), level, classified


def map_texture(job: TextureJob, base_folder: Path, library: MaterialLibrary) -> TextureMap:
    """Open a texture, find its seeds, train what is to be trained and measure how good it is.

    Raises InputError: a file cannot be read, or does not fit the image or the library; or the job names no material.

    Parameters
    ----------
    job : TextureJob
    base_folder : path
        Folder of the job file, to which its paths are relative.
    library : MaterialLibrary
        Gives the code of each material name.
    """
    base_folder = Path(base_folder)
    texture, colours, names, seeds = load_texture(job, base_folder, library)
    refuse_without_materials(job, names)
    confidence, typicality = thresholds(job, seeds)
    if seeds is not None:
        boxes = None
        if typicality > 0:
            radius = job.classifier.radius if job.classifier.speed == "fast" else TYPICAL_RADIUS
            boxes = seed_boxes(Boxes(texture, colours, radius), seeds)
            if job.classifier.typicality_threshold is None:
                typicality = min(typicality, boxes.threshold())
        general = None if job.model is None else read_model(model_path(job.model, base_folder))
        mapper_of = seed_mappers(job, texture, colours, seeds, general, library, boxes if typicality > 0 else None)
        mapper, quality = mapper_of(None), measure(job, seeds, mapper_of, (confidence, typicality))
    else:
        mapper, quality = _untrained(job, texture, colours, names, base_folder, library)
    if job.overrides is not None:
        mapper = Overrides(mapper, texture, job.overrides, base_folder, texture.path)
    return TextureMap(
        job=job,
        library_version=library.version,
        texture=texture,
        colours=colours,
        names=names,
        codes=np.array([library.code(name) for name in names], np.uint16),
        seeds=seeds,
        quality=quality,
        georeference=read_georeference(texture.path),
        files={name: file_sha256(path) for name, path in job_files(job, base_folder).items()},
        thresholds=(confidence, typicality),
        mapper=mapper,
    )


def thresholds(job: TextureJob, seeds: SeedTexels | None) -> tuple[float, float]:
    """Confidence and typicality below which a texel becomes unknown.

    Typicality has no threshold where there is too little evidence of what is typical: without seeds, or with few
    separate places of them. Answers to what `tmm suggest` asked lie where the map was in doubt, which is not typical,
    and say themselves where it is unknown, as seeds of that class do.
    """
    confidence, typicality = job.classifier.confidence_threshold, job.classifier.typicality_threshold
    if typicality is not None:
        return confidence, typicality
    if seeds is None or UNKNOWN in seeds.names or seeds.answered.any():
        return confidence, 0.0
    enough = np.median(seeds.separate_places) >= TYPICAL_PLACES
    box = job.classifier.radius if job.classifier.speed == "fast" else TYPICAL_RADIUS
    return confidence, UNTYPICAL if enough and box >= UNTYPICAL_RADIUS else 0.0


def seed_mappers(
    job: TextureJob,
    texture: TextureFile,
    colours: DistinctColours,
    seeds: SeedTexels,
    general: TrainedModel | None,
    library: MaterialLibrary,
    boxes: SeedBoxes | None,
) -> Callable[[npt.NDArray[np.bool_] | None], Mapper]:
    """Make mappers from all seeds (None) or from those chosen (N,), at the speed that the job asks for.

    general : TrainedModel or None; a library model beside the seeds.
    boxes : SeedBoxes or None; None where nothing becomes unknown by its typicality.
    """
    settings = job.classifier
    fast = settings.speed == "fast"

    def typicality(chosen: npt.NDArray[np.bool_] | None) -> Typicality | Everywhere:
        return Everywhere() if boxes is None else boxes.typicality(chosen)

    if fast:

        def by_colour(chosen: npt.NDArray[np.bool_] | None) -> Mapper:
            model = fit_seeds(seeds, texture.encoding, settings.prior, chosen)
            return ColourMapper(texture, colours, model, settings.radius, chosen is None, typicality(chosen))

        return by_colour
    surveyed = survey(texture, colours, general)
    groups = class_groups(general, seeds.names, library)

    def by_graph(chosen: npt.NDArray[np.bool_] | None) -> Mapper:
        model = fit_seeds(seeds, texture.encoding, settings.prior, chosen)
        classes = library_classes(() if general is None else general.names, model.names, groups)
        classes = and_unknown(classes, model.names)
        drawn = seeds.drawn(model.names, chosen)
        return GraphMapper(texture, colours, surveyed, model, classes, drawn, typicality(chosen))

    return by_graph


def _untrained(
    job: TextureJob,
    texture: TextureFile,
    colours: DistinctColours,
    names: tuple[str, ...],
    base_folder: Path,
    library: MaterialLibrary,
) -> tuple[Mapper, HeldOut]:
    quality, classes = untested(len(names)), (*names, *job.mixtures)
    if job.material is not None:
        return WholeTexture(texture, job.material), quality
    if job.rules is not None:
        return RuleMapper(texture, job.rules, classes, base_folder, texture.path), quality
    if job.palette is not None and job.palette.match == "exact":
        exact = ExactPalette(job.palette, classes, texture.dtype, texture.path)
        return ColourMapper(texture, colours, exact, 0), quality
    if job.palette is not None:
        model, material = nearest_palette(job.palette, classes, texture, texture.path)
        return Renamed(ColourMapper(texture, colours, model, 0), classes, material), quality
    if job.clusters is not None:
        model = find_clusters(texture, job.clusters)
        named = [job.clusters.names.get(int(number)) for number in model.names]
        material = np.array([-1 if name is None else classes.index(name) for name in named])
        return Renamed(ColourMapper(texture, colours, model, job.classifier.radius), classes, material), quality
    if job.model is None:
        raise ValueError(f"'{job.name}' assigns no materials")
    trained = read_model(model_path(job.model, base_folder))
    quality = replace(quality, calibration=trained.calibration)
    if not job.scene_materials:
        return ModelMapper(texture, colours, trained, job.classifier.radius), quality
    considered, material = narrowed(job, trained, library, names)
    among = ModelMapper(texture, colours, trained.only(considered.tolist()), job.classifier.radius)
    return Renamed(among, names, material), quality
