"""The ``.tmm.h5`` database: writing it, and reading texels from it.

Layout: ``/materials`` (codes, names), ``/usage``, ``/quality``, ``/composites``, ``/provenance`` and, for each mip
level, ``/levels/k`` with ``code``, ``mix_code`` and ``mix_weight``; level 0 also has ``confidence`` and ``typicality``.
"""

from __future__ import annotations

import itertools
import os
from dataclasses import dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import Literal

import h5py
import numpy as np
import yaml

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Streamed, Variable, content_hash, open_database, write_file
from skyshine.tmm.build import STRIP, TextureMap
from skyshine.tmm.job import TextureJob
from skyshine.tmm.levels import PERCENT, WEIGHT_TOTAL, Composites, Level, LevelStream, level_sizes, pure_level
from skyshine.tmm.raster import file_sha256

FILETYPE = "tmm"
FORMAT_VERSION = "1.0.0"
CHUNK = 256
LEVEL_TEXELS = 1 << 20  # texels whose mip levels are counted at a time


@dataclass(frozen=True)
class Written:
    """What the writing of a database counted.

    Attributes
    ----------
    texels : (K,) int64
        Number of texels of each material.
    with_data : int
        Texels with data; those beyond the sum of `texels` are unknown.
    confidence : float
        Mean over the texels with data.
    digest : str
        Hash of the content.
    """

    texels: np.ndarray
    with_data: int
    confidence: float
    digest: str = ""

    @property
    def usage(self) -> np.ndarray:
        """Share (K,) of the texels with data that have each material."""
        return self.texels / max(self.with_data, 1)


def write_texture(mapped: TextureMap, path: str | os.PathLike) -> Written:
    """Classify a texture and write its database, band by band.

    Raises
    ------
    InputError
        The image is damaged, or the file cannot be written.
    """
    counted: list[Written] = []

    def fill(file: h5py.File) -> Group:
        written, mixtures = _fill_levels(mapped, file)
        counted.append(written)
        return Group(groups={"usage": _usage(mapped, written), "composites": composite_layout(*mixtures)})

    height, width = mapped.texture.height, mapped.texture.width
    levels = {str(k): level_layout(k, size, height, width) for k, size in enumerate(level_sizes(height, width))}
    root = Group(
        groups={
            "materials": _materials(mapped),
            "quality": _quality(mapped),
            "provenance": _provenance(mapped),
            "levels": Group(groups=levels),
        }
    )
    digest = write_file(path, root, texture_header(mapped.job, mapped.library_version), fill)
    return replace(counted[0], digest=digest)


