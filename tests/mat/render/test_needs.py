"""What a scene reads, as needs of its job: known views, extreme ones, and that no pixel reads beyond them."""

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job
from skyshine.mat.render.camera import view_rays
from skyshine.mat.render.needs_text import needs_text, with_needs
from skyshine.mat.render.query_limits import face_nodes, scene_needs
from skyshine.mat.render.rays import ray_caster
from skyshine.mat.render.reads import scene_reads
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.render.seen import SeenSurface
from skyshine.mat.render.surface import SurfaceMaterials, surface_of_scene
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

JOB = """\
skyshine: 1
name: needs
site: {latitude_deg: 48, longitude_deg: 16, date: 2026-07-10, utc_offset_h: 2, altitude_km: 0.1}
states:
  - {profile: midlatitude_summer, weather: {air_temperature_c: [15, 28]}}
bands:
  - {name: long, wavelength_um: [8, 12]}
sources: [sun]
materials: [asphalt_road, brick_red, concrete]
# A comment that stays.
needs:  # old
  hours: ["01:00", "02:00"]
output: {folder: built}
"""


@pytest.fixture
def yard(tmp_path, write_glb):
    """Scenes of a level yard of 40 m before a wall of 10 m that faces north, with a plate in it, seen from north."""

    def quad(*corners):
        a, b, c, d = corners
        return [[a, b, c], [a, c, d]]

    # x east, y up, z south, as glTF has it.
    ground = quad([-20, 0, 20], [20, 0, 20], [20, 0, -20], [-20, 0, -20])
    wall = quad([20, 0, 20], [-20, 0, 20], [-20, 10, 20], [20, 10, 20])
    plate = quad([-0.1, 0.05, 0.1], [0.1, 0.05, 0.1], [0.1, 0.05, -0.1], [-0.1, 0.05, -0.1])
    write_glb([("ground", ground, None), ("wall", wall, None), ("plate", plate, None)], tmp_path / "yard.glb")
    (tmp_path / "job.yaml").write_text(JOB, encoding="utf-8")

    def make(**changes):
        content = {
            "skyshine_scene": 1,
            "name": "yard",
            "surface": {
                "altitude_km": 0.1,
                "mesh": {
                    "file": str(tmp_path / "yard.glb"),
                    "materials": {"ground": "asphalt_road", "wall": "brick_red", "plate": "concrete"},
                },
            },
            "camera": camera([0, 19, 6], [0, -20, 2]),
            "hours": [13, 15],
        }
        return load_scene(content | changes)

    return make


def camera(position, look_at, **more):
    kind = {"field_of_view_deg": 30, "size": [48, 12], "position_m": position, "look_at_m": look_at} | more
    return {"perspective": {name: value for name, value in kind.items() if value is not None}}


def limits_of(scene, loaded=None, **settings):
    needs = scene_needs(scene, scene_reads(scene), load_library(), loaded, **settings)
    return {limit.key: limit.value for limit in needs.limits}, needs


def test_a_yard_before_a_wall_gives_its_faces_materials_and_hours(yard):
    limits, needs = limits_of(yard())
    assert limits["faces_deg"] == [[0, 0], [90, 0]]
    assert limits["materials"] == ["brick_red", "asphalt_road"]
    assert limits["hours"] == ["13:00", "15:00"] and limits["sources"] == ["sun"]
    assert limits["observer_altitude_km"] == pytest.approx([0.105, 0.107], abs=2e-6)
    # The wall is 39 m away, and seen under 15 degree to both sides; its foot lies 6 m deeper.
    assert limits["range_km"][1] == pytest.approx(1.02 * np.hypot(39 / np.cos(np.radians(15)), 6) / 1e3, rel=0.02)
    assert needs.replaced == {"concrete": "asphalt_road"} and 0 <= needs.replaced_share < 1e-3


@pytest.mark.parametrize("seed", range(4))
def test_no_pixel_of_a_random_view_reads_beyond_the_limits(yard, tmp_path, seed):
    generator = np.random.default_rng(seed)
    position, look_at = generator.uniform([-15, -15, 3], [15, 15, 9]), generator.uniform(-15, 15, 3) * [1, 1, 0.4]
    hours = np.sort(generator.uniform(0, 24, 3)).round(2).tolist()
    scene = yard(camera=camera(position.tolist(), look_at.tolist()), hours=hours)
    loaded = load_job(tmp_path / "job.yaml")
    limits, _ = limits_of(scene, loaded)
    surface = surface_of_scene(scene)
    rays = view_rays(scene, surface, 0)
    with SurfaceMaterials(scene, surface) as materials:
        seen = SeenSurface.of(rays, surface, materials, ray_caster(surface))
    for key, values in (
        ("range_km", np.maximum(seen.range, loaded.requested.atmosphere_grid.range_km[0])),
        ("elevation_deg", rays.elevation),
        ("observer_altitude_km", rays.altitude),
        ("surface_altitude_km", np.maximum(seen.altitude, 0.1)),
    ):
        assert values.size == 0 or limits[key][0] <= values.min() <= values.max() <= limits[key][1], key
    faces = {tuple(face) for face in limits.get("faces_deg", [])}
    for slope, azimuth in zip(seen.slope.round(6), seen.azimuth.round(6), strict=True):
        assert (slope, azimuth if 0 < slope < 180 else 0.0) in faces


