"""Settings of a job: one number for the pixel, and what of the job they leave alone."""

import numpy as np
import pytest
import yaml

from skyshine.mat.api.examples import example, example_names
from skyshine.mat.bench.settings import AS_WRITTEN, KELVINS, at_kelvin, settings_of
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.grids import path_grid


@pytest.fixture
def content(tiny_job, tmp_path):
    """Keys of a tiny job."""
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    return load_job(tmp_path / "job.yaml").document.data


@pytest.mark.parametrize("name", example_names())
def test_packaged_jobs_take_every_setting(name):
    loaded = load_job(example(name))
    settings = settings_of(loaded.document.data, KELVINS)
    assert [setting.name for setting in settings] == [AS_WRITTEN, *(f"{kelvin:g} K" for kelvin in KELVINS)]
    for setting in settings:
        job = load_job(setting.content, folder=loaded.folder).trimmed
        assert (job.name, job.sources, len(job.states)) == (
            loaded.trimmed.name,
            loaded.trimmed.sources,
            len(loaded.trimmed.states),
        )
        for axis in ("range_km", "altitude_km", "elevation_deg"):
            ours, theirs = (getattr(path_grid(one), axis) for one in (job, loaded.trimmed))
            assert ours[0] <= theirs[0] and ours[-1] >= theirs[-1], (setting.name, axis)


def test_less_error_never_asks_less_of_any_part(content):
    jobs = [load_job(at_kelvin(content, kelvin)).trimmed for kelvin in sorted((*KELVINS, 0.1), reverse=True)]
    asked = {
        "air": [tolerance_parts(job.atmosphere_grid.tolerance)[0] for job in jobs],
        "surface": [tolerance_parts(job.surface_grid.tolerance)[0] for job in jobs],
        "spectral": [job.accuracy.spectral_tolerance for job in jobs],
        "faces": [job.accuracy.tilted_faces_k for job in jobs],
        "steps": [-job.accuracy.solver_steps for job in jobs],
    }
    for part, values in asked.items():
        assert np.all(np.diff(values) <= 0) and values[-1] < values[0], part


def test_a_setting_keeps_seed_axes_and_what_may_be_left_out(content):
    content["accuracy"] = {"seed": 7, "negligible_k": 0.5, "solver_steps": 288}
    before = yaml.safe_dump(content)
    fine = load_job(at_kelvin(content, 5.0)).trimmed
    assert (fine.accuracy.seed, fine.accuracy.negligible_k, fine.accuracy.solver_steps) == (7, 0.5, 96)
    assert fine.atmosphere_axes() == load_job(content).trimmed.atmosphere_axes()
    assert yaml.safe_dump(content) == before