def _fill_levels(mapped: TextureMap, file: h5py.File) -> tuple[Written, tuple[np.ndarray, np.ndarray]]:
    """Write all levels; returns the counts, and the components and weights of the distinct mixtures."""
    stream = LevelStream(mapped.texture.height, mapped.texture.width, mapped.codes)
    mixtures = Composites()
    writers = [_RowWriter(file[f"levels/{k}"], mapped.codes) for k in range(1, len(file["levels"]))]
    level0 = {name: file[f"levels/0/{name}"] for name in file["levels/0"]}
    texels, total = np.zeros(1 << 16, np.int64), 0.0
    for band, windows in itertools.groupby(mapped.windows(), key=lambda window: window[0]):
        rows = np.empty((band.stop - band.start, mapped.texture.width), np.uint16)
        for _, columns, code, found in windows:
            rows[:, columns] = code
            texels += np.bincount(code.ravel(), minlength=1 << 16)
            total += float(found.confidence.sum(dtype=np.float64))
            for name, values in (vars(pure_level(code)) | vars(found)).items():
                if name in level0:
                    level0[name][band, columns] = values
        step = max(LEVEL_TEXELS // rows.shape[1], 1)
        for top in range(0, len(rows), step):
            for level, _, part in stream.add(rows[top : top + step]):
                writers[level - 1].add(part)
                mixtures.add(part)
    mixtures.add(pure_level(np.flatnonzero(texels)[np.newaxis].astype(np.uint16)))
    with_data = mapped.colours.valid_texels
    return Written(texels[mapped.codes], with_data, total / with_data), mixtures.mixtures()


class _RowWriter:
    """Writes the rows of a level as whole chunks, so that each chunk is compressed once."""

    def __init__(self, group: h5py.Group, materials: np.ndarray):
        """`materials` (K,) are the codes that occur, in ascending order."""
        self._arrays = [group[name] for name in ("code", "mix_code", "mix_weight")]
        self._height, width = self._arrays[0].shape
        # Of the wide levels of a large texture these rows are the most that is held: materials are kept as their
        # number, in one byte where that does, and the third weight follows from the others.
        self._materials, kind = np.append(0, materials).astype(np.uint16), np.uint8 if len(materials) < 256 else np.uint16
        rows = min(CHUNK, self._height)
        self._numbers, self._weights = np.empty((rows, width, 3), kind), np.empty((rows, width, 2), np.uint16)
        self._kept, self._done = 0, 0

    def add(self, part: Level) -> None:
        """Take the next rows, which may be more than a chunk's."""
        start = 0
        while start < len(part.code):
            number = min(len(self._numbers) - self._kept, len(part.code) - start)
            to, of = slice(self._kept, self._kept + number), slice(start, start + number)
            self._numbers[to] = np.searchsorted(self._materials, part.mix_code[of])
            self._weights[to] = part.mix_weight[of, :, :2]
            start, self._kept = start + number, self._kept + number
            if self._kept == len(self._numbers) or self._done + self._kept == self._height:
                self._write()

    def _write(self) -> None:
        rows, width = slice(self._done, self._done + self._kept), self._arrays[0].shape[1]
        for left in range(0, width, STRIP):
            columns = slice(left, min(left + STRIP, width))
            codes = self._materials[self._numbers[: self._kept, columns]]
            two = self._weights[: self._kept, columns]
            third = WEIGHT_TOTAL - two.sum(axis=-1, keepdims=True, dtype=np.int32)
            weights = np.concatenate([two, third.astype(np.uint16)], axis=-1)
            for array, values in zip(self._arrays, (codes[..., 0], codes, weights)):
                array[rows, columns] = values
        self._done, self._kept = rows.stop, 0


def texture_header(job: TextureJob, library_version: str) -> Header:
    """Root attributes of the database of a texture."""
    text = yaml.safe_dump(job.model_dump(mode="json"), sort_keys=False, allow_unicode=True, default_flow_style=None)
    return Header(
        FILETYPE, FORMAT_VERSION, f"materials {library_version}", text, f"Materials of the texture {job.name}"
    )


def is_current(path: str | os.PathLike, job: TextureJob, base_folder: str | os.PathLike, library_version: str) -> bool:
    """Whether a database is there, undamaged, from this job, this image and seeds, and this library.

    Parameters
    ----------
    base_folder : path
        Folder to which the paths of the job are relative.
    """
    header = texture_header(job, library_version)
    expected = {
        "job": header.job,
        "format_version": header.format_version,
        "data_version": header.data_version,
        "generator": f"skyshine {metadata.version('skyshine')}",
    }
    try:
        with open_database(path, FILETYPE) as file:
            made = file["provenance"].attrs
            digests = {name.partition(":")[2]: made[name] for name in made if name.startswith("sha256:")}
            digests[job.image] = made["texture_sha256"]
            return (
                all(file.attrs.get(name) == value for name, value in expected.items())
                and all(file_sha256(Path(base_folder) / name) == digest for name, digest in digests.items())
                and content_hash(file) == file.attrs.get("content_sha256")
            )
    except (InputError, OSError, KeyError):
        return False


def _code_axis(mapped: TextureMap) -> Axis:
    return Axis(mapped.codes, "1", "material code")


def _materials(mapped: TextureMap) -> Group:
    names = Variable(("material",), np.array(mapped.names, dtype=object), "1", "material name")
    return Group({"material": _code_axis(mapped)}, {"name": names})


def _usage(mapped: TextureMap, written: Written) -> Group:
    share = Variable(("material",), written.usage, "1", "share of the texels with data that have the material")
    counts = {
        "texels": mapped.texture.height * mapped.texture.width,
        "texels_with_data": written.with_data,
        "texels_with_material": int(written.texels.sum()),
    }
    return Group({"material": _code_axis(mapped)}, {"share": share}, attributes=counts)


def _quality(mapped: TextureMap) -> Group:
    """Held-out quality of the materials that have seeds; empty where nothing is trained on this texture."""
    if mapped.seeds is None:
        return Group(attributes={"tested_texels": 0, "seed_texels": 0})
    held, seeds = mapped.quality, mapped.seeds
    codes = mapped.codes[[mapped.names.index(name) for name in seeds.names]]
    found = Axis(np.concatenate([[0], codes]).astype(np.uint16), "1", "material code found, 0 for unknown")
    what = {"whole": "held-out seed texels", "inside": "those in shadow", "outside": "those in sunlight"}
    attributes = {}
    for part, suffix in (("whole", ""), ("inside", "_inside_shadow"), ("outside", "_outside_shadow")):
        quality = getattr(held, part)
        attributes |= {
            f"overall_accuracy{suffix}": quality.overall_accuracy,
            f"mean_iou{suffix}": quality.mean_iou,
            f"calibration_error{suffix}": quality.calibration_error,
            f"tested_texels{suffix}": quality.tested,
        }
    return Group(
        {"material": Axis(codes, "1", "material code"), "found": found},
        {
            "confusion": Variable(
                ("material", "found"), held.whole.confusion, "1", f"{what['whole']} by true and found material"
            ),
            "intersection_over_union": Variable(
                ("material",), held.whole.intersection_over_union, "1", "intersection over union on held-out seeds"
            ),
        },
        attributes=attributes
        | {
            "calibration_slope": held.calibration.slope,
            "calibration_offset": held.calibration.offset,
            "seed_texels": len(seeds.rows),
            "conflicting_seed_texels": seeds.conflicting,
            "folds": mapped.job.held_out.folds,
            "random_seed": mapped.job.held_out.random_seed,
        },
    )


def _component_axis() -> Axis:
    return Axis(np.arange(3, dtype=np.uint8), "1", "rank of the component, largest share first")


def composite_layout(components: np.ndarray, weights: np.ndarray) -> Group:
    """The layout of distinct mixtures: codes (N, 3) and weights (N, 3) in percent."""
    number = Axis(np.arange(len(components), dtype=np.int32), "1", "number of the mixture")
    dims = ("composite", "component")
    return Group(
        {"composite": number, "component": _component_axis()},
        {
            "code": Variable(dims, components, "1", "material code, 0 where unused"),
            "weight": Variable(dims, weights, "percent", "share of the material", {"total": PERCENT}),
        },
    )


def level_layout(k: int, size: tuple[int, int], height: int, width: int) -> Group:
    """The layout of a level; its arrays are written as they come."""
    axes = {
        "y": Axis(_centres(height, size[0]), "1", "row of the texel's centre, in texels of level 0"),
        "x": Axis(_centres(width, size[1]), "1", "column of the texel's centre, in texels of level 0"),
        "component": _component_axis(),
    }
    plane, mixed, chunk = ("y", "x"), ("y", "x", "component"), (CHUNK, CHUNK)
    whole, parts = Streamed(size, np.uint16), Streamed((*size, 3), np.uint16)
    weights = {"total": WEIGHT_TOTAL}
    variables = {
        "code": Variable(plane, whole, "1", "material code of the largest share, 0 for none", chunks=chunk),
        "mix_code": Variable(mixed, parts, "1", "material codes of the mixture", chunks=(*chunk, 3)),
        "mix_weight": Variable(
            mixed, parts, "1", "shares of the mixture; they sum to `total`", weights, chunks=(*chunk, 3)
        ),
    }
    if k == 0:
        values = Streamed(size, np.float32)
        name = "probability that the material is right: its posterior, averaged over the box and calibrated"
        variables["confidence"] = Variable(plane, values, "1", name, chunks=chunk)
        name = "share of the material's own texels that lie farther from its mean"
        variables["typicality"] = Variable(plane, values, "1", name, chunks=chunk)
    return Group(axes, variables)


def _centres(length: int, parts: int) -> np.ndarray:
    return (np.arange(parts) + 0.5) * (length / parts)


def _provenance(mapped: TextureMap) -> Group:
    texture = mapped.texture
    attributes = {
        "texture": mapped.job.image,
        "texture_sha256": texture.sha256,
        "width": texture.width,
        "height": texture.height,
        "pixel_type": texture.dtype.name,
        "encoding": texture.encoding,
        "distinct_colours": mapped.colours.number,
    }
    if mapped.place is not None:
        # X = a x + b y + c, Y = d x + e y + f, with x and y in texels of level 0 from the top left corner.
        attributes |= {"geo_affine": np.array(mapped.place.affine), "geo_crs": mapped.place.crs}
    for name, digest in mapped.files.items():
        attributes[f"sha256:{name}"] = digest
    return Group(attributes=attributes)


class TmmFile:
    """A texture database, open for reading; see `open_tmm`.

    Attributes
    ----------
    materials : dict of int to str
        Material names by code.
    width, height : int
        Of level 0.
    levels : int
        Number of mip levels.
    """

    def __init__(self, file):
        self._file = file
        self._planes: dict[tuple[int, str], np.ndarray] = {}
        group = file["materials"]
        self.materials = dict(zip(group["material"][()].tolist(), group["name"].asstr()[()].tolist()))
        self.levels = len(file["levels"])
        self.height, self.width = file["levels/0/code"].shape

    def size(self, level: int) -> tuple[int, int]:
        """Height and width of a level."""
        return self._file[f"levels/{level}/code"].shape

    @property
    def attributes(self) -> dict:
        """Root attributes and provenance."""
        return {**self._file.attrs, **self._file["provenance"].attrs}

    def group_attributes(self, name: str) -> dict:
        """Attributes of ``usage``, ``quality`` or another group."""
        return {key: value.item() if hasattr(value, "item") else value for key, value in self._file[name].attrs.items()}

    def rows(self, name: str, rows: slice, step: int = 1) -> np.ndarray:
        """Rows of an array of level 0, such as ``code``; every `step`-th row and column of them."""
        return self._file[f"levels/0/{name}"][rows][::step, ::step]

    def thinned(self, name: str, step: int) -> np.ndarray:
        """Every `step`-th row and column of an array of level 0."""
        band = CHUNK * step
        return np.concatenate([self.rows(name, slice(top, top + band), step) for top in range(0, self.height, band)])

    def array(self, name: str) -> np.ndarray:
        """A whole array by its path in the file, such as ``levels/0/confidence``."""
        return self._file[name][()]

    def has(self, name: str) -> bool:
        """Whether the file holds an array of this path."""
        return name in self._file

    @property
    def usage(self) -> dict[str, float]:
        """Share of the texels with data that have each material."""
        return dict(zip(self.materials.values(), self._file["usage/share"][()].astype(float).tolist()))

    def code(self, x, y, level: int = 0, outside: Literal["error", "clamp"] = "error") -> np.ndarray:
        """Material code at points.

        Parameters
        ----------
        x, y : array_like
            Pixel coordinates of level 0, from the top left corner: the first texel spans 0 to 1.
        level : int
        outside : {"error", "clamp"}
            What to do with points beyond the image.

        Returns
        -------
        uint16
            0 where there is no material.

        Raises
        ------
        InputError
            There is no such level, or a point lies outside.
        """
        return self._at("code", x, y, level, outside)

    def mixture(
        self, x, y, level: int = 0, outside: Literal["error", "clamp"] = "error"
    ) -> tuple[np.ndarray, np.ndarray]:
        """Material codes (..., 3) uint16 and their shares (..., 3) float64 at points; parameters as for `code`."""
        weights = self._at("mix_weight", x, y, level, outside)
        return self._at("mix_code", x, y, level, outside), weights / WEIGHT_TOTAL

    def confidence(self, x, y, outside: Literal["error", "clamp"] = "error") -> np.ndarray:
        """Confidence at points of level 0; parameters as for `code`."""
        return self._at("confidence", x, y, 0, outside)

    def _at(self, name: str, x, y, level: int, outside: str) -> np.ndarray:
        if not 0 <= level < self.levels:
            raise InputError(f"found level {level}; allowed: 0 to {self.levels - 1}", file=self._file.filename)
        if (level, name) not in self._planes:
            self._planes[level, name] = self._file[f"levels/{level}/{name}"][()]
        plane = self._planes[level, name]
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        if outside == "clamp":
            x, y = np.clip(x, 0, self.width), np.clip(y, 0, self.height)
        inside = (x >= 0) & (x <= self.width) & (y >= 0) & (y <= self.height)
        if not inside.all():
            at = np.flatnonzero(~inside.ravel())[0]
            raise InputError(
                f"found the point ({x.flat[at]:g}, {y.flat[at]:g}); allowed: x from 0 to {self.width}, y from 0 to "
                f"{self.height}; or ask for outside='clamp'",
                file=self._file.filename,
            )
        row = np.minimum((y * plane.shape[0] / self.height).astype(int), plane.shape[0] - 1)
        column = np.minimum((x * plane.shape[1] / self.width).astype(int), plane.shape[1] - 1)
        return plane[row, column]

    def close(self) -> None:
        self._file.close()

    def __enter__(self) -> TmmFile:
        return self

    def __exit__(self, *_) -> None:
        self.close()


def open_tmm(path: str | os.PathLike) -> TmmFile:
    """Open a texture database.

    Raises
    ------
    InputError
        The file is missing or damaged, is of another type, or has a layout of another major version.
    """
    return TmmFile(open_database(Path(path), FILETYPE, int(FORMAT_VERSION.split(".")[0])))


def find_image(file: TmmFile, path: Path, image: str | os.PathLike | None) -> Path:
    """The texture's own image: the one given, or one of its name beside the database, in the folder above, or here.

    Raises
    ------
    InputError
        It is not found, or its bytes are not those that were classified.
    """
    wanted, digest = Path(str(file.attributes["texture"])), file.attributes["texture_sha256"]
    places = [Path(image)] if image else [path.parent / wanted.name, path.parent.parent / wanted, wanted]
    for place in places:
        if place.is_file():
            if file_sha256(place) == digest:
                return place
            raise InputError(
                "is not the image that was classified (its SHA-256 differs); name it with --image", file=place
            )
    tried = ", ".join(str(place) for place in places)
    raise InputError(f"the image of this texture is not at {tried}; name it with --image", file=path)
