"""Weather as its publishers write it: each form with the values that its units mean, at the times that they mean."""

from datetime import date

import numpy as np
import pytest

from skyshine.mat.job.weather_files import read_weather
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError

DAY = date(2026, 7, 1)
HOURS = range(24)


def write(folder, name, *lines):
    (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / name


def test_metar_of_an_airport(tmp_path):
    """Fahrenheit, knots, cloud layers, M for missing, T for a trace; reports of UTC, which is two hours behind."""
    rows = [
        f"KXX,2026-07-01 {hour:02d}:53,{50 + hour:.2f},M,{'M' if hour == 5 else '60.0'},180.00,10.00,29.92,M,T,FEW,BKN"
        for hour in HOURS
    ]
    rows.insert(3, "KXX,2026-07-01 02:10,M,M,M,180.00,10.00,29.92,M,M,M,M")  # a special report without temperature
    before = [f"KXX,2026-06-30 {hour:02d}:53,40.00,M,60.0,180.00,10.00,29.92,M,T,CLR,M" for hour in HOURS]
    head = "station,valid,tmpf,dwpf,relh,drct,sknt,alti,mslp,p01i,skyc1,skyc2"
    file = write(tmp_path, "asos.csv", "#DEBUG: Format Typ    -> comma", head, *before, *rows)
    weather = read_weather(file, DAY, 2.0)
    hourly = weather.hourly
    assert hourly.time[:3] == pytest.approx([0 + 53 / 60, 1 + 53 / 60, 2 + 53 / 60])
    assert hourly.air_temperature_c[0] == pytest.approx((40 - 32) / 1.8)
    assert hourly.air_temperature_c[2] == pytest.approx(10.0)
    assert hourly.wind_speed_m_s == pytest.approx([10 * 1852 / 3600] * 24)
    assert hourly.cloud_fraction == pytest.approx([0.0] * 2 + [0.75] * 22)
    assert hourly.relative_humidity_percent == pytest.approx([60.0] * 24) and hourly.pressure_hpa is None
    assert "by UTC" in weather.notes[0] and "alti (pressure reduced to sea level)" in weather.notes[1]
    assert "has no relative_humidity in 1 of 24 readings; interpolated" in weather.notes


def psm(tmp_path, zone=1):
    rows = [
        f"2026,7,{day},{hour},30,{100 if 6 <= hour < 18 else 0},{600 if hour == 12 else 0},0,10,{15 + hour},950,90,2.5"
        for day in (1, 2)
        for hour in HOURS
    ]
    head = "Year,Month,Day,Hour,Minute,DHI,DNI,GHI,Dew Point,Temperature,Pressure,Wind Direction,Wind Speed"
    place = f"NSRDB,1,-,-,-,45.0,9.0,{zone},100,1"
    names = "Source,Location ID,City,State,Country,Latitude,Longitude,Time Zone,Elevation,Local Time Zone"
    return write(tmp_path, "psm.csv", names, place, head, *rows)


def test_psm_of_the_nsrdb(tmp_path):
    """Light at half past is the mean about it: the mean of the hours that end there is half of both beside it."""
    weather = read_weather(psm(tmp_path), DAY, 1.0)
    hourly, station = weather.hourly, weather.station
    assert (station.latitude, station.longitude, station.altitude) == (45.0, 9.0, 100.0)
    assert hourly.time == pytest.approx(np.arange(24) + 0.5) and hourly.altitude_km == pytest.approx(0.1)
    assert hourly.direct_normal_w_m2[12:15] == pytest.approx([300.0, 300.0, 0.0])
    assert sum(hourly.diffuse_w_m2) == pytest.approx(1200.0) and hourly.pressure_hpa == pytest.approx([950.0] * 24)
    assert hourly.relative_humidity_percent[0] == pytest.approx(100 * 12.279 / 17.056, rel=2e-3)  # hPa at 10 and 15 C
    shifted = read_weather(psm(tmp_path, zone=0), date(2026, 7, 2), 1.0).hourly
    assert shifted.air_temperature_c[0] == pytest.approx(15 + 23)  # 23:30 UTC of the day before


PVGIS = ("Latitude (decimal degrees):\t45.000", "Longitude (decimal degrees):\t9.000", "Elevation (m):\t120.0")


@pytest.mark.parametrize(("slope", "lit"), [("0 deg. (optimum)", True), ("35 deg.", False)])
def test_pvgis_by_hour(tmp_path, slope, lit):
    """Light of a plane that is level is the total; of a tilted one it is left alone. A legend ends the table."""
    head = (*PVGIS, "Radiation database:\tPVGIS-SARAH3", "", "", f"Slope: {slope}", "Azimuth: 0 deg.", "")
    rows = [
        f"202607{day:02d}:{hour:02d}10,{50 * min(hour, 24 - hour):.1f},30.0,20.5,3.0,0.0"
        for day in (1, 2)
        for hour in HOURS
    ]
    file = write(
        tmp_path, "pvgis.csv", *head, "time,G(i),H_sun,T2m,WS10m,Int", *rows, "", "G(i): Global irradiance", ""
    )
    hourly = read_weather(file, DAY, 0.0).hourly
    assert len(hourly.time) == 24 and hourly.air_temperature_c == pytest.approx([20.5] * 24)
    assert (hourly.global_horizontal_w_m2 is not None) == lit
    if lit:
        assert hourly.global_horizontal_w_m2[12] == pytest.approx(575.0)


def test_a_typical_year_of_pvgis_has_months_of_several_years(tmp_path):
    years = {6: 2007, 7: 2011}
    rows = [
        f"{years[month]}{month:02d}{day:02d}:{hour:02d}00,{10 + hour}.0,50.0,0.0,0.0,{5.0 if 5 < hour < 18 else 0.0}"
        ",330.0,2.0,180.0,100000.0"
        for month in (6, 7)
        for day in ((30,) if month == 6 else (1, 2))
        for hour in HOURS
    ]
    head = "time(UTC),T2m,RH,G(h),Gb(n),Gd(h),IR(h),WS10m,WD10m,SP"
    file = write(tmp_path, "tmy.csv", *PVGIS, "month,year", "6,2007", "7,2011", head, *rows)
    hourly = read_weather(file, DAY, 0.0, days_before=1)
    assert hourly.hourly.air_temperature_c[:2] == pytest.approx([10.0, 11.0])
    assert hourly.hourly.longwave_down_w_m2 == pytest.approx([330.0] * 24) and len(hourly.before) == 1


@pytest.mark.parametrize("head", ["time", "date,hour"])
def test_meteostat(tmp_path, head):
    rows = [
        (f"2026-07-01 {hour:02d}:00:00" if head == "time" else f"2026-07-01,{hour}")
        + f",{hour}.0,,80,{0.5:g},,90,36.0,,1013.0,,"
        for hour in HOURS
    ]
    file = write(tmp_path, "meteostat.csv", f"{head},temp,dwpt,rhum,prcp,snow,wdir,wspd,wpgt,pres,tsun,coco", *rows)
    weather = read_weather(file, DAY, 0.0)
    assert weather.hourly.wind_speed_m_s == pytest.approx([10.0] * 24)
    assert weather.hourly.rain_mm_h == pytest.approx([0.5] * 24) and weather.hourly.pressure_hpa is None
    assert "pres (pressure reduced to sea level)" in weather.notes[1]


def test_bsrn_of_pangaea(tmp_path):
    """Minutes, of which some lack a value for less than three hours."""
    rows = [
        f"2026-07-01T{minute // 60:02d}:{minute % 60:02d}\t2\t{400 if 360 < minute < 1080 else -1}\t"
        f"{'' if 600 < minute < 660 else 310}\t{20:.1f}\t50.0\t1000"
        for minute in range(1440)
    ]
    head = "Date/Time\tHeight above ground [m]\tSWD [W/m**2]\tLWD [W/m**2]\tT2 [°C]\tRH [%]\tPoPoPoPo [hPa]"
    text = ("/* DATA DESCRIPTION:", "Event(s):\tXXX * LATITUDE: 46.8 * LONGITUDE: 6.9 * ELEVATION: 491.0 m", "*/")
    weather = read_weather(write(tmp_path, "bsrn.tab", *text, head, *rows), DAY, 0.0)
    hourly = weather.hourly
    assert len(hourly.time) == 1440 and sum(hourly.global_horizontal_w_m2) == 400 * 719
    assert hourly.longwave_down_w_m2 == pytest.approx([310.0] * 1440) and hourly.pressure_hpa[0] == pytest.approx(1000)


@pytest.fixture
def era5(tmp_path):
    netcdf = pytest.importorskip("netCDF4")

    def make(**changes):
        with netcdf.Dataset(tmp_path / "era5.nc", "w") as data:
            sizes = {"valid_time": 48, "latitude": changes.get("places", 1), "longitude": 1}
            for name, size in sizes.items():
                data.createDimension(name, size)
            clock = data.createVariable("valid_time", "i8", ("valid_time",))
            clock.units, clock[:] = "seconds since 1970-01-01", 1782864000 + 3600 * np.arange(48)  # 2026-07-01
            data.createVariable("latitude", "f8", ("latitude",))[:] = 45.0
            data.createVariable("longitude", "f8", ("longitude",))[:] = 9.0
            day = np.arange(48) % 24
            values = {
                "t2m": 290.0 + day,
                "d2m": np.full(48, 283.15),
                "u10": np.full(48, 3.0),
                "v10": np.full(48, -4.0),
                "sp": np.full(48, 98000.0),
                "ssrd": 3600.0 * np.where((day > 5) & (day < 19), 500.0, 0.0),
                "strd": np.full(48, 3600.0 * 320),
                "tp": np.full(48, 0.001),
                "tcc": np.full(48, 0.25),
            }
            for name, series in values.items():
                if name not in changes.get("without", ()):
                    variable = data.createVariable(name, "f8", tuple(sizes))
                    variable[:] = np.broadcast_to(series[:, None, None], (48, sizes["latitude"], 1))
        return tmp_path / "era5.nc"

    return make


def test_era5_of_a_point(era5):
    """Sums of the hour before are means over it; wind of its parts, humidity of the dew point."""
    weather = read_weather(era5(), DAY, 0.0)
    hourly, station = weather.hourly, weather.station
    assert (station.latitude, station.longitude, station.altitude) == (45.0, 9.0, None)
    assert hourly.air_temperature_c[:2] == pytest.approx([16.85, 17.85])
    assert hourly.wind_speed_m_s == pytest.approx([5.0] * 24) and hourly.pressure_hpa[0] == pytest.approx(980.0)
    assert max(hourly.global_horizontal_w_m2) == pytest.approx(500.0)
    assert hourly.longwave_down_w_m2 == pytest.approx([320.0] * 24)
    assert hourly.rain_mm_h == pytest.approx([1.0] * 24) and hourly.cloud_fraction == pytest.approx([0.25] * 24)
    assert hourly.relative_humidity_percent[0] == pytest.approx(100 * 12.279 / 19.19, rel=5e-3)  # hPa, 10 and 16.85 C


def test_era5_of_many_points_is_read_at_the_nearest_that_has_values(tmp_path):
    netcdf = pytest.importorskip("netCDF4")
    with netcdf.Dataset(tmp_path / "grid.nc", "w") as data:
        for name, size in (("valid_time", 24), ("longitude", 3), ("latitude", 2)):
            data.createDimension(name, size)
        clock = data.createVariable("valid_time", "i8", ("valid_time",))
        clock.units, clock[:] = "seconds since 1970-01-01", 1782864000 + 3600 * np.arange(24)
        data.createVariable("latitude", "f8", ("latitude",))[:] = [46.0, 45.0]
        data.createVariable("longitude", "f8", ("longitude",))[:] = [8.0, 9.0, 359.0]
        kelvin = data.createVariable("t2m", "f8", ("valid_time", "longitude", "latitude"), fill_value=-1.0)
        kelvin[:] = 280.0 + np.arange(6).reshape(3, 2)
        kelvin[:, 1, 1] = np.ma.masked  # of the sea

    def found(*place):
        weather = read_weather(tmp_path / "grid.nc", DAY, 0.0, place=place)
        return weather.hourly.air_temperature_c[0] + 273.15, (weather.station.latitude, weather.station.longitude)

    assert found(46.1, 8.2) == (pytest.approx(280.0), (46.0, 8.0))
    assert found(45.1, 9.1) == (pytest.approx(281.0), (45.0, 8.0))  # 86 km; 46, 9 is 100 km away
    assert found(45.2, -0.9) == (pytest.approx(285.0), (45.0, -1.0))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"places": 2}, "t2m: found 48 valid_time x 2 latitude x 1 longitude; allowed: one place"),
        ({"without": ["t2m"]}, "t2m over time"),
    ],
)
def test_netcdf_of_another_kind_is_one_line(era5, changes, words):
    with pytest.raises(InputError, match=words):
        read_weather(era5(**changes), DAY, 0.0)


