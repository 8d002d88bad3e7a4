"""A map measured by answers at places drawn at random."""

import json

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.schemas.errors import InputError
from skyshine.tmm.cli import main
from skyshine.tmm.job.model import TextureJob
from skyshine.tmm.mapping.suggest import draw_at_random
from skyshine.tmm.report.score import check_answers

GREEN, GREY = "grass_green", "asphalt_road"


def run(*arguments):
    return CliRunner().invoke(main, [str(part) for part in arguments])


@pytest.fixture
def answered(build, job, two_halves, tmp_path, library):
    """Writes answers (x, y, material) and checks the map of two halves by them."""

    def check(*places):
        database = build(job(two_halves)).path
        listed = [
            {"number": k, "x": x, "y": y, "radius": 0, "material": material}
            for k, (x, y, material) in enumerate(places, 1)
        ]
        (tmp_path / "check.yaml").write_text(yaml.safe_dump({"answers": listed}))
        return database, check_answers(database, tmp_path / "check.yaml", library)

    return check


def test_right_wrong_and_skipped(answered, tmp_path):
    places = [
        (2, 2, GREEN),
        (30, 3, GREY),
        (35, 5, GREY),
        (3, 9, GREY),
        (3, 10, "skip"),
        (4, 10, None),
        (31, 9, "unknown"),
    ]
    database, found = answered(*places)
    assert (found.answered, found.right, found.skipped) == (5, 3, 2)
    assert found.accuracy == pytest.approx(0.6)
    assert found.wrong == {(GREY, GREEN): 1, ("unknown", GREY): 1}
    # Wilson's interval of 3 of 5, by its formula with z = 1.959964.
    z = 1.959964
    middle, half = (3 + z**2 / 2) / (5 + z**2), z / (5 + z**2) * np.sqrt(3 * 2 / 5 + z**2 / 4)
    assert (found.low, found.high) == pytest.approx((middle - half, middle + half), abs=1e-6)
    assert 0.5 < found.stated <= 1
    text = run("check", database, "--truth", tmp_path / "check.yaml").output
    assert "3 of 5 places are right: accuracy 0.600" in text and "2 places are not answered" in text


def test_nothing_answered_and_places_beyond_the_image(answered):
    with pytest.raises(InputError, match="has no answer yet"):
        answered((2, 2, None), (3, 3, "skip"))
    with pytest.raises(InputError, match=r"check.yaml:.*found x 40; allowed: 0 to 39"):
        answered((40, 2, GREEN))
    with pytest.raises(InputError, match="unknown material 'gras'"):
        answered((4, 2, "gras"))


@pytest.fixture
def drawn(two_halves, tmp_path):
    (tmp_path / "job.yaml").write_text(f"textures:\n  - {{image: {two_halves}, material: {GREEN}}}\n")
    return tmp_path


def test_places_are_drawn_and_asked_again_until_they_are_answered(drawn):
    first = json.loads(run("suggest", drawn / "job.yaml", "--random", "--count", 5, "--json").stdout)["textures"][0]
    assert first["measures"] and len(first["questions"]) == 5 and first["list"].endswith("halves.check.yaml")
    assert all(question["expected_gain"] is None and question["now"] is None for question in first["questions"])
    assert (drawn / "build" / "halves.check.png").exists() and (drawn / "build" / "halves.check.html").exists()
    path = drawn / "halves.check.yaml"
    listed = yaml.safe_load(path.read_text())["answers"]
    listed[1]["material"] = GREEN
    path.write_text(yaml.safe_dump({"answers": listed}))
    again = json.loads(run("suggest", drawn / "job.yaml", "--random", "--count", 7, "--json").stdout)["textures"][0]
    assert [question["number"] for question in again["questions"]] == [1, 3, 4, 5, 6, 7, 8]
    after = {entry["number"]: entry for entry in yaml.safe_load(path.read_text())["answers"]}
    assert {k: (after[k]["x"], after[k]["y"]) for k in range(1, 6)} == {
        entry["number"]: (entry["x"], entry["y"]) for entry in listed
    }
    assert after[2]["material"] == GREEN


def test_every_texel_with_data_is_as_likely(tmp_path, write_image, library):
    values = np.full((40, 30, 4), 255, np.uint8)
    values[:20, :, 3] = 0  # no data above
    job = TextureJob.model_validate({"image": write_image("half.png", values), "material": GREEN})
    places = [(q.answer.x, q.answer.y) for q in draw_at_random(job, tmp_path, library, 2000).questions]
    columns, rows = np.array(places).T
    assert rows.min() >= 20
    for at, size in ((columns, 30), (rows - 20, 20)):
        expected = 2000 / size
        assert (((np.bincount(at, minlength=size) - expected) ** 2) / expected).sum() < 2.2 * size  # chi squared


def test_no_data_anywhere(tmp_path, write_image, library):
    job = TextureJob.model_validate(
        {"image": write_image("none.png", np.zeros((4, 4, 4), np.uint8)), "material": GREEN}
    )
    with pytest.raises(InputError, match="hardly any texel with data"):
        draw_at_random(job, tmp_path, library, 3)
