"""``mat render`` and ``mat contrast``: files, JSON, exit statuses; the packaged scenes."""

import json

import numpy as np
import pytest
import yaml
from PIL import Image

import skyshine.mat
from skyshine.mat.api.examples import starter_files
from skyshine.mat.cli import main
from skyshine.mat.render.rays import FEW
from skyshine.mat.render.scene_file import load_scene
from skyshine.mat.render.surface import surface_of_scene


@pytest.fixture
def mat(capsys):
    """Run ``mat`` with arguments: exit status, standard output, standard error."""

    def run(*arguments):
        with pytest.raises(SystemExit) as stop:
            main.main([str(argument) for argument in arguments])
        shown = capsys.readouterr()
        return stop.value.code, shown.out, shown.err

    return run


@pytest.fixture
def scene_file(one_material, plain_texture, tmp_path):
    content = {
        "skyshine_scene": 1,
        "name": "road",
        "databases": str(one_material),
        "surface": {"altitude_km": 0.0, "plan": {"texture": str(plain_texture), "metres_per_texel": 2.0}},
        "camera": {"plan_view": {"height_m": 500.0, "size": [8, 4]}},
        "hours": [6.0, 12.0],
        "sensors": {"b01": {"gain": 3.0}},
    }
    path = tmp_path / "scene.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    return path


def test_render_writes_the_frames_and_the_day(mat, scene_file, tmp_path):
    status, shown, _ = mat("render", scene_file, "--json")
    files = json.loads(shown)["files"]
    assert status == 0
    assert sorted(file.rpartition("/")[2] for file in files) == [
        "road_b01_0600_counts.png",
        "road_b01_0600_kelvin.png",
        "road_b01_0600_radiance.exr",
        "road_b01_1200_counts.png",
        "road_b01_1200_kelvin.png",
        "road_b01_1200_radiance.exr",
        "road_b01_day_animated.png",
        "road_day.png",
    ]
    morning, noon = (
        np.asarray(Image.open(tmp_path / "rendered" / f"road_b01_{hour}_kelvin.png")) / 100 for hour in ("0600", "1200")
    )
    frames = list(skyshine.mat.Scene(scene_file).frames())
    assert morning == pytest.approx(frames[0].apparent_temperature, abs=0.00501)
    assert noon.mean() > morning.mean() + 10


def test_render_of_a_wrong_scene_is_one_line_and_status_2(mat, scene_file):
    scene_file.write_text(scene_file.read_text(encoding="utf-8").replace("altitude_km: 0.0", "altitude_km: 7.0"))
    status, shown, error = mat("render", scene_file)
    assert status == 2 and not shown and error.count("\n") == 1


def test_render_without_the_ray_caster_says_what_to_install(mat, scene_file, write_glb, tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "embreex", None)
    monkeypatch.delitem(sys.modules, "embreex.mesh_construction", raising=False)
    file = write_glb([("ground", np.tile(np.eye(3), (FEW + 1, 1, 1)), None)], tmp_path / "a.glb")
    content = yaml.safe_load(scene_file.read_text(encoding="utf-8"))
    content["surface"] = {
        "altitude_km": 0.1,
        "mesh": {"metres_per_unit": 0.01, "file": file.name, "materials": {"ground": "asphalt_road"}},
    }
    scene_file.write_text(yaml.safe_dump(content), encoding="utf-8")
    status, _, error = mat("render", scene_file)
    assert status == 2 and "skyshine[render]" in error


def test_contrast_prints_the_day_and_its_crossovers(mat, one_material, tmp_path):
    out = tmp_path / "contrast.png"
    shade = ("--shade", "08:00-12:00")
    status, shown, _ = mat("contrast", one_material, "asphalt_road", "asphalt_road", *shade, "--out", out)
    assert status == 0 and "crossovers" in shown and out.is_file()
    status, shown, _ = mat("contrast", one_material, "asphalt_road", "asphalt_road", *shade, "--json")
    (band,) = json.loads(shown)["bands"]
    assert status == 0 and min(band["contrast"]["values"]) < -2 and band["contrast"]["units"] == "K"


def test_contrast_of_an_unknown_material_is_status_2(mat, one_material):
    status, _, error = mat("contrast", one_material, "sea", "asphalt_road")
    assert status == 2 and error.count("\n") == 1 and "lacks the material 'sea'" in error


def test_the_starter_has_a_scene_of_its_job():
    scene = next(file for file in starter_files() if file.name == "scene.yaml")
    job = yaml.safe_load(starter_files()[0].read_text(encoding="utf-8"))
    model = yaml.safe_load(scene.read_text(encoding="utf-8"))
    assert model["databases"] == job["output"]["folder"]
    assert model["surface"]["plan"]["texture"] == f"{job['output']['folder']}/{job['textures'][0]['name']}.tmm.h5"
    assert model["surface"]["altitude_km"] == job["site"]["altitude_km"]


def test_the_street_is_the_mesh_that_its_program_makes():
    import runpy

    folder = starter_files("street")[0].parent
    scene = load_scene(folder / "scene.yaml")
    surface = surface_of_scene(scene)
    made = runpy.run_path(str(folder / "make_street.py"))["parts"]()
    assert len(surface.triangles) == sum(len(faces) for faces in made.values())
    assert surface.area.sum() == pytest.approx(
        sum(
            0.5 * np.linalg.norm(np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), axis=1).sum()
            for faces in made.values()
        )
    )
    assert surface.bounds[:, 2] == pytest.approx([-0.05, 12.0])
    upward = surface.normal[surface.slope < 1.0]
    assert np.all(upward[:, 2] > 0) and surface.slope.max() == pytest.approx(90.0)
    job = yaml.safe_load((folder / "job.yaml").read_text(encoding="utf-8"))
    assert {covering.material for covering in surface.coverings} == set(job["materials"])
    low, high = job["surface_grid"]["altitude_km"]
    assert low <= surface.altitudes[0] and surface.altitudes[1] <= high
