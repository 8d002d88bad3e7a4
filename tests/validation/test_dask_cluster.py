"""Builds on Dask clusters of two workers; one is killed in mid-build, one comes late, the client is killed: the same
bytes as on this machine.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter

import pytest

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job

pytestmark = pytest.mark.validation
THREE_DAYS = "{first: 2026-06-01, last: 2026-06-03}"


@pytest.fixture(scope="module")
def distributed():
    return pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def job(tmp_path_factory, tiny_job):
    """Three days, built in processes of this machine too."""
    folder = tmp_path_factory.mktemp("days")
    (folder / "job.yaml").write_text(tiny_job(THREE_DAYS), encoding="utf-8")
    build(load_job(folder / "job.yaml"), out=folder / "local", jobs=2)
    return folder / "job.yaml"


def when_a_file_is_there(folder, act):
    """A thread that acts once, when the first database is in the folder."""

    def wait():
        while not list(folder.glob("*.h5")):
            time.sleep(0.02)
        act()

    thread = threading.Thread(target=wait, daemon=True)
    thread.start()
    return thread


def test_a_worker_that_comes_while_a_build_runs_takes_part(tmp_path, job, contents, distributed):
    done = Counter()

    class Ended(distributed.SchedulerPlugin):
        def transition(self, key, start, finish, *arguments, worker=None, **more):
            if (start, finish) == ("processing", "memory"):
                done[worker] += 1

    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        cluster.scheduler.add_plugin(Ended())
        when_a_file_is_there(tmp_path, lambda: cluster.scale(2))
        report = build(load_job(job), out=tmp_path, executor=f"dask:{cluster.scheduler_address}")
    assert len(report["files"]) == 7 and len(done) == 2 and min(done.values()) >= 1
    assert contents(tmp_path) == contents(job.parent / "local")


def test_a_client_that_is_killed_and_comes_back_keeps_what_is_finished(tmp_path, job, contents, distributed):
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        executor = f"dask:{cluster.scheduler_address}"
        command = [sys.executable, "-c", "from skyshine.mat.cli import main; main()", "build", str(job)]
        client = subprocess.Popen([*command, "--out", str(tmp_path), "--executor", executor], stderr=subprocess.DEVNULL)
        when_a_file_is_there(tmp_path, client.kill).join()
        assert client.wait() == -signal.SIGKILL
        report = build(load_job(job), out=tmp_path, executor=executor)
    assert any(entry["kept"] for entry in report["files"].values())
    assert contents(tmp_path) == contents(job.parent / "local")


def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path, job, contents, distributed):
    loaded = load_job(job)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        victim = next(iter(cluster.workers.values())).pid
        watcher = when_a_file_is_there(tmp_path, lambda: os.kill(victim, signal.SIGKILL))
        report = build(loaded, out=tmp_path, executor=f"dask:{cluster.scheduler_address}")
        was_killed = not watcher.is_alive()
    assert was_killed and len(report["files"]) == 7
    assert contents(tmp_path) == contents(job.parent / "local")
