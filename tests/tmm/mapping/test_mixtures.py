"""Mixtures by ratio: from the job to the levels of the database and its readers."""

import numpy as np
import pytest
import yaml
from click.testing import CliRunner

from skyshine.tmm import open_tmm, read_usage
from skyshine.tmm.cli import main
from skyshine.tmm.database.levels import WEIGHT_TOTAL
from skyshine.tmm.job.materials import is_mixture, parts_of
from skyshine.tmm.job.model import TextureJob, stored_job

ROAD, GRASS, SOIL = "asphalt_road", "grass_dry", "soil_sand"
VERGE = {ROAD: 60, GRASS: 40}


def shares(path, level=0):
    """Share of each material in each texel of a level, by name."""
    with open_tmm(path) as file:
        codes, weights = (file.array(f"levels/{level}/{name}") for name in ("mix_code", "mix_weight"))
        return {
            name: np.where(codes == code, weights, 0).sum(axis=-1) / WEIGHT_TOTAL
            for code, name in file.materials.items()
        }


@pytest.fixture
def index_image(write_image):
    """4 x 4 grey levels: 7 above, 3 on the lower left, 9, which no palette has, on the lower right."""
    values = np.full((4, 4, 1), 7, np.uint8)
    values[2:, :2], values[2:, 2:] = 3, 9
    return write_image("index.png", values)


def test_composites_of_a_palette_become_mixtures(index_image, build):
    job = TextureJob.model_validate({"image": index_image, "palette": {"colours": {"7": VERGE, "3": SOIL}}})
    result = build(job)
    with open_tmm(result.path) as file:
        by_name = {name: code for code, name in file.materials.items()}
        assert set(by_name) == {ROAD, GRASS, SOIL}
        assert file.array("levels/0/mix_code")[0, 0].tolist() == [by_name[ROAD], by_name[GRASS], 0]
        assert file.array("levels/0/mix_weight")[0, 0].tolist() == [39321, 26214, 0]  # 65535 x .6 and .4, no remainder
        assert (result.code[:2] == by_name[ROAD]).all() and (result.code[2:, 2:] == 0).all()
        composites = {
            (*codes, *weights)
            for codes, weights in zip(
                file.array("composites/code").tolist(), file.array("composites/weight").tolist(), strict=True
            )
        }
        assert (by_name[ROAD], by_name[GRASS], 0, 60, 40, 0) in composites
        assert file.group_attributes("usage")["texels_with_material"] == 12
    # Of 16 texels with data 8 are the mixture and 4 soil; the top of the pyramid has the shares of those 12.
    assert read_usage(result.path) == pytest.approx({ROAD: 8 * 0.6 / 16, GRASS: 8 * 0.4 / 16, SOIL: 4 / 16})
    top = {name: float(share[0, 0]) for name, share in shares(result.path, 2).items()}
    assert top == pytest.approx({ROAD: 8 * 0.6 / 12, GRASS: 8 * 0.4 / 12, SOIL: 4 / 12}, abs=1.01 / WEIGHT_TOTAL)


def test_mixtures_in_the_other_ways(index_image, write_image, build, library):
    third = {ROAD: 1, GRASS: 1, SOIL: 1}
    whole = build(TextureJob.model_validate({"image": index_image, "material": third}))
    assert all(share == pytest.approx(1 / 3, abs=1e-5) for share in (s[0, 0] for s in shares(whole.path).values()))
    rules = {"rules": [{"material": VERGE, "when": {"red": {"below": 5 / 255}}}, {"material": SOIL}]}
    ruled = build(TextureJob.model_validate({"image": index_image, "rules": rules}))
    assert shares(ruled.path)[GRASS].tolist()[3] == pytest.approx([0.4, 0.4, 0, 0], abs=1e-5)
    clusters = {"count": 3, "names": {1: VERGE, 3: SOIL}}
    grey = write_image("grey.png", np.repeat(np.uint8([[20, 120, 240]] * 3), 8, axis=1)[..., np.newaxis])
    found = build(TextureJob.model_validate({"image": grey, "clusters": clusters, "classifier": {"radius": 0}}))
    assert shares(found.path)[ROAD][0, ::8].tolist() == pytest.approx([0.6, 0, 0], abs=1e-5)
    assert shares(found.path)[SOIL][0, ::8].tolist() == [0, 0, 1]
    painted = np.zeros((4, 4, 1), np.uint8)
    painted[0, 0] = 1
    labels = {"image": write_image("labels.png", painted), "palette": {"1": VERGE}}
    given = build(TextureJob.model_validate({"image": index_image, "material": SOIL, "overrides": {"labels": labels}}))
    assert shares(given.path)[SOIL].ravel().tolist() == [0.0] + [1.0] * 15
    assert shares(given.path)[GRASS][0, 0] == pytest.approx(0.4, abs=1e-5)


