"""Writing the ``.tmm.h5`` database."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from skyshine.schemas import hdf5
from skyshine.schemas.abandoned_parts import remove_abandoned
from skyshine.schemas.hdf5 import Axis, Filled, Group, Variable, write_file
from skyshine.schemas.hdf5_chunks import ChunkWriter
from skyshine.tmm.database.layout import (
    CHUNK,
    SHADE_TOTAL,
    chunk_writers,
    composite_layout,
    in_ratios,
    in_steps,
    level_layout,
    materials_layout,
    texture_header,
    usage_layout,
)
from skyshine.tmm.database.levels import WEIGHT_TOTAL, Composites, Level, LevelStream, level_sizes, pure_level
from skyshine.tmm.features.shade import RelitTexture
from skyshine.tmm.images.georeference import read_georeference
from skyshine.tmm.images.raster import file_sha256
from skyshine.tmm.inputs.load import job_files
from skyshine.tmm.job.materials import UNKNOWN
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.texture_map import STRIP, TextureMap

LEVEL_TEXELS = 1 << 20  # texels whose mip levels are counted at a time


@dataclass(frozen=True)
class Written:
    """What the writing of a database counted.

    texels : (K,) float64; number of texels of each material; a mixture counts by its shares.
    with_data : int; texels with data.
    with_material : int; those that have a material; the others are unknown.
    confidence : float; mean over the texels with data.
    confidence_of_known : float; mean over those that have a material: the share of them that is expected to be right.
    shade : float or None; share of the texels with data in cast shade; None where none was looked for.
    digest : str; hash of the content.
    """

    texels: npt.NDArray[np.float64]
    with_data: int
    with_material: int
    confidence: float
    confidence_of_known: float
    shade: float | None = None
    digest: str = ""

    @property
    def usage(self) -> npt.NDArray[Any]:
        """Share (K,) of the texels with data that have each material."""
        return self.texels / max(self.with_data, 1)


def write_texture(mapped: TextureMap, path: str | os.PathLike[str]) -> Written:
    """Classify a texture and write its database, band by band.

    Raises InputError: the image is damaged, or the file cannot be written.
    """
    remove_abandoned(Path(path))
    counted: list[Written] = []
    height, width = mapped.texture.height, mapped.texture.width

    def fill(file: h5py.File) -> Filled:
        summary, mixtures, digests = _fill_levels(mapped, file)
        counted.append(summary)
        metadata = Group(
            groups={
                "usage": usage_layout(
                    mapped.codes, summary.usage, height * width, summary.with_data, summary.with_material
                ),
                "quality": _quality(mapped, summary),
                "composites": composite_layout(*mixtures),
            }
        )
        return Filled(metadata, digests)

    shaded = isinstance(mapped.texture, RelitTexture)
    levels = {
        str(k): level_layout(k, size, height, width, shade=shaded, typicality=mapped.thresholds[1] > 0)
        for k, size in enumerate(level_sizes(height, width))
    }
    root = Group(
        groups={
            "materials": materials_layout(mapped.codes, mapped.names),
            "provenance": _provenance(mapped),
            "levels": Group(groups=levels),
        }
    )
    digest = write_file(path, root, texture_header(mapped.job, mapped.library_version), fill)
    return replace(counted[0], digest=digest)


def _fill_levels(
    mapped: TextureMap, file: h5py.File
) -> tuple[Written, tuple[npt.NDArray[Any], npt.NDArray[Any]], dict[str, bytes]]:
    """Write all levels; returns the counts, the components and weights of the distinct mixtures, and the digests of
    arrays by their paths.
    """
    stream = LevelStream(mapped.texture.height, mapped.texture.width, mapped.codes)
    mixtures = Composites()
    arrays = [chunk_writers(file[f"levels/{k}"]) for k in range(len(file["levels"]))]
    writers = [_RowWriter(level, file[f"levels/{k}/code"].shape, mapped.codes) for k, level in enumerate(arrays) if k]
    level0 = arrays[0]
    texels, classified_count, total, unsure, shaded = np.zeros(1 << 16), 0, 0.0, 0.0, 0.0
    for band, windows in itertools.groupby(mapped.windows(), key=lambda window: window[0]):
        rows = _Rows(band.stop - band.start, mapped.texture.width, mapped.mixed)
        for _, columns, level, classified in windows:
            rows.put(columns, level)
            if mapped.mixed:
                texels += np.bincount(level.mix_code.ravel(), level.mix_weight.ravel(), 1 << 16) / WEIGHT_TOTAL
                mixtures.add(level)
            else:
                texels[mapped.codes] += [np.count_nonzero(level.code == code) for code in mapped.codes]
            unknown = level.code == 0
            classified_count += unknown.size - int(np.count_nonzero(unknown))
            total += float(classified.confidence.sum(dtype=np.float64))
            unsure += float(classified.confidence[unknown].sum(dtype=np.float64))
            further = {"confidence": in_steps(classified.confidence)}
            if "typicality" in level0:
                further["typicality"] = in_ratios(classified.typicality)
            if isinstance(mapped.texture, RelitTexture):
                shade = mapped.texture.shade(band, columns)
                shaded += float(shade.sum(dtype=np.float64))
                further["shade"] = np.rint(shade * SHADE_TOTAL).astype(np.uint8)
            for name, values in (vars(level) | further).items():
                level0[name].write((band.start, columns.start, 0)[: values.ndim], values)
        for number, _, part in rows.coarser(stream):
            writers[number - 1].add(part)
            # A texel of one material covers texels of the finest level that have it alone, and these are taken there.
            mixtures.add(part, pure=False)
    if "shade" in level0:
        _fill_shade(file)
    if not mapped.mixed:
        mixtures.add(pure_level(np.flatnonzero(texels)[np.newaxis].astype(np.uint16)))
    with_data = mapped.colours.valid_texels
    in_shade = shaded / with_data if "shade" in level0 else None
    digests = {
        f"/levels/{k}/{name}": digest
        for k, level in enumerate(arrays)
        for name, writer in level.items()
        if (digest := writer.digest()) is not None
    }
    sure = (total - unsure) / max(classified_count, 1)
    summary = Written(texels[mapped.codes], with_data, classified_count, total / with_data, sure, in_shade)
    return summary, mixtures.mixtures(), digests


class _Rows:
    """Rows of level 0 that are put together of windows: codes alone where no texel is mixed."""

    def __init__(self, height: int, width: int, mixed: bool) -> None:
        self._code = np.empty((height, width), np.uint16)
        self._mixture = [np.empty((height, width, 3), np.uint16) for _ in range(2)] if mixed else []

    def put(self, columns: slice, level: Level) -> None:
        """Take a window of these rows."""
        self._code[:, columns] = level.code
        for plane, part in zip(self._mixture, (level.mix_code, level.mix_weight), strict=False):
            plane[:, columns] = part

    def coarser(self, stream: LevelStream) -> Iterator[tuple[int, int, Level]]:
        """What these rows complete of the coarser levels; see `LevelStream.add`."""
        step = max(LEVEL_TEXELS // self._code.shape[1], 1)
        for top in range(0, len(self._code), step):
            rows = slice(top, top + step)
            if self._mixture:
                yield from stream.add_mixed(Level(self._code[rows], *(part[rows] for part in self._mixture)))
            else:
                yield from stream.add(self._code[rows])


def _fill_shade(file: h5py.File) -> None:
    """Write the shade of all levels but the first, each the mean over what it covers of the one before."""
    for k in range(1, len(file["levels"])):
        finer, coarser = (file[f"levels/{level}/shade"] for level in (k - 1, k))
        height, width = coarser.shape
        # The last row and column of a level may cover three of the one before.
        down, across = (np.arange(0, 2 * count, 2) for count in (height, width))
        for top in range(0, height, CHUNK):
            bottom = min(top + CHUNK, height)
            rows = finer[2 * top : 2 * bottom if bottom < height else finer.shape[0]].astype(np.float32)
            sums = np.add.reduceat(np.add.reduceat(rows, down[: bottom - top], axis=0), across, axis=1)
            counts = np.add.reduceat(np.ones(len(rows)), down[: bottom - top])[:, np.newaxis] * np.add.reduceat(
                np.ones(rows.shape[1]), across
            )
            coarser[top:bottom] = np.rint(sums / counts).astype(np.uint8)


class _RowWriter:
    """Writes the rows of a level as whole chunks, so that each chunk is compressed once."""

    def __init__(self, arrays: dict[str, ChunkWriter], shape: tuple[int, int], materials: npt.NDArray[Any]) -> None:
        """`materials` (K,) are the codes that occur, in ascending order; `shape` is that of the level."""
        self._arrays = [arrays[name] for name in ("code", "mix_code", "mix_weight")]
        self._height, self._width = shape
        # These rows of the wide levels of a large texture are the most that is in memory: materials are kept as their
        # number, in one byte where that does, and the third weight follows from the others.
        self._materials, kind = (
            np.append(0, materials).astype(np.uint16),
            np.uint8 if len(materials) < 256 else np.uint16,
        )
        self._number = np.zeros(1 << 16, kind)
        self._number[self._materials] = np.arange(len(self._materials))
        rows = min(CHUNK, self._height), self._width
        self._numbers, self._weights = np.empty((*rows, 3), kind), np.empty((*rows, 2), np.uint16)
        self._kept, self._done = 0, 0

    def add(self, part: Level) -> None:
        """Take the next rows, which may be more than a chunk's."""
        start = 0
        while start < len(part.code):
            number = min(len(self._numbers) - self._kept, len(part.code) - start)
            to, of = slice(self._kept, self._kept + number), slice(start, start + number)
            self._numbers[to] = np.take(self._number, part.mix_code[of])
            self._weights[to] = part.mix_weight[of, :, :2]
            start, self._kept = start + number, self._kept + number
            if self._kept == len(self._numbers) or self._done + self._kept == self._height:
                self._write()

    def _write(self) -> None:
        for left in range(0, self._width, STRIP):
            columns = slice(left, min(left + STRIP, self._width))
            codes = np.take(self._materials, self._numbers[: self._kept, columns])
            two = self._weights[: self._kept, columns]
            weights = np.empty_like(codes)
            weights[..., :2] = two
            weights[..., 2] = np.uint16(WEIGHT_TOTAL) - two[..., 0] - two[..., 1]
            for array, values in zip(self._arrays, (codes[..., 0], codes, weights), strict=True):
                array.write((self._done, left, 0)[: values.ndim], values)
        self._done, self._kept = self._done + self._kept, 0


