"""The ground of a state in a sensor's band."""

from dataclasses import replace

import numpy as np
import pytest
import yaml

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.products.atmosphere import AtmosphereProduct
from skyshine.mat.products.product import Context
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import response_of
from skyshine.mat.scene.ground import band_albedo, over_ground
from skyshine.materials.library import load_library


@pytest.fixture
def load(tiny_job):
    def make(**keys):
        content = yaml.safe_load(tiny_job())
        content["states"][0].update(keys)
        content["materials"] = ["brick_red"]  # no ground by default
        content["surface_grid"]["time"] = ["00:00", "12:00"]
        return load_job(content)

    return make


def test_a_material_gives_the_ground_its_reflectance_in_the_band(load):
    """10.0 to 10.2 um: the mean of the material's own spectrum there."""
    job = load(ground_material="sand_desert").trimmed
    sand = load_library()["sand_desert"]
    wavelength = np.linspace(10.0, 10.2, 2001)
    expected = np.interp(wavelength, sand.wavelength, sand.reflectance).mean()
    response = response_of(job.bands[0])
    assert band_albedo(job.states[0], response, load_library()) == pytest.approx(expected, rel=1e-3)
    air = over_ground(atmospheric_state(job.site, job.states[0]), job.states[0], response, load_library())
    assert air.mean_albedo == pytest.approx(expected, rel=1e-3)
    seen = air.albedo_at(1e4 / wavelength[::500])
    np.testing.assert_allclose(seen, np.interp(wavelength[::500], sand.wavelength, sand.reflectance), rtol=1e-9)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [({}, 0.1), ({"surface_albedo": 0.3}, 0.3), ({"surface_albedo": 0.1, "ground_material": "sand_desert"}, 0.1)],
)
def test_an_albedo_that_is_written_stays(load, keys, expected):
    job = load(**keys).trimmed
    assert band_albedo(job.states[0], response_of(job.bands[0]), load_library()) == expected


def test_tables_of_a_written_and_of_a_material_albedo_are_told_apart(load):
    def header(**keys):
        loaded, library = load(**keys), load_library()
        plan = make_plan(loaded, library)
        task = next(task for task in plan.tasks if task.kind is Kind.ATMOSPHERE)
        return AtmosphereProduct().identity(Context(task, loaded, plan.materials, library))[0].header.job

    sand = {"ground_material": "sand_desert"}
    assert header(**sand) != header(**sand, surface_albedo=0.1)
    assert header() == header(surface_albedo=0.1) and "ground_reflectance" not in header()
    assert header() == header(surroundings={"horizon_deg": 30})


def test_a_changed_spectrum_with_the_same_mean_is_another_table(load, monkeypatch):
    """Two grounds of one mean reflectance light the air differently; a kept file of one must not serve the other."""
    from skyshine.mat.products import atmosphere
    from skyshine.mat.scene.ground import ground_albedo

    loaded, library = load(ground_material="sand_desert"), load_library()
    plan = make_plan(loaded, library)
    task = next(task for task in plan.tasks if task.kind is Kind.ATMOSPHERE)

    def header():
        return AtmosphereProduct().identity(Context(task, loaded, plan.materials, library))[0].header.job

    before = header()
    real = ground_albedo(loaded.trimmed.states[0], response_of(loaded.trimmed.bands[0]), load_library())
    other = replace(real, reflectance=real.reflectance[::-1].copy())
    monkeypatch.setattr(atmosphere, "ground_albedo", lambda state, response, library: other)
    assert header() != before