def test_hours_over_midnight_are_the_shorter_part_of_the_day(yard):
    assert limits_of(yard(hours=[23.5, 1, 0.25]))[0]["hours"] == ["23:30", "01:00"]
    assert limits_of(yard(hours=[12.51]))[0]["hours"] == ["12:30", "12:31"]


def test_a_track_is_gathered_over_all_its_stations(yard):
    stations = [
        {"hour": 9, "position_m": [0, 19, 6], "look_at_m": [0, -20, 2]},
        {"hour": 9.5, "position_m": [0, 19, 40], "look_at_m": [0, 0, 0]},
    ]
    moving = camera(None, None, track=stations)
    limits, _ = limits_of(yard(camera=moving, hours=None))
    assert limits["observer_altitude_km"] == pytest.approx([0.105, 0.141], abs=2e-6)
    assert limits["elevation_deg"][0] < -64 and limits["hours"] == ["09:00", "09:30"]


def test_a_camera_that_sees_only_sky_reads_the_longest_range_and_no_surface(yard, tmp_path):
    scene = yard(camera=camera([0, 0, 5], [0, 10, 40]))
    loaded = load_job(tmp_path / "job.yaml")
    limits, needs = limits_of(scene, loaded)
    assert limits["range_km"] == [1000, 1000]
    assert not {"materials", "faces_deg", "slope_deg", "surface_altitude_km"} & limits.keys()
    assert needs.notes == ("no pixel meets the surface: materials, faces and altitudes of surfaces are not limited",)
    copy = with_needs(JOB, needs_text("scene.yaml", needs))
    (tmp_path / "copy.yaml").write_text(copy, encoding="utf-8")
    assert load_job(tmp_path / "copy.yaml").trimmed.atmosphere_grid.range_km == [1000]


def test_a_sphere_has_a_span_of_slopes(yard, tmp_path, write_glb):
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=3, radius=5.0)
    write_glb([("ground", ball.triangles, None)], tmp_path / "ball.glb")
    mesh = {"file": str(tmp_path / "ball.glb"), "materials": {"ground": "concrete"}}
    scene = yard(surface={"altitude_km": 0.11, "mesh": mesh}, camera=camera([0, 40, 30], [0, 0, 0]))
    limits, _ = limits_of(scene)
    assert "faces_deg" not in limits and 0 < limits["slope_deg"][0] < 25 and limits["slope_deg"][1] > 90
    job = yaml.safe_load(JOB)
    job["states"][0]["ground_material"] = "asphalt_road"  # which is level, and whose temperature the faces see
    limits, needs = limits_of(scene, load_job(job))
    assert limits["slope_deg"][0] == 0
    load_job(yaml.safe_load(with_needs(yaml.safe_dump(job), needs_text("scene.yaml", needs))))


def test_walls_that_no_pixel_shows_keep_a_tilted_face(yard, plain_texture):
    limits, _ = limits_of(yard(camera=camera([0, 0, 9], [0, 0.5, 0], field_of_view_deg=20)))
    # The wall, and the lower side of the plate, which ground beside it sees.
    assert limits["faces_deg"] == [[0, 0], [90, 0], [180, 0]] and limits["materials"][0] == "asphalt_road"
    plan = {"altitude_km": 0.1, "plan": {"texture": str(plain_texture), "metres_per_texel": 2.0}}
    limits, _ = limits_of(yard(surface=plan, camera={"plan_view": {"height_m": 500.0, "size": [8, 4]}}))
    assert limits["faces_deg"] == [[0, 0]] and limits["elevation_deg"] == [-90, -89.5]
    under_trees = plan | {"shaded_materials": {"asphalt_road": 0.4}}
    limits, _ = limits_of(yard(surface=under_trees, camera={"plan_view": {"height_m": 500.0, "size": [8, 4]}}))
    assert limits["faces_deg"] == [[0, 0], [90, 0]]


