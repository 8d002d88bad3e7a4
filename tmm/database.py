"""The ``.tmm.h5`` database: writing it, and reading texels from it.

Layout: ``/materials`` (codes, names), ``/usage``, ``/quality``, ``/composites``, ``/provenance`` and, for each mip
level, ``/levels/k`` with ``code``, ``mix_code`` and ``mix_weight``; level 0 also has ``confidence`` and ``typicality``.
"""

from __future__ import annotations

import os
from importlib import metadata
from pathlib import Path
from typing import Literal

import numpy as np
import yaml

from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, content_hash, open_database, write_file
from skyshine.tmm.build import TextureResult
from skyshine.tmm.job import TextureJob
from skyshine.tmm.levels import PERCENT, WEIGHT_TOTAL, composites
from skyshine.tmm.texture import file_sha256

FILETYPE = "tmm"
FORMAT_VERSION = "1.0.0"
CHUNK = 256


def write_texture(result: TextureResult, path: str | os.PathLike) -> str:
    """Write a mapped texture; returns the hash of its content.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    root = Group(
        groups={
            "materials": _materials(result),
            "usage": _usage(result),
            "quality": _quality(result),
            "composites": _composites(result),
            "levels": Group(groups={str(k): _level(result, k) for k in range(len(result.levels))}),
            "provenance": _provenance(result),
        }
    )
    return write_file(path, root, _header(result.job, result.library_version))


def _header(job: TextureJob, library_version: str) -> Header:
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
    header = _header(job, library_version)
    expected = {
        "job": header.job,
        "format_version": header.format_version,
        "data_version": header.data_version,
        "generator": f"skyshine {metadata.version('skyshine')}",
    }
    try:
        with open_database(path, FILETYPE) as file:
            made = file["provenance"].attrs
            digests = {name.partition(":")[2]: made[name] for name in made if name.startswith("seeds_sha256:")}
            digests[job.image] = made["texture_sha256"]
            return (
                all(file.attrs.get(name) == value for name, value in expected.items())
                and all(file_sha256(Path(base_folder) / name) == digest for name, digest in digests.items())
                and content_hash(file) == file.attrs.get("content_sha256")
            )
    except (InputError, OSError, KeyError):
        return False


def _code_axis(result: TextureResult) -> Axis:
    return Axis(result.codes, "1", "material code")


def _materials(result: TextureResult) -> Group:
    names = Variable(("material",), np.array(result.names, dtype=object), "1", "material name")
    return Group({"material": _code_axis(result)}, {"name": names})


def _usage(result: TextureResult) -> Group:
    share = Variable(("material",), result.usage, "1", "share of the texels with data that have the material")
    total, known = result.texture.valid.size, int(np.count_nonzero(result.levels[0].code))
    with_data = int(result.texture.valid.sum())
    counts = {"texels": total, "texels_with_data": with_data, "texels_with_material": known}
    return Group({"material": _code_axis(result)}, {"share": share}, attributes=counts)


def _quality(result: TextureResult) -> Group:
    quality = result.quality
    found = Axis(np.concatenate([[0], result.codes]).astype(np.uint16), "1", "material code found, 0 for unknown")
    return Group(
        {"material": _code_axis(result), "found": found},
        {
            "confusion": Variable(
                ("material", "found"), quality.confusion, "1", "held-out seed texels by true and found material"
            ),
            "intersection_over_union": Variable(
                ("material",), quality.intersection_over_union, "1", "intersection over union on held-out seeds"
            ),
        },
        attributes={
            "overall_accuracy": quality.overall_accuracy,
            "mean_iou": quality.mean_iou,
            "tested_texels": quality.tested,
            "seed_texels": len(result.seeds.rows),
            "conflicting_seed_texels": result.seeds.conflicting,
            "folds": result.job.held_out.folds,
            "random_seed": result.job.held_out.random_seed,
        },
    )


def _component_axis() -> Axis:
    return Axis(np.arange(3, dtype=np.uint8), "1", "rank of the component, largest share first")


def _composites(result: TextureResult) -> Group:
    components, weights = composites(result.levels)
    number = Axis(np.arange(len(components), dtype=np.int32), "1", "number of the mixture")
    dims = ("composite", "component")
    return Group(
        {"composite": number, "component": _component_axis()},
        {
            "code": Variable(dims, components, "1", "material code, 0 where unused"),
            "weight": Variable(dims, weights, "percent", "share of the material", {"total": PERCENT}),
        },
    )


def _level(result: TextureResult, k: int) -> Group:
    level = result.levels[k]
    height, width = level.code.shape
    axes = {
        "y": Axis(_centres(result.texture.height, height), "1", "row of the texel's centre, in texels of level 0"),
        "x": Axis(_centres(result.texture.width, width), "1", "column of the texel's centre, in texels of level 0"),
        "component": _component_axis(),
    }
    plane, mixed, chunk = ("y", "x"), ("y", "x", "component"), (CHUNK, CHUNK)
    weights = {"total": WEIGHT_TOTAL}
    variables = {
        "code": Variable(plane, level.code, "1", "material code of the largest share, 0 for none", chunks=chunk),
        "mix_code": Variable(mixed, level.mix_code, "1", "material codes of the mixture", chunks=(*chunk, 3)),
        "mix_weight": Variable(
            mixed, level.mix_weight, "1", "shares of the mixture; they sum to `total`", weights, chunks=(*chunk, 3)
        ),
    }
    if k == 0:
        name = "posterior probability of the material, averaged over the box"
        variables["confidence"] = Variable(plane, result.confidence, "1", name, chunks=chunk)
        name = "share of the material's own texels that lie farther from its mean colour"
        variables["typicality"] = Variable(plane, result.typicality, "1", name, chunks=chunk)
    return Group(axes, variables)


def _centres(length: int, parts: int) -> np.ndarray:
    return (np.arange(parts) + 0.5) * (length / parts)


def _provenance(result: TextureResult) -> Group:
    attributes = {
        "texture": result.job.image,
        "texture_sha256": result.texture.sha256,
        "width": result.texture.width,
        "height": result.texture.height,
        "pixel_type": result.texture.pixels.dtype.name,
        "encoding": result.texture.encoding,
        "distinct_colours": result.distinct_colours,
    }
    for name, digest in result.seed_files.items():
        attributes[f"seeds_sha256:{name}"] = digest
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

    @property
    def attributes(self) -> dict:
        """Root attributes and provenance."""
        return {**self._file.attrs, **self._file["provenance"].attrs}

    def group_attributes(self, name: str) -> dict:
        """Attributes of ``usage``, ``quality`` or another group."""
        return {key: value.item() if hasattr(value, "item") else value for key, value in self._file[name].attrs.items()}

    def array(self, name: str) -> np.ndarray:
        """A whole array by its path in the file, such as ``levels/0/confidence``."""
        return self._file[name][()]

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
