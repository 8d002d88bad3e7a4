"""An interrupted build: status 130, nothing half-written, finished files kept; the next build completes to the same
bytes.
"""

import os
import shutil
import signal
import subprocess
import sys
import time

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job

FIRST, LAST = "s01.htt.h5", "s01b01.lunar_atmq.h5"


def test_an_interrupted_build_keeps_what_is_finished_and_completes_later(small_job, small_build, tmp_path):
    shutil.copyfile(small_job, tmp_path / "job.yaml")
    folder = tmp_path / "built"
    command = [
        sys.executable,
        "-c",
        "from skyshine.mat.cli import main; main()",
        "build",
        tmp_path / "job.yaml",
        "--jobs",
        "2",
    ]
    compiling = {**os.environ, "SKYSHINE_CACHE": ""}  # or the last file may be there as soon as the first
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=compiling)
    end = time.monotonic() + 120
    while not (folder / FIRST).exists() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, complaint = process.communicate(timeout=60)
    assert (
        process.returncode == 130 and complaint.strip().splitlines()[-1] == "mat: interrupted; finished parts are kept"
    )
    assert (folder / FIRST).exists() and not (folder / LAST).exists()
    assert not list(folder.glob(".*"))
    report = build(load_job(tmp_path / "job.yaml"), jobs=1)
    assert report["files"][FIRST]["kept"] and not report["files"][LAST]["kept"]
    for name in report["files"]:
        assert (folder / name).read_bytes() == (small_build / name).read_bytes()
