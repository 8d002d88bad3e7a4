"""``tmm suggest``: from nothing to a map, by answering what it asks."""

import json
import re

import numpy as np
import pytest

from skyshine.tmm.images.raster import read_channels
from skyshine.tmm.inputs.answers import read_answers

FIELDS = ("grass_green", "asphalt_road", "water_fresh")


@pytest.fixture
def fields(tmp_path, write_image):
    """A sheet of three fields, the third a small pond, and what each texel is."""
    truth = np.zeros((120, 160), int)
    truth[:, 90:] = 1
    truth[10:40, 10:50] = 2
    colours = np.array([[60, 140, 50], [120, 120, 125], [30, 60, 110]])[truth]
    noise = np.random.default_rng(0).normal(0, 5, colours.shape)
    write_image("fields.png", np.clip(colours + noise, 0, 255).astype(np.uint8))
    (tmp_path / "job.yaml").write_text("textures: [{image: fields.png, seeds: {suggested: '{name}.list.yaml'}}]\n")
    return tmp_path, truth


def _fill(path, truth, names=FIELDS):
    """Answer what is asked by what is there."""
    text = path.read_text()
    for answer in read_answers(path):
        start = f"number: {answer.number}, x: {answer.x}, y: {answer.y}, radius: {answer.radius}, material: "
        text = text.replace(start + "null", start + names[truth[answer.y, answer.x]])
    path.write_text(text)


def test_from_nothing_to_a_map(run, fields):
    folder, truth = fields
    job, path = folder / "job.yaml", folder / "fields.list.yaml"
    asked = run("suggest", job, "--count", 6)
    assert asked.exit_code == 0, asked.output
    assert "0 answers so far, nothing is known yet" in asked.output and "label patches 1 to 6" in asked.output
    unfilled = run("check", job)
    assert unfilled.exit_code == 2 and "no place of fields.list.yaml has a material yet" in unfilled.output
    first = read_answers(path)
    assert {truth[answer.y, answer.x] for answer in first} == {0, 1, 2}  # also the pond, a sixteenth of the sheet
    _fill(path, truth)
    report = json.loads(run("check", job, "--json").output)["textures"][0]
    assert set(report["seed_texels"]) == set(FIELDS) and all(report["seed_texels"].values())
    again = json.loads(run("suggest", job, "--count", 3, "--json").output)["textures"][0]
    assert again["answered"] == 6 and [entry["number"] for entry in again["questions"]] == [7, 8, 9]
    assert again["expected_wrong"]["value"] < 0.5
    answers = read_answers(path)
    assert [answer.material for answer in answers[:6]] == [FIELDS[truth[each.y, each.x]] for each in first]
    assert [answer.material for answer in answers[6:]] == [None] * 3
    places = {(answer.x, answer.y) for answer in answers}
    assert len(places) == 9
    _fill(path, truth)
    assert run("classify", job).exit_code == 0
    listed = json.loads(run("preview", folder / "build" / "fields.tmm.h5", "--json").output)["materials"]
    share = {material["name"]: material["share"]["value"] for material in listed}
    for k, name in enumerate(FIELDS):
        assert share[name] == pytest.approx((truth == k).mean(), abs=0.04)


def test_gain_gets_small_and_it_says_so(run, fields):
    folder, truth = fields
    gains = []
    for _ in range(6):
        report = json.loads(run("suggest", folder / "job.yaml", "--count", 8, "--json").output)["textures"][0]
        gains.append(report["expected_gain"]["value"])
        if report["small"]:
            break
        _fill(folder / "fields.list.yaml", truth)
    assert report["small"] and gains[-1] < 0.01 < gains[0] <= 1
    assert "the expected gain is small" in run("suggest", folder / "job.yaml", "--count", 8).output