def test_an_archive_is_named(tmp_path):
    (tmp_path / "era5.nc").write_bytes(b"PK\x03\x04" + bytes(200))
    with pytest.raises(InputError, match="is a zip archive; unpack it and name the file in it"):
        read_weather(tmp_path / "era5.nc", DAY, 0.0)


def test_columns_that_are_not_known_are_left_alone_and_slips_refused(tmp_path):
    rows = [f"{hour:02d}:00,{hour},x,3" for hour in range(0, 24, 3)]
    weather = read_weather(write(tmp_path, "a.csv", "time,air_temperature[C],station,gust", *rows), DAY, 0.0)
    assert weather.notes == ("has columns that are not read: station, gust",)
    with pytest.raises(InputError, match="found the column 'wind_sped'; did you mean 'wind_speed'"):
        read_weather(write(tmp_path, "a.csv", "time,air_temperature[C],station,wind_sped", *rows), DAY, 0.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("2026,7,1,5,30", "2026,7,41,5,30", "psm.csv:9:1: found '2026 7 41 5 30'; allowed: a date and time"),
        (",20,950,", ",warm,950,", "psm.csv:9:.*Temperature: found 'warm'"),
        (",20,950,", ",20,95000,", "psm.csv:9:.*Pressure: found '95000'; allowed: numbers from"),
        ("Temperature,", "Other,", "has no air temperature"),
    ],
)
def test_what_is_wrong_in_a_form_is_placed(tmp_path, old, new, words):
    file = psm(tmp_path)
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(InputError, match=words):
        read_weather(file, DAY, 1.0)


