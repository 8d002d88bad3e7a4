"""The solver's error that a table of temperatures states, against twice as many steps as it compares with."""

import numpy as np
import pytest

from skyshine.mat.api.examples import starter_files
from skyshine.mat.job.load import load_job
from skyshine.mat.products.temperature import Solver, _errors, _rules
from skyshine.mat.scene.surface import scene_inputs, surface_materials
from skyshine.materials.library import load_library

PLACES = {
    "altitude_km": np.array([2.4, 3.7]),
    "azimuth_deg": np.array([20.0, 75.0, 140.0, 260.0]),
    "slope_deg": np.array([12.0, 55.0, 90.0, 128.0]),
    "time_h": np.arange(48) / 2 + 0.21,
}


@pytest.fixture(scope="module")
def solver():
    job = load_job(next(file for file in starter_files() if file.name == "job.yaml")).trimmed
    library = load_library()
    materials = surface_materials([library[name] for name in ("concrete", "grass_green", "paint_grey_on_metal")], {})
    return Solver(materials, scene_inputs(job, 1), {})


@pytest.mark.parametrize("steps", [96, 192])
def test_stated_error_is_near_that_against_576_steps(solver, steps):
    axes = {name: values[[0, -1]] for name, values in PLACES.items()}
    table = solver.table(axes, steps)
    _, stated = _errors(solver, table, _rules([1, 2, 3], axes, True), PLACES, steps)
    lowest = PLACES | {"altitude_km": PLACES["altitude_km"][:1]}
    few, many = (solver.table(lowest, count).temperature.astype(float) for count in (steps, 576))
    actual = np.sqrt(np.mean((few - many) ** 2)) / (1 - (steps / 576) ** 2)
    assert actual / 1.5 < stated.rms < 2 * actual


def test_the_finest_steps_state_an_error_too(solver):
    axes = {name: values[[0, -1]] for name, values in PLACES.items()}
    rules = _rules([1, 2, 3], axes, True)
    rms = [_errors(solver, solver.table(axes, steps), rules, PLACES, steps)[1].rms for steps in (288, 96)]
    assert 0 < rms[0] < rms[1]
