"""Words that people use for materials."""

import pytest
from click.testing import CliRunner

from skyshine.mat.cli import main
from skyshine.materials.library import load_library, unknown_material
from skyshine.materials.words import aliases, matches


@pytest.fixture(scope="module")
def names():
    return load_library(None).names


def test_every_alias_names_materials_of_the_library(names):
    for word, meant in aliases().items():
        assert meant and set(meant) <= set(names), word
        assert word not in names and word == word.lower(), word


@pytest.mark.parametrize(
    "word, first",
    [
        ("road", "asphalt_road"),
        ("lawn", "grass_green"),
        ("tree", "deciduous"),
        ("trees", "deciduous"),
        ("Car", "car_paint_white"),
        ("roof", "roof_shingle_asphalt_grey"),
        ("person", "clothing_dark"),
        ("concret", "concrete"),
        ("copper", "copper_bare"),
    ],
)
def test_words_find_materials(names, word, first):
    assert matches(word, names)[0] == first


def test_what_is_nothing_matches_nothing(names):
    assert matches("xyzzy", names) == []


def test_a_message_names_five_and_the_command(names):
    said = unknown_material("roof", names)
    assert said.count("roof_") == 5 and "'mat materials roof' lists what there is" in said and len(said) < 320
    assert "'mat materials' lists what there is" in unknown_material("xyzzy", names)
    assert "did you mean 'asphalt_road'?" in unknown_material("asfalt_road", names)  # a slip of the pen


def test_the_command_lists_what_a_word_may_mean():
    listed = CliRunner().invoke(main, ["materials", "lawn"])
    assert listed.exit_code == 0 and "grass_green" in listed.output and "concrete" not in listed.output
    for word in ("xyzzy", "asfalt_road"):
        nothing = CliRunner().invoke(main, ["materials", word])
        assert nothing.exit_code == 2 and "unknown material" in nothing.stderr
