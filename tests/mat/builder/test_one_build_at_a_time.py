"""What keeps builds whole: one at a time in a folder, clear lines where the disk is full, processes that end with their
parent.
"""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from filelock import FileLock

from skyshine.mat.builder.build import build
from skyshine.mat.builder.folder import LOCK
from skyshine.mat.job.load import load_job
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file
from skyshine.schemas.whole_files import write_whole

FOLLOWER = """
import os, sys, time
from skyshine.mat.builder.executors import open_executor
if __name__ == "__main__":
    with open_executor(None, 1, None) as pool:
        print(pool.submit(os.getpid).result(), flush=True)
        pool.submit(time.sleep, 600)
        time.sleep(600)
"""


def test_two_builds_do_not_share_a_folder(small_job, tmp_path):
    with FileLock(tmp_path / LOCK), pytest.raises(InputError, match="another build writes into this folder"):
        build(load_job(small_job), out=tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [LOCK]


def test_an_unknown_executor_and_a_silent_address_are_one_clear_line(small_job, tmp_path, monkeypatch):
    with pytest.raises(InputError, match="found --executor 'slurm'; allowed: dask:ADDRESS"):
        build(load_job(small_job), out=tmp_path, executor="slurm")
    pytest.importorskip("distributed")
    monkeypatch.setattr("skyshine.mat.builder.cluster.CONNECT_SECONDS", 0.5)
    with pytest.raises(InputError, match="where no scheduler answers"):
        build(load_job(small_job), out=tmp_path, executor="dask:tcp://127.0.0.1:9")


@pytest.fixture
def small_disk(tmp_path):
    """A disk of 64 KiB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", disk], capture_output=True, check=False
    )
    if mounted.returncode != 0:
        pytest.skip("no right to mount a small disk here")
    yield disk
    subprocess.run(["umount", disk], check=True)


def test_a_full_disk_is_one_clear_line_and_leaves_nothing(small_disk):
    noise = np.random.default_rng(1).random(100_000)
    root = Group({"x": Axis(np.arange(noise.size), "1", "x")}, {"y": Variable(("x",), noise, "1", "y")})
    with pytest.raises(InputError, match="cannot be written: .*check free space and permissions"):
        write_file(small_disk / "a.h5", root, Header("band", "1", "job"))
    with pytest.raises(InputError, match="cannot be written: No space left on device"):
        write_whole(small_disk / "build.json", "x" * 100_000)
    assert list(small_disk.iterdir()) == []


def test_processes_end_when_their_parent_is_killed(tmp_path):
    (tmp_path / "follower.py").write_text(FOLLOWER, encoding="utf-8")
    parent = subprocess.Popen([sys.executable, tmp_path / "follower.py"], stdout=subprocess.PIPE, text=True)
    worker = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    end = time.monotonic() + 30
    while os.path.exists(f"/proc/{worker}") and time.monotonic() < end:
        time.sleep(0.02)
    assert not os.path.exists(f"/proc/{worker}")