def epw_day(folder, hours, per_hour=1, minute=lambda hour: 60, station="45.00,9.00,1.0,100.0"):
    """A July day of EPW whose temperature is its hour, with as many records an hour as the header states."""
    header = [
        f"LOCATION,T,ST,XXX,TEST,999999,{station}",
        *["HEADER"] * 6,
        f"DATA PERIODS,1,{per_hour},Data,Sunday, 7/ 1, 7/ 1",
    ]
    rows = []
    for hour in hours:
        whole = int(np.ceil(hour)) if per_hour > 1 else hour
        cells = ["2001", "7", "1", str(whole), str(minute(hour)), "?", str(float(hour)), "1.0", "40", "98000"]
        rows.append(",".join([*cells, *["0"] * 11, "2", "5", "4", *["0"] * 11]))
    return write(folder, "day.epw", *header, *rows)


def test_epw_of_half_hours(tmp_path):
    """Each record is of the half hour that ends at its minute: 48 of them."""
    halves = np.arange(0.5, 24.5, 0.5)
    file = epw_day(tmp_path, halves, 2, lambda hour: 60 if hour == int(hour) else 30)
    hourly = read_weather(file, DAY, 1.0).hourly
    assert len(hourly.time) == 48 and hourly.time[:3] == pytest.approx([0.0, 0.5, 1.0])
    assert hourly.air_temperature_c[:3] == pytest.approx([24.0, 0.5, 1.0])


