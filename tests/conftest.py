"""Fixtures that the whole suite shares."""

import os
from concurrent.futures import Executor, Future
from contextlib import contextmanager, nullcontext
from pathlib import Path

# One thread a process for linear algebra, as in a build: the workers of the suite share the cores. Before numpy comes.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("SKYSHINE_THREADS", "1")

import numpy as np
import pytest
from filelock import FileLock

from skyshine.mat.builder import build as building
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.job.load import load_job
from skyshine.mat.measure import faces
from skyshine.mat.plan.plan import Kind, make_plan
from skyshine.mat.products import atmosphere, channel_tables
from skyshine.mat.quantities import aureole
from skyshine.mat.scene import clear_sky
from skyshine.materials.library import load_library

TINY_JOB = """\
skyshine: 1
name: tiny
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    weather: {air_temperature_c: [22, 33]}
bands:
  - wavelength_um: [10.0, 10.2]
sources: [sun]
materials: [asphalt_road]
output: {folder: built, pictures: false}
atmosphere_grid:
  tolerance: 5 K
  range_km: [0.001, 5]
  altitude_km: [0.01, 1]
  elevation_deg: [-90, 0, 90]
  source_elevation_deg: [-20, 60]
  source_azimuth_deg: [0, 180]
surface_grid: {altitude_km: [0], azimuth_deg: [0, 180], slope_deg: [0, 45], time: [00:00, 12:00]}
"""
SCENE = """\
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: midlatitude_summer
    visibility_km: 23
    weather: {air_temperature_c: [22, 33], relative_humidity_percent: 60, wind_speed_m_s: 2}
"""
SMALL_JOB = f"""\
skyshine: 1
name: small
{SCENE}bands:
  - wavelength_um: [8, 8.4]
materials: [asphalt_road, grass_green]
atmosphere_grid:
  tolerance: 5 K
  range_km: [0.001, 1, 5, 20]
  altitude_km: [0.01, 1]
  elevation_deg: [-90, -30, -5, 0, 30, 90]
  source_elevation_deg: [-20, 0, 30, 60]
  source_azimuth_deg: [0, 90, 180]
surface_grid:
  altitude_km: [0, 1]
  azimuth_deg: [0, 90, 180, 270]
  slope_deg: [0, 45]
  time: [00:00, 06:00, 12:00, 18:00]
output: {{folder: built, pictures: false}}
"""
CHANNEL_JOB = f"""\
skyshine: 1
name: channels
{SCENE}bands:
  - wavelength_um: [10.0, 10.2]
sources: [sun]
materials: [asphalt_road]
atmosphere_grid:
  tolerance: 5 K
  range_km: [0, 20]
  altitude_km: [0.01, 2]
  source_elevation_deg: [-8, 60]
surface_grid: {{altitude_km: [0], azimuth_deg: [0, 180], slope_deg: [0, 45], time: [00:00, 12:00]}}
output: {{folder: built, pictures: false}}
"""
# Random lines of sight of a build, fewer than a user's: on which tables are measured, those of them with sky light,
# those with tilted faces at their ends; on which channels are placed, their directions of the source and points chosen,
# and light is parted by wavelength. Builds that are not `in_this_process` have all.
FEW_LINES = (
    (atmosphere, "LINES", 24),
    (atmosphere, "SKY", 8),
    (faces, "LINES", 3),
    (faces, "FEWEST_LINES", 3),
    (channel_tables, "LINES", 60),
    (channel_tables, "_SOURCE_LINES", (24, 24)),
    (channel_tables, "_POINT_LINES", 20),
    (channel_tables, "_SHARE_LINES", 40),
)


@pytest.fixture(scope="session")
def tiny_job():
    """Text of a job of three files that is built in seconds; of more states with a series."""

    def text(series: str | None = None) -> str:
        return TINY_JOB if series is None else TINY_JOB.replace("    weather:", f"    series: {series}\n    weather:")

    return text


@pytest.fixture(scope="session")
def contents():
    """Bytes of the databases of a folder, by name."""
    return lambda folder: {path.name: path.read_bytes() for path in folder.glob("*.h5")}


@pytest.fixture(scope="session")
def folder_of_the_run(tmp_path_factory):
    """Folder that all workers of one run of the suite share."""
    base = tmp_path_factory.getbasetemp()
    return base.parent if "PYTEST_XDIST_WORKER" in os.environ else base


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_tests(folder_of_the_run):
    """No test reads or writes the user's own cache of compiled bands."""
    before = os.environ.get("SKYSHINE_CACHE")
    os.environ["SKYSHINE_CACHE"] = str(folder_of_the_run / "cache")
    yield
    os.environ.pop("SKYSHINE_CACHE") if before is None else os.environ.__setitem__("SKYSHINE_CACHE", before)