def test_what_is_skipped_is_not_asked_again(run, fields):
    folder, _ = fields
    path = folder / "fields.list.yaml"
    run("suggest", folder / "job.yaml", "--count", 5)
    path.write_text(path.read_text().replace("null}", "skip}", 3).replace("null}", "unknown}"))
    skipped = read_answers(path)
    assert [answer.material for answer in skipped] == ["skip"] * 3 + ["unknown"] * 2
    assert run("suggest", folder / "job.yaml", "--count", 5).exit_code == 0
    answers = read_answers(path)
    assert answers[:5] == skipped and len(answers) == 10
    for answer in answers[5:]:
        assert all(np.hypot(answer.x - other.x, answer.y - other.y) > 3 for other in skipped)


def test_pictures(run, fields):
    folder, _ = fields
    run("suggest", folder / "job.yaml", "--out", folder / "out", "--count", 7)
    assert sorted(file.name for file in (folder / "out").iterdir()) == ["fields.suggest.html", "fields.suggest.png"]
    picture = read_channels(folder / "out" / "fields.suggest.png")
    red = (picture[..., :3] == (255, 42, 42)).all(axis=-1)
    assert red.sum() > 100  # circles
    page = (folder / "out" / "fields.suggest.html").read_text()
    assert not re.search(r'(src|href)="(?!data:)', page) and "http" not in page
    assert page.count("<input ") == 7 and "<option>grass_green</option>" in page
    assert "number: 7, x: " in page and page.count("data:image/png;base64,") == 8


def test_a_list_of_somebody_else_is_not_lost(run, fields):
    folder, _ = fields
    job = folder / "other.yaml"
    seeds = "{polygons: {grass_green: [[[70, 70], [80, 80], [70, 80]]]}}"
    job.write_text(f"textures: [{{image: fields.png, seeds: {seeds}}}]\n")
    assert run("suggest", job).exit_code == 0
    mine = (folder / "fields.answers.yaml").read_text()
    refused = run("suggest", job)
    assert refused.exit_code == 2 and "add 'suggested: fields.answers.yaml' to its seeds" in refused.output
    assert (folder / "fields.answers.yaml").read_text() == mine


@pytest.mark.parametrize(
    "way, words",
    [
        ("material: asphalt_road", "has its materials by material; allowed for suggestions: seeds, model, clusters"),
        ("seeds: {suggested: ../list.yaml}", "leads out of the job's folder"),
        ("seeds: {}", "allowed: polygons, file, labels, suggested"),
    ],
)
def test_failures(run, fields, way, words):
    folder, _ = fields
    (folder / "bad.yaml").write_text(f"textures: [{{image: fields.png, {way}}}]\n")
    result = run("suggest", folder / "bad.yaml")
    assert result.exit_code == 2 and words in result.output and "Traceback" not in result.output


def test_a_wrong_name_is_shown_at_its_line(run, fields):
    folder, _ = fields
    path = folder / "fields.list.yaml"
    path.write_text("answers:\n  - {number: 1, x: 70, y: 70, radius: 4, material: watr_fresh}\n")
    for command in ("check", "suggest", "classify"):
        result = run(command, folder / "job.yaml")
        assert result.exit_code == 2
        assert "fields.list.yaml:2:52: " in result.output and "did you mean 'water_fresh'" in result.output


def test_tiny_and_empty_textures(run, tmp_path, write_image):
    write_image("one.png", np.full((1, 1, 3), 90, np.uint8))
    write_image("none.png", np.zeros((8, 8, 4), np.uint8))
    for name in ("one", "none"):
        (tmp_path / f"{name}.yaml").write_text(
            f"textures: [{{image: {name}.png, seeds: {{suggested: {name}.l.yaml}}}}]\n"
        )
    assert run("suggest", tmp_path / "one.yaml").exit_code == 0
    assert len(read_answers(tmp_path / "one.l.yaml")) == 1
    result = run("suggest", tmp_path / "none.yaml")
    assert result.exit_code == 2 and "has no texel with data" in result.output
