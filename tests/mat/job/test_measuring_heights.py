"""Heights of wind and air: of the job, of its file, or of WMO-No. 8."""

from datetime import date

import pytest

from skyshine.mat.job.site import Site
from skyshine.mat.job.surface import Weather
from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.scene.weather import mean_wind, near_surface_air, sun_path
from skyshine.schemas.errors import InputError


def day_table(folder, heights=lambda hour: "3"):
    file = folder / "day.csv"
    rows = [f"{hour:02d}:00,285,4,{heights(hour)}" for hour in range(24)]
    file.write_text("\n".join(["time,air_temperature,wind_speed,wind_height", *rows]) + "\n")
    return file


def test_what_the_job_writes_comes_before_the_file_s(tmp_path):
    hourly = read_weather(day_table(tmp_path), date(2026, 6, 21), 0).hourly
    assert Weather(air_temperature_c=12.0).heights_m == (10.0, 2.0)
    assert Weather(hourly=hourly).heights_m == (3.0, 2.0)
    assert Weather(hourly=hourly, wind_height_m=5.0, air_height_m=1.5).heights_m == (5.0, 1.5)


def test_the_air_at_the_ground_has_the_heights_of_the_weather(tmp_path):
    site = Site(latitude_deg=40.0, longitude_deg=0.0, date=date(2026, 6, 21), utc_offset_h=0.0)
    hourly = read_weather(day_table(tmp_path), site.date, 0).hourly
    daily = {"air_temperature_c": (12.0, 20.0), "wind_height_m": 3.0}
    for weather in (Weather(**daily), Weather(hourly=hourly)):
        air = near_surface_air(sun_path(site), weather)
        assert (air.wind_height, air.air_height) == (3.0, 2.0)


def test_a_mast_that_grows_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"day.csv:14: wind_height: found 4 after 3"):
        read_weather(day_table(tmp_path, lambda hour: "3" if hour < 12 else "4"), date(2026, 6, 21), 0)


def test_aerosols_get_the_wind_of_ten_metres():
    """At 2 m over open ground an anemometer reads 0.723 of that at 10 m."""
    assert mean_wind(Weather(air_temperature_c=12.0, wind_speed_m_s=2.892, wind_height_m=2.0)) == pytest.approx(
        4.0, rel=1e-3
    )