@pytest.fixture(scope="session", autouse=True)
def few_suns():
    """Clear skies of the tests are computed at few elevations of the Sun: each takes seconds of a processor, and most
    tests of surfaces need one of their own. Gives those of a user's sky.
    """
    all_elevations = clear_sky.SUN_ELEVATIONS
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(clear_sky, "SUN_ELEVATIONS", np.array([-8, -4, -1, 1, 3, 6, 10, 15, 25, 40, 60, 90], float))
        patch.setattr(clear_sky, "AUREOLE_ELEVATIONS", np.array([0.5, 10.0, 30.0, 90.0]))
        patch.setattr(aureole, "_POINTS", 4)
        yield all_elevations


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the reference data; the tests that need it are skipped where it is absent."""
    folder = Path(os.environ.get("SKYSHINE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("reference data not present: set SKYSHINE_DATA to its folder")
    return folder


class Inline(Executor):
    """Runs the tasks of a build in this process: others take two seconds each to import what is here already."""

    def submit(self, function, /, *arguments, **keywords):
        future = Future()
        try:
            future.set_result(function(*arguments, **keywords))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def few_lines():
    """Atmospheres are placed and state their errors on some of a build's random lines of sight: to compute the light
    along all of them takes half of a small build.
    """
    with pytest.MonkeyPatch.context() as patch:
        for module, name, count in FEW_LINES:
            patch.setattr(module, name, count)
        yield


@contextmanager
def in_this_process():
    """Builds have no processes of their own, and `few_lines`."""
    with few_lines(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(building, "open_executor", lambda *_: nullcontext(Inline()))
        yield


def inline(loaded, **settings):
    """`build` in this process."""
    with in_this_process():
        return building.build(loaded, **settings)


@pytest.fixture(scope="session")
def build_inline():
    """`build` `in_this_process`, for tests of what is built and not of how."""
    return inline


@pytest.fixture(scope="module")
def builds_here():
    """Commands and functions of the tests of a module build `in_this_process`."""
    with in_this_process():
        yield


def built_alone(loaded, folder, kind):
    """Path of the first file of a kind, to which no other file of the job is built."""
    plan = make_plan(loaded, load_library())
    task = next(task for task in plan.tasks if task.kind is kind)
    with few_lines():
        run_task(task, loaded, folder, plan.materials, True)
    return folder / task.files[0]


@pytest.fixture(scope="session")
def build_surface():
    """Builds the table of temperatures of a job's first state and no other file; gives its path."""
    return lambda loaded, folder: built_alone(loaded, folder, Kind.TEMPERATURE)


@pytest.fixture(scope="session")
def build_atmosphere():
    """Builds the atmosphere of a job's first state and band and no other file; gives its path."""
    return lambda loaded, folder: built_alone(loaded, folder, Kind.ATMOSPHERE)


def written_once(folder, text, write_files=lambda folder: None):
    """The job file of a folder that the workers of a run share, and the files that it names."""
    folder.mkdir(exist_ok=True)
    with FileLock(folder / "lock"):
        if not (folder / "job.yaml").exists():
            write_files(folder)
            (folder / "job.yaml").write_text(text, encoding="utf-8")
    return folder / "job.yaml"


def built_once(job):
    """Folder of the databases of a job, which the first worker that needs them builds and the others keep."""
    with FileLock(job.parent / "lock"):
        if not (job.parent / "whole").exists():
            inline(load_job(job), jobs=1)
            (job.parent / "whole").touch()
    return job.parent / "built"


@pytest.fixture(scope="session")
def build_once(folder_of_the_run):
    """Builds a job, of a name, a text and maybe a function that writes the files that it names, where no worker of the
    run has built it yet; gives the folder of its databases.
    """

    def built(name, text, write_files=lambda folder: None):
        return built_once(written_once(folder_of_the_run / name, text, write_files))

    return built


@pytest.fixture(scope="session")
def channel_atmosphere(folder_of_the_run):
    """Path of an atmosphere in channels, of a band of few lines, to which no other file is built."""
    job = written_once(folder_of_the_run / "channels", CHANNEL_JOB)
    with FileLock(job.parent / "lock"):
        if not (job.parent / "whole").exists():
            built_alone(load_job(job), job.parent, Kind.ATMOSPHERE)
            (job.parent / "whole").touch()
    return job.parent / "s01b01.atmq.h5"


@pytest.fixture(scope="session")
def tiny_build(build_once):
    """Folder of the databases of the tiny job."""
    return build_once("tiny", TINY_JOB)


@pytest.fixture(scope="session")
def small_job(folder_of_the_run):
    return written_once(folder_of_the_run / "small", SMALL_JOB)


@pytest.fixture(scope="session")
def small_build(small_job):
    """Folder of the databases of the small job."""
    return built_once(small_job)
