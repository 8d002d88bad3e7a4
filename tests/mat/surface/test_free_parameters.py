"""Parameters of a material that may be free: bounds, what they change, and those without effect."""

from dataclasses import replace

import numpy as np
import planted_skin
import pytest

from skyshine.mat.surface.free_parameters import PARAMETERS, changed_numbers, free_parameters, with_numbers
from skyshine.materials.records import Back
from skyshine.schemas.errors import InputError


def test_a_share_of_the_way_between_bounds():
    albedo, conductivity = free_parameters(planted_skin.library("concrete"), ["albedo", "conductivity"], 288.0)
    assert (conductivity.low, conductivity.high) == (0.01, 10.0) and conductivity.start == 1.51
    assert conductivity.value(0.5) == pytest.approx(np.sqrt(0.01 * 10.0))
    assert albedo.value(0.5) == pytest.approx(0.48)
    for each in (albedo, conductivity):
        assert each.value(each.share(each.start)) == pytest.approx(each.start)
        slope = (each.value(0.3 + 1e-6) - each.value(0.3 - 1e-6)) / 2e-6
        assert each.slope(0.3) == pytest.approx(slope, rel=1e-6)


def test_metals_have_bounds_of_their_own():
    (steel,) = free_parameters(planted_skin.library("steel_bare"), ["conductivity"], 288.0)
    assert steel.low == 10.0 and steel.low < steel.start < steel.high == 450.0


@pytest.mark.parametrize("name", ["concrete", "sand_wet", "grass_green", "deciduous", "roof_gravel", "steel_bare"])
def test_starts_lie_within_the_bounds(name):
    material = planted_skin.library(name)
    for parameter in PARAMETERS:
        try:
            (each,) = free_parameters(material, [parameter], 288.0)
        except InputError:
            continue
        assert each.low <= each.start <= each.high and each.low < each.high


def test_layers_of_the_same_substance_change_together():
    values = {"conductivity": 0.7}
    whole = {f"{part}.conductivity": 0.7 for part in ("skin", "layers.1", "layers.2")}
    assert changed_numbers(planted_skin.library("sand_wet"), values) == whole
    assert set(changed_numbers(planted_skin.library("concrete"), values)) == set(whole) - {"layers.2.conductivity"}
    assert set(changed_numbers(planted_skin.library("grass_green"), values)) == {"layers.1.conductivity"}


def test_numbers_stand_where_they_belong():
    values = {
        "albedo": 0.3,
        "emissivity": 0.9,
        "thickness": 0.2,
        "roughness_length": 0.01,
        "wetness": 0.4,
        "surface_resistance": 60.0,
        "back_temperature": 281.0,
    }
    changed = with_numbers(planted_skin.library("concrete"), values)
    assert (changed.solar_absorptance, changed.thermal_emissivity) == (0.7, 0.9)
    surface, stack = changed.surface, changed.thermal
    assert (surface.roughness_length, surface.wetness, surface.surface_resistance) == (0.01, 0.4, 60.0)
    assert stack.layers[0].thickness == 0.2 and stack.back.temperature == 281.0


@pytest.mark.parametrize(
    "name, free, message",
    [
        ("concrete", [], "found no parameter to free; allowed: albedo, "),
        ("concrete", ["albeddo"], "found the parameter 'albeddo'; did you mean 'albedo'"),
        ("concrete", ["albedo", "albedo"], "twice"),
        ("concrete", ["surface_resistance"], "no effect on material 'concrete': it is dry; free wetness too"),
        ("steel_bare", ["roughness_length"], "no effect on material 'steel_bare': its exposure is 'plate'"),
    ],
)
def test_what_cannot_be_free_is_refused(name, free, message):
    with pytest.raises(InputError, match=message):
        free_parameters(planted_skin.library(name), free, 288.0)


@pytest.mark.parametrize(
    "back, depth, reason",
    [
        (Back("adiabatic"), 1.0, "its back is of kind 'adiabatic'"),
        (Back("fixed"), np.inf, "its second layer has no end"),
    ],
)
def test_a_back_that_is_not_felt_is_refused(back, depth, reason):
    material = planted_skin.library("concrete")
    first, second = material.thermal.layers
    stack = replace(material.thermal, layers=(first, replace(second, thickness=depth)), back=back)
    with pytest.raises(InputError, match=reason):
        free_parameters(replace(material, thermal=stack), ["back_temperature"], 288.0)


def test_wetness_makes_a_resistance_act():
    assert len(free_parameters(planted_skin.library("concrete"), ["wetness", "surface_resistance"], 288.0)) == 2