def test_faces_of_nearly_one_direction_are_told_by_the_ends(yard):
    faces = [(0.0, 0.0), (89.99, 10.0), (90.0, 10.02), (90.01, 100.0)]
    assert face_nodes(faces) == [
        (0.0, 0.0), (89.99, 10.0), (89.99, 10.02), (89.99, 100.0), (90.01, 10.0), (90.01, 10.02), (90.01, 100.0),
    ]  # fmt: skip


def test_a_polar_night_keeps_the_source_of_the_scene(yard, tmp_path):
    text = JOB.replace("latitude_deg: 48", "latitude_deg: 88").replace("2026-07-10", "2026-12-21")
    (tmp_path / "job.yaml").write_text(text.replace("[sun]", "[sun, moon]"), encoding="utf-8")
    limits, needs = limits_of(yard(), load_job(tmp_path / "job.yaml"))
    # The Sun at noon on the solstice: 90 - 88 - 23.4 degree.
    assert -23 < limits["source_elevation_deg"][0] < limits["source_elevation_deg"][1] < -20.5
    (tmp_path / "copy.yaml").write_text(with_needs(text, needs_text("scene.yaml", needs)), encoding="utf-8")
    job = load_job(tmp_path / "copy.yaml").trimmed
    assert job.sources == ["sun"] and job.atmosphere_grid.source_elevation_deg == [-10]


def test_the_sun_of_the_window_stands_within_its_limits(yard, tmp_path):
    """Highest Sun at 48 degree north on 10 July: 64.3 degree, near 13:02 of the clock there."""
    limits, _ = limits_of(yard(hours=[12, 14]), load_job(tmp_path / "job.yaml"))
    low, high = limits["source_elevation_deg"]
    assert 58 < low < 62 and 64.3 < high < 65.2
    # The camera looks south: the Sun is ahead.
    assert limits["source_azimuth_deg"][0] == 0 and limits["source_azimuth_deg"][1] < 60


def test_a_job_that_does_not_reach_the_scene_is_refused_at_its_place(yard, tmp_path):
    air, ground = "atmosphere_grid: ", "surface_grid: "
    for old, new, words in (
        ("bands:", air + "{range_km: [0.001, 0.02]}\nbands:", "grid.range_km: has 0.001 to 0.02; the scene .*widen"),
        ("bands:", air + "{altitude_km: [5, 9]}\nbands:", "atmosphere_grid.altitude_km: has 5 to 9; .*widen"),
        ("bands:", ground + "{altitude_km: [0.1]}\nbands:", "surface_grid.altitude_km: has 0.1 to 0.1; the scene"),
        ("[asphalt_road, brick_red, concrete]", "[asphalt_road]", "materials: lacks 'brick_red', which .* shows"),
        ("sources: [sun]", "sources: [moon]", "source: found sun; job.yaml builds moon"),
    ):
        (tmp_path / "job.yaml").write_text(JOB.replace(old, new), encoding="utf-8")
        with pytest.raises(InputError, match=words):
            limits_of(yard(), load_job(tmp_path / "job.yaml"))


def test_the_command_writes_a_job_that_differs_in_its_needs_alone(yard, tmp_path):
    scene = yard()
    (tmp_path / "scene.yaml").write_text(
        yaml.safe_dump(scene.document.data).replace(f"{tmp_path}/", ""), encoding="utf-8"
    )
    arguments = ["check", str(tmp_path / "job.yaml"), "--scene", str(tmp_path / "scene.yaml"), "--out"]
    done = CliRunner().invoke(main, [*arguments, str(tmp_path / "new.yaml")], standalone_mode=False)
    assert done.exit_code == 0, done.output
    text = (tmp_path / "new.yaml").read_text()
    assert text.startswith(JOB[: JOB.index("needs:")]) and "# old" not in text and "output: {folder: built}" in text
    assert load_job(tmp_path / "new.yaml").trimmed.query_limits.materials == ["brick_red", "asphalt_road"]
    for wrong in (tmp_path / "job.yaml", tmp_path / "elsewhere" / "new.yaml"):
        refused = CliRunner().invoke(main, [*arguments, str(wrong)], standalone_mode=False)
        assert refused.exit_code == 2 and "allowed: another file in the folder of the job" in refused.output


def test_a_replaced_material_is_drawn_as_the_other(yard):
    model = yard().document.data["surface"]
    scene = yard(surface=model | {"replaced_materials": {"concrete": "brick_red"}})
    surface = surface_of_scene(scene)
    with SurfaceMaterials(scene, surface) as materials:
        assert materials.names == ("asphalt_road", "brick_red")
        plate = int(np.flatnonzero(surface.covering == 2)[0])
        mixture = materials.at(np.array([plate]), np.full((1, 3), 1 / 3), np.ones(1))
        assert mixture.names[mixture.number[0, 0]] == "brick_red"
