"""A build on a Dask cluster of two workers, one of them killed in mid-build: the same bytes as on this machine."""

import os
import signal
import threading

import pytest

from skyshine.mat.build import build
from skyshine.mat.job import load_job

pytestmark = pytest.mark.validation
JOB = """\
skyshine: 1
name: kills
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    weather: {air_temperature_c: [22, 33]}
    series: {first: 2026-06-01, last: 2026-06-02}
bands:
  - wavelength_um: [10.0, 10.2]
materials: [asphalt_road]
output: {folder: built, pictures: false}
atmosphere_grid:
  range_km: [0.001, 5]
  altitude_km: [0.01, 1]
  elevation_deg: [-90, 0, 90]
  source_elevation_deg: [-20, 60]
  source_azimuth_deg: [0, 180]
surface_grid: {altitude_km: [0], azimuth_deg: [0, 180], slope_deg: [0, 45], time: [00:00, 12:00]}
"""


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.glob("*.h5")}


def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path):
    distributed = pytest.importorskip("distributed")
    (tmp_path / "job.yaml").write_text(JOB.replace("2026-06-02", "2026-06-03"), encoding="utf-8")
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
    assert was_killed and len(report["files"]) == 10
    assert contents(tmp_path / "cluster") == contents(tmp_path / "local")
