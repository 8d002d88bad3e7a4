"""The page of a scene file: its triangles, its camera and its bands.

Faces are shown in full sun, but for the shade of photographs; shadows of the surface are those of `mat render`, which
follows the Sun through the day.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from skyshine.mat.gpu.band import export_band
from skyshine.mat.gpu.codes import WIDTH, export_codes
from skyshine.mat.gpu.container import GpuFile, texture
from skyshine.mat.gpu.coordinates import AirCoordinates
from skyshine.mat.gpu.export import AirSet, air_sets, databases, exported_air
from skyshine.mat.gpu.surface import export_surface
from skyshine.mat.gpu.viewer import FARTHEST_KM, LARGEST, TEXELS, bands_of, table_name, write_page
from skyshine.mat.render.camera import station, view_rays
from skyshine.mat.render.databases import SceneTables
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.mat.render.surface import SurfaceMaterials, surface_of_scene
from skyshine.mat.render.surface_mesh import SurfaceMesh

DATA = "surface.mesh"
_MOST_TEXTURES = 8


def write_scene_viewer(scene: LoadedScene, folder: Path) -> Path:
    """Write the page of a scene; nothing of it is asked for elsewhere.

    Returns
    -------
    Path
        Of the page.

    Raises
    ------
    InputError
        A database, a material or a file of the surface is missing, or the camera is not where the tables are.
    """
    tables, surface = SceneTables.of_scene(scene), surface_of_scene(scene)
    band_names = {air_set.band.path.name for air_set in tables.bands}
    sets = [
        air_set
        for air_set in air_sets(databases([scene.databases]))
        if air_set.surface.path.name == tables.surface.path.name and air_set.band.path.name in band_names
    ]
    altitude = float(view_rays(scene, surface, 0).altitude[0])
    _refuse_altitude(scene, sets, altitude)
    altitudes = _altitudes(scene, surface, tables)
    exported = {DATA: _mesh(scene, surface, tables)}
    for air_set in sets:
        exported[air_set.name] = exported_air(air_set, None, altitude=altitude, range_km=FARTHEST_KM, texels=TEXELS)
        exported.setdefault(table_name(air_set.band.path), export_band(air_set.band))
    shaded_sky = scene.model.surface.shaded_sky if "shade0" in exported[DATA].textures else None
    exported[table_name(tables.surface.path)] = export_surface(
        tables.surface, altitudes_km=altitudes, shaded_sky=shaded_sky
    )
    columns, rows = scene.model.camera.size
    camera, nearest, farthest = _camera(scene, surface)
    limit = min(FARTHEST_KM, *(float(AirCoordinates.of(air_set.air).range_km[1]) for air_set in sets))
    settings = {
        "texture": DATA,
        "columns": columns,
        "rows": rows,
        "surface_km": surface.altitude,
        "altitude_km": altitude,
        "range_km": [
            nearest,
            max(limit - (farthest - nearest), nearest) if camera["kind"] == "perspective" else nearest,
        ],
        "bands": bands_of(sets),
        "mesh": {
            "data": DATA,
            "parts": exported[DATA].numbers["parts"],
            "bounds": surface.bounds.tolist(),
            "camera": camera,
        },
    }
    return write_page(scene.model.name, settings, exported, folder, None, hour=scene.hours[0])


def _refuse_altitude(scene: LoadedScene, sets: list[AirSet], altitude: float) -> None:
    for air_set in sets:
        low, high = AirCoordinates.of(air_set.air).altitude_km
        if not low <= altitude <= high:
            raise scene.error(
                ("camera",),
                f"is at {altitude:g} km; allowed: {low:g} to {high:g} km, as in {air_set.air.path.name}",
            )


def _altitudes(scene: LoadedScene, surface: SurfaceMesh, tables: SceneTables) -> list[float]:
    """Altitudes [km] between which temperatures on the surface are linear."""
    low, high = surface.altitudes
    nodes = np.asarray(tables.surface.root.axes["altitude"].values, float)
    if low < nodes[0] or high > nodes[-1]:
        raise scene.error(
            ("surface", "altitude_km"),
            f"the surface spans {low:g} to {high:g} km; allowed: {nodes[0]:g} to {nodes[-1]:g} km, as in"
            f" {tables.surface.path.name}",
        )
    return [float(value) for value in np.unique([low, *nodes[(nodes > low) & (nodes < high)], high])]


def _camera(scene: LoadedScene, surface: SurfaceMesh) -> tuple[dict[str, Any], float, float]:
    """The first camera of a scene as the page reads it, and the ranges [km] of what it looks at and of the farthest."""
    camera = scene.model.camera
    if camera.plan_view is not None:
        rays, view = view_rays(scene, surface, 0), camera.plan_view
        plan = scene.model.surface.plan
        top = view.top_azimuth_deg if view.top_azimuth_deg is not None else plan.top_azimuth_deg if plan else 0.0
        described = {
            "kind": "plan_view",
            "height_m": view.height_m,
            "centre_m": list(view.centre_m),
            "width_m": rays.side * view.size[0],
            "top_azimuth_deg": top,
        }
        return described, view.height_m * 1e-3, view.height_m * 1e-3
    assert camera.perspective is not None
    position, look_at = station(camera.perspective, 0)
    described = {
        "kind": "perspective",
        "position_m": position.tolist(),
        "look_at_m": look_at.tolist(),
        "field_of_view_deg": camera.perspective.field_of_view_deg,
    }
    reach = np.linalg.norm(surface.triangles.reshape(-1, 3) - position, axis=-1)
    return described, float(np.linalg.norm(look_at - position)) * 1e-3, float(reach.max()) * 1e-3


def _mesh(scene: LoadedScene, surface: SurfaceMesh, tables: SceneTables) -> GpuFile:
    """Triangles with their coverings: codes of materials, or -1 less the number of a texture."""
    with SurfaceMaterials(scene, surface) as materials:
        codes = dict(zip(materials.names, tables.codes(materials.places, scene.error), strict=True))
        textures = materials.textures()
        if len(textures) > _MOST_TEXTURES:
            key = surface.coverings[list(textures)[_MOST_TEXTURES]].place
            raise scene.error(key, f"is texture {_MOST_TEXTURES + 1}; allowed: {_MOST_TEXTURES} textures in a page")
        unknown = scene.model.surface.unknown_material
        code = 0 if unknown is None else int(codes[unknown])
        rows, shade, mixtures, parts = _texels(list(textures.values()), code)
        numbers = {index: -1 - position for position, index in enumerate(textures)}
    cover = np.array(
        [numbers[n] if n in numbers else codes[str(kind.material)] for n, kind in enumerate(surface.coverings)], float
    )
    count = len(surface.triangles)
    corners = np.concatenate(
        [
            surface.triangles.reshape(-1, 3),
            np.repeat(surface.normal, 3, axis=0),
            surface.uv.reshape(-1, 2),
            np.repeat(cover[surface.covering], 3)[:, None],
        ],
        axis=1,
    )
    material_codes = tables.surface.materials
    return GpuFile(
        "mesh",
        {"file": str(scene.model.name)},
        {
            "corners": texture("R32F", corners, "corner and normal (m), texture coordinates, covering"),
            "level0": texture("R16UI", rows, "number of the mixture of a texel, textures one under another"),
            "mixtures": texture("RGBA16UI", mixtures, "three material codes, then their shares"),
        }
        | ({"shade0": texture("R8", shade, "share of a texel in the shade, as level0")} if shade.any() else {}),
        {
            "triangles": count,
            "parts": parts,
            "share_total": 65535,
            "material": [int(value) for value in material_codes.values()],
            "material_name": list(material_codes),
        },
    )


def _texels(files: list[Any], unknown: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[list[int]]]:
    """Numbers of mixtures of all textures one under another and their shade, the mixtures, and where each texture
    begins.
    """
    if not files:
        return np.zeros((1, 1), np.uint16), np.zeros((1, 1), np.uint8), np.zeros((1, 2 * WIDTH, 4), np.uint16), []
    pictures, shades, tables, parts = [], [], [], []
    for file in files:
        content = export_codes(file, "")
        level = next(n for n in range(file.levels) if max(file.size(n)) <= LARGEST)
        pictures.append(content.textures[f"level{level}"].texels[0, ..., 0])
        shades.append(content.textures[f"shade{level}"].texels[0, ..., 0] if file.has_shade else None)
        table = content.textures["mixtures"].texels[0].copy()
        empty = table[:, 1::2, :3].sum(axis=-1) == 0
        if unknown:
            table[:, 0::2, 0][empty], table[:, 1::2, 0][empty] = unknown, 65535
        tables.append(table)
    width, top, offset = max(picture.shape[1] for picture in pictures), 0, 0
    rows = np.zeros((sum(picture.shape[0] for picture in pictures), width), np.uint16)
    dark = np.zeros(rows.shape, np.uint8)
    for picture, shade, table in zip(pictures, shades, tables, strict=True):
        height, across = picture.shape
        rows[top : top + height, :across] = picture
        if shade is not None:
            dark[top : top + height, :across] = shade
        parts.append([top, across, height, offset])
        top, offset = top + height, offset + table.shape[0] * WIDTH
    return rows, dark, np.concatenate(tables), parts
