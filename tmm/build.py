"""From a texture job to codes, confidence, mip levels, usage and quality."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.classify import TextureClassifier, fit_seeds
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.job import TextureJob
from skyshine.tmm.levels import Level, mip_levels
from skyshine.tmm.quality import Quality, measure, with_unknown
from skyshine.tmm.seeds import SeedTexels, seed_files, seed_texels
from skyshine.tmm.texture import Texture, file_sha256, read_texture


@dataclass(frozen=True)
class TextureResult:
    """A mapped texture.

    Attributes
    ----------
    job : TextureJob
    library_version : str
        Version of the material library that gave the codes.
    texture : Texture
    seeds : SeedTexels
    codes : (K,) uint16
        Material codes, in ascending order.
    levels : list of Level
        The first is the texture itself.
    confidence, typicality : (H, W) float32
        0 where there is no data.
    quality : Quality
    distinct_colours : int
        Number of distinct colours of an 8 bit texture; 0 for others, where they are not counted.
    seed_files : dict of str to str
        SHA-256 of the files that the seeds came from, by their path in the job.
    """

    job: TextureJob
    library_version: str
    texture: Texture
    seeds: SeedTexels
    codes: np.ndarray
    levels: list[Level]
    confidence: np.ndarray
    typicality: np.ndarray
    quality: Quality
    distinct_colours: int
    seed_files: dict[str, str]

    @property
    def names(self) -> tuple[str, ...]:
        """Materials in the order of their codes."""
        return self.seeds.names

    @property
    def usage(self) -> np.ndarray:
        """Share (K,) of the texels with data that have each material; what is missing to 1 is unknown."""
        counts = np.bincount(self.levels[0].code.ravel(), minlength=int(self.codes.max()) + 1)
        return counts[self.codes] / max(int(self.texture.valid.sum()), 1)


def load_texture(job: TextureJob, base_folder: Path, library) -> tuple[Texture, SeedTexels]:
    """Read a job's image and find its seeds; see `build_texture` for what it raises."""
    base_folder = Path(base_folder)
    texture = read_texture(base_folder / job.image, job.colour_space, job.alpha)
    if not texture.valid.any():
        raise InputError(
            "has no texel with data (all are transparent or not finite); name another image, or say 'alpha: ignore'",
            file=texture.path,
        )
    seeds = seed_texels(job, texture, base_folder, library)
    for name in job.classifier.prior if isinstance(job.classifier.prior, dict) else ():
        if name not in seeds.names:
            raise InputError(f"'{job.name}' has a prior for '{name}', which has no seeds; {nearest(name, seeds.names)}")
    return texture, seeds


def build_texture(job: TextureJob, base_folder: Path, library) -> TextureResult:
    """Map the texels of a texture to materials.

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
        The image, the label image or the GeoJSON cannot be read, or the seeds do not fit the image or the library.
    """
    texture, seeds = load_texture(job, base_folder, library)
    colours = DistinctColours(texture)
    model = fit_seeds(texture, seeds, job.classifier)
    classified = TextureClassifier(texture, colours, model, job.classifier.radius).whole()
    codes = np.array([library[name].code for name in seeds.names], np.uint16)
    code = np.concatenate([codes, np.zeros(1, np.uint16)])[with_unknown(classified, job)]
    return TextureResult(
        job=job,
        library_version=library.version,
        texture=texture,
        seeds=seeds,
        codes=codes,
        levels=mip_levels(code),
        confidence=classified.confidence,
        typicality=classified.typicality,
        quality=measure(job, texture, colours, seeds),
        distinct_colours=0 if colours.colours is None else len(colours.colours),
        seed_files={name: file_sha256(Path(base_folder) / name) for name in seed_files(job)},
    )
