"""Running a job file of `tmm`."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.abandoned_parts import remove_abandoned
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path
from skyshine.schemas.quantity import quantity
from skyshine.tmm.classify.gaussian import GaussianModel
from skyshine.tmm.images.georeference import read_georeference
from skyshine.tmm.inputs.load import load_texture
from skyshine.tmm.inputs.seeds import unlabelled
from skyshine.tmm.job.model import Clusters, TextureJob, TmmJob
from skyshine.tmm.mapping.texture_map import TextureMap, map_texture
from skyshine.tmm.mapping.ways import find_clusters
from skyshine.tmm.mapping.write import Written, is_current, write_texture


def check(job: TextureJob, folder: Path, library: MaterialLibrary) -> dict[str, Any]:
    """What `tmm check` says of a texture: it is read, its seeds or clusters are found; nothing is classified.

    Raises InputError: an image or its seeds are wrong.
    """
    texture, colours, _, seeds = load_texture(job, folder, library)
    georeference = read_georeference(texture.path)
    counts = {name: int((seeds.material == k).sum()) for k, name in enumerate(seeds.names)} if seeds else {}
    counts |= dict.fromkeys(unlabelled(job, seeds), 0)
    return {
        "name": job.name,
        "image": job.image,
        "way": job.way,
        "width": texture.width,
        "height": texture.height,
        "pixel_type": texture.dtype.name,
        "encoding": texture.encoding,
        "taken_as": texture.interpretation
        | ({} if georeference is None else {"place": georeference.crs or "a map without a name"}),
        "texels_with_data": colours.valid_texels,
        "without_data": {reason: quantity(share, "1") for reason, share in texture.without_data().items()},
        "warnings": list(texture.intake.warnings),
        "distinct_colours": colours.number,
        "seed_texels": counts,
        "conflicting_seed_texels": seeds.conflicting if seeds else 0,
        "clusters": [] if job.clusters is None else _clusters(job.clusters, find_clusters(texture, job.clusters)),
    }


def _clusters(clusters: Clusters, model: GaussianModel) -> list[dict[str, Any]]:
    """Number, mean colour, share and name of each cluster."""
    from skimage.color import lab2rgb

    with warnings.catch_warnings():
        # A mean of high dynamic range may lie beyond what sRGB shows; it is drawn at the border.
        warnings.filterwarnings("ignore", message="Conversion from CIE-LAB", category=UserWarning)
        colours = np.rint(255 * lab2rgb(model.means[:, :3])).astype(int)
    return [
        {
            "number": number,
            "colour": "#{:02X}{:02X}{:02X}".format(*colour),
            "share": quantity(float(np.exp(share)), "1"),
            "name": clusters.names.get(number),
        }
        for number, colour, share in zip(range(1, len(colours) + 1), colours, model.log_prior, strict=True)
    ]


@dataclass(frozen=True)
class Outcome:
    """What became of one texture of a job.

    job : TextureJob
    path : Path; of its database.
    mapped : TextureMap or None
    summary : Written or None; both None where the database was there already, or could not be made.
    problem : InputError or None; why it could not be made.
    """

    job: TextureJob
    path: Path
    mapped: TextureMap | None = None
    summary: Written | None = None
    problem: InputError | None = None


def classify(
    job: TmmJob, folder: Path, out: str | os.PathLike[str] | None, library: MaterialLibrary, *, fresh: bool = False
) -> Iterator[Outcome]:
    """Build and write the databases of a job one by one; what is wrong with one texture does not keep from the others.

    Raises InputError: the job's output folder lies outside its own.

    Parameters
    ----------
    folder : Path
        Folder of the job file.
    out : path, optional
        Output folder; by default the job's.
    fresh : bool
        Build all; else databases that are there, from the same job, image, seeds and library, are kept.

    Yields
    ------
    Outcome
    """
    target = output_folder(job, folder, out)
    for texture in job.textures:
        path = target / f"{texture.name}.tmm.h5"
        if not fresh and is_current(path, texture, folder, library.version):
            remove_abandoned(path)
            yield Outcome(texture, path)
            continue
        try:
            mapped = map_texture(texture, folder, library)
            outcome = Outcome(texture, path, mapped, write_texture(mapped, path))
        except InputError as problem:
            outcome = Outcome(texture, path, problem=problem)
        yield outcome


def output_folder(job: TmmJob, folder: Path, out: str | os.PathLike[str] | None) -> Path:
    """The folder that is written to: `out`, by default the job's, which must lie inside the job's own `folder`.

    Raises InputError.
    """
    if out is not None:
        return Path(out)
    try:
        return job_path(folder, job.output.folder, for_output=True)
    except ValueError as error:
        raise InputError(f"output: {error}") from None
