"""Fixtures that the whole suite shares."""

import os
from pathlib import Path

import pytest

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
  range_km: [0.001, 5]
  altitude_km: [0.01, 1]
  elevation_deg: [-90, 0, 90]
  source_elevation_deg: [-20, 60]
  source_azimuth_deg: [0, 180]
surface_grid: {altitude_km: [0], azimuth_deg: [0, 180], slope_deg: [0, 45], time: [00:00, 12:00]}
"""


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


@pytest.fixture(scope="session", autouse=True)
def cache_of_the_tests(tmp_path_factory):
    """No test reads or writes the user's own cache of compiled bands."""
    before = os.environ.get("SKYSHINE_CACHE")
    os.environ["SKYSHINE_CACHE"] = str(tmp_path_factory.mktemp("cache"))
    yield
    os.environ.pop("SKYSHINE_CACHE") if before is None else os.environ.__setitem__("SKYSHINE_CACHE", before)


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of the reference data; the tests that need it are skipped where it is absent."""
    folder = Path(os.environ.get("SKYSHINE_DATA", Path(__file__).parents[2] / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip("reference data not present: set SKYSHINE_DATA to its folder")
    return folder
