"""Lists of answered places: the texels that they name, and what is wrong with them at its line and column."""

import numpy as np
import pytest

from skyshine.schemas.errors import InputError
from skyshine.tmm.images.texture import Texture
from skyshine.tmm.inputs.answers import Answer, disk, read_answers, to_text
from skyshine.tmm.inputs.load import job_files, load_texture
from skyshine.tmm.inputs.polygons import polygon_mask
from skyshine.tmm.job.model import TextureJob

GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def listed(tmp_path):
    def write(*entries, name="answers.yaml"):
        path = tmp_path / name
        path.write_text("answers:\n" + "".join(f"  - {{{entry}}}\n" for entry in entries))
        return path

    return write


def _job(image="halves.png", **seeds):
    return TextureJob.model_validate({"image": image, "seeds": {"suggested": "answers.yaml", **seeds}})


@pytest.mark.parametrize("radius", [0, 1, 2, 5, 8])
@pytest.mark.parametrize("x, y", [(20, 18), (0, 0), (49, 39), (3, 39)])
def test_a_disk_holds_the_texels_within_its_radius(x, y, radius):
    texture = Texture(np.zeros((40, 50, 3), np.uint8), np.ones((40, 50), bool), "srgb")
    mask = polygon_mask((disk(Answer(number=1, x=x, y=y, radius=radius), 50, 40),), texture, 0, 0, (40, 50))
    distance = np.hypot(*np.meshgrid(np.arange(50) - x, np.arange(40) - y))
    assert mask[distance <= radius].all() and not mask[distance > radius + 0.8].any()


def test_answers_are_seeds_and_the_others_are_none(two_halves, listed, tmp_path, library):
    listed(
        f"number: 1, x: 9, y: 9, radius: 3, material: {GREEN}",
        "number: 2, x: 20, y: 10, radius: 3, material: skip",
        f"number: 3, x: 30, y: 9, radius: 0, material: {GREY}",
        "number: 4, x: 5, y: 15, radius: 3, material: null",
        "number: 5, x: 5, y: 3, radius: 1, material: unknown",
    )
    job = _job(two_halves)
    seeds = load_texture(job, tmp_path, library)[3]
    assert {*seeds.names[:-1]} == {GREEN, GREY} and seeds.names[-1] == "unknown" and seeds.answered.all()
    assert job_files(job, tmp_path) == {"answers.yaml": tmp_path / "answers.yaml"}
    found = {name: (seeds.material == k) for k, name in enumerate(seeds.names)}
    # Of i^2 + j^2 <= 9 the circle problem of Gauss gives 29; corners stand in some of the texels beside them.
    assert 29 <= found[GREEN].sum() <= 45 and found[GREY].sum() == 1
    assert (np.hypot(seeds.rows[found[GREEN]] - 9, seeds.columns[found[GREEN]] - 9) < 3.8).all()


def test_answers_stand_beside_polygons_and_as_overrides(two_halves, listed, tmp_path, library, build):
    listed(f"number: 7, x: 30, y: 15, radius: 2, material: {GREEN}")
    square = [[[25, 1], [35, 1], [35, 8], [25, 8]]]
    assert set(load_texture(_job(two_halves, polygons={GREY: square}), tmp_path, library)[3].names) == {GREEN, GREY}
    job = TextureJob.model_validate({"image": two_halves, "material": GREY, "overrides": {"suggested": "answers.yaml"}})
    code = build(job).code
    assert code[15, 30] == library[GREEN].code and code[15, 33] == library[GREY].code


@pytest.mark.parametrize(
    "entries, line, column, words",
    [
        (["number: 1, x: 3, y: 3, material: gras_green"], 2, 39, "did you mean 'grass_green'"),
        (
            ["number: 1, x: 3, y: 3", "number: 1, x: 9, y: 9"],
            3,
            14,
            "number 1 twice; allowed: each once; see line 2",
        ),
        (["number: 0, x: 3, y: 3"], 2, 14, "greater than or equal to 1"),
        (["number: one, x: 3, y: 3"], 2, 14, "valid integer"),
        (["number: 1, x: 40, y: 3"], 2, 20, "found x 40; allowed: 0 to 39"),
        (["number: 1, x: 3, y: 20"], 2, 26, "found y 20; allowed: 0 to 19"),
        (["number: 1, x: -1, y: 3"], 2, 20, "greater than or equal to 0"),
        (["number: 1, x: .nan, y: 3"], 2, 20, "found nan"),
        (["number: 1, x: 3, y: 3, radius: 5000"], 2, 37, "4096"),
        (["number: 1, x: 3, y: 3, name: grass_green"], 2, 29, "unknown key 'name'"),
        (["number: 1, y: 3"], 2, 5, "the key 'x' is missing"),
    ],
)
def test_what_is_wrong_is_shown_at_its_place(two_halves, listed, tmp_path, library, entries, line, column, words):
    path = listed(*entries)
    with pytest.raises(InputError) as caught:
        load_texture(_job(two_halves), tmp_path, library)
    assert (caught.value.file, caught.value.line, caught.value.column) == (path, line, column)
    assert words in str(caught.value) and "\n" not in str(caught.value)


def test_a_list_without_names_or_not_yet_written(two_halves, listed, tmp_path, library):
    with pytest.raises(InputError, match="not there yet; let 'tmm suggest' write it"):
        load_texture(_job(two_halves), tmp_path, library)
    listed("number: 1, x: 3, y: 3, material: null", "number: 2, x: 9, y: 3, material: skip")
    with pytest.raises(InputError, match=r"no place of answers.yaml has a material yet"):
        load_texture(_job(two_halves), tmp_path, library)
    listed("number: 1, x: 3, y: 3, material: unknown")
    with pytest.raises(InputError, match="seeds of unknown alone; name a material"):
        load_texture(_job(two_halves), tmp_path, library)


def test_a_written_list_reads_back(tmp_path):
    answers = [Answer(number=3, x=1, y=2, radius=4, material="skip"), Answer(number=9, x=5, y=6)]
    path = tmp_path / "list.yaml"
    path.write_text(to_text(answers, {9: 0.0123}, "sheet"))
    assert read_answers(path) == answers
    assert "material: null}  # expected gain 1.23 %" in path.read_text()
