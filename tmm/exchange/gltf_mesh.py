"""Material feature IDs in a glTF mesh of the user's own, beside its photograph.

Every primitive whose base colour is the photograph gets a feature ID texture in the same texture coordinates (with
their transform, KHR_texture_transform) and repeated as the photograph is; all else in the file stays as it is. The
result is one ``.glb`` that holds buffers and images which were files of their own.
"""

from __future__ import annotations

import base64
import binascii
import json
import mimetypes
import os
import struct
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from skyshine.schemas.errors import InputError
from skyshine.schemas.paths import job_path
from skyshine.tmm.exchange.files import write_bytes
from skyshine.tmm.exchange.gltf import BINARY_CHUNK, MAGIC, NEAREST, Buffer, feature_ids, glb, metadata
from skyshine.tmm.exchange.image import MaterialImage

OWN = ("EXT_mesh_features", "EXT_structural_metadata")
PACKED = ("EXT_meshopt_compression", "KHR_meshopt_compression")  # their views lie in buffers that hold nothing yet
BYTE_LIMIT = 1 << 31  # of a mesh with all that it names
TRANSFORM = "KHR_texture_transform"


def write_mesh(
    folder: str | os.PathLike[str], image: MaterialImage, mesh: str | os.PathLike[str], photograph: str | None = None
) -> list[Path]:
    """Write ``NAME.glb`` with the feature IDs of a texture; NAME is that of the mesh's file and the texture's.

    Parameters
    ----------
    image : MaterialImage
    mesh : path
        A ``.glb``, or a ``.gltf`` whose buffers and images lie in its folder or in data URIs.
    photograph : str, optional
        Name of the image in the file (or its number); by default the one that is named as the texture, or the only one.

    Raises
    ------
    InputError
        The file cannot be read, is no glTF 2.0, has feature IDs or metadata already, or no primitive shows the
        photograph.
    """
    path = Path(mesh)
    document, binary = _read(path)
    for name in (*OWN, *PACKED):
        if name in document.get("extensionsUsed", ()):
            raise InputError(f"has {name}; allowed: a mesh without it; export it so", file=path)
    try:
        buffer = _one_buffer(document, binary, path)
        found = _showing(document, _image_number(document, image.name, photograph, path))
        if not found:
            raise InputError(
                "no primitive has the photograph as its base colour; name the image with --photograph", file=path
            )
        _add(document, buffer, image, found)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError):
        raise InputError(
            "is damaged: a part refers to one that is not there; check it with a glTF validator", file=path
        ) from None
    document["buffers"] = [{"byteLength": len(buffer.content)}]
    document["bufferViews"] = buffer.views
    out = Path(folder) / f"{path.stem}.{image.name}.glb"
    write_bytes(out, glb(document, bytes(buffer.content)))
    return [out]


