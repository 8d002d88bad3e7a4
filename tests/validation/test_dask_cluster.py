"""Builds on Dask clusters of two workers, one of them killed in mid-build: the same bytes as on this machine."""

import os
import signal
import threading

import pytest

from mat.maintain.bench.batch_timing import Size, bench_batch
from skyshine.mat.bench.sample import sampled
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job

pytestmark = pytest.mark.validation
THREE_DAYS = "{first: 2026-06-01, last: 2026-06-03}"


def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path, tiny_job, contents):
    distributed = pytest.importorskip("distributed")
    (tmp_path / "job.yaml").write_text(tiny_job(THREE_DAYS), encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    build(loaded, out=tmp_path / "local", jobs=2)
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        victim = next(iter(cluster.workers.values())).pid
        killed = threading.Event()

        def kill_when_the_first_file_is_there():
            while not list((tmp_path / "cluster").glob("*.h5")) and not killed.wait(0.02):
                pass
            os.kill(victim, signal.SIGKILL)
            killed.set()

        watcher = threading.Thread(target=kill_when_the_first_file_is_there)
        watcher.start()
        try:
            report = build(loaded, out=tmp_path / "cluster", executor=f"dask:{cluster.scheduler_address}")
        finally:
            was_killed = killed.is_set()
            killed.set()
            watcher.join()
    assert was_killed and len(report["files"]) == 7
    assert contents(tmp_path / "cluster") == contents(tmp_path / "local")


def test_a_batch_is_timed_in_every_place_and_has_the_same_bytes_there(tmp_path, tiny_job):
    pytest.importorskip("distributed")
    (tmp_path / "job.yaml").write_text(tiny_job(THREE_DAYS), encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    few = sampled(loaded, 2)
    found = bench_batch(few, 2)
    assert [each.executor for each in found] == ["one process", "2 processes", "Dask, 2 workers"]
    assert all(each.identical for each in found)
    sample, batch = Size.of(few), Size.of(loaded)
    assert (sample, batch) == (Size(2, 1), Size(3, 1))
    for each in found:
        assert 0 < each.further < each.processor_seconds * 3 and each.choice > 0
        assert each.whole(sample, batch) == pytest.approx(each.seconds + each.further / each.workers)
