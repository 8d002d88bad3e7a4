"""Five sites, twelve months and two bands on a Dask cluster of four worker processes.

One worker is killed on the way, the scheduler is killed and started again, and another worker comes: every table is
built, the catalogue opens each by its site and date, and parts of the same job that run side by side give the same
bytes. SKYSHINE_MONTHS sets how many months (default 2).
"""

import json
import os
import re
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from result_blocks import keep

from skyshine.mat import open_catalog

pytest.importorskip("distributed")
pytestmark = pytest.mark.validation
MONTHS = int(os.environ.get("SKYSHINE_MONTHS", "2"))
RESULTS = Path(__file__).with_name("five_sites_results.json")
PAGE = Path(__file__).parents[2] / "examples" / "CLUSTER.md"
PLACES = {
    "hamburg": (53.6, 10.0, 0.0),
    "madrid": (40.4, -3.7, 0.65),
    "dakar": (14.7, -17.5, 0.0),
    "tromso": (69.6, 18.9, 0.0),
    "alice": (-23.7, 133.9, 0.55),
}
JOB = """\
skyshine: 1
name: five_sites
site: {date: 2026-01-15, utc_offset_h: 0}
sites: {sites: PLACES}
states:
  - profile: midlatitude_summer
    weather: {air_temperature_c: [12, 22]}
    series: {table: months.csv}
bands:
  - {name: mwir, wavelength_um: [4.5, 4.9]}
  - {name: lwir, wavelength_um: [10.2, 11.2]}
sources: [sun]
accuracy: 1 K
materials: [concrete, grass_green, asphalt_road]
output: {folder: built, pictures: false}
"""
MAT = [sys.executable, "-c", "from skyshine.mat.cli import main; main()"]
PARTS = 2


def write_job(folder):
    """The job and its months of warmer and colder air."""
    places = [
        {"name": name, "latitude_deg": latitude, "longitude_deg": longitude, "altitude_km": height}
        for name, (latitude, longitude, height) in PLACES.items()
    ]
    folder.mkdir()
    (folder / "job.yaml").write_text(JOB.replace("{sites: PLACES}", json.dumps(places)), encoding="utf-8")
    rows = [f'2026-{month:02d}-15,"[{6 + month}, {16 + month}]"' for month in range(1, MONTHS + 1)]
    table = "\n".join(["date,weather.air_temperature_c", *rows])
    (folder / "months.csv").write_text(table + "\n", encoding="utf-8")


def free_port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


class Cluster:
    """A scheduler and workers, each a process of its own as `dask scheduler` and `dask worker` start them."""

    def __init__(self, folder):
        self.folder, self.port, self.running = folder, free_port(), []
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.scheduler = self.start_scheduler()

    def start(self, *arguments):
        # Each process has a cache of its own, as on machines that share nothing but the folder of results.
        environment = os.environ | {"SKYSHINE_CACHE": str(self.folder / f"cache{len(self.running)}")}
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *arguments],
            cwd=self.folder,
            env=environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        self.running.append(process)
        return process

    def start_scheduler(self):
        return self.start("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")

    def start_worker(self):
        return self.start("worker", self.address, "--nworkers", "1", "--nthreads", "1", "--no-dashboard")

    def end(self):
        for process in self.running:
            process.kill()  # a worker waits for a scheduler that has gone; its processes end with it
        for process in self.running:
            process.wait()


@pytest.fixture
def cluster(tmp_path):
    cluster = Cluster(tmp_path)
    yield cluster
    cluster.end()


def wait_for(build, folder, count):
    """Until the folder has so many databases while the build runs."""
    while build.poll() is None and len(list(folder.rglob("*.h5"))) < count:
        time.sleep(0.1)
    assert build.poll() is None


def everything(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*.h5")}


def test_all_sites_and_months_are_built_by_a_cluster_that_loses_a_worker(tmp_path, cluster):
    states = len(PLACES) * MONTHS
    files = 3 * states + 2
    write_job(tmp_path / "job")
    workers = [cluster.start_worker() for _ in range(4)]
    start = time.monotonic()
    build = subprocess.Popen([*MAT, "build", "job.yaml", "--executor", f"dask:{cluster.address}"], cwd=tmp_path / "job")
    built = tmp_path / "job" / "built"
    wait_for(build, built, files // 5)
    workers[0].kill()
    wait_for(build, built, 2 * files // 5)
    cluster.scheduler.kill()
    cluster.scheduler.wait()
    cluster.scheduler = cluster.start_scheduler()
    for _ in range(4):  # those of before end with their scheduler
        cluster.start_worker()
    assert build.wait() == 0
    seconds = time.monotonic() - start
    found = everything(built)
    assert len(found) == files

    catalogue = open_catalog(built)
    for site in PLACES:
        for month in range(1, MONTHS + 1):
            table = catalogue.open("htt", site=site, date=f"2026-{month:02d}-15")
            assert re.fullmatch(rf"2026-{month:02d}-15", str(table.attributes["date"])[:10])
            for band in ("mwir", "lwir"):
                catalogue.open("atmq", site=site, date=f"2026-{month:02d}-15", band=band)

    write_job(tmp_path / "parts")
    environment = os.environ | {"SKYSHINE_CACHE": str(tmp_path / "cache of parts")}
    parts = [
        subprocess.Popen(
            [*MAT, "build", "job.yaml", "--jobs", "1", "--part", f"{part}/{PARTS}"],
            cwd=tmp_path / "parts",
            env=environment,
        )
        for part in range(1, PARTS + 1)
    ]
    assert [part.wait() for part in parts] == [0] * PARTS
    of_parts = everything(tmp_path / "parts" / "built")
    assert sorted(of_parts) == sorted(found)
    assert [name for name in found if found[name] != of_parts[name]] == []
    if os.environ.get("SKYSHINE_WRITE"):
        results = {"months": MONTHS, "files": files, "seconds": round(seconds), "load": round(os.getloadavg()[1], 1)}
        keep(results, RESULTS, PAGE, paragraph)


def paragraph(results):
    """The results as the page has them."""
    return (
        f"5 sites, {results['months']} months and 2 bands on four workers, of which one was killed on the way and the"
        f" scheduler was killed and started again: {results['files']} of {results['files']} files in"
        f" {results['seconds']:,} s of two cores at a load of {results['load']:.0f}, the bytes of two parts that ran"
        " side by side (`tests/validation/test_five_sites.py`)."
    )


def test_page_has_the_results():
    assert paragraph(json.loads(RESULTS.read_text(encoding="utf-8"))) in PAGE.read_text(encoding="utf-8")