def test_a_job_comes_back_as_it_was_written(index_image, build):
    given = {"7": VERGE, "3": SOIL, "1": {SOIL: 5}}
    result = build(TextureJob.model_validate({"image": index_image, "palette": {"colours": given}}))
    with open_tmm(result.path) as file:
        text = file.attributes["job"]
    assert yaml.safe_load(text)["palette"]["colours"] == {"7": VERGE, "3": SOIL, "1": SOIL}
    assert stored_job(text) == result.map.job
    (mixture,) = result.map.job.mixtures
    assert is_mixture(mixture) and parts_of(mixture) == VERGE and list(parts_of(mixture)) == [ROAD, GRASS]


@pytest.mark.parametrize(
    "entry, place, message",
    [
        ("{asphalt_road: 60, grass_drj: 40}", "palette.colours.7", "unknown material 'grass_drj'"),
        ("{asphalt_road: 60, grass_dry: 0}", "palette.colours.7", "found the weight 0 of grass_dry; allowed: whole"),
        ("{asphalt_road: 60.5, grass_dry: 40}", "palette.colours.7", "found the weight 60.5 of asphalt_road"),
        ("{asphalt_road: yes, grass_dry: 40}", "palette.colours.7", "found the weight 'yes' of asphalt_road"),
        ("{asphalt_road: 99999, grass_dry: 40}", "palette.colours.7", "found the weight 99999 of asphalt_road"),
        ("{asphalt_road: .nan}", "palette.colours.7", "found the weight nan of asphalt_road"),
        ("{}", "palette.colours.7", "found a mixture of 0 materials; allowed: 1 to 3"),
        (
            "{asphalt_road: 1, grass_dry: 1, soil_sand: 1, concrete_aged: 1}",
            "palette.colours.7",
            "found a mixture of 4 materials; allowed: 1 to 3",
        ),
        ("[asphalt_road]", "palette.colours.7", "found ['asphalt_road']; allowed: a material, or a mixture"),
        ("60 asphalt_road + 40 grass_dry", "palette.colours.7", "unknown material"),
    ],
)
@pytest.mark.parametrize("command", ["check", "classify"])
def test_wrong_mixtures_are_one_line_with_their_place(index_image, tmp_path, command, entry, place, message):
    (tmp_path / "tmm.yaml").write_text(
        f"textures:\n  - image: {index_image}\n    palette:\n      colours:\n        7: {entry}\n"
    )
    result = CliRunner().invoke(main, [command, str(tmp_path / "tmm.yaml")])
    assert result.exit_code == 2
    (line,) = result.stderr.strip().splitlines()
    assert "tmm.yaml:5:" in line and place in line and message in line


def test_a_seed_names_one_material(two_halves, write_image, tmp_path):
    labels = write_image("labels.png", np.ones((20, 40, 1), np.uint8))
    (tmp_path / "tmm.yaml").write_text(
        f"textures:\n  - image: {two_halves}\n    seeds:\n      labels:\n        image: {labels}\n"
        f"        palette: {{1: {{asphalt_road: 60, grass_dry: 40}}}}\n"
    )
    result = CliRunner().invoke(main, ["check", str(tmp_path / "tmm.yaml")])
    assert result.exit_code == 2 and "tmm.yaml:6:" in result.stderr
    assert "allowed here: one material; mixtures are allowed in material, palette" in result.stderr
