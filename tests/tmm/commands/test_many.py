"""Jobs of many textures: one that is damaged, and a second run that does what is missing."""

import json
import os

import numpy as np
import pytest


@pytest.fixture
def sheets(tmp_path, write_image):
    """A job of a folder of four images of one colour, of which one is cut short."""
    (tmp_path / "sheets").mkdir()
    for name in "abcd":
        write_image(f"sheets/{name}.png", np.full((40, 50, 3), 90, np.uint8))
    whole = (tmp_path / "sheets" / "b.png").read_bytes()
    (tmp_path / "sheets" / "b.png").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "job.yaml").write_text("textures:\n  - {image: sheets, material: asphalt_road}\n")
    return tmp_path, whole


def _states(result):
    return {entry["name"]: entry["state"] for entry in json.loads(result.stdout)["textures"]}


def test_one_damaged_image_is_reported_and_the_rest_finished(run, sheets):
    folder, _ = sheets
    result = run("classify", folder / "job.yaml")
    assert result.exit_code == 2
    lines = result.stderr.splitlines()
    assert len(lines) == 2 and "texture 'b'" in lines[0] and "b.png: is " in lines[0]
    assert "1 of 4 textures failed" in lines[1]
    assert sorted(path.name for path in (folder / "build").iterdir()) == [f"{k}.tmm.h5" for k in "acd"]


def test_processes_write_what_one_does(run, sheets):
    folder, _ = sheets
    one, more = (
        run("classify", folder / "job.yaml", "--out", folder / name, *rest)
        for name, rest in (("1", ()), ("2", ("--jobs", "2")))
    )
    assert (more.exit_code, more.stderr) == (one.exit_code, one.stderr) == (2, one.stderr)
    assert more.stdout.replace(str(folder / "2"), str(folder / "1")) == one.stdout
    for name in "acd":
        assert (folder / "1" / f"{name}.tmm.h5").read_bytes() == (folder / "2" / f"{name}.tmm.h5").read_bytes()
    assert not (folder / "2" / "b.tmm.h5").exists()
    assert set(
        _states(run("classify", folder / "job.yaml", "--out", folder / "2", "--jobs", 2, "--json")).values()
    ) == {
        "kept",
        "failed",
    }


def test_a_process_that_is_stopped_leaves_one_line(run, sheets, monkeypatch):
    folder, whole = sheets
    (folder / "sheets" / "b.png").write_bytes(whole)
    monkeypatch.setattr("skyshine.tmm.commands.classify._in_a_process", _stopped)
    result = run("classify", folder / "job.yaml", "--jobs", 2)
    assert result.exit_code == 2 and "run it again with fewer --jobs" in result.stderr
    assert len(result.stderr.splitlines()) == 1


def _stopped(*_):
    os._exit(9)


def test_a_second_run_does_what_is_missing(run, sheets):
    folder, whole = sheets
    job = folder / "job.yaml"
    assert _states(run("classify", job, "--json")) == {"a": "written", "b": "failed", "c": "written", "d": "written"}
    (folder / "sheets" / "b.png").write_bytes(whole)
    before = {path.name: path.stat().st_mtime_ns for path in (folder / "build").iterdir()}
    again = run("classify", job, "--json")
    assert again.exit_code == 0
    assert _states(again) == {"a": "kept", "b": "written", "c": "kept", "d": "kept"}
    assert all((folder / "build" / name).stat().st_mtime_ns == time for name, time in before.items())
    assert "kept" in run("classify", job).output
    assert set(_states(run("classify", job, "--json", "--fresh")).values()) == {"written"}


def test_what_changed_is_done_again(run, sheets, write_image):
    folder, whole = sheets
    (folder / "sheets" / "b.png").write_bytes(whole)
    job = folder / "job.yaml"
    run("classify", job)
    write_image("sheets/a.png", np.full((40, 50, 3), 91, np.uint8))
    database = folder / "build" / "c.tmm.h5"
    database.write_bytes(database.read_bytes()[:-100])
    assert _states(run("classify", job, "--json")) == {"a": "written", "b": "kept", "c": "written", "d": "kept"}
    job.write_text(job.read_text().replace("asphalt_road", "grass_green"))
    assert set(_states(run("classify", job, "--json")).values()) == {"written"}


def test_a_texture_that_moved_on_the_ground_is_done_again(run, sheets):
    folder, whole = sheets
    (folder / "sheets" / "b.png").write_bytes(whole)
    run("classify", folder / "job.yaml")
    (folder / "sheets" / "d.pgw").write_text("1 0 0 -1 100 200")
    assert _states(run("classify", folder / "job.yaml", "--json"))["d"] == "written"
    assert _states(run("classify", folder / "job.yaml", "--json"))["d"] == "kept"


def test_check_goes_through_all(run, sheets):
    folder, _ = sheets
    (folder / "sheets" / "c.png").write_text("no image")
    result = run("check", folder / "job.yaml")
    assert result.exit_code == 2 and "holds" not in result.output
    assert [line.split("'")[1] for line in result.stderr.splitlines()[:-1]] == ["b", "c"]
    assert "a: sheets/a.png, 50 x 40" in result.stdout and "d: sheets/d.png" in result.stdout
