"""A state that fails: the others are built, the failure is named at the end, and a second build retries it alone."""

import json
import logging
from concurrent.futures import CancelledError
from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace

import pytest

import skyshine.mat
from skyshine.mat.builder import build as builder
from skyshine.mat.builder import failures
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, Task, make_plan
from skyshine.mat.products.table import PRODUCTS
from skyshine.materials.library import load_library
from skyshine.schemas.errors import CheckFailed, InputError

SERIES = "{first: 2026-06-28, last: 2026-06-29}"


@pytest.fixture
def job(tmp_path, tiny_job):
    """Temperatures alone of the tiny job, of two states."""
    text = tiny_job(series=SERIES).replace("bands:\n  - wavelength_um: [10.0, 10.2]\n", "bands: []\n")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    return load_job(tmp_path / "job.yaml")


@pytest.fixture
def planted(monkeypatch):
    """Makes the product of a kind raise in one state."""

    def plant(kind, state, error):
        compute = PRODUCTS[kind].compute

        def failing(context, report):
            if context.task.index == state:
                raise error
            yield from compute(context, report)

        monkeypatch.setattr(PRODUCTS[kind], "compute", failing, raising=True)

    return plant


@pytest.mark.parametrize(
    ("error", "ends", "words"),
    [
        (ValueError("no\nroot"), CheckFailed, "ValueError: no root; 1 of 2 files failed (s01.htt.h5)"),
        (
            InputError("is thin air", file="air.csv", line=4),
            InputError,
            "air.csv:4: is thin air; 1 of 2 files failed",
        ),
    ],
)
def test_the_other_states_are_built_and_the_failed_one_is_retried(
    job, planted, build_inline, monkeypatch, caplog, error, ends, words
):
    failed = "s01.htt.h5"
    whole = {name for task in make_plan(job, load_library()).tasks for name in task.files}
    with monkeypatch.context():
        planted(Kind.TEMPERATURE, 1, error)  # the first, so that the other comes after it
        with caplog.at_level(logging.INFO), pytest.raises(ends) as stop:
            build_inline(job, jobs=1)
        monkeypatch.undo()
    assert words in str(stop.value) and "\n" not in str(stop.value)
    assert f"failed: {failed}: " in caplog.text
    folder = job.output_folder
    built = {path.name for path in folder.glob("*.h5")}
    assert len(whole) > 1 and built == whole - {failed}
    record = json.loads((folder / "build.json").read_text())
    assert list(record["failed"]) == [failed] and set(record["files"]) == built
    assert {entry.file for entry in skyshine.mat.open_catalog(folder).entries} == built
    again = build_inline(job, jobs=1)
    assert [name for name, entry in again["files"].items() if not entry["kept"]] == [failed]
    assert not again["failed"] and set(again["files"]) == whole


def test_a_state_that_processes_cannot_build_stops_no_other(job, monkeypatch):
    """In a process of their own: air of a profile that is not there, past what looks at all states before."""
    bad = job.trimmed.states[1].model_copy(update={"profile": "no_such_profile"})
    states = [job.trimmed.states[0], bad]
    broken = replace(job, trimmed=job.trimmed.model_copy(update={"states": states}))
    with monkeypatch.context() as without:
        without.setattr(builder, "check_scene", lambda loaded: None)
        with pytest.raises((CheckFailed, InputError), match="files failed"):
            builder.build(broken, jobs=1)
    built = {path.name for path in job.output_folder.glob("*.h5")}
    assert built == {"s01.htt.h5"}


def test_what_no_other_task_could_do_better_stops_the_build(tmp_path):
    task = Task(Kind.ATMOSPHERE, 1, 1, ("s01b01.atmq.h5",), 1)
    full = InputError("cannot be written: No space left on device", file=tmp_path / "s01b01.atmq.h5")
    assert failures.stops_the_build(task, full, tmp_path)
    assert failures.stops_the_build(task, BrokenProcessPool(), tmp_path)
    assert failures.stops_the_build(task, CancelledError(), tmp_path)
    assert not failures.stops_the_build(task, InputError("is wrong", file="air.csv"), tmp_path)
    assert not failures.stops_the_build(task, MemoryError(), tmp_path)
    assert failures.stops_the_build(Task(Kind.TEXTURE, 1, 0, ("a.tmm.h5",), 1), ValueError(), tmp_path)
