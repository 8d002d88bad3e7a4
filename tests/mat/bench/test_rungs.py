"""Rungs of a tiny job: built, measured on the same scenes, kept, and named where they cannot run."""

import json

import numpy as np
import pytest

from skyshine.mat.bench import front as front_module
from skyshine.mat.bench import rungs as module
from skyshine.mat.bench.front import Options, describe, measured
from skyshine.mat.bench.pixel_errors import Variant, described, errors_of_band
from skyshine.mat.bench.rungs import STAGES, BuildTime, Rung, TaskTime
from skyshine.mat.bench.settings import AS_WRITTEN, Setting
from skyshine.mat.budget.budget import error_budget
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.job.load import load_job
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

STEPS, REFUSED, FINER = "48 steps", "refused", "finer"
OPTIONS = Options((5.0,), 2, 1, 1, None, True)


@pytest.fixture(scope="module")
def loaded(tiny_job, tmp_path_factory):
    """A tiny job."""
    file = tmp_path_factory.mktemp("front") / "job.yaml"
    file.write_text(tiny_job(), encoding="utf-8")
    return load_job(file)


def four_settings(content, _kelvins):
    """The job as written, with fewer solver steps, and twice with a tolerance that its few nodes cannot hold."""
    few = {**content["atmosphere_grid"], "most_nodes": 32}
    changes = {AS_WRITTEN: {}, STEPS: {"accuracy": {"solver_steps": 48}}}
    settings = [Setting(name, None, {**content, **change}) for name, change in changes.items()]
    for name, kelvin in ((REFUSED, 0.01), (FINER, 0.005)):
        settings.append(Setting(name, kelvin, {**content, "atmosphere_grid": {**few, "tolerance": f"{kelvin} K"}}))
    return settings


@pytest.fixture(scope="module")
def run(loaded, build_inline, tmp_path_factory):
    """The folder of a whole front, the front, and what was said."""
    folder, said = tmp_path_factory.mktemp("bench"), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "build", build_inline)
        patch.setattr(front_module, "settings_of", four_settings)
        front = measured(loaded, folder, OPTIONS, said.append)
    return folder, front, said


@pytest.mark.validation  # of the front of 20 s
def test_what_runs_is_measured_and_what_does_not_is_named_with_its_reason(run):
    _, front, said = run
    assert [rung.setting.name for rung in front.rungs] == [AS_WRITTEN, STEPS]
    assert (
        list(front.failed) == [REFUSED, FINER]
        and "\n" not in front.failed[REFUSED]
        and "0.01 cannot be held" in front.failed[REFUSED]
    )
    assert front.failed[FINER] == "not tried: finer than refused, which cannot run"
    assert said[-1].startswith("measuring the pixel of 2 settings")
    described = describe(front)
    json.dumps(described, allow_nan=False)
    parts = {part["key"]: part for part in described["parts"]}
    keys = {"atmosphere_grid.tolerance", "surface_grid.tolerance", "accuracy.solver_steps"}
    assert set(parts) >= keys | {"accuracy.spectral_tolerance"}
    assert all(part["error"]["value"] > 0 for part in parts.values())
    for rung in described["rungs"]:
        assert 0 < rung["rms"]["value"] <= rung["error"]["value"] <= rung["maximum"]["value"]
        assert not rung["modelled"] and rung["size"]["value"] > 1000
        assert sum(stage["value"] for stage in rung["stages"].values()) == pytest.approx(rung["time"]["value"], rel=0.3)
        assert all(rung["stages"][name]["value"] > 0 for name in ("compile", "tables", "temperature", "accuracy"))
    assert {"marching in time", "scipy"} <= {peer["peer"] for peer in described["peers"]}
    assert all(peer["time_of_this_job"]["value"] > 0 for peer in described["peers"])


@pytest.mark.validation  # of the front of 20 s
def test_a_damaged_database_is_not_kept(run, loaded, tmp_path):
    folder, _, _ = run
    kept, damaged = (rung_of(loaded, folder) for _ in range(2))
    kept.resume(load_library())
    file = damaged.files / "s01.htt.h5"
    content = file.read_bytes()
    try:
        file.write_bytes(content[:-100])
        damaged.resume(load_library())
    finally:
        file.write_bytes(content)
    assert kept.cost is not None and damaged.cost is None


@pytest.mark.validation  # of the front of 20 s
def test_the_pixel_of_the_job_as_written_errs_as_its_error_budget_says(run, loaded):
    folder, _, _ = run
    rung = rung_of(loaded, folder)
    (of_set,) = errors_of_band(rung.loaded, [Variant(AS_WRITTEN, rung)], 4, 3, (1, 1))
    shares = described([of_set], AS_WRITTEN)["all"]
    budget = error_budget(Prepared.of(loaded, 1, 1), rung.files, load_library(), source="sun", scenes=4, seed=3)
    rms = float(np.sqrt(np.mean(budget.errors["pixel"] ** 2)) / budget.radiance.mean())
    averages, whole = (entry["share_of_radiance"]["rms"]["value"] for entry in (shares["exact_tables"], shares))
    assert 0 < averages < whole and whole == pytest.approx(rms, rel=1e-12)


@pytest.mark.validation  # of the front of 20 s
def test_a_finished_rung_is_kept_and_a_changed_job_is_built_again(run, loaded, monkeypatch):
    folder, first, _ = run

    def refuse(*_, **__):
        raise InputError("is not to be built")

    monkeypatch.setattr(module, "build", refuse)
    monkeypatch.setattr(front_module, "settings_of", four_settings)
    again = measured(loaded, folder, OPTIONS)
    assert [rung.setting.name for rung in again.rungs] == [AS_WRITTEN, STEPS]
    assert [rung.cost for rung in again.rungs] == [rung.cost for rung in first.rungs]
    assert again.failed == first.failed and REFUSED in again.failed  # it is not tried again
    # The job is changed last: what it replaces is deleted.
    content = loaded.document.data | {"materials": ["grass_green"]}
    changed = measured(load_job(content), folder, OPTIONS)
    assert not changed.rungs and changed.failed[AS_WRITTEN] == "is not to be built"


def test_stages_add_up_to_the_build():
    tasks = (
        TaskTime("atmosphere", 1, {"compile": 1.0, "tables": 2.0, "harmonics": 0.5, "accuracy": 0.25, "write": 0.125}),
        TaskTime("temperature", 0, {"tables": 4.0, "response": 1.0, "accuracy": 0.5}),
        TaskTime("texture", 0, {"train": 3.0, "write": 1.0}),
    )
    stages = BuildTime(20.0, 30.0, tasks).stages
    assert stages == {
        "compile": 1.0,
        "tables": 2.5,
        "temperature": 5.0,
        "accuracy": 0.75,
        "writing": 0.125,
        "textures": 4.0,
        "start and rest": pytest.approx(6.625),
    }
    assert list(stages) == list(STAGES)


def rung_of(loaded, folder):
    return Rung.of(Setting(AS_WRITTEN, None, loaded.document.data), loaded, folder / "rungs", 1)
