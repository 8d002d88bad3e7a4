"""The commands, on the demo that comes with the project and on jobs that are wrong."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine import schemas
from skyshine.tmm.cli import COMMANDS, main


def test_every_command_shows_an_example(run):
    for name in COMMANDS:
        result = run(name, "--help")
        assert result.exit_code == 0 and f"Example: tmm {name}" in result.output


def test_demo_is_sensible(demo):
    _, report = demo
    usage = {name: entry["value"] for name, entry in report["usage"].items()}
    assert 0.05 < usage["asphalt_road"] < 0.10
    assert usage["conifer"] > usage["grass_green"] > usage["asphalt_road"] > usage["wood_pine_weathered"]
    assert report["overall_accuracy"]["value"] > 0.9 and report["mean_iou"]["value"] > 0.75


def test_check(run, demo_folder):
    result = run("check", demo_folder / "job.tmm.yaml", "--json")
    report = json.loads(result.output)["textures"][0]
    assert result.exit_code == 0 and report["width"] == 960 and len(report["seed_texels"]) == 4


def test_preview_shows_content_and_shares(run, demo):
    path, report = demo
    info = json.loads(run("preview", path, "--json").output)
    assert info["filetype"] == "tmm" and info["levels"] == 10
    assert info["quality"]["tested_texels"] == report["held_out_texels"]
    assert "asphalt_road" in run("preview", path).output
    usage = json.loads(run("preview", path, path, "--json").output)
    assert usage["all"]["conifer"]["value"] == pytest.approx(report["usage"]["conifer"]["value"], rel=1e-5)


def test_preview(run, demo, demo_folder, tmp_path):
    path, _ = demo
    out = tmp_path / "picture.png"
    result = run("preview", path, "--out", out, "--image", demo_folder / "yellowstone_road.png")
    assert result.exit_code == 0, result.output
    assert out.read_bytes().startswith(b"\x89PNG")
    assert run("preview", path, "--out", out).exit_code == 2
    other = run("preview", path, "--out", out, "--image", out)
    assert other.exit_code == 2 and "not the image that was classified" in other.output


JOB = """\
textures:
  - image: photo.png
    seeds:
      polygons:
        grass_green: [[[1, 1]]]
"""


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("grass_green", "gras_green", "5:9: textures.0.seeds.polygons.gras_green.*did you mean 'grass_green'"),
        ("image:", "picture:", "2:5: .*unknown key 'picture'"),
        ("polygons:", "polygon:", "4:7: .*unknown key 'polygon'; did you mean 'polygons'"),
        ("[[[1, 1]]]", "[]", "found no polygon"),
        ("[[[1, 1]]]", "[[[1, .nan]]]", "5:28: .*finite number"),
        ("[[[1, 1]]]", "[[[1]]]", "5:"),
        ("    seeds:", "    alpha: keep\n    seeds:", "3:12: .*'no-data' or 'ignore'"),
        ("    seeds:", "    classifier: {radius: 128}\n    seeds:", "3:26: .*less than or equal to 127"),
        ("    seeds:", "    name: ../up\n    seeds:", "3:11: .*pattern"),
        ("photo.png", "missing.png", "missing.png: does not exist"),
        ("textures:\n", "textures: []\nold:\n", "unknown key 'old'"),
    ],
)
def test_wrong_jobs(run, tmp_path, old, new, message):
    import re

    path = tmp_path / "job.yaml"
    path.write_text(JOB.replace(old, new))
    result = run("classify", path)
    assert result.exit_code == 2
    assert re.search(message, result.output) and result.output.count("\n") == 1, result.output


def test_palette_of_bare_digits(run, tmp_path):
    path = tmp_path / "job.yaml"
    path.write_text(
        "textures:\n  - image: a.png\n    seeds:\n      labels: {image: b.png, palette: {323232: grass_green}}\n"
    )
    result = run("check", path)
    assert result.exit_code == 2 and '"#RRGGBB" (in quotes)' in result.output


def test_two_textures_of_one_name(run, tmp_path):
    path = tmp_path / "job.yaml"
    path.write_text(JOB + JOB.split("\n", 1)[1])
    result = run("check", path)
    assert result.exit_code == 2 and "two textures named 'photo'" in result.output


@pytest.mark.parametrize(
    "old, new",
    [
        ("image: photo.png", "image: ../photo.png"),
        ("polygons:\n        grass_green: [[[1, 1]]]", "file: a/../../seeds.json"),
        ("polygons:\n        grass_green: [[[1, 1]]]", "labels: {image: ../labels.png, palette: {'1': grass_green}}"),
        ("seeds:\n      polygons:\n        grass_green: [[[1, 1]]]", "model: ../a.tmm-model.h5"),
        (
            "seeds:\n      polygons:\n        grass_green: [[[1, 1]]]",
            "rules: {layers: {height: ../h.tif}, rules: [{material: grass_green}]}",
        ),
    ],
)
def test_paths_out_of_the_folder(run, tmp_path, monkeypatch, old, new):
    monkeypatch.setenv("SKYSHINE_ALLOW_OUTSIDE", "0")
    (tmp_path / "in").mkdir()
    path = tmp_path / "in" / "job.yaml"
    path.write_text(JOB.replace(old, new))
    result = run("check", path)
    assert result.exit_code == 2 and "leads out of the job's folder" in result.output and result.output.count("\n") == 1
    allowed = run("check", path, "--allow-outside")
    assert allowed.exit_code == 2 and "does not exist" in allowed.output


@pytest.mark.parametrize(
    "way, warning",
    [
        ("seeds: {polygons: {water_fresh: [[[1, 1], [9, 1], [9, 9]]]}}", "all seeds are of one material"),
        ("rules: {rules: [{material: water_fresh, when: {hue: {at_least: 400}}}]}", "no rule matches anywhere"),
        ("palette: {colours: {'50': water_fresh}}", None),
    ],
)
def test_what_is_probably_not_meant_is_said(run, tmp_path, write_image, way, warning):
    image = write_image("index.png", np.full((16, 16, 1), 50, np.uint8))
    (tmp_path / "job.yaml").write_text(f"textures: [{{image: {image}, {way}}}]\n")
    result = run("classify", tmp_path / "job.yaml", "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert ("warning: " in result.output) == (warning is not None) and (warning or "") in result.output


def test_init_names_the_schema_by_which_editors_complete_a_job(tmp_path):
    result = CliRunner().invoke(main, ["init", str(tmp_path)])
    assert result.exit_code == 0, result.output
    first = (tmp_path / "job.tmm.yaml").read_text(encoding="utf-8").splitlines()[0]
    assert first == "# yaml-language-server: $schema=tmm-job.schema.json"
    assert (tmp_path / "tmm-job.schema.json").read_bytes() == schemas.path("tmm-job.schema.json").read_bytes()
    again = CliRunner().invoke(main, ["init", str(tmp_path)])
    assert again.exit_code == 2 and "exists already; name an empty folder" in again.stderr