def is_current(
    path: str | os.PathLike[str], job: TextureJob, base_folder: str | os.PathLike[str], library_version: str
) -> bool:
    """Whether a database is there, undamaged, from this job, this image and seeds, and this library.

    base_folder : path; folder to which the paths of the job are relative.
    """

    def same_sources(file: h5py.File) -> bool:
        provenance = file["provenance"].attrs
        digests = {name.partition(":")[2]: provenance[name] for name in provenance if name.startswith("sha256:")}
        digests[job.image] = provenance["texture_sha256"]
        georeference = read_georeference(Path(base_folder) / job.image)
        if tuple(provenance.get("geo_affine", ())) != (() if georeference is None else georeference.affine):
            return False
        files = job_files(job, Path(base_folder)) | {job.image: Path(base_folder, job.image)}
        return digests == {name: file_sha256(path) for name, path in files.items()}

    return hdf5.is_current(path, texture_header(job, library_version), same_sources)


def in_words(entries: dict[str, str]) -> str:
    """A dictionary as one line.

    >>> in_words({"alpha": "12 %", "collar": "3 %"})
    'alpha: 12 %; collar: 3 %'
    """
    return "; ".join(f"{key}: {value}" for key, value in entries.items())


def _quality(mapped: TextureMap, summary: Written) -> Group:
    """Held-out quality of the materials that have seeds; empty where nothing is trained on this texture."""
    if mapped.seeds is None:
        return Group(attributes={"tested_texels": 0, "seed_texels": 0})
    measured, seeds = mapped.quality, mapped.seeds
    quality = measured.quality
    codes = mapped.codes[[mapped.names.index(name) for name in seeds.names if name != UNKNOWN]]
    assigned = Axis(np.concatenate([[0], codes]).astype(np.uint16), "1", "material code found, 0 for unknown")
    attributes: dict[str, float] = {
        "expected_accuracy": summary.confidence_of_known,
        "separate_places": len(np.unique(seeds.region)),
        "tested_places": measured.areas,
        "typicality_threshold": mapped.thresholds[1],
        "overall_accuracy": quality.overall_accuracy,
        "mean_iou": quality.mean_iou,
        "calibration_error": quality.calibration_error,
        "tested_texels": quality.tested,
    }
    return Group(
        {"material": Axis(codes, "1", "material code"), "found": assigned},
        {
            "confusion": Variable(
                ("material", "found"), quality.confusion, "1", "held-out seed texels by true and found material"
            ),
            "intersection_over_union": Variable(
                ("material",),
                quality.intersection_over_union,
                "1",
                "intersection over union on held-out seeds",
            ),
        },
        attributes=attributes
        | {
            "calibration_slope": measured.calibration.slope,
            "calibration_offset": measured.calibration.offset,
            "seed_texels": len(seeds.rows),
            "conflicting_seed_texels": seeds.conflicting,
            "folds": mapped.job.held_out.folds,
            "random_seed": mapped.job.held_out.random_seed,
        },
    )


def _provenance(mapped: TextureMap) -> Group:
    texture = mapped.texture
    attributes: dict[str, Any] = {
        "texture": mapped.job.image,
        "texture_sha256": texture.sha256,
        "width": texture.width,
        "height": texture.height,
        "pixel_type": texture.dtype.name,
        "encoding": texture.encoding,
        "distinct_colours": mapped.colours.number,
        "taken_as": in_words(texture.interpretation),
    }
    if mapped.colours.valid_texels < texture.height * texture.width:
        lost = {reason: f"{100 * share:.4g} %" for reason, share in texture.without_data().items()}
        attributes["without_data"] = in_words(lost)
    if mapped.georeference is not None:
        # X = a x + b y + c, Y = d x + e y + f, with x and y in texels of level 0 from the top left corner.
        attributes |= {"geo_affine": np.array(mapped.georeference.affine), "geo_crs": mapped.georeference.crs}
    for name, digest in mapped.files.items():
        attributes[f"sha256:{name}"] = digest
    return Group(attributes=attributes)
