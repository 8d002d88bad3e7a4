"""Builds killed at random moments or stopped by a full disk: no unreadable file, what is finished is reused, the next
build gives the same bytes.

``SKYSHINE_KILLS`` sets how many builds are killed (default 100).
"""

import multiprocessing
import os
import random
import shutil
import signal
import subprocess
import sys
import time

import pytest

from skyshine.mat.builder import executors
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.measure import faces
from skyshine.mat.products import atmosphere, channel_tables
from skyshine.mat.tables.verify import problems

pytestmark = pytest.mark.validation
# Random lines of sight of a build, fewer than a user's.
FEW_LINES = ((atmosphere, "LINES", 40), (atmosphere, "SKY", 12), (faces, "LINES", 6), (channel_tables, "LINES", 150))
SMALL_DISK = 28 * 4096  # bytes: a table of the tiny job, not all of them
KILLS = int(os.environ.get("SKYSHINE_KILLS", "100"))
COMMAND = [sys.executable, "-c", "from skyshine.mat.cli import main; main()", "build"]


@pytest.fixture
def forked(monkeypatch):
    """Builds have a worker that is a fork, as the build itself is: what is tested is not how fast libraries are loaded.
    Few lines of sight.
    """
    context = multiprocessing.get_context
    monkeypatch.setattr(executors.multiprocessing, "get_context", lambda _: context("fork"))
    monkeypatch.setenv("SKYSHINE_CACHE", os.environ["SKYSHINE_CACHE"])
    for module, name, count in FEW_LINES:
        monkeypatch.setattr(module, name, count)


def started(job):
    """Process number of a build that leads a group of its own; 0 is its status where all is built."""
    child = os.fork()
    if child:
        return child
    status = 1
    try:
        os.setsid()
        build(load_job(job), jobs=1)
        status = 0
    finally:
        os._exit(status)


def ended(child):
    """Exit status of a process; -9 where it was killed."""
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")
def test_builds_killed_at_random_moments_leave_no_unreadable_file_and_complete_to_the_same_bytes(
    tmp_path, tiny_job, contents, forked
):
    job, folder = tmp_path / "job.yaml", tmp_path / "built"
    job.write_text(tiny_job(), encoding="utf-8")
    assert ended(started(job)) == 0
    expected = contents(folder)
    assert len(expected) == 3
    shutil.rmtree(folder)
    begin = time.monotonic()  # with the compiled band kept, as all the builds that follow
    assert ended(started(job)) == 0
    whole = time.monotonic() - begin
    assert contents(folder) == expected
    draw = random.Random(3)
    reused = killed = 0
    for number in range(1, KILLS + 1):
        shutil.rmtree(folder)
        child = started(job)
        time.sleep(draw.uniform(0, whole))
        os.kill(child, signal.SIGKILL)  # the build alone: its worker has to follow
        killed += ended(child) == -signal.SIGKILL
        for path in folder.glob("*.h5"):
            assert problems(path) == [], path
        kept = set(contents(folder))
        begin = time.monotonic()
        assert ended(started(job)) == 0
        if not kept:
            whole = time.monotonic() - begin  # follows the load of the machine
        reused += bool(kept)
        assert contents(folder) == expected
        assert not list(folder.glob(".*"))
        print(f"{number} builds, {killed} killed while they ran, {reused} with finished files to reuse", flush=True)
    print(f"0 unreadable files, {KILLS} completed to the same bytes")
    assert killed > KILLS / 2


@pytest.fixture
def small_disk(tmp_path):
    """A file system of `SMALL_DISK` bytes that can be made larger."""
    folder = tmp_path / "small"
    folder.mkdir()
    if sys.platform != "linux" or os.geteuid() or not shutil.which("mount"):
        pytest.skip("mounting a tmpfs takes root on Linux")
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={SMALL_DISK}", "tmpfs", str(folder)], capture_output=True
    ).returncode:
        pytest.skip("this system mounts no tmpfs")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_full_disk_stops_a_build_that_completes_when_there_is_space(tmp_path, small_disk, tiny_job, contents):
    job = tmp_path / "job.yaml"
    job.write_text(tiny_job(), encoding="utf-8")
    subprocess.run([*COMMAND, str(job), "--jobs", "1"], check=True, capture_output=True)
    expected = contents(tmp_path / "built")
    assert sum(map(len, expected.values())) > SMALL_DISK > max(map(len, expected.values()))
    command = [*COMMAND, str(job), "--jobs", "1", "--out", str(small_disk)]
    stopped = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert stopped.returncode == 2, stopped.stderr
    assert stopped.stderr.strip().count("\n") == 0 and "No space left on device" in stopped.stderr
    assert list(small_disk.glob("*.h5"))
    assert [problem for path in small_disk.glob("*.h5") for problem in problems(path)] == []
    assert not list(small_disk.glob(".*part*"))
    subprocess.run(["mount", "-o", "remount,size=8m", str(small_disk)], check=True)
    again = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert again.returncode == 0, again.stderr
    assert contents(small_disk) == expected
