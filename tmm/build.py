"""From a texture job to a map of the texture: who finds the material of its texels, and how good the answer is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.assign import (
    ExactPalette,
    Overrides,
    Renamed,
    RuleMapper,
    WholeTexture,
    find_clusters,
    nearest_palette,
)
from skyshine.tmm.classify import Classified, ColourMapper, Mapper, fit_seeds
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.job import TextureJob
from skyshine.tmm.quality import HeldOut, measure, untested, with_unknown
from skyshine.tmm.raster import file_sha256
from skyshine.tmm.seeds import SeedTexels, seed_files, seed_polygons, seed_texels
from skyshine.tmm.texture import TextureFile

BAND, STRIP = 256, 1024  # texels of a window: the rows of a chunk of the file; what stays in a processor's cache


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
    files : dict of str to str
        SHA-256 of the files besides the image that the map depends on, by their path in the job.
    """

    job: TextureJob
    library_version: str
    texture: TextureFile
    colours: DistinctColours
    names: tuple[str, ...]
    codes: np.ndarray
    seeds: SeedTexels | None
    quality: HeldOut
    files: dict[str, str]
    mapper: Mapper

    def windows(self) -> Iterator[tuple[slice, slice, np.ndarray, Classified]]:
        """Classify the texture from the top to the bottom.

        Yields
        ------
        rows, columns : slice
        code : (h, w) uint16
            Material codes; 0 for unknown and no data.
        classified : Classified
            With calibrated confidence.
        """
        code_of = np.append([self.codes[self.names.index(name)] for name in self.mapper.names], 0).astype(np.uint16)
        for top in range(0, self.texture.height, BAND):
            for left in range(0, self.texture.width, STRIP):
                bottom, right = min(top + BAND, self.texture.height), min(left + STRIP, self.texture.width)
                found = self.mapper.window(top, bottom, left, right)
                found = Classified(found.material, self.quality.calibration(found.confidence), found.typicality)
                code = code_of[with_unknown(found, self.job.classifier)]
                yield slice(top, bottom), slice(left, right), code, found


def open_texture(job: TextureJob, base_folder: Path) -> TextureFile:
    """The image of a job, read as the job says; see `TextureFile` for what it raises."""
    return TextureFile(Path(base_folder) / job.image, job.colour_space, job.alpha, job.near_infrared)


def job_materials(job: TextureJob, base_folder: Path) -> tuple[str, ...]:
    """Names of all materials that a job names, those of its GeoJSON and model files included.

    Raises
    ------
    InputError
        Such a file cannot be read.
    """
    names = set(job.materials)
    for seeds in (job.seeds, job.overrides):
        if seeds is not None:
            names |= {name for name, _ in seed_polygons(seeds, Path(base_folder))}
    if job.model is not None:
        from skyshine.tmm.model import read_model

        names |= set(read_model(Path(base_folder) / job.model).names)
    return tuple(sorted(names))


def job_files(job: TextureJob) -> tuple[str, ...]:
    """Files besides the image that a map depends on, relative to the job's folder."""
    layers = tuple(job.rules.layers.values()) if job.rules else ()
    model = (job.model,) if job.model else ()
    return tuple(dict.fromkeys((*seed_files(job.seeds), *layers, *model, *seed_files(job.overrides))))


def load_texture(
    job: TextureJob, base_folder: Path, library
) -> tuple[TextureFile, DistinctColours, tuple[str, ...], SeedTexels | None]:
    """Read a job's image once, and find its materials, in the order of their codes, and its seeds.

    Raises as `map_texture`.
    """
    base_folder = Path(base_folder)
    texture = open_texture(job, base_folder)
    colours = DistinctColours(texture)
    if not colours.valid_texels:
        raise InputError(
            "has no texel with data (all are transparent or not finite); name another image, or say 'alpha: ignore'",
            file=texture.path,
        )
    names = job_materials(job, base_folder)
    for name in names:
        if name not in library:
            raise InputError(f"unknown material '{name}' in '{job.name}'; {nearest(name, library.names)}")
    names = tuple(sorted(names, key=lambda name: library[name].code))
    return texture, colours, names, None if job.seeds is None else _seeds(job, names, texture, base_folder)


def map_texture(job: TextureJob, base_folder: Path, library) -> TextureMap:
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
    if seeds is not None:
        mapper, quality = _trained(job, texture, colours, seeds)
    else:
        mapper, quality = _untrained(job, texture, colours, names, base_folder)
    if job.overrides is not None:
        mapper = Overrides(mapper, texture, job.overrides, base_folder, texture.path)
    return TextureMap(
        job=job,
        library_version=library.version,
        texture=texture,
        colours=colours,
        names=names,
        codes=np.array([library[name].code for name in names], np.uint16),
        seeds=seeds,
        quality=quality,
        files={name: file_sha256(base_folder / name) for name in job_files(job)},
        mapper=mapper,
    )


def _seeds(job: TextureJob, names: tuple[str, ...], texture: TextureFile, base_folder: Path) -> SeedTexels:
    labelled = job.seeds.labels.palette.values() if job.seeds.labels else ()
    seeded = {*labelled, *(name for name, _ in seed_polygons(job.seeds, base_folder))}
    for name in job.classifier.prior if isinstance(job.classifier.prior, dict) else ():
        if name not in seeded:
            raise InputError(f"'{job.name}' has a prior for '{name}', which has no seeds; {nearest(name, sorted(seeded))}")
    return seed_texels(job, tuple(name for name in names if name in seeded), texture, texture.path, base_folder)


def _trained(job: TextureJob, texture: TextureFile, colours: DistinctColours, seeds: SeedTexels) -> tuple[Mapper, HeldOut]:
    """What is trained on all seeds, and its quality on seeds held out."""
    settings = job.classifier

    def mapper_of(chosen: np.ndarray | None) -> Mapper:
        model = fit_seeds(seeds, texture.encoding, settings, chosen)
        return ColourMapper(texture, colours, model, settings.radius, tabulate=chosen is None)

    quality = measure(job, texture.encoding, seeds, mapper_of)
    return mapper_of(None), quality


def _untrained(
    job: TextureJob, texture: TextureFile, colours: DistinctColours, names: tuple[str, ...], base_folder: Path
) -> tuple[Mapper, HeldOut]:
    quality = untested(len(names))
    if job.material is not None:
        return WholeTexture(texture, job.material), quality
    if job.rules is not None:
        return RuleMapper(texture, job.rules, names, base_folder, texture.path), quality
    if job.palette is not None and job.palette.match == "exact":
        return ColourMapper(texture, colours, ExactPalette(job.palette, names, texture.dtype, texture.path), 0), quality
    if job.palette is not None:
        model, material = nearest_palette(job.palette, names, texture, texture.path)
        return Renamed(ColourMapper(texture, colours, model, 0), names, material), quality
    if job.clusters is not None:
        model = find_clusters(texture, job.clusters)
        named = [job.clusters.names.get(int(number)) for number in model.names]
        material = np.array([-1 if name is None else names.index(name) for name in named])
        return Renamed(ColourMapper(texture, colours, model, job.classifier.radius), names, material), quality
    raise AssertionError(job.way)
