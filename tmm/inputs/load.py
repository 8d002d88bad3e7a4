"""What a texture job names: its image, its materials, its seeds and the files they come from."""

from __future__ import annotations

from collections import Counter
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.materials.library import MaterialLibrary, unknown_material
from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.classify.model_file import model_path, read_model
from skyshine.tmm.classify.trained import TrainedModel
from skyshine.tmm.classify.translation import library_classes
from skyshine.tmm.features.colour import DistinctColours
from skyshine.tmm.features.shade import RelitTexture
from skyshine.tmm.images.no_data import SIDECAR
from skyshine.tmm.images.texture import TextureFile
from skyshine.tmm.inputs.answers import read_answers
from skyshine.tmm.inputs.named_materials import job_materials
from skyshine.tmm.inputs.palette import palette_colour
from skyshine.tmm.inputs.polygons import check_vertices, polygon_mask, seed_names
from skyshine.tmm.inputs.seeds import SeedTexels, seed_files, seed_texels
from skyshine.tmm.inputs.sun import shadow_fall
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import Palette, Seeds, TextureJob

BAND_ROWS = 256  # looked at at a time
SHOWN_COLOURS = 8  # shown colours of an image that has none of its palette
MOST_COLOURS = 1 << 16  # colours of an image that is looked at for those of a palette: beyond, it is a photograph


def open_texture(job: TextureJob, base_folder: Path) -> TextureFile:
    """The image of a job, read as the job says, without its shade where it says so; see `TextureFile`,
    `RelitTexture` and `shadow_fall` for what they raise.
    """
    arguments = (Path(base_folder) / job.image, *reading(job))
    if job.shade is None:
        return TextureFile(*arguments)
    texture = RelitTexture(*arguments, fall=shadow_fall(job.shade, arguments[0]))
    for fraction, polygons in ((1.0, job.shade.shaded), (0.0, job.shade.sunlit)):
        for polygon in polygons:
            check_vertices("shade", (polygon,), texture, texture.path)
            texture.draw(fraction, partial(polygon_mask, (polygon,), texture))
    return texture


def reading(job: TextureJob) -> tuple[str, str, str | None, float | str | None, bool]:
    """How a job has its image read: the arguments of `TextureFile` after the path.

    Colours that are compared with those of a palette or with limits are left as they are stored.
    """
    white = job.white or (None if job.palette or job.rules or job.material else "auto")
    indices = job.palette is not None and all(key.isdecimal() for key in job.palette.colours)
    return job.colour_space, job.alpha, job.near_infrared, white, indices


def narrowed(
    job: TextureJob, model: TrainedModel, library: MaterialLibrary, names: tuple[str, ...]
) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
    """The classes (C,) of a model that represent what the scene contains, and which (C,) of `names` each represents.

    Raises InputError: none does.
    """
    groups = {name: library.group(name) for name in (*model.names, *names) if name in library}
    shares = library_classes(model.names, names, groups)
    classes = np.flatnonzero(shares.any(axis=1))
    if not len(classes):
        raise InputError(
            f"'{job.name}' has scene_materials {', '.join(names)}, of which its model knows none; allowed: its classes "
            f"({', '.join(model.names)}) and materials of their groups"
        )
    return classes, shares[classes].argmax(axis=1)


def job_files(job: TextureJob, base_folder: Path) -> dict[str, Path]:
    """Files besides the image that a map depends on, by their names in the job."""
    layers = tuple(job.rules.layers.values()) if job.rules else ()
    named = (*seed_files(job.seeds), *layers, *seed_files(job.overrides), *mask_files(job, base_folder))
    files = {name: base_folder / name for name in named}
    return files if job.model is None else {**files, job.model: model_path(job.model, base_folder)}


def mask_files(job: TextureJob, base_folder: Path) -> tuple[str, ...]:
    """Files beside the image that say where it has data, relative to the job's folder; those that are there."""
    name = job.image + SIDECAR
    return (name,) if job.alpha != "ignore" and (base_folder / name).is_file() else ()


