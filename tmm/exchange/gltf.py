"""glTF 2.0 with a feature ID texture: EXT_mesh_features and EXT_structural_metadata.

A quad of one unit carries the texture (`gltf_mesh` writes it into a mesh of the user's); each texel's feature ID is a
row of the property table, which has code, name and share of the materials. A texel without material has the ID that
follows the last row, stated as `nullFeatureId`. Specifications: glTF 2.0 (Khronos, ISO/IEC 12113), EXT_mesh_features
and EXT_structural_metadata (3D Tiles community, CesiumGS).
"""

from __future__ import annotations

import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from skyshine.schemas.errors import InputError
from skyshine.schemas.gltf import BINARY_CHUNK, JSON_CHUNK, MAGIC, VERSION
from skyshine.tmm.exchange.files import write_bytes
from skyshine.tmm.exchange.image import MaterialImage
from skyshine.tmm.exchange.rasters import png_bytes

MAX_IDS = 65536  # number of ids of two 8 bit channels
FLOAT, UNSIGNED_SHORT, ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 5126, 5123, 34962, 34963  # enums of OpenGL, as in glTF 2.0
NEAREST, CLAMP_TO_EDGE, TRIANGLES = 9728, 33071, 4  # enums of OpenGL, as in glTF 2.0
_ALIGNMENT = 8  # alignment of property table buffers, by the metadata specification


class Buffer:
    """Collects buffer views of one binary buffer.

    content : bytearray
    views : list of dict; as a document has them.
    """

    def __init__(self) -> None:
        self.content = bytearray()
        self.views: list[dict[str, Any]] = []

    def add(self, data: bytes, **settings: Any) -> int:
        """Append a view and return its number."""
        self.content += b"\0" * (-len(self.content) % _ALIGNMENT)
        self.views.append({"buffer": 0, "byteOffset": len(self.content), "byteLength": len(data), **settings})
        self.content += data
        return len(self.views) - 1


def write_gltf(folder: str | os.PathLike[str], image: MaterialImage) -> list[Path]:
    """Write ``NAME.glb``.

    Raises InputError: there are more materials than feature IDs, or the file cannot be written.
    """
    if len(image.materials) >= MAX_IDS:
        raise InputError(
            f"'{image.name}' has {len(image.materials)} materials; allowed in a feature ID texture: {MAX_IDS - 1}"
        )
    buffer, path = Buffer(), Path(folder) / f"{image.name}.glb"
    ids, channels = feature_ids(image)
    document = _document(image, buffer, channels)
    document["images"] = [{"name": "material feature IDs", "mimeType": "image/png", "bufferView": buffer.add(ids)}]
    write_bytes(path, glb(document, buffer))
    return [path]


def feature_ids(image: MaterialImage) -> tuple[bytes, list[int]]:
    """The feature IDs as PNG, and the channels that contain them, the lowest byte first."""
    index = image.index(start=0)
    index[index < 0] = len(image.materials)
    rgb = np.zeros((*index.shape, 3), np.uint8)
    rgb[..., 0], rgb[..., 1] = index & 0xFF, index >> 8
    return png_bytes(rgb), [0] if len(image.materials) < 256 else [0, 1]


def _document(image: MaterialImage, buffer: Buffer, channels: list[int]) -> dict[str, Any]:
    aspect = image.width / image.height
    positions = np.array([[0, 0, 0], [aspect, 0, 0], [aspect, 1, 0], [0, 1, 0]], "<f4")
    corners = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], "<f4")  # texture coordinates run down from the top left
    triangles = np.array([0, 1, 2, 0, 2, 3], "<u2")
    views = [
        buffer.add(positions.tobytes(), target=ARRAY_BUFFER),
        buffer.add(corners.tobytes(), target=ARRAY_BUFFER),
        buffer.add(triangles.tobytes(), target=ELEMENT_ARRAY_BUFFER),
    ]
    bounds = {"min": positions.min(axis=0).tolist(), "max": positions.max(axis=0).tolist()}
    count = len(image.materials)
    feature_ids = {
        "featureCount": count,
        "nullFeatureId": count,
        "label": "material",
        "propertyTable": 0,
        "texture": {"index": 0, "texCoord": 0, "channels": channels},
    }
    primitive = {
        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
        "indices": 2,
        "mode": TRIANGLES,
        "extensions": {"EXT_mesh_features": {"featureIds": [feature_ids]}},
    }
    return {
        "asset": {"version": "2.0", "generator": "skyshine"},
        "extensionsUsed": ["EXT_mesh_features", "EXT_structural_metadata"],
        "extensions": {"EXT_structural_metadata": metadata(image, buffer)},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": image.name, "mesh": 0}],
        "meshes": [{"name": image.name, "primitives": [primitive]}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": NEAREST, "minFilter": NEAREST, "wrapS": CLAMP_TO_EDGE, "wrapT": CLAMP_TO_EDGE}],
        "accessors": [
            {"bufferView": views[0], "componentType": FLOAT, "count": 4, "type": "VEC3", **bounds},
            {"bufferView": views[1], "componentType": FLOAT, "count": 4, "type": "VEC2"},
            {"bufferView": views[2], "componentType": UNSIGNED_SHORT, "count": 6, "type": "SCALAR"},
        ],
    }


def metadata(image: MaterialImage, buffer: Buffer) -> dict[str, Any]:
    """The property table of a texture's materials, for EXT_structural_metadata; its values go into the buffer."""
    names = [name.encode() for name in image.materials.values()]
    offsets = np.cumsum([0, *map(len, names)]).astype("<u4")
    counts = np.bincount(image.level.code.ravel(), minlength=max(image.materials) + 1)[list(image.materials)]
    share = (counts / image.level.code.size).astype("<f4")
    properties = {
        "code": {"values": buffer.add(np.array(list(image.materials), "<u2").tobytes())},
        "name": {
            "values": buffer.add(b"".join(names)),
            "stringOffsets": buffer.add(offsets.tobytes()),
            "stringOffsetType": "UINT32",
        },
        "share": {"values": buffer.add(share.tobytes())},
    }
    described = {
        "code": {"type": "SCALAR", "componentType": "UINT16", "description": "material code", "required": True},
        "name": {"type": "STRING", "description": "material name", "required": True},
        "share": {"type": "SCALAR", "componentType": "FLOAT32", "description": "share of all texels", "required": True},
    }
    classes = {"material": {"name": "Material", "properties": described}}
    table = {"name": "materials", "class": "material", "count": len(names), "properties": properties}
    return {"schema": {"id": "skyshine_materials", "classes": classes}, "propertyTables": [table]}


def glb(document: dict[str, Any], buffer: Buffer) -> bytes:
    """A binary glTF of a document and its buffer."""
    complete = {**document, "buffers": [{"byteLength": len(buffer.content)}], "bufferViews": buffer.views}
    text = json.dumps(complete, separators=(",", ":"), ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    content = bytes(buffer.content) + b"\0" * (-len(buffer.content) % 4)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text + struct.pack("<II", len(content), BINARY_CHUNK) + content
    return struct.pack("<III", MAGIC, VERSION, 12 + len(chunks)) + chunks
