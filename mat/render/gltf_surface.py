"""A mesh of a scene as triangles: glTF or OBJ."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skyshine.mat.render.gltf_triangles import gltf_parts
from skyshine.mat.render.obj_triangles import obj_parts
from skyshine.mat.render.plan_surface import turned
from skyshine.mat.render.scene_file import LoadedScene, Mesh
from skyshine.mat.render.surface_mesh import MAX_TRIANGLES, Covering, MeshPart, SurfaceMesh, surface_of
from skyshine.schemas.errors import InputError, nearest

READERS = {".glb": gltf_parts, ".gltf": gltf_parts, ".obj": obj_parts}


def mesh_surface(scene: LoadedScene, mesh: Mesh) -> SurfaceMesh:
    """The surface of a mesh; the origin of its file is the origin of the scene.

    Raises
    ------
    InputError
        The file cannot be read, has no triangle, or a material that the scene does not name.
    """
    parts = _parts(mesh.file)
    names = sorted({name for name, _, _ in parts})
    for name in names:
        if name not in mesh.materials:
            message = f"the file has the material '{name}', which is not named here; {nearest(name, mesh.materials)}"
            raise scene.error(("surface", "mesh", "materials"), message)
    for name in mesh.materials:
        if name not in names:
            raise scene.error(
                ("surface", "mesh", "materials", name), f"the file has no such material; {nearest(name, names)}"
            )
    coverings = tuple(_covering(mesh, name) for name in names)
    for name, _, uv in parts:
        if uv is None and coverings[names.index(name)].texture is not None:
            raise scene.error(
                ("surface", "mesh", "materials", name),
                "names a texture, but the file has no texture coordinates for it",
            )
    triangles = np.concatenate([corners for _, corners, _ in parts])
    uv = np.concatenate([np.zeros((len(c), 3, 2)) if uv is None else uv for _, c, uv in parts])
    numbers = np.concatenate([np.full(len(corners), names.index(name)) for name, corners, _ in parts])
    if mesh.up == "y":  # x stays; glTF looks along -z where z-up files look along +y
        triangles = np.stack([triangles[..., 0], -triangles[..., 2], triangles[..., 1]], axis=-1)
    triangles = turned(triangles * mesh.metres_per_unit, mesh.x_azimuth_deg - 90.0)
    return surface_of(triangles, numbers, coverings, uv, scene.model.surface.altitude_km, mesh.file)


def _covering(mesh: Mesh, name: str) -> Covering:
    value, key = mesh.materials[name], ("surface", "mesh", "materials", name)
    return Covering(value, None, key) if isinstance(value, str) else Covering(None, value.texture, key)


def _parts(file: Path) -> list[MeshPart]:
    """The parts of a file, by its ending."""
    reader = READERS.get(file.suffix.lower())
    if reader is None:
        raise InputError(f"ends in '{file.suffix}'; allowed: {', '.join(READERS)}; convert it", file=file)
    parts = reader(file)
    if not any(len(corners) for _, corners, _ in parts):
        raise InputError(f"has no triangle; allowed: 1 to {MAX_TRIANGLES}; name another file", file=file)
    return parts
