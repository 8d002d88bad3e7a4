"""Days before in a job: what `mat temperature` solves and what the database of the job holds."""

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.builder.tasks import run_task
from skyshine.mat.job.load import load_job
from skyshine.mat.plan.plan import Kind, Task
from skyshine.mat.tables.loader import open_table
from skyshine.schemas.errors import InputError


def weather_file(folder):
    """A cold, windy day before a calm, mild one."""
    rows = [
        f"2026-06-{day}T{hour:02d}:00-05:00,{mean + 4 * np.sin((hour - 9) * np.pi / 12):.2f},60,{wind}"
        for day, mean, wind in ((27, 12.0, 8.0), (28, 24.0, 2.0))
        for hour in range(24)
    ]
    (folder / "days.csv").write_text("\n".join(["time,air_temperature[C],relative_humidity,wind_speed", *rows]) + "\n")


def job_with(tiny_job, folder, weather):
    weather_file(folder)
    text = tiny_job().replace("weather: {air_temperature_c: [22, 33]}", f"weather: {weather}")
    text = text.replace("materials: [asphalt_road]", "materials: [concrete]").replace(
        "slope_deg: [0, 45]", "slope_deg: [0]"
    )
    file = folder / "job.yaml"
    file.write_text(text.replace("time: [00:00, 12:00]", "time: [00:00, 06:00, 12:00, 18:00]"))
    return file


def test_the_database_holds_the_day_after_its_days_before(tiny_job, tmp_path):
    job = job_with(tiny_job, tmp_path, "{file: days.csv, history_days: 1}")
    after = skyshine.mat.temperature("concrete", job=job)
    alone = skyshine.mat.temperature("concrete", job=job_with(tiny_job, tmp_path, "{file: days.csv}"))
    colder = alone.temperature - after.temperature
    assert colder[0] > 2.0 and np.all(colder > 0) and colder[-1] < 0.5 * colder[0]
    job_with(tiny_job, tmp_path, "{file: days.csv, history_days: 1}")
    run_task(Task(Kind.TEMPERATURE, 1, 0, ("s01.htt.h5",), 0), load_job(job), tmp_path, ("concrete",), True)
    table = open_table(tmp_path / "s01.htt.h5")
    read = table.temperature(
        material="concrete", altitude=0.0, azimuth=0.0, slope=0.0, time=np.array([0.0, 6.0, 12.0, 18.0])
    )
    assert np.ravel(read) == pytest.approx(after.temperature[::48], abs=0.02)  # stored in steps of 1/32 K


def test_a_depth_under_days_before_is_refused(tiny_job, tmp_path):
    job = job_with(tiny_job, tmp_path, "{file: days.csv, history_days: 1}")
    with pytest.raises(InputError, match="found a depth and days before; allowed: one of them"):
        skyshine.mat.temperature("concrete", job=job, depth=0.05)


def test_one_table_serves_a_job_and_a_surface(tiny_job, tmp_path):
    """The total of the file, parted in both; the job's clock, UTC-5, is that of the file."""
    hours = np.arange(24)
    sun = 900 * np.maximum(np.sin(np.pi * (hours - 6.5) / 12), 0.0)
    rows = [f"2026-06-28T{hour:02d}:00-05:00,{25 + hour % 12},60,2,1013,{sun[hour]:.1f},380" for hour in hours]
    header = "time,air_temperature[C],relative_humidity,wind_speed,pressure[hPa],sw_down,lw_down"
    job = job_with(tiny_job, tmp_path, "{file: days.csv, radiation: measured}")
    (tmp_path / "days.csv").write_text("\n".join([header, *rows]) + "\n")
    by_job = skyshine.mat.temperature("concrete", job=job)
    alone = skyshine.mat.temperature("concrete", forcing=tmp_path / "days.csv")
    assert alone.notes == ("no days before: the record, 24 h, repeats",) and len(alone.temperature) == 24
    # The record begins at 5 h UTC; its readings hold at their time, those of a job are means of the time before.
    assert by_job.temperature[::8] == pytest.approx(alone.temperature, abs=3.0)
    assert by_job.fluxes["shortwave_absorbed"].mean() == pytest.approx(
        alone.fluxes["shortwave_absorbed"].mean(), rel=0.01
    )
