"""The model that comes with the package, and models narrowed to what a scene holds."""

import numpy as np
import pytest
import yaml
from pydantic import ValidationError

from mat.maintain.textures import library_model
from skyshine.schemas.errors import InputError
from skyshine.tmm.classify.model_file import model_path, read_model, write_model
from skyshine.tmm.features.textured import names as feature_names
from skyshine.tmm.inputs.load import load_texture, narrowed
from skyshine.tmm.job.model import PACKAGED, TextureJob
from skyshine.tmm.mapping.write import is_current

GREEN, GREY = "grass_green", "asphalt_road"


@pytest.fixture
def packaged():
    return read_model(model_path(PACKAGED, "."))


def of(image, **settings):
    return TextureJob.model_validate({"image": image, **settings})


def test_the_packaged_model_knows_materials_of_the_library(packaged, library):
    assert len(packaged.names) >= 8
    assert set(packaged.names) <= set(library.names)
    for material in {"conifer", "grass_green", "asphalt_road"}:
        assert material in packaged.names


def test_its_labels_are_those_that_are_packed(packaged, library):
    folder = library_model.__file__.rsplit("/", 1)[0]
    labelled = set()
    with open(f"{folder}/job.yaml") as file:
        jobs = yaml.safe_load(file)["textures"]
    for job in jobs:
        with open(f"{folder}/{job['seeds']['suggested']}") as file:
            answers = yaml.safe_load(file)["answers"]
        assert len({answer["number"] for answer in answers}) == len(answers)
        labelled |= {answer["material"] for answer in answers} - {"skip", "unknown", None}
    assert labelled == set(packaged.names)
    assert {job["image"] for job in jobs} == set(library_model.PHOTOGRAPHS)


def test_a_photograph_that_was_not_labelled_is_refused(tmp_path):
    for name in library_model.PHOTOGRAPHS:
        (tmp_path / name).write_bytes(b"another")
    with pytest.raises(InputError, match="is not the photograph that was labelled"):
        library_model.train(tmp_path, tmp_path / "model.h5")
    assert not (tmp_path / "model.h5").exists()


def test_a_texture_by_the_packaged_model(two_halves, build, library):
    result = build(of(two_halves, model="library"))
    assert set(np.unique(result.code[:, 5:15])) <= {
        library[name].code for name in ("grass_green", "shrub", "deciduous", "conifer", "grass_dry")
    }
    assert set(result.map.files) == {"library"}


def test_posteriors_among_some_classes_keep_their_ratios(packaged):
    random = np.random.default_rng(0)
    spread = random.normal(0, 0.3, (len(feature_names()), 50)).astype(np.float32)
    stack = packaged.network.mean[:, np.newaxis] + packaged.network.scale[:, np.newaxis] * spread
    kept = [4, 1, 6]
    whole = packaged.network.posterior(stack)[kept].astype(float)
    said = whole.sum(axis=0) > 1e-3
    assert said.sum() > 20
    among = packaged.only(kept).network.posterior(stack)
    np.testing.assert_allclose(among[:, said], (whole / whole.sum(axis=0))[:, said], rtol=1e-3, atol=1e-5)
    assert packaged.only(kept).names == tuple(packaged.names[k] for k in kept)


def test_classes_stand_for_their_name_else_for_their_group_else_for_none(packaged, library):
    wanted = ("conifer", "crop_cereal", "soil_sand", "concrete")
    kept, material = narrowed(of("x.png", model="library", scene_materials=wanted), packaged, library, wanted)
    stands = {packaged.names[k]: wanted[m] for k, m in zip(kept, material, strict=True)}
    assert stands["conifer"] == "conifer" and stands["soil_sand"] == "soil_sand"
    assert stands["grass_green"] == stands["shrub"] == "crop_cereal"
    assert "asphalt_road" not in stands and "wood_pine_weathered" not in stands


def test_a_scene_of_two_materials(two_halves, build, library):
    result = build(of(two_halves, model="library", scene_materials=["maize", GREY]))
    assert result.map.names == tuple(sorted(("maize", GREY), key=lambda name: library[name].code))
    assert (result.code[:, 4:16] == library["maize"].code).mean() > 0.9
    assert set(np.unique(result.code)) <= {library["maize"].code, library[GREY].code}


def test_a_scene_of_which_the_model_knows_nothing_fails_in_the_check(two_halves, tmp_path, library):
    job = of(two_halves, model="library", scene_materials=["water_fresh"])
    with pytest.raises(InputError, match="of which its model knows none; allowed: its classes"):
        load_texture(job, tmp_path, library)


def test_scene_materials_beside_seeds_are_refused():
    seeds = {"polygons": {GREEN: [[[1, 1]]]}}
    with pytest.raises(ValidationError, match="scene_materials beside seeds and model"):
        of("x.png", seeds=seeds, model="library", scene_materials=[GREEN])


def test_another_model_makes_a_database_anew(two_halves, tmp_path, build, library, packaged):
    for name, kept in (("first.h5", [0, 1, 2]), ("second.h5", [1, 3, 5])):
        write_model(packaged.only(kept), tmp_path / name, "test", "test", {})
    (tmp_path / "model.h5").write_bytes((tmp_path / "first.h5").read_bytes())
    job = of(two_halves, model="model.h5")
    path = build(job).path
    assert is_current(path, job, tmp_path, library.version)
    (tmp_path / "model.h5").write_bytes((tmp_path / "second.h5").read_bytes())
    assert not is_current(path, job, tmp_path, library.version)
