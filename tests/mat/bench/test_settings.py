"""Settings of a job: one number for the pixel, the default axes, and what of the job they leave alone."""

import numpy as np
import pytest
import yaml

from skyshine.mat.api.examples import example, example_names
from skyshine.mat.bench.settings import (
    AS_WRITTEN,
    DEFAULT_AXES,
    DRAFT,
    KELVINS,
    as_draft,
    at_kelvin,
    on_default_axes,
    settings_of,
)
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.grids import path_grid


@pytest.fixture
def content(tiny_job, tmp_path):
    """Keys of a tiny job."""
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    return load_job(tmp_path / "job.yaml").document.data


def names(loaded, kelvins=(1.0,)):
    return [setting.name for setting in settings_of(loaded.document.data, loaded.trimmed, kelvins)]


@pytest.mark.parametrize("name", example_names())
def test_packaged_jobs_take_every_setting(name):
    loaded = load_job(example(name))
    for setting in settings_of(loaded.document.data, loaded.trimmed, KELVINS):
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
    jobs = [load_job(at_kelvin(content, kelvin)).trimmed for kelvin in sorted(KELVINS, reverse=True)]
    asked = {
        "air": [tolerance_parts(job.atmosphere_grid.tolerances["beta_star"])[0] for job in jobs],
        "surface": [tolerance_parts(job.surface_grid.tolerance)[0] for job in jobs],
        "spectral": [job.accuracy.spectral_tolerance for job in jobs],
        "classes": [job.accuracy.class_tolerance for job in jobs],
        "faces": [job.accuracy.tilted_faces_k for job in jobs],
        "steps": [-job.accuracy.solver_steps for job in jobs],
    }
    for part, values in asked.items():
        assert np.all(np.diff(values) <= 0) and values[-1] < values[0], part


def test_a_setting_keeps_seed_layout_and_what_may_be_left_out(content):
    content["accuracy"] = {"seed": 7, "negligible_k": 0.5, "solver_steps": 288}
    content["atmosphere_grid"]["layout"] = "classic"
    before = yaml.safe_dump(content)
    fine, default = load_job(at_kelvin(content, 5.0)), load_job(on_default_axes(content, load_job(content).trimmed))
    for loaded in (fine, default):
        assert (loaded.trimmed.accuracy.seed, loaded.trimmed.accuracy.negligible_k) == (7, 0.5)
    assert not fine.trimmed.atmosphere_grid.in_channels and fine.trimmed.accuracy.solver_steps == 96
    assert default.trimmed.accuracy.solver_steps == 96
    assert yaml.safe_dump(content) == before


def test_default_axes_are_a_setting_only_where_the_job_has_others(content):
    loaded = load_job(content)
    assert names(loaded) == [AS_WRITTEN, DRAFT, DEFAULT_AXES, "1 K"]
    default = load_job(on_default_axes(loaded.document.data, loaded.trimmed))
    assert names(default) == [AS_WRITTEN, DRAFT, "1 K"]
    bare = {key: value for key, value in content.items() if not key.endswith("_grid")}
    assert names(load_job(bare)) == [AS_WRITTEN, DRAFT, "1 K"]


def test_a_draft_has_fewer_nodes_between_the_same_ends_with_the_horizon():
    loaded = load_job(example("starter"))
    draft = load_job(as_draft(loaded.document.data, loaded.trimmed), folder=loaded.folder).trimmed
    for axis in ("range_km", "altitude_km", "elevation_deg", "source_elevation_deg", "source_azimuth_deg"):
        ours, theirs = (getattr(path_grid(job), axis) for job in (draft, loaded.trimmed))
        assert set(ours) < set(theirs) and (ours[0], ours[-1]) == (theirs[0], theirs[-1]), axis
    assert 0 in path_grid(draft).elevation_deg
    assert len(draft.surface_grid.time) == len(loaded.trimmed.surface_grid.times) / 2
    assert draft.accuracy.solver_steps == 96 and draft.atmosphere_grid.tolerances == {}