@pytest.mark.parametrize(
    ("hours", "per_hour", "words"),
    [
        (range(24), 1, "found hours from 0 to 23 of 01 July; allowed: 1 to 24, the ends of the hours"),
        ([1, *range(1, 25)], 1, "found 25 readings of 01 July; allowed: 24; that of 1 h is there twice"),
        (
            [*range(1, 9), *range(10, 25)],
            1,
            "found 23 readings of 01 July; allowed: 24; those that end at 9 h are missing",
        ),
        (
            sorted([*range(1, 25)] * 2),
            1,
            "found 48 readings of 01 July.*field 3 of DATA PERIODS states 1 an hour; write 2",
        ),
        (range(1, 25), 7, "found 7 records an hour; allowed: 1 to 60, a divisor of 60; mend field 3 of DATA PERIODS"),
        ([], 1, "found 0 hours of 01 July, and no others"),
    ],
)
def test_hours_of_epw_that_are_wrong_are_named(tmp_path, hours, per_hour, words):
    with pytest.raises(InputError, match=words):
        read_weather(epw_day(tmp_path, hours, per_hour), DAY, 1.0)


def history(rows=193, step=0.25, humidity=1.0, first=None):
    """Text of a weather history: cool on its first day, 10 K warmer on its second; blanks missing before signs."""
    lines = [first or f"{rows} {step:f}"]
    for number in range(rows):
        hour = number * step
        air = (-15.0 if hour < 24 else -5.0) + 3.0 * np.sin(2 * np.pi * (hour - 9) / 24)
        share = humidity * saturation_pressure(253.15) / saturation_pressure(air + 273.15)
        lines.append(
            f"{hour:.2f}{air:6.2f} 1000.00 {share:5.2f}-20.00   5.00    98.02     5.17 1.00  0  0   0.00  0.00"
        )
    return lines


