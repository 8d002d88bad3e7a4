"""Documents of glTF 2.0 files: JSON, buffers, and the gate of extensions, before anything is computed from them.

References
----------
Khronos Group: glTF 2.0 (ISO/IEC 12113), and the registry of its extensions.
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path
from skyshine.schemas.regular_files import refuse_special_file

# "glTF", and chunk types "JSON" and "BIN" (glTF 2.0, section 4.4).
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942
BYTE_LIMIT = 1 << 31  # byte limit of a mesh with all that it names

# Extensions that change triangles or texture coordinates, and are decoded.
DECODED = {
    "KHR_mesh_quantization": "positions and texture coordinates as integers",
    "KHR_texture_transform": "offset, rotation, scale and set of the base colour's texture coordinates",
    "EXT_mesh_gpu_instancing": "every instance of a mesh",
}
# Extensions that a file may require: they change neither triangles nor where the base colour lies. All KHR_materials_*
# are of them too.
HARMLESS = (
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_texture_basisu",
    "KHR_xmp_json_ld",
    "EXT_instance_features",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "MSFT_texture_dds",
)
DRACO = "KHR_draco_mesh_compression"
_UNDO = "decompress it, as `npx @gltf-transform/cli copy IN.glb OUT.glb` or Blender does"
# Compressed geometry, with what to do; a file that merely may use them is refused too.
REFUSED = {
    DRACO: _UNDO,
    "EXT_meshopt_compression": _UNDO,
    "KHR_meshopt_compression": _UNDO,
}


def read_gltf(path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON of a ``.glb`` or ``.gltf``, and the binary chunk that it may have.

    Raises
    ------
    InputError
        The file cannot be read, is cut short or no glTF 2.0, or requires an extension that is not understood.
    """
    refuse_special_file(path)
    try:
        if path.stat().st_size > BYTE_LIMIT:
            raise InputError(f"found {path.stat().st_size} bytes; allowed: at most {BYTE_LIMIT}", file=path)
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None
    text, binary = content, b""
    if content[:4] == struct.pack("<I", MAGIC):
        text, binary = _chunks(content, path)
    try:
        document = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError):
        document = None
    asset = document.get("asset") if isinstance(document, dict) else None
    if (
        not isinstance(document, dict)
        or not isinstance(asset, dict)
        or str(asset.get("version", "")).split(".")[0] != str(VERSION)
    ):
        raise InputError("is no glTF 2.0; allowed: a .glb or .gltf of version 2", file=path)
    with references(path):
        _gate(document, path)
    return document, binary


@contextmanager
def references(path: Path) -> Iterator[None]:
    """Turns what a wrong reference or kind of a document raises into one line about its file."""
    try:
        yield
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, OverflowError):
        raise InputError(
            "is damaged: a part refers to one that is not there; check it with a glTF validator", file=path
        ) from None


def _gate(document: dict[str, Any], path: Path) -> None:
    """Refuse what is required and not understood, and views that are packed."""
    declared, required = ({*document.get(key, ())} for key in ("extensionsUsed", "extensionsRequired"))
    for name in sorted((declared & {*REFUSED} - {DRACO}) | (required - {*DECODED, *HARMLESS, DRACO})):
        if name.startswith("KHR_materials_") and name not in REFUSED:
            continue
        remedy = REFUSED.get(name, "export the mesh without it")
        raise InputError(f"uses {name}, which is not read; allowed: {', '.join(DECODED)}; {remedy}", file=path)


def _chunks(content: bytes, path: Path) -> tuple[bytes, bytes]:
    chunks: list[tuple[int, bytes]] = []
    at = 12
    while at + 8 <= len(content) and len(chunks) < 2:
        size, kind = struct.unpack_from("<II", content, at)
        if at + 8 + size > len(content):
            raise InputError("is cut short; export the mesh again", file=path)
        chunks.append((kind, content[at + 8 : at + 8 + size]))
        at += 8 + size
    if not chunks:
        raise InputError("is cut short; export the mesh again", file=path)
    binary = chunks[1][1] if len(chunks) > 1 and chunks[1][0] == BINARY_CHUNK else b""
    return chunks[0][1], binary


def view_bytes(document: dict[str, Any], binary: bytes, path: Path) -> list[bytes]:
    """The bytes of every buffer view of a document.

    Raises
    ------
    InputError
        A buffer cannot be read or is shorter than it says, or a view reaches beyond its buffer.
    """
    buffers = []
    for number, buffer in enumerate(document.get("buffers", [])):
        source = resource(buffer["uri"], path) if "uri" in buffer else binary if number == 0 else b""
        if len(source) < buffer["byteLength"]:
            raise InputError(
                f"buffer {number} has {len(source)} bytes; stated: {buffer['byteLength']}; export the mesh again",
                file=path,
            )
        buffers.append(source)
    views = []
    for view in document.get("bufferViews", []):
        start, size = view.get("byteOffset", 0), view["byteLength"]
        data = numbered(buffers, view["buffer"])[start : start + size]
        if start < 0 or size < 0 or len(data) < size:
            raise InputError("a buffer view reaches beyond its buffer; export the mesh again", file=path)
        views.append(data)
    return views


def numbered(items: list[Any], number: object) -> Any:
    """The item of a number that a document states; IndexError for numbers below 0 too, which a list would accept."""
    if not isinstance(number, int) or not 0 <= number < len(items):
        raise IndexError(number)
    return items[number]


def resource(uri: str, path: Path) -> bytes:
    """The bytes that a URI of a file names: in itself, or in a file of its folder, percent-encoded.

    Raises
    ------
    InputError
        The URI leads out of the folder, or its file cannot be read.
    """
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except binascii.Error:
            raise InputError("a data URI is not base64; export the mesh again", file=path) from None
    try:
        target = job_path(path.parent, unquote(uri))
        refuse_special_file(target, f"{path.name} names it; put it there")
        return target.read_bytes()
    except ValueError as error:
        raise InputError(str(error), file=path) from None
    except OSError as error:
        raise InputError(f"names '{uri}', which cannot be read: {error.strerror}; put it there", file=path) from None


def base_colour(document: dict[str, Any], primitive: dict[str, Any]) -> dict[str, Any] | None:
    """Reference to the texture of a primitive's base colour; None where it has none."""
    if "material" not in primitive:
        return None
    material = numbered(document["materials"], primitive["material"])
    reference: dict[str, Any] | None = material.get("pbrMetallicRoughness", {}).get("baseColorTexture")
    return reference


def texture_set(reference: dict[str, Any]) -> int:
    """Number of the set of texture coordinates that a reference to a texture uses; its transform may name another."""
    transform = reference.get("extensions", {}).get("KHR_texture_transform", {})
    return int(transform.get("texCoord", reference.get("texCoord", 0)))
