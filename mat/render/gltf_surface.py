"""A glTF mesh of a scene as triangles, read by trimesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skyshine.mat.render.plan_surface import turned
from skyshine.mat.render.scene_file import LoadedScene, Mesh
from skyshine.mat.render.surface_mesh import Covering, SurfaceMesh, surface_of
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError, nearest

MAX_TRIANGLES = 1 << 24
ENDINGS = (".glb", ".gltf")


def mesh_surface(scene: LoadedScene, mesh: Mesh) -> SurfaceMesh:
    """The surface of a mesh; the origin of its file is the origin of the scene.

    Raises
    ------
    InputError
        The file cannot be read, holds no triangle, or a material that the scene does not name.
    ModuleNotFoundError
        trimesh is not installed.
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
    given, place = mesh.materials[name], ("surface", "mesh", "materials", name)
    return Covering(given, None, place) if isinstance(given, str) else Covering(None, given.texture, place)


def _parts(file: Path) -> list[tuple[str, Floats, Floats | None]]:
    """Name of the material, corners (F, 3, 3) and texture coordinates (F, 3, 2) of each part of a file."""
    import trimesh

    if file.suffix.lower() not in ENDINGS:
        raise InputError(f"ends in '{file.suffix}'; allowed: {', '.join(ENDINGS)}; convert it", file=file)
    try:
        loaded = trimesh.load_scene(file, process=False)
        meshes = [part for part in loaded.dump() if isinstance(part, trimesh.Trimesh)]
    except Exception as error:  # trimesh raises whatever its parsers meet
        raise InputError(
            f"cannot be read as glTF ({type(error).__name__}: {error}); export it again", file=file
        ) from None
    parts = []
    for part in meshes:
        corners = np.asarray(part.triangles, float)
        uv = getattr(part.visual, "uv", None)
        if uv is not None:
            uv = np.asarray(uv, float)[np.asarray(part.faces)]
            uv = np.stack([uv[..., 0], 1.0 - uv[..., 1]], axis=-1)  # trimesh counts v from the bottom
        material = getattr(part.visual, "material", None)
        parts.append((str(getattr(material, "name", None) or ""), corners, uv))
    count = sum(len(corners) for _, corners, _ in parts)
    if count == 0 or count > MAX_TRIANGLES:
        raise InputError(f"holds {count} triangles; allowed: 1 to {MAX_TRIANGLES}; name another file", file=file)
    return parts