def _read(path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON of a file, and the binary chunk that it may have."""
    try:
        if path.exists() and not path.is_file():
            raise InputError("is no file that can be read; check the path", file=path)
        if path.stat().st_size > BYTE_LIMIT:
            raise InputError(f"found {path.stat().st_size} bytes; allowed: at most {BYTE_LIMIT}", file=path)
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}; check the path", file=path) from None
    text, binary = content, b""
    if content[:4] == struct.pack("<I", MAGIC):
        text, binary = _chunks(content, path)
    try:
        document = json.loads(text.decode())
    except (ValueError, RecursionError):
        document = None
    asset = document.get("asset") if isinstance(document, dict) else None
    if (
        not isinstance(document, dict)
        or not isinstance(asset, dict)
        or str(asset.get("version", "")).split(".")[0] != "2"
    ):
        raise InputError("is no glTF 2.0; allowed: a .glb or .gltf of version 2", file=path)
    return document, binary


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


def _one_buffer(document: dict[str, Any], binary: bytes, path: Path) -> Buffer:
    """All buffers and images of a file in one buffer, by the views that the document has and those of the images."""
    sources = []
    for number, each in enumerate(document.get("buffers", [])):
        source = _resource(each["uri"], path) if "uri" in each else binary if number == 0 else b""
        if len(source) < each["byteLength"]:
            raise InputError(
                f"buffer {number} has {len(source)} bytes; stated: {each['byteLength']}; export the mesh again",
                file=path,
            )
        sources.append(source)
    buffer = Buffer()
    for view in document.get("bufferViews", []):
        start = view.get("byteOffset", 0)
        data = sources[view["buffer"]][start : start + view["byteLength"]]
        if len(data) < view["byteLength"]:
            raise InputError("a buffer view reaches beyond its buffer; export the mesh again", file=path)
        kept = {key: value for key, value in view.items() if key not in ("buffer", "byteOffset", "byteLength")}
        buffer.add(data, **kept)
    for each in document.get("images", []):
        if "uri" in each:
            uri = each.pop("uri")
            each.setdefault("name", Path(unquote(uri)).stem if not uri.startswith("data:") else "image")
            each["mimeType"] = _mime(uri)
            each["bufferView"] = buffer.add(_resource(uri, path))
    return buffer


def _resource(uri: str, path: Path) -> bytes:
    """The bytes that a URI of the file names: in itself, or in a file of its folder."""
    if uri.startswith("data:"):
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except binascii.Error:
            raise InputError("a data URI is not base64; export the mesh again", file=path) from None
    try:
        return job_path(path.parent, unquote(uri)).read_bytes()
    except ValueError as error:
        raise InputError(str(error), file=path) from None
    except OSError as error:
        raise InputError(f"names '{uri}', which cannot be read: {error.strerror}; put it there", file=path) from None


def _mime(uri: str) -> str:
    if uri.startswith("data:"):
        return uri[5:].partition(";")[0]
    return mimetypes.guess_type(unquote(uri))[0] or "image/png"


def _image_number(document: dict[str, Any], texture: str, photograph: str | None, path: Path) -> int:
    """Which image of a file is the photograph."""
    names = [str(each.get("name", number)) for number, each in enumerate(document.get("images", []))]
    wanted = texture if photograph is None else photograph
    for number, name in enumerate(names):
        if Path(name).stem == Path(wanted).stem or (photograph is not None and photograph == str(number)):
            return number
    if photograph is None and len(names) == 1:
        return 0
    listed = ", ".join(names) if names else "none"
    raise InputError(
        f"has no image '{wanted}'; its images: {listed}; say which is the photograph with --photograph", file=path
    )


def _showing(document: dict[str, Any], photograph: int) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """The primitives whose base colour is an image, each with its texture reference."""
    found = []
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            if "material" not in primitive:
                continue
            colour = (
                document["materials"][primitive["material"]].get("pbrMetallicRoughness", {}).get("baseColorTexture")
            )
            if colour is None:
                continue
            shown = document["textures"][colour["index"]].get("source") == photograph
            if shown and f"TEXCOORD_{_coordinates(colour)}" in primitive["attributes"]:
                found.append((primitive, colour))
    return found


def _coordinates(reference: dict[str, Any]) -> int:
    """Set of texture coordinates that a reference to a texture uses; its transform may name another."""
    transform = reference.get("extensions", {}).get(TRANSFORM, {})
    return int(transform.get("texCoord", reference.get("texCoord", 0)))


def _add(
    document: dict[str, Any],
    buffer: Buffer,
    image: MaterialImage,
    found: list[tuple[dict[str, Any], dict[str, Any]]],
) -> None:
    """Put the feature IDs into a document; one texture for each sampler's way to repeat."""
    png, channels = feature_ids(image)
    images, textures, samplers = (document.setdefault(key, []) for key in ("images", "textures", "samplers"))
    images.append(
        {"name": f"{image.name} material feature IDs", "mimeType": "image/png", "bufferView": buffer.add(png)}
    )
    source, count = len(images) - 1, len(image.materials)
    document.setdefault("extensions", {})["EXT_structural_metadata"] = metadata(image, buffer)
    document["extensionsUsed"] = sorted({*document.get("extensionsUsed", ()), *OWN})
    of_sampler: dict[Any, int] = {}
    for primitive, colour in found:
        own = document["textures"][colour["index"]].get("sampler")
        if own not in of_sampler:
            repeated = {} if own is None else {k: v for k, v in samplers[own].items() if k in ("wrapS", "wrapT")}
            samplers.append({"magFilter": NEAREST, "minFilter": NEAREST, **repeated})
            textures.append({"source": source, "sampler": len(samplers) - 1})
            of_sampler[own] = len(textures) - 1
        texture = {"index": of_sampler[own], "texCoord": colour.get("texCoord", 0), "channels": channels}
        if TRANSFORM in colour.get("extensions", {}):
            texture["extensions"] = {TRANSFORM: colour["extensions"][TRANSFORM]}
        identity = {"featureCount": count, "nullFeatureId": count, "label": "material", "propertyTable": 0}
        features = {"featureIds": [{**identity, "texture": texture}]}
        primitive.setdefault("extensions", {})["EXT_mesh_features"] = features
