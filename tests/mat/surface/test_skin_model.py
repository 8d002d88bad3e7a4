"""The casadi column under a record: the solver's temperatures, and derivatives by every parameter."""

import numpy as np
import planted_skin
import pytest

from skyshine.mat.surface.column import from_record
from skyshine.mat.surface.free_parameters import PARAMETERS, free_parameters, with_numbers
from skyshine.mat.surface.skin_model import SkinModel, start_shares
from skyshine.schemas.errors import InputError

RECORD = planted_skin.weather(3, step=1800.0)


@pytest.mark.parametrize(
    "name, values",
    [
        ("soil_loam_brown", {"albedo": 0.4, "conductivity": 0.9, "heat_capacity": 1400.0, "roughness_length": 0.05}),
        ("sand_wet", {"wetness": 0.3, "surface_resistance": 200.0, "back_temperature": 280.0}),
        ("grass_green", {"surface_resistance": 90.0, "emissivity": 0.9}),
        ("concrete", {"thickness": 0.08, "wetness": 0.4}),
        ("roof_gravel", {"roughness_length": 0.004}),
        ("paint_olive_on_aluminium", {"albedo": 0.5}),
        ("conifer", {"roughness_length": 0.6, "surface_resistance": 60.0}),
    ],
)
def test_temperatures_are_the_solvers(name, values):
    material = planted_skin.library(name)
    parameters = free_parameters(material, list(values), 288.0)
    shares = np.array([each.share(values[each.name]) for each in parameters])
    found, _ = SkinModel(material, RECORD, parameters).temperatures(shares)
    solver = from_record(with_numbers(material, values), RECORD, 0.0, 0.0, None, 0.2).temperature
    assert np.sqrt(np.mean((found - solver) ** 2)) < 0.02
    assert np.abs(found - solver).max() < 0.1


@pytest.mark.parametrize("name, step", [("concrete", 7200.0), ("maize", 3600.0)])
def test_coarse_records_are_solved_between_their_times(name, step):
    """Over maize Newton's whole steps go to and fro across a bend of the balance."""
    material, record = planted_skin.library(name), planted_skin.weather(4, step)
    found, _ = SkinModel(material, record, ()).temperatures(np.zeros(0))
    solver = from_record(material, record, 0.0, 0.0, None, 0.2).temperature
    assert np.sqrt(np.mean((found - solver) ** 2)) < 0.05


@pytest.mark.parametrize(
    "name, free",
    [
        ("sand_wet", [each for each in PARAMETERS if each != "thickness"]),
        ("grass_green", ["albedo", "roughness_length", "surface_resistance", "wetness"]),
        ("concrete", ["thickness", "wetness", "conductivity"]),
        ("roof_gravel", ["roughness_length", "back_temperature"]),
    ],
)
def test_derivatives_are_those_of_the_temperatures(name, free):
    material = planted_skin.library(name)
    parameters = free_parameters(material, free, 288.0)
    model = SkinModel(material, planted_skin.weather(2), parameters)
    shares = np.clip(start_shares(parameters) + 0.013, 0.1, 0.9)  # beside the bends of laws at tabled roughnesses
    _, whole = model.temperatures(shares)
    derivatives = model.derivatives(shares, whole)
    for index, each in enumerate(parameters):
        step = 1e-4 * np.eye(len(shares))[index]
        after, before = (model.temperatures(shares + sign * step, whole)[0] for sign in (1, -1))
        numerical = (after - before) / 2e-4
        assert derivatives[:, index] == pytest.approx(numerical, abs=1e-3 * np.abs(numerical).max() + 1e-5), each.name


def test_snow_is_refused():
    with pytest.raises(InputError, match="snow; allowed: surfaces that do not melt"):
        SkinModel(planted_skin.library("snow_fine"), RECORD, ())
