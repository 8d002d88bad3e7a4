"""Material feature IDs in a glTF mesh of the user's own, beside its photograph.

Every primitive whose base colour is the photograph gets a feature ID texture in the same texture coordinates (with
their transform, KHR_texture_transform) and repeated as the photograph is; all else in the file stays as it is. The
result is one ``.glb`` that contains buffers and images which were files of their own.
"""

from __future__ import annotations

import mimetypes
import os
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from skyshine.schemas.errors import InputError
from skyshine.schemas.gltf import base_colour, numbered, read_gltf, references, resource, texture_set, view_bytes
from skyshine.tmm.exchange.files import write_bytes
from skyshine.tmm.exchange.gltf import NEAREST, Buffer, feature_ids, glb, metadata
from skyshine.tmm.exchange.image import MaterialImage

OWN = ("EXT_mesh_features", "EXT_structural_metadata")
TRANSFORM = "KHR_texture_transform"


def write_mesh(
    folder: str | os.PathLike[str], image: MaterialImage, mesh: str | os.PathLike[str], photograph: str | None = None
) -> list[Path]:
    """Write ``NAME.glb`` with the feature IDs of a texture; NAME is that of the mesh's file and the texture's.

    Raises InputError: the file cannot be read, is no glTF 2.0, has feature IDs or metadata already, or no primitive
    shows the photograph.

    image : MaterialImage
    mesh : path; a ``.glb``, or a ``.gltf`` whose buffers and images lie in its folder or in data URIs.
    photograph : str, optional
        Name of the image in the file (or its number); by default the one that is named as the texture, or the only one.
    """
    path = Path(mesh)
    document, binary = read_gltf(path)
    for name in OWN:
        if name in document.get("extensionsUsed", ()):
            raise InputError(f"has {name}; allowed: a mesh without it; export it so", file=path)
    with references(path):
        buffer = _one_buffer(document, binary, path)
        primitives = _showing(document, _image_number(document, image.name, photograph, path))
        if not primitives:
            raise InputError(
                "no primitive has the photograph as its base colour; name the image with --photograph", file=path
            )
        _add(document, buffer, image, primitives)
    out = Path(folder) / f"{path.stem}.{image.name}.glb"
    write_bytes(out, glb(document, buffer))
    return [out]


def _one_buffer(document: dict[str, Any], binary: bytes, path: Path) -> Buffer:
    """All buffers and images of a file in one buffer, by the views that the document has and those of the images."""
    buffer = Buffer()
    for view, data in zip(document.get("bufferViews", []), view_bytes(document, binary, path), strict=True):
        properties = {key: value for key, value in view.items() if key not in ("buffer", "byteOffset", "byteLength")}
        buffer.add(data, **properties)
    for image in document.get("images", []):
        if "uri" in image:
            uri = image.pop("uri")
            image.setdefault("name", Path(unquote(uri)).stem if not uri.startswith("data:") else "image")
            image["mimeType"] = _mime(uri)
            image["bufferView"] = buffer.add(resource(uri, path))
    return buffer


def _mime(uri: str) -> str:
    if uri.startswith("data:"):
        return uri[5:].partition(";")[0]
    return mimetypes.guess_type(unquote(uri))[0] or "image/png"


def _image_number(document: dict[str, Any], texture: str, photograph: str | None, path: Path) -> int:
    """Which image of a file is the photograph."""
    names = [str(image.get("name", number)) for number, image in enumerate(document.get("images", []))]
    requested = texture if photograph is None else photograph
    for number, name in enumerate(names):
        if Path(name).stem == Path(requested).stem or (photograph is not None and photograph == str(number)):
            return number
    if photograph is None and len(names) == 1:
        return 0
    listed = ", ".join(names) if names else "none"
    raise InputError(
        f"has no image '{requested}'; its images: {listed}; say which is the photograph with --photograph", file=path
    )


def _showing(document: dict[str, Any], photograph: int) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    """The primitives whose base colour is an image, each with its texture reference."""
    matches = []
    for mesh in document.get("meshes", []):
        for primitive in mesh["primitives"]:
            colour = base_colour(document, primitive)
            if colour is None:
                continue
            is_photograph = numbered(document["textures"], colour["index"]).get("source") == photograph
            if is_photograph and f"TEXCOORD_{texture_set(colour)}" in primitive["attributes"]:
                matches.append((primitive, colour))
    return matches


def _add(
    document: dict[str, Any],
    buffer: Buffer,
    image: MaterialImage,
    primitives: list[tuple[dict[str, Any], dict[str, Any]]],
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
    for primitive, colour in primitives:
        sampler = document["textures"][colour["index"]].get("sampler")
        if sampler not in of_sampler:
            repeated = (
                {} if sampler is None else {k: v for k, v in samplers[sampler].items() if k in ("wrapS", "wrapT")}
            )
            samplers.append({"magFilter": NEAREST, "minFilter": NEAREST, **repeated})
            textures.append({"source": source, "sampler": len(samplers) - 1})
            of_sampler[sampler] = len(textures) - 1
        texture = {"index": of_sampler[sampler], "texCoord": colour.get("texCoord", 0), "channels": channels}
        if TRANSFORM in colour.get("extensions", {}):
            texture["extensions"] = {TRANSFORM: colour["extensions"][TRANSFORM]}
        identity = {"featureCount": count, "nullFeatureId": count, "label": "material", "propertyTable": 0}
        features = {"featureIds": [{**identity, "texture": texture}]}
        primitive.setdefault("extensions", {})["EXT_mesh_features"] = features