def load_texture(
    job: TextureJob, base_folder: Path, library: MaterialLibrary
) -> tuple[TextureFile, DistinctColours, tuple[str, ...], SeedTexels | None]:
    """Read a job's image once, and find its materials, in the order of their codes, and its seeds.

    Raises InputError: a file cannot be read, or does not fit the image or the library.
    """
    base_folder = Path(base_folder)
    texture = open_texture(job, base_folder)
    colours = DistinctColours(texture)
    if not colours.valid_texels:
        raise InputError(
            "has no texel with data (all are transparent, masked, of the no-data value or not finite); name another "
            "image, or say 'alpha: ignore'",
            file=texture.path,
        )
    for source in (job.seeds, job.overrides):
        if source is not None and source.suggested is not None:
            # Names are compared here, where the library is known, so that a wrong one is shown at its line.
            path = base_folder / source.suggested
            if not path.exists():
                raise InputError("is not there yet; let 'tmm suggest' write it, then fill in its names", file=path)
            read_answers(path, texture, library.names)
    if job.palette is not None and job.palette.match == "exact":
        _require_colours(job.palette, texture, colours)
    names = job_materials(job, base_folder)
    for name in names:
        if name not in library:
            raise InputError(f"'{job.name}': {unknown_material(name, library.names)}")
    names = tuple(sorted(names, key=lambda name: library.code(name)))
    if job.model is not None:
        model = read_model(model_path(job.model, base_folder))
        if job.scene_materials:
            narrowed(job, model, library, names)
    return texture, colours, names, None if job.seeds is None else _seeds(job, job.seeds, names, texture, base_folder)


def _require_colours(palette: Palette, texture: TextureFile, colours: DistinctColours) -> None:
    """Refuse an image that has no colour of a palette, and say which it has."""
    required = {palette_colour(key, texture.dtype, texture.path) for key in palette.colours}
    counts: Counter[tuple[int, ...]] = Counter()
    for top in range(0, texture.height, BAND_ROWS):
        rows = slice(top, min(top + BAND_ROWS, texture.height))
        pixels, valid = texture.window(rows, slice(0, texture.width))
        values, number = np.unique(pixels[valid][:, :3], axis=0, return_counts=True)
        counts.update(dict(zip(map(tuple, values.tolist()), number.tolist(), strict=True)))
        if not required.isdisjoint(counts) or len(counts) > MOST_COLOURS:
            break
    if not required.isdisjoint(counts) or len(counts) > MOST_COLOURS:
        return
    limit = np.iinfo(texture.dtype).max // 255
    frequent = [
        str(colour[0]) if len(set(colour)) == 1 else "#" + "".join(f"{part // limit:02X}" for part in colour)
        for colour, _ in counts.most_common(SHOWN_COLOURS)
    ]
    more = f" and {len(counts) - SHOWN_COLOURS} more" if len(counts) > SHOWN_COLOURS else ""
    raise InputError(
        f"has no colour of the palette ({', '.join(sorted(palette.colours))}); it has {', '.join(frequent)}{more}; "
        "give these as keys, or the numbers of a palette image's entries",
        file=texture.path,
    )


def _seeds(
    job: TextureJob, seeds: Seeds, names: tuple[str, ...], texture: TextureFile, base_folder: Path
) -> SeedTexels:
    labelled = seeds.labels.palette.values() if seeds.labels else ()
    seeded = {*labelled, *seed_names(seeds, base_folder)}
    for name in job.classifier.prior if isinstance(job.classifier.prior, dict) else ():
        if name not in seeded:
            raise InputError(
                f"'{job.name}' has a prior for '{name}', which has no seeds; {nearest(name, sorted(seeded))}"
            )
    classes = tuple(name for name in (*names, UNKNOWN) if name in seeded)
    return seed_texels(job, seeds, classes, texture, texture.path, base_folder)