def test_a_history_of_dirsig_gives_its_second_day(tmp_path):
    found = read_weather(write(tmp_path, "a.wth", *history()), DAY, 0.0)
    table = found.hourly
    assert len(table.time) == 96 and table.time[:2] == [0.0, 0.25]
    air = np.array(table.air_temperature_c)
    assert air.min() == pytest.approx(-8, abs=0.01) and air.max() == pytest.approx(-2, abs=0.01)
    assert table.time[int(air.argmax())] == pytest.approx(15, abs=0.5)
    assert np.all(np.array(table.wind_speed_m_s) == 5) and np.all(np.array(table.pressure_hpa) == 1000)
    assert 20 < min(table.relative_humidity_percent) < max(table.relative_humidity_percent) < 45
    assert table.direct_normal_w_m2 is None and "whose unit is not sure" in " ".join(found.notes)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["193 0.25", "0 20 1000"], r"a\.wth:1: found 1 rows; allowed: 193"),
        (history(first="97 0.25"), r"a\.wth:1: found '97 0.25'; allowed: the number of rows"),
        (history(first="a history"), r"a\.wth:1: found 'a history'"),
        ([], r"a\.wth:1: found ''"),
        ([*history()[:9], "0 20 1000", *history()[10:]], r"a\.wth:10: found 3 numbers; allowed: 13"),
        ([*history()[:9], history()[12], *history()[10:]], r"a\.wth:10: found hour 2.75; allowed: 2"),
        ([*history()[:9], history()[9].replace("1000.00", "100.00"), *history()[10:]], r"a\.wth:10: pressure: "),
        (history(humidity=40.0), r"relative_humidity: found .*; allowed: 0 to 1, a share"),
        (history(humidity=0.6), r"humidities in column 4 that differ by 0\.\d+ from those of the dew points"),
    ],
)
def test_a_history_of_dirsig_that_is_none_is_one_line(tmp_path, lines, words):
    with pytest.raises(InputError, match=words) as refused:
        read_weather(write(tmp_path, "a.wth", *lines), DAY, 0.0)
    assert "\n" not in str(refused.value)
