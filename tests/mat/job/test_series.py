"""States in series: a state for each day or each row of a table, each on its own day, file names that have room for
them.
"""

from datetime import date

import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import make_plan
from skyshine.materials.library import load_library
from skyshine.schemas.errors import InputError

JOB = """\
skyshine: 1
name: series
site: {latitude_deg: 29.7, longitude_deg: -82.0, date: 2026-06-28, utc_offset_h: -5}
states:
  - profile: us_standard
    weather: {air_temperature_c: [1, 9]}
  - profile: midlatitude_summer
    visibility_km: 23
    weather: {air_temperature_c: [22, 33], wind_speed_m_s: 2}
    series: SERIES
bands:
  - wavelength_um: [8, 12]
materials: [asphalt_road]
"""
TABLE = """\
# a small ensemble
date, profile, visibility_km, weather.wind_speed_m_s, weather.air_temperature_c
2026-01-03, midlatitude_winter, 5, 1.5, "[-4, 2]"
2026-07-30, tropical, 40, 7, 31
"""


@pytest.fixture
def job(tmp_path):
    def write(series, table=None):
        (tmp_path / "job.yaml").write_text(JOB.replace("SERIES", series), encoding="utf-8")
        if table is not None:
            (tmp_path / "ensemble.csv").write_text(table, encoding="utf-8")
        return load_job(tmp_path / "job.yaml")

    return write


def test_a_year_has_365_days_each_with_its_own_date_and_three_digits(job):
    loaded = job("{first: 2026-01-01, last: 2026-12-31}")
    assert len(loaded.trimmed.states) == 366
    assert loaded.on_date_of_state(1).trimmed.site.date == date(2026, 6, 28)
    assert loaded.on_date_of_state(366).trimmed.site.date == date(2026, 12, 31)
    assert loaded.on_date_of_state(3).trimmed.states[2].visibility_km == 23
    files = [name for task in make_plan(loaded, load_library()).tasks for name in task.files]
    assert "s001b01.atmq.h5" in files and "s366.htt.h5" in files and len(set(files)) == len(files) == 366 * 3 + 1


def test_steps_and_two_digits_up_to_99_states(job):
    loaded = job("{first: 2026-01-01, last: 2026-12-31, step_days: 30}")
    assert len(loaded.trimmed.states) == 14 and loaded.trimmed.states[2].date == date(2026, 1, 31)
    assert make_plan(loaded, load_library()).tasks[0].files[0] == "s01b01.atmq.h5"


def test_a_table_gives_each_state_its_values(job):
    states = job("{table: ensemble.csv}", TABLE).trimmed.states
    assert [state.profile for state in states] == ["us_standard", "midlatitude_winter", "tropical"]
    assert states[1].weather.air_temperature_c == (-4, 2) and states[2].weather.air_temperature_c == 31
    assert (
        states[2].visibility_km == 40
        and states[1].weather.wind_speed_m_s == 1.5
        and states[2].date == date(2026, 7, 30)
    )


@pytest.mark.parametrize(
    ("series", "table", "message"),
    [
        ("{first: 2026-01-02, last: 2026-01-01}", None, r"job.yaml:10:\d+: .*found last 2026-01-01 before first"),
        ("{first: 2026-01-02}", None, "give one of the three"),
        ("{first: 0001-01-01, last: 9999-12-31}", None, "found more than 9999 days"),
        (
            "{table: ensemble.csv}",
            "profile,visibility_km\ntropcal,3\n",
            r"ensemble.csv:2: profile: .*did you mean 'tropical'",
        ),
        ("{table: ensemble.csv}", "profile,visibility_km\ntropical\n", r"ensemble.csv:2: found 1 cells"),
        ("{table: ensemble.csv}", "visibilty_km\n3\n", r"ensemble.csv:2: .*did you mean 'visibility_km'"),
        ("{table: ensemble.csv}", "visibility_km\n!!python/name:os.system\n", r"ensemble.csv:2: .*tag"),
        ("{table: ensemble.csv}", "visibility_km\n", "has no rows"),
        ("{table: ../../etc/passwd}", None, "leads out of the job's folder"),
    ],
)
def test_a_wrong_series_is_one_clear_line(job, series, table, message):
    with pytest.raises(InputError, match=message):
        job(series, table)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("materials:", "output: {folder: ../elsewhere}\nmaterials:"),
        ("materials:", "output: {folder: /tmp/elsewhere}\nmaterials:"),
        ("profile: us_standard", "profile: us_standard\n    sounding: ../secret.csv"),
    ],
)
def test_a_path_leads_out_of_the_job_only_with_leave(job, tmp_path, monkeypatch, old, new):
    (tmp_path.parent / "secret.csv").write_text(
        "altitude[km],pressure[hPa],temperature[K],relative_humidity[%]\n0,1013,288,50\n5,540,255,30\n",
        encoding="utf-8",
    )
    text = JOB.replace("    series: SERIES\n", "").replace(old, new, 1)
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="leads out of the job's folder"):
        load_job(tmp_path / "job.yaml").output_folder
    monkeypatch.setenv("SKYSHINE_ALLOW_OUTSIDE", "1")
    assert load_job(tmp_path / "job.yaml").output_folder.parent


def test_a_wrong_value_of_a_row_is_told_with_what_is_allowed(tmp_path):
    (tmp_path / "days.csv").write_text("date,weather.wind_speed_m_s\n2026-06-01,2\n2026-06-02,900\n", encoding="utf-8")
    job = {
        "skyshine": 1,
        "name": "days",
        "site": {"latitude_deg": 45, "longitude_deg": 9, "date": "2026-06-01", "utc_offset_h": 1},
        "states": [
            {
                "profile": "midlatitude_summer",
                "weather": {"air_temperature_c": [9, 21]},
                "series": {"table": "days.csv"},
            }
        ],
        "bands": [],
        "materials": ["concrete"],
    }
    with pytest.raises(InputError, match=r"days.csv:3: weather.wind_speed_m_s: found 900.*; input should be less than"):
        load_job(job, folder=tmp_path)
