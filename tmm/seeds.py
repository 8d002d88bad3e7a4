"""Seeds: the texels whose material is known, from polygons, GeoJSON and label images."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import pydantic
from pydantic import Field

from skyshine.schemas.documents import parse_model, read_yaml
from skyshine.schemas.errors import InputError, nearest
from skyshine.tmm.job import LabelImage, TextureJob
from skyshine.tmm.texture import Texture, read_channels

BLOCK = 32  # texels; a label image, or a material's only polygon, is divided into regions of this size at most


@dataclass(frozen=True)
class SeedTexels:
    """Texels of known material, each once.

    Attributes
    ----------
    names : tuple of str
        Materials in the order of their codes.
    rows, columns : (N,) int
    material : (N,) int
        Index into `names`.
    region : (N,) int
        Texels of one region (a polygon, or a block of a label image) are alike and are held out together.
    conflicting : int
        Texels that more than one material claimed; they are left out.
    """

    names: tuple[str, ...]
    rows: np.ndarray
    columns: np.ndarray
    material: np.ndarray
    region: np.ndarray
    conflicting: int


class _Open(pydantic.BaseModel):
    model_config = pydantic.ConfigDict(extra="ignore", frozen=True)


Position = tuple[float, float] | tuple[float, float, float]
Ring = tuple[Position, ...]


class _Point(_Open):
    type: Literal["Point"]
    coordinates: Position


class _Polygon(_Open):
    type: Literal["Polygon"]
    coordinates: tuple[Ring, ...] = Field(min_length=1)


class _MultiPolygon(_Open):
    type: Literal["MultiPolygon"]
    coordinates: tuple[tuple[Ring, ...], ...] = Field(min_length=1)


class _Properties(_Open):
    material: str


class _Feature(_Open):
    type: Literal["Feature"]
    properties: _Properties
    geometry: _Point | _Polygon | _MultiPolygon = Field(discriminator="type")


class _FeatureCollection(_Open):
    type: Literal["FeatureCollection"]
    features: tuple[_Feature, ...] = Field(min_length=1)


def seed_polygons(job: TextureJob, base_folder: Path) -> list[tuple[str, tuple[Ring, ...]]]:
    """All polygons of a job, inline and GeoJSON: material name and rings (the outer one first, then holes).

    Raises
    ------
    InputError
        The GeoJSON file cannot be read or is not a FeatureCollection of polygons and points with a material.
    """
    found = [(name, (ring,)) for name, rings in job.seeds.polygons.items() for ring in rings]
    if job.seeds.file is None:
        return found
    collection = parse_model(read_yaml(base_folder / job.seeds.file), _FeatureCollection)
    for feature in collection.features:
        name, geometry = feature.properties.material, feature.geometry
        if isinstance(geometry, _Point):
            found.append((name, ((geometry.coordinates,),)))
        else:
            shapes = geometry.coordinates if isinstance(geometry, _MultiPolygon) else (geometry.coordinates,)
            found += [(name, rings) for rings in shapes]
    return found


def seed_materials(job: TextureJob, base_folder: Path) -> tuple[str, ...]:
    """Names of all materials that the seeds of a job name, its GeoJSON file included.

    Raises
    ------
    InputError
        The GeoJSON file cannot be read.
    """
    return tuple(sorted({*job.materials, *(name for name, _ in seed_polygons(job, base_folder))}))


def seed_files(job: TextureJob) -> tuple[str, ...]:
    """Files that the seeds of a job come from, relative to its folder."""
    found = (job.seeds.file, job.seeds.labels.image if job.seeds.labels else None)
    return tuple(name for name in found if name is not None)


def seed_texels(job: TextureJob, texture: Texture, base_folder: Path, library) -> SeedTexels:
    """Find the seed texels of a texture.

    Parameters
    ----------
    library : MaterialLibrary

    Raises
    ------
    InputError
        A material is unknown, a polygon reaches beyond the image, the label image does not fit, or a material has no
        texel left once texels without data and texels claimed by several materials are taken away.
    """
    names = seed_materials(job, base_folder)
    for name in names:
        if name not in library:
            raise InputError(f"unknown material '{name}' in the seeds of '{job.name}'; {nearest(name, library.names)}")
    names = tuple(sorted(names, key=lambda name: library[name].code))
    claims = [_polygon_claims(job, names, texture, base_folder)]
    if job.seeds.labels is not None:
        claims.append(_label_claims(job.seeds.labels, names, texture, base_folder))
    return _settle(job, names, texture, np.concatenate(claims, axis=1))


def _settle(job: TextureJob, names: tuple[str, ...], texture: Texture, claims: np.ndarray) -> SeedTexels:
    """Keep each claimed texel once; `claims` is (3, N): texel number, material, region."""
    texel, material, region = claims
    order = np.argsort(texel, kind="stable")
    texel, material, region = texel[order], material[order], region[order]
    unique, first, counts = np.unique(texel, return_index=True, return_counts=True)
    lowest, highest = (reduce.reduceat(material, first) for reduce in (np.minimum, np.maximum))
    agreed = lowest == highest
    keep = agreed & texture.valid.ravel()[unique]
    kept = first[keep]
    number = np.bincount(material[kept], minlength=len(names))
    for index in np.flatnonzero(number == 0):
        raise InputError(
            f"material '{names[index]}' of '{job.name}' has no seed texel left (outside the data, or claimed by other "
            "materials too); draw a polygon that it has alone",
            file=texture.path,
        )
    rows, columns = np.divmod(unique[keep], texture.width)
    region = _divide(material[kept], region[kept], rows, columns)
    return SeedTexels(names, rows, columns, material[kept], region, int(np.sum(~agreed)))


def _divide(material, region, rows, columns) -> np.ndarray:
    """Split the regions of a material that has only one into four blocks at most, so that a part can be held out."""
    block = np.zeros_like(region)
    for index in np.unique(material):
        mine = material == index
        if len(np.unique(region[mine])) == 1:
            for bit, position in ((1, rows[mine]), (2, columns[mine])):
                block[mine] += bit * (position > np.median(position))
    return np.unique(np.stack([region, block]), axis=1, return_inverse=True)[1].ravel()


def _polygon_claims(job: TextureJob, names: tuple[str, ...], texture: Texture, base_folder: Path) -> np.ndarray:
    claims = [np.empty((3, 0), np.int64)]
    for region, (name, rings) in enumerate(seed_polygons(job, base_folder)):
        texels = _inside(rings, texture, name)
        claims.append(np.stack([texels, np.full_like(texels, names.index(name)), np.full_like(texels, region)]))
    return np.concatenate(claims, axis=1)


def _inside(rings: tuple[Ring, ...], texture: Texture, name: str) -> np.ndarray:
    """Numbers of the texels whose centre a polygon holds, and of those that its outer vertices stand in."""
    from skimage.draw import polygon

    outlines = [np.array([position[:2] for position in ring]) for ring in rings]
    for x, y in np.concatenate(outlines):
        if not (0 <= x <= texture.width and 0 <= y <= texture.height):
            raise InputError(
                f"a seed of '{name}' has the vertex [{x:g}, {y:g}]; allowed: pixel coordinates within the image of "
                f"{texture.width} x {texture.height} texels",
                file=texture.path,
            )
    low = outlines[0].min(axis=0).astype(int)
    mask = np.zeros((outlines[0].max(axis=0).astype(int) - low + 1)[::-1], bool)
    for number, outline in enumerate(outlines):
        if len(outline) > 2:
            # Texel centres stand at half integers, those of skimage at integers.
            columns, rows = (outline - low - 0.5).T
            mask[polygon(rows, columns, mask.shape)] = number == 0
    columns, rows = (outlines[0].astype(int) - low).T
    mask[rows, columns] = True
    rows, columns = np.nonzero(mask)
    # A vertex on the far edge of the image stands in its last texel.
    rows, columns = np.minimum(rows + low[1], texture.height - 1), np.minimum(columns + low[0], texture.width - 1)
    return np.unique(rows * texture.width + columns)


def _label_claims(labels: LabelImage, names: tuple[str, ...], texture: Texture, base_folder: Path) -> np.ndarray:
    path = base_folder / labels.image
    channels, _ = read_channels(path)
    if channels.shape[:2] != texture.pixels.shape[:2]:
        raise InputError(
            f"the label image is {channels.shape[1]} x {channels.shape[0]}; allowed: the texture's "
            f"{texture.width} x {texture.height}",
            file=path,
        )
    claims = [np.empty((3, 0), np.int64)]
    for key, name in labels.palette.items():
        rows, columns = np.nonzero(_matches(channels, key, path))
        # Negative, so that no block shares its number with a polygon.
        region = -1 - (rows // BLOCK * (texture.width // BLOCK + 1) + columns // BLOCK)
        claims.append(np.stack([rows * texture.width + columns, np.full_like(rows, names.index(name)), region]))
    return np.concatenate(claims, axis=1)


def _matches(channels: np.ndarray, key: str, path: Path) -> np.ndarray:
    """Where a label image has the palette colour `key`."""
    grey = channels.shape[2] < 3
    if channels.dtype.kind != "u" or (not grey and channels.dtype != np.uint8):
        raise InputError(
            "the label image holds floats or 16 bit colours; allowed: 8 bit colours or a grey level", file=path
        )
    if key.startswith("#"):
        wanted = [int(key[i : i + 2], 16) for i in (1, 3, 5)]
        if grey and len(set(wanted)) > 1:
            raise InputError(
                f"the label image is grey and cannot hold {key}; give grey levels in the palette", file=path
            )
        return (channels[..., :1] == wanted[0]).all(-1) if grey else (channels[..., :3] == wanted).all(-1)
    return (channels[..., : 1 if grey else 3] == int(key)).all(-1)
