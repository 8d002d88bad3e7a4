"""What a build says while it runs, through Python's logging."""

import logging

from skyshine.mat.builder import build as building
from skyshine.mat.job.load import load_job
from skyshine.mat.products.product import TaskReport


def test_each_file_is_a_line_with_its_state_and_the_error_that_it_reached(
    tmp_path, tiny_job, build_inline, caplog, monkeypatch
):
    job = tmp_path / "job.yaml"
    job.write_text(tiny_job("{first: 2026-06-28, last: 2026-06-29}"), encoding="utf-8")

    def made(task, *rest):
        reached = {name: {"p99": 0.1234} for name in task.files if "atmq" in name}
        return TaskReport(task.files, kept="htt" in task.files[0], seconds=2.04, error_kelvin=reached)

    monkeypatch.setattr(building, "run_task", made)
    monkeypatch.setattr(building, "write_catalog", lambda folder, names: None)
    with caplog.at_level(logging.INFO, "skyshine"):
        build_inline(load_job(job))
    assert [record.name for record in caplog.records] == ["skyshine.mat.build"] * 5
    lines = [record.getMessage().partition("; ") for record in caplog.records]
    assert {line for line, _, _ in lines} == {
        "s01b01.atmq.h5, state 1 of 2: built in 2.0 s, 99 % within 0.12 K",
        "s02b01.atmq.h5, state 2 of 2: built in 2.0 s, 99 % within 0.12 K",
        "s01.htt.h5, state 1 of 2: kept",
        "s02.htt.h5, state 2 of 2: kept",
        "b01.band.h5, band 1 of 1: built in 2.0 s",
    }
    assert [done for _, _, done in lines] == [f"{number} of 5 done" for number in range(1, 6)]


def test_files_are_said_to_be_ready_before_their_pictures_are_drawn(
    tmp_path, tiny_job, build_inline, caplog, monkeypatch
):
    job = tmp_path / "job.yaml"
    job.write_text(tiny_job(), encoding="utf-8")
    monkeypatch.setattr(building, "run_task", lambda task, *rest: TaskReport(task.files, seconds=2.04))
    monkeypatch.setattr(building, "write_catalog", lambda folder, names: None)
    drawn = []
    monkeypatch.setattr(building, "draw_task", lambda task, *rest: drawn.append((task.files, len(caplog.records))))
    with caplog.at_level(logging.INFO, "skyshine"):
        build_inline(load_job(job), pictures=True)
    assert caplog.records[-1].getMessage().startswith(f"{tmp_path / 'built'}: 3 files ready in ")
    assert len(drawn) == 3 and {said for _, said in drawn} == {4} and (tmp_path / "built" / "build.json").is_file()
