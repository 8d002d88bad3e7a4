"""From a texture job to a map of the texture: the choice of the classifier, the map and its quality."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary
from skyshine.tmm.classify.combined import TYPICAL_RADIUS, CombinedMapper, survey
from skyshine.tmm.classify.mapper import Classified, ColourMapper, Mapper
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.classify.translation import library_classes
from skyshine.tmm.classify.typicality import Boxes
from skyshine.tmm.database.levels import Level
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.features.tokens import TokenFeatures
from skyshine.tmm.images.georeference import GeoReference, read_georeference
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.load import job_files, load_texture, narrowed, token_features
from skyshine.tmm.inputs.seeds import SeedTexels
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.mixtures import ClassMixtures
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
from skyshine.tmm.training.examples import examples
from skyshine.tmm.training.seed_boxes import seed_boxes
from skyshine.tmm.training.train import train_on_seeds

BAND, STRIP = 256, 512  # texels of a window, whole chunks of the file: what stays in a processor's cache


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
    place : GeoReference or None
    files : dict of str to str
        SHA-256 of the files besides the image that the map depends on, by their path in the job.
    """

    job: TextureJob
    library_version: str
    texture: TextureFile
    colours: DistinctColours
    names: tuple[str, ...]
    codes: npt.NDArray[np.uint16]
    seeds: SeedTexels | None
    quality: HeldOut
    place: GeoReference | None
    files: dict[str, str]
    mapper: Mapper

    @property
    def mixed(self) -> bool:
        """Whether texels of the first level may have several materials."""
        return self.job.classifier.mixtures or bool(self.job.mixtures)

    def windows(self) -> Iterator[tuple[slice, slice, Level, Classified]]:
        """Classify the texture from the top to the bottom.

        Yields
        ------
        rows, columns : slice
        level : Level
            Materials of the window (h, w); code 0 for unknown and no data.
        classified : Classified
            With calibrated confidence.
        """
        classes = ClassMixtures(self.mapper.names, dict(zip(self.names, self.codes.tolist(), strict=True)))
        for top in range(0, self.texture.height, BAND):
            for left in range(0, self.texture.width, STRIP):
                bottom, right = min(top + BAND, self.texture.height), min(left + STRIP, self.texture.width)
                raw = self.mapper.window(top, bottom, left, right)
                classified = Classified(raw.material, self.quality.calibration(raw.confidence), raw.typicality)
                known = with_unknown(classified, self.job.thresholds)
                if self.job.classifier.mixtures:
                    level = classes.likeliest(self.mapper.posterior(top, bottom, left, right), known)
                else:
                    level = classes.of(known)
                yield slice(top, bottom), slice(left, right), level, classified


def map_texture(job: TextureJob, base_folder: Path, library: MaterialLibrary) -> TextureMap:
    """Open a texture, find its seeds, train what is to be trained and measure how good it is.

    Parameters
    ----------
    job : TextureJob
    base_folder : path
        Folder of the job file, to which its paths are relative.
    library : MaterialLibrary
        Gives the code of each material name.

    Raises
    ------
    InputError
        A file cannot be read, or does not fit the image or the library.
    """
    base_folder = Path(base_folder)
    texture, colours, names, seeds = load_texture(job, base_folder, library)
    if seeds is not None and job.model is not None:
        mapper, quality = _combined(job, texture, colours, seeds, base_folder, library)
    elif seeds is not None:
        mapper, quality = _trained(job, texture, colours, seeds, token_features(job, texture, base_folder))
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
        place=read_georeference(texture.path),
        files={name: file_sha256(path) for name, path in job_files(job, base_folder).items()},
        mapper=mapper,
    )


def _trained(
    job: TextureJob,
    texture: TextureFile,
    colours: DistinctColours,
    seeds: SeedTexels,
    tokens: TokenFeatures | None,
) -> tuple[Mapper, HeldOut]:
    """What is trained on all seeds, and its quality on seeds held out."""
    settings, random_seed = job.classifier, job.held_out.random_seed
    known = examples(texture, seeds, random_seed, tokens=tokens) if settings.method == "textured" else None
    typical = seed_boxes(Boxes(texture, colours, settings.radius), seeds)

    def mapper_of(chosen: npt.NDArray[np.bool_] | None) -> Mapper:
        model = train_on_seeds(texture, seeds, settings, known, random_seed, chosen)
        typicality = typical.typicality(chosen)
        return model.mapper(texture, colours, settings.radius, chosen is None, tokens, typicality)

    quality = measure(job, texture.encoding, seeds, mapper_of)
    return mapper_of(None), quality


def _combined(
    job: TextureJob,
    texture: TextureFile,
    colours: DistinctColours,
    seeds: SeedTexels,
    base_folder: Path,
    library: MaterialLibrary,
) -> tuple[Mapper, HeldOut]:
    """Seeds and a library model together, and their quality on seeds held out."""
    if job.model is None:
        raise ValueError(f"'{job.name}' names no model")
    general = read_model(model_path(job.model, base_folder))
    mapper_of = combined_mappers(job, texture, colours, seeds, general, library)
    return mapper_of(None), measure(job, texture.encoding, seeds, mapper_of)


def combined_mappers(
    job: TextureJob,
    texture: TextureFile,
    colours: DistinctColours,
    seeds: SeedTexels,
    general: TrainedModel | None,
    library: MaterialLibrary,
) -> Callable[[npt.NDArray[np.bool_] | None], Mapper]:
    """Make mappers of seeds and a library model together, of all seeds (None) or of those chosen (N,).

    Parameters
    ----------
    general : TrainedModel or None
        The library model; without one the seeds and the graph of superpixels say all.

    Raises
    ------
    InputError
        The model was trained with near infrared and the texture has none, or the reverse.
    """
    settings, random_seed = job.classifier, job.held_out.random_seed
    if general is not None:
        general.require_channels(texture)
    surveyed = survey(texture, colours, general)
    known = examples(texture, seeds, random_seed) if settings.method == "textured" else None
    typical = seed_boxes(Boxes(texture, colours, TYPICAL_RADIUS), seeds)
    general_names = () if general is None else general.names
    groups = {name: library.group(name) for name in (*general_names, *seeds.names) if name in library}

    def mapper_of(chosen: npt.NDArray[np.bool_] | None) -> Mapper:
        keep = np.ones(len(seeds.rows), bool) if chosen is None else chosen
        model = train_on_seeds(texture, seeds, settings, known, random_seed, chosen)
        number = np.array([model.names.index(name) if name in model.names else -1 for name in seeds.names])
        drawn = seeds.rows[keep], seeds.columns[keep], number[seeds.material[keep]]
        classes = library_classes(general_names, model.names, groups)
        typicality = typical.typicality(chosen)
        return CombinedMapper(texture, colours, surveyed, model, classes, drawn, chosen is None, typicality)

    return mapper_of


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
    tokens = token_features(job, texture, base_folder, trained)
    if not job.scene_materials:
        return trained.mapper(texture, colours, job.classifier.radius, tokens=tokens), quality
    kept, material = narrowed(job, trained, library, names)
    among = trained.only(kept.tolist()).mapper(texture, colours, job.classifier.radius, tokens=tokens)
    return Renamed(among, names, material), quality
