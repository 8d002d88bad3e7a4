"""Polygons of a job and of GeoJSON files, and the texels inside them."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt
import pydantic
from pydantic import Field

from skyshine.schemas.documents import parse_model, read_yaml
from skyshine.schemas.errors import InputError
from skyshine.tmm.images.gdal import WGS84, find_system, transformed
from skyshine.tmm.images.georeference import GeoReference, read_georeference
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.inputs.answers import disk, read_answers
from skyshine.tmm.job.model import Seeds


class _Open(pydantic.BaseModel):
    model_config = pydantic.ConfigDict(extra="ignore", frozen=True)


Position = tuple[float, float] | tuple[float, float, float]
Ring = tuple[Position, ...]


class SeedPolygon(NamedTuple):
    """A polygon of seeds: its material, its rings (the outer one first), and whether `tmm suggest` asked for it."""

    material: str
    rings: tuple[Ring, ...]
    answered: bool = False


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


class _CrsName(_Open):
    name: str


class _Crs(_Open):
    properties: _CrsName


class _FeatureCollection(_Open):
    """RFC 7946, with the member `crs` of GeoJSON 2008 that geographic information systems still write."""

    type: Literal["FeatureCollection"]
    features: tuple[_Feature, ...] = Field(min_length=1)
    crs: _Crs | None = None


def seed_names(seeds: Seeds, base_folder: Path) -> set[str]:
    """Materials of all polygons of seeds, GeoJSON and answered places included; raises as `seed_polygons`."""
    features = _read_features(base_folder, seeds.file).features if seeds.file is not None else ()
    answered = {answer.seed for answer in read_answers(base_folder / seeds.suggested)} if seeds.suggested else set()
    named = {name for name in answered if name is not None}
    return {*seeds.polygons, *(feature.properties.material for feature in features), *named}


def seed_polygons(seeds: Seeds, base_folder: Path, texture: Windowed, image: Path) -> list[SeedPolygon]:
    """All polygons of seeds in pixel coordinates; disks around answered places, then those of the GeoJSON file, last.

    Raises InputError: the GeoJSON file cannot be read or is not a FeatureCollection of polygons and points with a
    material; its coordinates are those of a map, and the image has no place on it; or a polygon in pixel coordinates
    reaches beyond the texture.

    image : Path; of the texture; it gives the place on the map.

    Returns
    -------
    list of SeedPolygon
        Polygons in map coordinates that lie beyond the image are omitted; others may reach beyond it.
    """
    polygons = [SeedPolygon(name, (ring,)) for name, rings in seeds.polygons.items() for ring in rings]
    mapped: list[SeedPolygon] = []
    for answer in read_answers(base_folder / seeds.suggested, texture) if seeds.suggested else ():
        if answer.seed is not None:
            polygons.append(SeedPolygon(answer.seed, (disk(answer, texture.width, texture.height),), answered=True))
    if seeds.file is not None:
        collection = _read_features(base_folder, seeds.file)
        read = _shapes(collection)
        if seeds.coordinates == "map":
            file = base_folder / seeds.file
            georeference = _place(image, file)
            mapped = _on_image(_on_map(read, collection, georeference, image, file), georeference, texture)
        else:
            polygons += read
    for polygon in polygons:
        check_vertices(polygon.material, polygon.rings, texture, image)
    return polygons + mapped


def _shapes(collection: _FeatureCollection) -> list[SeedPolygon]:
    polygons: list[SeedPolygon] = []
    for feature in collection.features:
        name, geometry = feature.properties.material, feature.geometry
        if isinstance(geometry, _Point):
            polygons.append(SeedPolygon(name, ((geometry.coordinates,),)))
        else:
            shapes = geometry.coordinates if isinstance(geometry, _MultiPolygon) else (geometry.coordinates,)
            polygons += [SeedPolygon(name, rings) for rings in shapes]
    return polygons


def _place(image: Path, file: Path) -> GeoReference:
    """The georeference of an image, on whose map features lie."""
    georeference = read_georeference(image)
    if georeference is None:
        raise InputError(
            f"has no place on a map, in whose coordinates {file.name} is; give it GeoTIFF tags or a world file, or draw"
            " in pixel coordinates",
            file=image,
        )
    return georeference


def _on_map(
    polygons: list[SeedPolygon], collection: _FeatureCollection, georeference: GeoReference, image: Path, file: Path
) -> list[SeedPolygon]:
    """Polygons in the image's system, of those of a file in its own.

    A file that names no system is in longitude and latitude, as RFC 7946 has it, unless its numbers cannot be.
    """
    stated = "" if collection.crs is None else _system_name(collection.crs.properties.name)
    if not stated:
        degrees = all(
            abs(x) <= 180 and abs(y) <= 90 for polygon in polygons for ring in polygon.rings for x, y, *_ in ring
        )
        if not degrees or not georeference.crs:  # a world file names none: both are then in one system
            return polygons
        stated = WGS84
    if stated == georeference.crs:
        return polygons
    source, target = find_system(stated, file), find_system(georeference.crs, image)
    moved = []
    for polygon in polygons:
        rings = []
        for ring in polygon.rings:
            x, y = transformed(source, target, *np.array([position[:2] for position in ring]).T)
            rings.append(tuple(zip(x.tolist(), y.tolist(), strict=True)))
        moved.append(polygon._replace(rings=tuple(rings)))
    return moved


def _system_name(name: str) -> str:
    """A coordinate system as PROJ knows it, by a name such as EPSG:32633 or urn:ogc:def:crs:EPSG::32633."""
    if name.upper().endswith("CRS84"):
        return WGS84  # the same system; in both files longitude comes first
    match = re.search(r"EPSG:(?:[0-9.]*:)?([0-9]+)$", name, re.IGNORECASE)
    return f"EPSG:{match[1]}" if match else name


def _on_image(polygons: list[SeedPolygon], georeference: GeoReference, texture: Windowed) -> list[SeedPolygon]:
    """Polygons in pixel coordinates, of those in map coordinates whose bounds meet the image."""
    a, b, c, d, e, f = georeference.affine
    size = (texture.width, texture.height)
    mapped: list[SeedPolygon] = []
    for polygon in polygons:
        pixels: list[Ring] = []
        for ring in polygon.rings:
            ground = np.array([position[:2] for position in ring]) - (c, f)
            # Rounded far below a texel, so that what lies on an edge of the image does so exactly.
            texels = np.round(np.linalg.solve([[a, b], [d, e]], ground.T).T, 6)
            pixels.append(tuple((float(x), float(y)) for x, y in texels))
        outer = np.array(pixels[0])
        if (outer.max(axis=0) >= 0).all() and (outer.min(axis=0) <= size).all():
            mapped.append(polygon._replace(rings=tuple(pixels)))
    return mapped


def _read_features(folder: Path, name: str) -> _FeatureCollection:
    path = folder / name
    try:
        return parse_model(read_yaml(path), _FeatureCollection)
    except InputError:
        if path.resolve().is_relative_to(folder.resolve()):
            raise
        # A job may come from somebody else: the content of a file elsewhere is not shown by way of an error.
        raise InputError(
            "cannot be read as a GeoJSON FeatureCollection of polygons and points with a material; it lies outside the "
            "job's folder, so what was found is not shown",
            file=path,
        ) from None


def check_vertices(name: str, rings: tuple[Ring, ...], texture: Windowed, path: Path) -> None:
    """Refuse a polygon that reaches beyond the texture."""
    for x, y, *_ in (position for ring in rings for position in ring):
        if not (0 <= x <= texture.width and 0 <= y <= texture.height):
            raise InputError(
                f"a polygon of '{name}' has the vertex [{x:g}, {y:g}]; allowed: pixel coordinates within the image of "
                f"{texture.width} x {texture.height} texels",
                file=path,
            )


def polygon_mask(
    rings: tuple[Ring, ...], texture: Windowed, top: int, left: int, shape: tuple[int, int], step: int = 1
) -> npt.NDArray[Any]:
    """Where a window of the texture has texels whose centre a polygon contains, or in which its outer vertices are.

    top, left : int; first row and column of the window.
    shape : (h, w)
    step : int; distance of the rows and columns looked at; others are omitted from the answer.
    """
    from skimage.draw import polygon

    outlines = [np.array([position[:2] for position in ring]) for ring in rings]
    mask = np.zeros([-(-n // step) for n in shape], bool)
    for number, outline in enumerate(outlines):
        if len(outline) > 2:
            # Texel centres are at half integers, those of skimage at integers.
            columns, rows = (outline - (left + 0.5, top + 0.5)).T / step
            mask[polygon(rows, columns, mask.shape)] = number == 0  # type: ignore[no-untyped-call]
    vertices = outlines[0][((outlines[0] >= 0) & (outlines[0] <= (texture.width, texture.height))).all(axis=1)]
    # A vertex on the far edge of the image is in its last texel.
    corner = (texture.width - 1, texture.height - 1)
    columns, rows = (np.minimum(vertices.astype(int), corner) - (left, top)).T
    there = (columns >= 0) & (columns < shape[1]) & (rows >= 0) & (rows < shape[0])
    there &= (columns % step == 0) & (rows % step == 0)
    mask[rows[there] // step, columns[there] // step] = True
    return mask
