"""Frames over a texture with a layer of shade, against pixels of the library that are given its share: two ways, one
through doubled materials and columns of temperature, one through `Faces.shade`.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "fuzz"))
from good_databases import with_shade

from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.render.exposure import hidden
from skyshine.mat.render.frames import Renderer
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.render.surface import SurfaceMaterials
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance
from skyshine.mat.tables.loader import open_table
from skyshine.tmm import open_tmm

HOURS = [6.0, 9.5, 15.5, 18.0]
HOUR = 10.0  # under the roof
SHADED_SKY, HEIGHT_M, GROUND_KM = 0.3, 500.0, 0.1
HALF = 8.0  # m


@pytest.fixture(scope="module")
def shaded_texture(two_materials, tmp_path_factory):
    """Path of the texture of two materials with shade of all shares, drawn for each level."""
    return with_shade(Path(shutil.copy(two_materials, tmp_path_factory.mktemp("shaded") / "shaded.tmm.h5")))


@pytest.fixture(scope="module")
def tables(small_build):
    return tuple(open_table(small_build / f"{name}.h5") for name in ("s01.htt", "b01.band", "s01b01.atmq"))


def view_of(surface, count, hour, distance, elevation, heading, altitude, normal):
    one, sun = np.ones(count), surface.source_track("sun", time=hour)
    place = distance, altitude, elevation, float(sun.elevation), np.mod(float(sun.azimuth) - heading, 360.0)
    return View(
        LinesOfSight(*(value * one for value in place)),
        distance * one,
        normal=np.broadcast_to(normal, (count, 3)),
        to_source=np.broadcast_to(direction(sun.elevation, sun.azimuth), (count, 3)),
        to_observer=-np.broadcast_to(direction(elevation, heading), (count, 3)),
        source_heading=float(sun.azimuth) * one,
    )


@pytest.mark.parametrize("texels", [1, 2])
def test_a_plan_in_the_shade_is_that_of_the_library_s_pixels(shaded_texture, small_build, tables, texels):
    """At several hours, of level 0 and of level 1."""
    surface_of = {
        "altitude_km": GROUND_KM,
        "shaded_sky": SHADED_SKY,
        "plan": {"texture": str(shaded_texture), "metres_per_texel": 2.0},
    }
    columns, rows = 8 // texels, 4 // texels
    scene = load_scene(
        {
            "skyshine_scene": 1,
            "name": "shaded",
            "databases": str(small_build),
            "surface": surface_of,
            "camera": {"plan_view": {"height_m": HEIGHT_M, "size": [columns, rows]}},
            "hours": HOURS,
        }
    )
    with Renderer(scene) as renderer:
        frames = list(renderer.frames())
    x, y = np.meshgrid((np.arange(columns) + 0.5) * texels, (np.arange(rows) + 0.5) * texels)
    with open_tmm(shaded_texture) as file:
        codes, shares = (each.reshape(-1, 3) for each in file.mixture(x, y, level=texels - 1))
        shade = file.shade(x, y, level=texels - 1).ravel()
    assert len(set(shade)) > 2 and shade.max() == 1
    one = np.ones(shade.size)
    for hour, frame in zip(HOURS, frames, strict=True):
        faces = Faces(
            codes.astype(int), shares, GROUND_KM * one, 0 * one, 0 * one, hour * one, shade=shade,
            shaded_sky=SHADED_SKY * one,
        )  # fmt: skip
        upright = np.array([0.0, 0.0, 1.0])
        view = view_of(tables[0], shade.size, hour, HEIGHT_M / 1e3, -90.0, 0.0, GROUND_KM + HEIGHT_M / 1e3, upright)
        expected = pixel_radiance(*tables, faces, view)
        np.testing.assert_allclose(frame.radiance.ravel(), expected.radiance, rtol=1e-9)
        np.testing.assert_allclose(frame.surface_temperature.ravel(), expected.temperature, rtol=1e-9)


@pytest.mark.parametrize("shaded_sky", [0.6, 0.95])
def test_shade_of_a_photograph_beside_a_roof_sees_the_smaller_of_both_skies(
    shaded_texture, small_build, tables, write_glb, tmp_path, shaded_sky, monkeypatch
):
    """Ground of a texture beside a roof, which leaves less or more of the sky than the photograph."""

    def level(height, half):
        low, high = -half, half
        first = [[low, height, high], [high, height, high], [high, height, low]]
        return np.array([first, [[low, height, high], [high, height, low], [low, height, low]]], float)

    uv = np.array([[[0, 1], [1, 1], [1, 0]], [[0, 1], [1, 0], [0, 0]]], float)
    mesh = write_glb([("ground", level(0.0, HALF), uv), ("roof", level(2.0, 3.0), None)], tmp_path / "roof.glb")
    materials = {"ground": {"texture": str(shaded_texture)}, "roof": "grass_green"}
    camera = {"field_of_view_deg": 40.0, "size": [32, 24], "position_m": [0, -30, 24], "look_at_m": [0, 0, 0]}
    scene = load_scene(
        {
            "skyshine_scene": 1,
            "name": "roofed",
            "databases": str(small_build),
            "surface": {
                "altitude_km": GROUND_KM,
                "shaded_sky": shaded_sky,
                "mesh": {"file": str(mesh), "materials": materials},
            },
            "camera": {"perspective": camera},
            "hours": [HOUR],
        }
    )
    # A roof whose material is not known is as warm as the air.
    monkeypatch.setattr(SurfaceMaterials, "of_faces", lambda self, face: np.full(len(face), -1))
    with Renderer(scene) as renderer:
        (frame,) = renderer.frames()
        place = renderer._see(0, np.array([HOUR]))
        sun = tables[0].source_track("sun", time=HOUR)
        dark_now = hidden(place.points, renderer._caster, direction(sun.elevation, sun.azimuth))
    seen, own = place.points, place.exposure.sky_view
    chosen = np.flatnonzero((seen.point[:, 2] < 1) & ~place.exposure.shaded.any(axis=1) & ~dark_now)
    assert chosen.size > 20 and own[chosen].min() < 0.95 < own[chosen].max()
    mixture = seen.materials
    shade = mixture.share[:, 3:].sum(axis=1)
    codes = renderer._codes[mixture.number[:, :3]]
    shares = mixture.share[:, :3] / np.maximum(1 - shade, 1e-300)[:, None]
    shares = np.where(shade[:, None] == 1, mixture.share[:, 3:], shares)
    wall = tables[0].value("air_temperature", altitude=GROUND_KM, forcing_time=HOUR)
    for row in chosen[:: max(chosen.size // 6, 1)]:
        pixel = seen.pixel[row]
        kelvin = tables[0].temperature(
            material=codes[row],
            altitude=seen.altitude[row],
            azimuth=seen.azimuth[row],
            slope=seen.slope[row],
            time=HOUR,
            absorbed_change=tables[0].absorbed_change(
                material=codes[row], altitude=seen.altitude[row], sky_view=float(own[row])
            ),
        )
        given = {"sky_view": own[row], "wall_temperature": float(wall), "shade": shade[row], "shaded_sky": shaded_sky}
        faces = Faces(
            codes[row][None],
            shares[row][None],
            *(np.array([float(each)]) for each in (seen.altitude[row], seen.azimuth[row], seen.slope[row], HOUR)),
            temperature=kelvin[None],
            **{name: np.array([value]) for name, value in given.items()},
        )
        rays = place.rays
        view = view_of(
            tables[0], 1, HOUR, seen.range[row], rays.elevation[pixel], rays.azimuth[pixel], rays.altitude[pixel],
            seen.normal[row],
        )  # fmt: skip
        expected = pixel_radiance(*tables, faces, view)
        assert frame.radiance.ravel()[pixel] == pytest.approx(expected.radiance[0], rel=1e-7)
    assert set(np.round(shade[chosen], 3)) >= {0.0, 1.0} and np.any((shade > 0.1) & (shade < 0.9))
