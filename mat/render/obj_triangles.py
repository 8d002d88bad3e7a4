"""Triangles of a Wavefront OBJ file, with the texture scales of its MTL files.

References
----------
Wavefront Technologies: Advanced Visualizer manual, appendices B1 (object files) and B2 (material libraries).
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import numpy as np

from skyshine.mat.render.surface_mesh import MAX_TRIANGLES, MeshPart
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path
from skyshine.schemas.plain_numbers import plain_number
from skyshine.schemas.regular_files import refuse_special_file

BYTE_LIMIT = 1 << 30  # 1 GiB
READ = ("v", "vt", "f", "usemtl", "mtllib")  # statements of an OBJ that are read; map_Kd -s -o of an MTL
# Curves and surfaces that are no polygons: without them a part of the scene would be missing.
FREE_FORM = ("curv", "curv2", "surf", "bzp", "bsp", "cdc", "cdp", "res", "call", "csh")

_Corner = tuple[int, int | None]  # number of the vertex, and of its texture coordinates


def obj_parts(file: Path) -> list[MeshPart]:
    """The triangles of a file, a part for each material; texture coordinates count from the top left corner.

    Raises
    ------
    InputError
        With file:line of what cannot be read; for a face that no fan of triangles fills.
    """
    vertices: list[list[float]] = []
    coordinates: list[list[float]] = []
    faces: dict[str, list[list[_Corner]]] = {}
    material, scales = "", dict[str, tuple[Floats, Floats]]()
    for number, key, words in _lines(file):
        try:
            if key == "v":
                x, y, z = (plain_number(word) for word in words[:3])
                vertices.append([x, y, z])
            elif key == "vt":
                u, *v = (plain_number(word) for word in words[:2])
                coordinates.append([u, v[0] if v else 0.0])
            elif key == "f":
                corners = [_corner(word, len(vertices), len(coordinates)) for word in words]
                faces.setdefault(material, []).extend(_fan(corners, vertices, file, number))
            elif key == "usemtl":
                material = " ".join(words)
            elif key == "mtllib":
                scales |= _texture_scales(file, " ".join(words))
            elif key in FREE_FORM:
                raise InputError(
                    f"found '{key}', a free-form curve or surface; allowed: polygons; export it as a mesh",
                    file=file,
                    line=number,
                )
        except (ValueError, IndexError):
            raise InputError(
                f"found '{key} {' '.join(words)[:60]}'; allowed: numbers, and vertices above this line; export the mesh"
                " again",
                file=file,
                line=number,
            ) from None
        if sum(map(len, faces.values())) > MAX_TRIANGLES:
            raise InputError(f"has more than {MAX_TRIANGLES} triangles; name another file", file=file, line=number)
    positions, uv = np.array(vertices, float).reshape(-1, 3), np.array(coordinates, float).reshape(-1, 2)
    return [_part(name, corners, positions, uv, scales.get(name), file) for name, corners in faces.items() if corners]


def _lines(file: Path) -> Iterator[tuple[int, str, list[str]]]:
    """Number, keyword and words of each line of an OBJ or MTL file, without comments; a backslash continues a line."""
    refuse_special_file(file)
    if file.stat().st_size > BYTE_LIMIT:
        raise InputError(f"found {file.stat().st_size} bytes; allowed: at most {BYTE_LIMIT}", file=file)
    begun: list[str] = []
    with file.open(encoding="utf-8", errors="replace") as lines:  # names of other encodings are compared as they are
        for number, line in enumerate(lines, 1):
            begun += line.partition("#")[0].rstrip().removesuffix("\\").split()
            if line.rstrip().endswith("\\"):
                continue
            if begun:
                yield number, begun[0], begun[1:]
            begun = []


def _corner(word: str, vertices: int, coordinates: int) -> _Corner:
    """Numbers from 0 of a corner such as 3, 3/1, 3//2 or -1/-1/-1; negative ones count back from this line."""
    vertex, *indices = word.split("/")
    uv = _number(indices[0], coordinates) if indices and indices[0] else None
    return _number(vertex, vertices), uv


def _number(text: str, count: int) -> int:
    value = int(text)
    number = value - 1 if value > 0 else count + value
    if value == 0 or not 0 <= number < count:
        raise IndexError(value)
    return number


def _fan(corners: list[_Corner], vertices: list[list[float]], file: Path, line: int) -> list[list[_Corner]]:
    """Triangles of a polygon, all turned as it is, from the first corner that allows it."""
    if len(corners) < 3:
        raise ValueError(corners)
    if len(corners) == 3:
        return [corners]
    positions = np.array([vertices[vertex] for vertex, _ in corners])
    for start in range(len(corners)):
        rolled = np.roll(positions, -start, axis=0) - positions[start]
        crosses = np.cross(rolled[1:-1], rolled[2:])
        # Rounding of corners on a line leaves a product of either sign.
        if np.all(crosses @ crosses.sum(axis=0) >= -1e-9 * np.sum(crosses.sum(axis=0) ** 2)):
            ring = corners[start:] + corners[:start]
            return [[ring[0], second, third] for second, third in pairwise(ring[1:])]
    raise InputError(
        f"found a face of {len(corners)} corners that no fan of triangles fills; triangulate the mesh on export",
        file=file,
        line=line,
    )


def _part(
    name: str,
    corners: list[list[_Corner]],
    positions: Floats,
    uv: Floats,
    scale: tuple[Floats, Floats] | None,
    file: Path,
) -> MeshPart:
    missing = sum(coordinate is None for face in corners for _, coordinate in face)
    triangles = positions[np.array([[vertex for vertex, _ in face] for face in corners])]
    if missing == 3 * len(corners):
        return name, triangles, None
    if missing:
        raise InputError(
            f"material '{name}' has corners with and without texture coordinates; unwrap all of it", file=file
        )
    factor, offset = scale or (np.ones(2), np.zeros(2))
    scaled = uv[np.array([[coordinate for _, coordinate in face] for face in corners])] * factor + offset
    return name, triangles, np.stack([scaled[..., 0], 1.0 - scaled[..., 1]], axis=-1)  # OBJ counts v from the bottom


def _texture_scales(file: Path, names: str) -> dict[str, tuple[Floats, Floats]]:
    """Scale and offset (2,) of the texture coordinates of each material, of the MTL files of a line.

    A library that is not there, or not in the folder of the mesh, gives none: the scene names the materials.
    """
    scales = {}
    for library in _libraries(file.parent, [names]) or _libraries(file.parent, names.split()):
        material = ""
        for number, key, words in _lines(library):
            if key == "newmtl":
                material = " ".join(words)
            elif key == "map_Kd":
                scale, offset = (_option(words, *option, library, number) for option in (("-s", 1.0), ("-o", 0.0)))
                scales[material] = scale, offset
    return scales


def _libraries(folder: Path, names: list[str]) -> list[Path]:
    """Those of some names that are files of a folder."""
    libraries = []
    for name in names:
        with suppress(ValueError):  # leads elsewhere, or is too long for a file
            libraries.append(job_path(folder, name.replace("\\", "/")))
    return [library for library in libraries if library.is_file()]


def _option(words: list[str], option: str, default: float, file: Path, line: int) -> Floats:
    """The first two numbers of an option of a texture map; a second number that is missing is the default."""
    values: list[float] = []
    if option in words:
        for word in words[words.index(option) + 1 :][:2]:
            try:
                values.append(plain_number(word))
            except ValueError:
                break
        if not values:
            raise InputError(f"found {option} without a number; allowed: one to three; fix it", file=file, line=line)
    return np.array([*values, default, default][:2])
