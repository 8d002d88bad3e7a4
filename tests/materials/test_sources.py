"""Kinds of source: what begins how, what may be a definition, and that the library keeps to both."""

import re
from dataclasses import replace

import pytest

from mat.maintain.materials import sources
from mat.maintain.materials.sources import SPECTRUM, count_kinds, kind_of
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

# Of library 1.6.0; of the 3,108 values of 1.4.0 881 were "chosen" and 202 an "estimate". The share may fall, not rise.
MOST_ESTIMATES = 187 / 3178


@pytest.fixture(scope="module")
def library():
    return load_library()


@pytest.mark.parametrize(
    "source, kind",
    [
        ("[oke1987] table 2.1", "cited"),
        ("derived: heat crosses it in 13 s", "derived"),
        ("derived from [coxmunk1954] at 3 m s-1", "derived"),
        ("definition: dry surface", "definition"),
        ("estimate: broad sheen", "estimate"),
        ("user", "user"),
    ],
)
def test_kind_is_how_a_source_begins(source, kind):
    assert kind_of(source) == kind


@pytest.mark.parametrize("source", ["chosen: usual sheet", "estimated", "users", "table 2.1 of [oke1987]", ""])
def test_source_of_no_kind_is_refused_in_words(source):
    with pytest.raises(InputError, match=r"allowed: \[reference\]"):
        kind_of(source)


# The values that a definition may stand behind: those with which the file would be of another object, in another place
# or state, and which no sample of the substance has.
_OBJECT = re.compile(
    r"(skin|layers\.\d)\.thickness|back\.\w+|operated\.\w+\.\w+|surface\.(exposure|canopy|snow)|soil\.layers|stand\.soil"
)


def may_be_defined(material, field):
    """Whether a definition may stand behind a field of a material, as `materials/README.md` says.

    Of an object or its state: thicknesses, what lies behind, exposure, whether leaves or snow, what leaves stand on;
    wetness, and a resistance that is without effect; the roughness of a plate, roof or wall, which is a class; a lobe's
    width where nothing is in the lobe. All else is a property of the substance, which somebody can measure.
    """
    surface = material.surface
    if field == "surface.roughness_length":
        return surface.exposure != "field"
    if field == "surface.surface_resistance":
        return surface.wetness == 0 or surface.surface_resistance == 0
    if field == "lobe_fwhm":
        return material.specular_fraction == 0
    return field == "surface.wetness" or _OBJECT.fullmatch(field) is not None


def test_definitions_stand_behind_objects_and_not_behind_substances(library):
    wrong = [
        (material.name, field)
        for material in library
        for field, source in material.sources.items()
        if field != SPECTRUM and kind_of(source) == "definition" and not may_be_defined(material, field)
    ]
    assert wrong == []


def test_what_a_sample_could_tell_is_no_definition(library):
    concrete = library["concrete"]
    for field in ("skin.conductivity", "layers.1.density", "layers.2.heat_capacity", "specular_fraction", "lobe_fwhm"):
        assert not may_be_defined(concrete, field), field
    assert not may_be_defined(concrete, "surface.roughness_length")  # of a field, it is measured
    roof = replace(concrete, surface=replace(concrete.surface, exposure="roof"))
    assert may_be_defined(roof, "surface.roughness_length")
    wet = replace(concrete, surface=replace(concrete.surface, wetness=1.0, surface_resistance=50.0))
    assert may_be_defined(concrete, "surface.surface_resistance") != may_be_defined(wet, "surface.surface_resistance")


def test_numbers_without_a_source_do_not_rise(library):
    counts = count_kinds(library)
    values = sum(count.total() for count in counts.values())
    assert sum(count["estimate"] for count in counts.values()) <= MOST_ESTIMATES * values
    assert sum(count["user"] for count in counts.values()) == 0
    for field in ("skin.conductivity", "skin.density", "skin.heat_capacity", "layers.conductivity"):
        assert counts[field]["cited"] > 20 * counts[field]["estimate"], field


def test_the_table_counts_every_value_once(library, capsys):
    sources.main()
    last = capsys.readouterr().out.strip().splitlines()[-1].split()
    values = sum(len(material.sources) - 1 for material in library)  # but for the spectrum
    assert last[0] == "all" and sum(map(int, last[1:])) == values
    counts = count_kinds(library)
    assert counts["back.kind"] == {"definition": len(library)}
