"""Triangles of a glTF 2.0 file, decoded as its document says.

References
----------
Khronos Group: glTF 2.0 (ISO/IEC 12113), 3.6 accessors, 3.7 geometry; KHR_mesh_quantization; KHR_texture_transform;
EXT_mesh_gpu_instancing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy

from skyshine.mat.render.surface_mesh import MAX_TRIANGLES, MeshPart
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError
from skyshine.schemas.gltf import (
    DRACO,
    REFUSED,
    base_colour,
    numbered,
    read_gltf,
    references,
    texture_set,
    view_bytes,
)

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
TRIANGLES, STRIP, FAN = 4, 5, 6  # codes of primitives (glTF 2.0, section 3.7.2)
# Translation, rotation and scale of what is not moved.
_REST = {
    "TRANSLATION": np.array([0.0, 0.0, 0.0]),
    "ROTATION": np.array([0.0, 0.0, 0.0, 1.0]),
    "SCALE": np.array([1.0, 1.0, 1.0]),
}
_MOST_ZEROS = (
    1 << 20
)  # largest number of zeros of an accessor without data: a file of few bytes must not fill the memory
MODES = {TRIANGLES: "triangles", STRIP: "triangle strips", FAN: "triangle fans"}  # points and lines have no area


def gltf_parts(file: Path) -> list[MeshPart]:
    """The triangles of the scene that a file shows by default, a part for each primitive of each node.

    Raises
    ------
    InputError
        The file cannot be read, is damaged, or needs what is not understood.
    """
    document, binary = read_gltf(file)
    with references(file):
        reader = _Reader(document, view_bytes(document, binary, file), file)
        return list(reader.parts())


@dataclass(frozen=True, eq=False)
class _Reader:
    """A document with the bytes of its buffer views."""

    document: dict[str, Any]
    views: list[bytes]
    file: Path

    def parts(self) -> Iterator[MeshPart]:
        count = 0
        for node, placements in self._placed():
            mesh = numbered(self.document["meshes"], node["mesh"])
            if "skin" in node:
                raise self._error(f"mesh '{mesh.get('name', node['mesh'])}' has a skin", "apply the armature")
            weights = node.get("weights", mesh.get("weights", ()))
            for primitive in mesh["primitives"]:
                if DRACO in primitive.get("extensions", {}):
                    raise self._error(f"uses {DRACO}", REFUSED[DRACO])
                if primitive.get("mode", TRIANGLES) not in MODES:
                    continue
                name, corners, uv = self._triangles(primitive, weights)
                count += len(corners) * len(placements)
                if count > MAX_TRIANGLES:
                    raise self._error(f"has {count} triangles or more", f"allowed: {MAX_TRIANGLES}")
                for placement in placements:
                    yield name, *_moved(corners, uv, placement)

    def _error(self, message: str, remedy: str) -> InputError:
        return InputError(f"{message}, which is not read; {remedy}", file=self.file)

    def _placed(self) -> Iterator[tuple[dict[str, Any], Floats]]:
        """Nodes with a mesh, each with matrices (n, 4, 4) to the scene of its instances."""
        document, visited = self.document, set()
        nodes = document.get("nodes", [])
        scenes = document.get("scenes", [])
        if scenes:
            roots = numbered(scenes, document.get("scene", 0)).get("nodes", [])
        else:  # a library of nodes: all of them
            children = {child for node in nodes for child in node.get("children", ())}
            roots = [number for number in range(len(nodes)) if number not in children]
        waiting = [(number, np.eye(4)) for number in reversed(roots)]
        while waiting:
            number, parent = waiting.pop()
            if number in visited:
                raise self._error(f"node {number} has two parents", "export the mesh again")
            visited.add(number)
            node = numbered(nodes, number)
            matrix = parent @ _local(node)
            waiting += [(child, matrix) for child in reversed(node.get("children", ()))]
            if "mesh" in node:
                instances = node.get("extensions", {}).get("EXT_mesh_gpu_instancing")
                yield node, matrix[None] if instances is None else matrix @ self._instances(instances["attributes"])

    def _instances(self, attributes: dict[str, int]) -> Floats:
        """Matrices (n, 4, 4) of the instances of a node."""
        read = {
            name: self._accessor(attributes[name], len(value)) for name, value in _REST.items() if name in attributes
        }
        if len({*map(len, read.values())}) != 1:
            raise ValueError("no attributes, or of different lengths")
        count = len(next(iter(read.values())))
        return _matrices(*(read.get(name, np.tile(value, (count, 1))) for name, value in _REST.items()))

    def _triangles(self, primitive: dict[str, Any], weights: Any) -> tuple[str, Floats, Floats | None]:
        """Material, corners (F, 3, 3) and texture coordinates (F, 3, 2) of a primitive, in the axes of its mesh."""
        attributes, targets = primitive["attributes"], primitive.get("targets", ())
        reference = base_colour(self.document, primitive)
        key = f"TEXCOORD_{texture_set(reference) if reference is not None else 0}"
        vertices = self._morphed("POSITION", 3, attributes, targets, weights)
        if "indices" in primitive:
            index = self._accessor(primitive["indices"], 1)[:, 0].astype(np.int64)
            if index.size and index.max() >= len(vertices):
                raise InputError(
                    f"a primitive has the index {index.max()}; allowed: 0 to {len(vertices) - 1}, its vertices; export"
                    " the mesh again",
                    file=self.file,
                )
        else:
            index = np.arange(len(vertices))
        faces = _faces(index, primitive.get("mode", TRIANGLES))
        uv = None
        if key in attributes:
            coordinates = self._morphed(key, 2, attributes, targets, weights)
            if reference is not None:
                coordinates = _transformed(coordinates, reference)
            uv = coordinates[faces]
        material = {}
        if "material" in primitive:
            material = numbered(self.document["materials"], primitive["material"])
        return str(material.get("name") or ""), vertices[faces], uv

    def _morphed(self, key: str, width: int, attributes: Any, targets: Any, weights: Any) -> Floats:
        """An attribute (n, width) with the morph targets that the file shows."""
        values = self._accessor(attributes[key], width)
        for target, weight in zip(targets, weights, strict=False):
            if weight and key in target:
                values = values + float(weight) * self._accessor(target[key], width)
        return values

    def _accessor(self, number: object, width: int) -> Floats:
        """Values (n, width) of an accessor, normalised integers as numbers from -1 or 0 to 1."""
        accessor = numbered(self.document["accessors"], number)
        kind, count = np.dtype(COMPONENTS[accessor["componentType"]]), accessor["count"]
        if WIDTHS[accessor["type"]] != width or not 0 <= count <= 3 * MAX_TRIANGLES:
            raise ValueError("another type than its use needs, or too many values")
        if "bufferView" in accessor:
            values = self._array(accessor["bufferView"], accessor.get("byteOffset", 0), kind, count, width)
        elif count > _MOST_ZEROS:
            raise ValueError("more zeros than a file needs")
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in accessor:
            values = self._replaced(values, accessor["sparse"])
        result: Floats = values.astype(float)
        if accessor.get("normalized", False) and kind.kind in "iu":
            result = np.maximum(result / np.iinfo(kind).max, -1.0)
        return result

    def _replaced(self, values: Any, sparse: dict[str, Any]) -> Any:
        """Values (n, width) with those that a sparse accessor writes in their places."""
        count, where, new = sparse["count"], sparse["indices"], sparse["values"]
        kind = np.dtype(COMPONENTS[where["componentType"]])
        at = self._array(where["bufferView"], where.get("byteOffset", 0), kind, count, 1)[:, 0].astype(np.int64)
        values = values.copy()
        width = values.shape[1]
        values[at] = self._array(new["bufferView"], new.get("byteOffset", 0), values.dtype, count, width)
        return values

    def _array(self, view: object, offset: int, kind: np.dtype[Any], count: int, width: int) -> Any:
        """Values (count, width) of a kind in a buffer view; ValueError or TypeError beyond its end."""
        data = numbered(self.views, view)
        stride = self.document["bufferViews"][view].get("byteStride", kind.itemsize * width)
        if offset < 0 or stride < kind.itemsize * width:
            raise ValueError("a step shorter than a value")
        if count == 0:
            return np.zeros((0, width), kind)
        return np.ndarray((count, width), kind, data, offset, (stride, kind.itemsize))


def _local(node: dict[str, Any]) -> Floats:
    """Matrix (4, 4) of a node to its parent."""
    if "matrix" in node:
        stated: Floats = np.array(node["matrix"], float).reshape(4, 4).T
        return stated
    parts = (np.array(node.get(name.lower(), default), float).reshape(1, -1) for name, default in _REST.items())
    matrix: Floats = _matrices(*parts)[0]
    return matrix


def _matrices(translation: Floats, rotation: Floats, scale: Floats) -> Floats:
    """Matrices (n, 4, 4) of translations (n, 3), quaternions (n, 4) x, y, z, w, and scales (n, 3)."""
    matrices = np.zeros((len(translation), 4, 4))
    matrices[:, :3, :3] = scipy.spatial.transform.Rotation.from_quat(rotation).as_matrix() * scale[:, None, :]
    matrices[:, :3, 3], matrices[:, 3, 3] = translation, 1.0
    return matrices


def _moved(corners: Floats, uv: Floats | None, matrix: Floats) -> tuple[Floats, Floats | None]:
    """Triangles under a matrix; a mirror would turn them over, so that two corners change places."""
    transformed = corners @ matrix[:3, :3].T + matrix[:3, 3]
    if np.linalg.det(matrix[:3, :3]) >= 0:
        return transformed, uv
    return transformed[:, ::-1], None if uv is None else uv[:, ::-1]


def _faces(index: Integers, mode: int) -> Integers:
    """Numbers of the corners (F, 3) of a list, strip or fan of triangles."""
    if mode == TRIANGLES:
        return index[: len(index) // 3 * 3].reshape(-1, 3)
    if len(index) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == FAN:
        return np.stack([index[1:-1], index[2:], np.full(len(index) - 2, index[0])], axis=-1)
    faces = np.stack([index[:-2], index[1:-1], index[2:]], axis=-1)
    faces[1::2] = faces[1::2, [0, 2, 1]]
    return faces


def _transformed(uv: Floats, reference: dict[str, Any]) -> Floats:
    """Texture coordinates (n, 2) scaled, then turned, then moved, as KHR_texture_transform defines it."""
    transform = reference.get("extensions", {}).get("KHR_texture_transform")
    if transform is None:
        return uv
    angle = float(transform.get("rotation", 0.0))
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    moved: Floats = (uv * np.array(transform.get("scale", [1, 1]), float)) @ turn.T + transform.get("offset", [0, 0])
    return moved
