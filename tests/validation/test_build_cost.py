"""The estimate of `mat check` against the processor time that a build takes."""

import math
import resource

import pytest
import yaml

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.cost import estimate
from skyshine.mat.plan.plan import make_plan
from skyshine.materials.library import load_library

pytestmark = pytest.mark.validation
JOB = """\
skyshine: 1
name: cost
site: {{latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}}
states:
  - profile: midlatitude_summer
    weather: {{air_temperature_c: [22, 33]}}
bands:
  - wavelength_um: {band}
materials: [asphalt_road, grass_green, concrete]
output: {{folder: built, pictures: {pictures}}}
"""
AXES = """\
atmosphere_grid:
  range_km: [0.001, 0.01, 0.1, 0.5, 1, 2, 5, 10]
  altitude_km: [0.01, 0.5, 2]
  elevation_deg: [-90, -30, -10, -3, 0, 5, 30, 90]
  source_elevation_deg: [-10, -5, 0, 10, 30, 60, 90]
  source_azimuth_deg: [0, 30, 90, 180]
"""


@pytest.mark.parametrize("band, pictures", [("[8, 12]", "true"), ("[3, 5]", "false")])
def test_estimate_is_right_within_a_factor_of_two(band, pictures, tmp_path, monkeypatch):
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    file = tmp_path / "job.yaml"
    file.write_text(JOB.format(band=band, pictures=pictures), encoding="utf-8")
    loaded = load_job(file)
    expected = sum(estimate(loaded, make_plan(loaded, load_library())).values())

    taken = processor_seconds(loaded)
    print(f"\n{band}: estimated {expected:.1f} s, took {taken:.1f} s")
    assert 0.5 <= taken / expected <= 2


@pytest.mark.parametrize("band", ["[8, 12]", "[4.5, 5]"])
def test_estimate_of_a_series_is_right_within_a_factor_of_one_and_a_half(band, tmp_path, monkeypatch):
    """Four days of different weather, none of them among those that the constants were fitted to."""
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    rows = ["date,weather.air_temperature_c", '2026-01-10,"[6, 15]"', '2026-04-10,"[14, 26]"']
    rows += ['2026-07-10,"[23, 34]"', '2026-10-10,"[16, 28]"']
    (tmp_path / "days.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    text = JOB.format(band=band, pictures="false").replace(
        "    weather:", "    series: {table: days.csv}\n    weather:"
    )
    (tmp_path / "job.yaml").write_text(text + AXES, encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    expected = sum(estimate(loaded, make_plan(loaded, load_library())).values())
    taken = processor_seconds(loaded)
    print(f"\nfour days, {band}: estimated {expected:.1f} s, took {taken:.1f} s")
    assert 1 / 1.5 <= taken / expected <= 1.5


@pytest.mark.parametrize("rain", [0.0, 0.4])
def test_estimate_of_rainy_surfaces_is_right_within_a_factor_of_two(rain, tmp_path, monkeypatch):
    """Drizzle at night and in the evening, or none in a table that has rain: other than the shower that was fitted."""
    monkeypatch.setenv("SKYSHINE_CACHE", "")
    hours = range(24)
    weather = {
        "time": [f"{hour:02d}:00" for hour in hours],
        "air_temperature_c": [18 + 7 * math.cos(math.pi * (hour - 15) / 12) for hour in hours],
        "rain_mm_h": [rain if hour in (1, 2, 3, 18) else 0.0 for hour in hours],
    }
    job = {
        "skyshine": 1,
        "name": "drizzle",
        "site": {"latitude_deg": 45, "longitude_deg": 5, "date": "2026-06-28", "utc_offset_h": 2},
        "states": [{"profile": "midlatitude_summer", "weather": {"hourly": weather}}],
        "bands": [],
        "materials": ["brick_red", "grass_dry", "gravel_limestone"],
        "output": {"folder": "built", "pictures": False},
    }
    (tmp_path / "job.yaml").write_text(yaml.safe_dump(job), encoding="utf-8")
    loaded = load_job(tmp_path / "job.yaml")
    expected = sum(estimate(loaded, make_plan(loaded, load_library())).values())
    taken = processor_seconds(loaded)
    print(f"\n{rain} mm/h: estimated {expected:.1f} s, took {taken:.1f} s")
    assert 0.5 <= taken / expected <= 2


def processor_seconds(loaded):
    """Of the processes of a build."""

    def spent():
        used = resource.getrusage(resource.RUSAGE_CHILDREN)
        return used.ru_utime + used.ru_stime

    before = spent()
    build(loaded, jobs=1)
    return spent() - before
