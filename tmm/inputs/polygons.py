"""Polygons of a job and of GeoJSON files, and the texels that they hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import pydantic
from pydantic import Field

from skyshine.schemas.documents import parse_model, read_yaml
from skyshine.schemas.errors import InputError
from skyshine.tmm.images.texture import Windowed
from skyshine.tmm.job.model import Seeds


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


def seed_polygons(seeds: Seeds, base_folder: Path) -> list[tuple[str, tuple[Ring, ...]]]:
    """All polygons of seeds, those of the GeoJSON file last: material and rings (the outer one first, then holes).

    Raises
    ------
    InputError
        The GeoJSON file cannot be read or is not a FeatureCollection of polygons and points with a material.
    """
    polygons: list[tuple[str, tuple[Ring, ...]]] = [
        (name, (ring,)) for name, rings in seeds.polygons.items() for ring in rings
    ]
    if seeds.file is None:
        return polygons
    collection = _read_features(base_folder, seeds.file)
    for feature in collection.features:
        name, geometry = feature.properties.material, feature.geometry
        if isinstance(geometry, _Point):
            polygons.append((name, ((geometry.coordinates,),)))
        else:
            shapes = geometry.coordinates if isinstance(geometry, _MultiPolygon) else (geometry.coordinates,)
            polygons += [(name, rings) for rings in shapes]
    return polygons


def _read_features(folder: Path, name: str) -> _FeatureCollection:
    path = folder / name
    try:
        return parse_model(read_yaml(path), _FeatureCollection)
    except InputError:
        if path.resolve().is_relative_to(folder.resolve()):
            raise
        # A job may come from somebody else: what a file elsewhere holds is not shown by way of an error.
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
    """Where a window of the texture has texels whose centre a polygon holds, or that its outer vertices stand in.

    Parameters
    ----------
    top, left : int
        First row and column of the window.
    shape : (h, w)
    step : int
        Distance of the rows and columns looked at; others are left out of the answer.
    """
    from skimage.draw import polygon

    outlines = [np.array([position[:2] for position in ring]) for ring in rings]
    mask = np.zeros([-(-n // step) for n in shape], bool)
    for number, outline in enumerate(outlines):
        if len(outline) > 2:
            # Texel centres stand at half integers, those of skimage at integers.
            columns, rows = (outline - (left + 0.5, top + 0.5)).T / step
            mask[polygon(rows, columns, mask.shape)] = number == 0  # type: ignore[no-untyped-call]
    # A vertex on the far edge of the image stands in its last texel.
    last = (texture.width - 1, texture.height - 1)
    columns, rows = (np.minimum(outlines[0].astype(int), last) - (left, top)).T
    there = (columns >= 0) & (columns < shape[1]) & (rows >= 0) & (rows < shape[0])
    there &= (columns % step == 0) & (rows % step == 0)
    mask[rows[there] // step, columns[there] // step] = True
    return mask
