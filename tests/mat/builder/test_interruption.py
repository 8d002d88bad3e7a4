"""An interrupted build: status 130, nothing half-written, finished files kept; the next build completes to the same
bytes.
"""

import os
import subprocess
import sys

import pytest

from skyshine.mat.builder import build as building
from skyshine.mat.cli import main
from skyshine.mat.job.load import load_job

FIRST, LAST = "s01.htt.h5", "s01b01.atmq.h5"
# The command, with an interrupt from the terminal at the moment when the first file is finished.
INTERRUPTED = f"""
import contextlib, signal
from skyshine.mat.builder import build
from skyshine.mat.cli import main

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job begins with it ignored

def run_all(run, start, batches, total, progress, run_all=build._Run.all):
    @contextlib.contextmanager
    def interrupting(total, description):
        with progress(total, description) as advance:
            def advance_then_stop(tasks):
                advance(tasks)
                if (run.folder / "{FIRST}").exists():
                    signal.raise_signal(signal.SIGINT)
            yield advance_then_stop
    return run_all(run, start, batches, total, interrupting)

build._Run.all = run_all
main()
"""


def test_an_interrupt_after_the_first_file_keeps_it(build_inline, builds_here, tiny_job, tmp_path, capsys, monkeypatch):
    """Temperatures of two days, in this process: what processes do is in `validation`."""
    text = tiny_job(series="{first: 2026-06-28, last: 2026-06-29}")
    text = text.replace("bands:\n  - wavelength_um: [10.0, 10.2]\n", "bands: []\n")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    folder, run_task = tmp_path / "built", building.run_task

    def interrupted(task, *rest):
        if task.index == 2:
            raise KeyboardInterrupt
        return run_task(task, *rest)

    with monkeypatch.context() as patch, pytest.raises(SystemExit) as stop:
        patch.setattr(building, "run_task", interrupted)
        main.main(["build", str(tmp_path / "job.yaml")])
    assert stop.value.code == 130
    assert capsys.readouterr().err.strip().splitlines()[-1] == "mat: interrupted; finished parts are kept"
    assert (folder / FIRST).exists() and not (folder / "s02.htt.h5").exists() and not list(folder.glob(".*"))
    report = build_inline(load_job(tmp_path / "job.yaml"), jobs=1)
    assert [entry["kept"] for entry in report["files"].values()] == [True, False]


@pytest.mark.validation  # 11 s
def test_an_interrupted_build_keeps_what_is_finished_and_completes_later(build_inline, tiny_job, tiny_build, tmp_path):
    (tmp_path / "job.yaml").write_text(tiny_job(), encoding="utf-8")
    folder = tmp_path / "built"
    command = [sys.executable, "-c", INTERRUPTED, "build", tmp_path / "job.yaml", "--jobs", "2"]
    compiling = {**os.environ, "SKYSHINE_CACHE": ""}  # or the last file may be there as soon as the first
    stopped = subprocess.run(command, capture_output=True, text=True, env=compiling, timeout=300)
    assert stopped.returncode == 130, stopped.stderr
    assert stopped.stderr.strip().splitlines()[-1] == "mat: interrupted; finished parts are kept"
    assert (folder / FIRST).exists() and not (folder / LAST).exists()
    assert not list(folder.glob(".*"))
    report = build_inline(load_job(tmp_path / "job.yaml"), jobs=1)
    assert report["files"][FIRST]["kept"] and not report["files"][LAST]["kept"]
    for name in report["files"]:
        assert (folder / name).read_bytes() == (tiny_build / name).read_bytes()
