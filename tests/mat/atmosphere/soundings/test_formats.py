"""One column of air written in each of the formats that are read: the same air from all, and what is refused."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from skyshine.mat.atmosphere.soundings.choice import Choice
from skyshine.mat.atmosphere.soundings.files import read_levels, times_of
from skyshine.mat.atmosphere.state.profiles import load_profile
from skyshine.mat.atmosphere.state.sounding import continued
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError

# Altitude m, pressure hPa, temperature C, dew point C: hydrostatic within 0.2 %.
AIR = [
    (10, 1010.0, 20.0, 12.0),
    (800, 920.6, 14.2, 9.0),
    (1500, 846.4, 10.0, -2.0),
    (3100, 695.2, 1.0, -14.0),
    (5600, 505.5, -16.0, -30.0),
]
EARTH = 6356766.0  # m, US Standard Atmosphere 1976


def geopotential(altitude):
    return EARTH * altitude / (EARTH + altitude)


def relative_humidity(celsius, dew):
    return 100 * float(saturation_pressure(dew + 273.15) / saturation_pressure(celsius + 273.15))


def plain_csv(rows=AIR):
    return "altitude[m],pressure[hPa],temperature[C],dew_point[C]\n" + "".join(
        f"{z},{p},{t},{d}\n" for z, p, t, d in rows
    )


def sonde_csv(rows=AIR):
    """A list of a sonde: other columns, blanks, semicolons."""
    head = "time [s];Height (m);P (hPa);Temp (degC);RH (%);wind_speed (m/s);Latitude\n"
    return head + "".join(
        f"{n};{z};{p};{t};{relative_humidity(t, d):.4f};;-34.9\n" for n, (z, p, t, d) in enumerate(rows)
    )


def wyoming_csv(rows=AIR):
    head = (
        "time,longitude,latitude,pressure_hPa,geopotential height_m,temperature_C,dew point temperature_C,"
        "ice point temperature_C,relative humidity_%,humidity wrt ice_%,mixing ratio_g/kg,wind speed_m/s\n"
    )
    return head + "".join(
        f"2026-01-15 05:15:0{n},138.5,-34.9,{p:7.1f},{geopotential(z):9.3f},{t:5.1f},{d:5.1f},{d:5.1f},"
        f"{relative_humidity(t, d):3.0f},20,7.23,3.0\n"
        for n, (z, p, t, d) in enumerate(rows)
    )


def wyoming_text(rows=AIR, when="06Z 15 Jan 2026"):
    line = "-" * 77
    text = f"<PRE>\n94672 YPAD Adelaide Airport Observations at {when}\n\n{line}\n"
    text += "   PRES   HGHT   TEMP   DWPT   RELH   MIXR   DRCT   SKNT   THTA   THTE   THTV\n"
    text += f"    hPa     m      C      C      %    g/kg    deg   knot     K      K      K \n{line}\n"
    text += " 1025.0   -120\n"  # a standard level below the ground
    for z, p, t, d in rows:
        text += f"{p:7.1f}{geopotential(z):7.0f}{t:7.1f}{d:7.1f}{relative_humidity(t, d):7.0f}   7.00    220      6\n"
    return text + "</PRE>\n\nStation information and sounding indices\n\n   Station identifier: YPAD\n"


def igra_text(rows=AIR, when="2026 01 15 06 0517", heights=True):
    lines = [f"#ASM00094672 {when} {len(rows) + 1:4d} ncdc6310 ncdc6310 -349500  1385300"]
    for n, (z, p, t, d) in enumerate(rows):
        height = round(geopotential(z)) if heights or n == 0 else -9999
        lines.append(
            f"20 {n:5d} {round(100 * p):6d}B{height:5d}B{round(10 * t):5d}B-9999 {round(10 * (t - d)):5d}   220    30 "
        )
    lines.insert(2, "30    20  -9999    50 -9999 -9999 -9999   220    31 ")  # wind alone
    return "\n".join(lines) + "\n"


def write_netcdf(file, rows=AIR, latitudes=(-35.0,), longitudes=(138.5,), hours=(6,), change=None):
    """A grid of the same air; `change(t, latitude, longitude, hour)` gives the temperatures, [K]."""
    netcdf = pytest.importorskip("netCDF4")
    z, p, t, d = (np.array(column, float) for column in zip(*rows, strict=True))
    e = saturation_pressure(d + 273.15)
    q = 0.62198 * e / (100 * p - 0.37802 * e)
    shape = (len(hours), p.size, len(latitudes), len(longitudes))
    with netcdf.Dataset(file, "w") as data:
        axes = {"valid_time": hours, "pressure_level": p, "latitude": latitudes, "longitude": longitudes}
        for name, nodes in axes.items():
            data.createDimension(name, len(nodes))
            data.createVariable(name, "f8", (name,))[:] = nodes
        data["valid_time"].units = "hours since 2026-01-15 00:00:00"
        data["pressure_level"].units = "hPa"
        for name, standard, unit, column in (
            ("t", "air_temperature", "K", t + 273.15),
            ("q", "specific_humidity", "kg kg**-1", q),
            ("z", "geopotential", "m**2 s**-2", 9.80665 * geopotential(z)),
        ):
            variable = data.createVariable(name, "f8", tuple(axes))
            variable.standard_name, variable.units = standard, unit
            values = np.broadcast_to(column[None, :, None, None], shape).copy()
            if name == "t" and change is not None:
                for i, hour in enumerate(hours):
                    for j, latitude in enumerate(latitudes):
                        for k, longitude in enumerate(longitudes):
                            values[i, :, j, k] = change(column, latitude, longitude, hour)
            variable[:] = values
    return file


@pytest.fixture
def formats(tmp_path):
    """Files of the same air, by format."""
    texts = {
        "plain.csv": plain_csv(),
        "sonde.csv": sonde_csv(),
        "wyoming.csv": wyoming_csv(),
        "wyoming.txt": wyoming_text(),
        "ASM00094672-data.txt": igra_text(),
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return [*(tmp_path / name for name in texts), write_netcdf(tmp_path / "era5.nc")]


def humidity(levels):
    """Relative, percent."""
    return 100 * levels.mole_fraction["H2O"] * levels.pressure / saturation_pressure(levels.temperature)


def saved(tmp_path, text, name="air.txt"):
    (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / name


def test_every_format_gives_the_same_air(formats):
    altitude, pressure, temperature, dew = (np.array(column) for column in zip(*AIR, strict=True))
    for file in formats:
        levels = read_levels(file)
        assert levels.temperature == pytest.approx(temperature + 273.15, abs=0.1), file.name
        assert levels.pressure == pytest.approx(100 * pressure, rel=1e-6), file.name
        assert levels.altitude == pytest.approx(altitude, abs=1.0), file.name
        truth = [relative_humidity(t, d) for t, d in zip(temperature, dew, strict=True)]
        assert humidity(levels) == pytest.approx(truth, abs=0.5), file.name
        assert levels.notes == ()


def test_files_that_know_their_time_say_it(formats):
    known = [times_of(file) for file in formats]
    six = datetime(2026, 1, 15, 6, tzinfo=UTC)
    assert known == [[None], [None], [datetime(2026, 1, 15, 5, 15, tzinfo=UTC)], [six], [six], [six]]


def test_samples_of_five_formats_hold_the_same_air(shared_data):
    """Adelaide at 06 UTC; on the levels of the grid, to which the balloon's are interpolated in the log of pressure."""
    folder = shared_data / "inputs"
    if not folder.is_dir():
        pytest.skip("no samples of inputs in the reference data")
    truth = read_levels(folder / "adelaide_sonde.csv")
    for name in ("adelaide_vaisala.csv", "wyoming.csv", "wyoming.txt", "ASM00094672-data.txt", "era5.nc"):
        levels = read_levels(folder / name)
        inside = (levels.pressure <= truth.pressure[0] * 1.001) & (levels.pressure >= truth.pressure[-1] * 0.999)
        assert np.count_nonzero(inside) >= 29
        at, nodes = -np.log(levels.pressure[inside]), -np.log(truth.pressure)
        temperature = np.interp(at, nodes, truth.temperature)
        assert np.max(np.abs(levels.temperature[inside] - temperature)) < 0.1, name
        water = np.interp(at, nodes, truth.mole_fraction["H2O"])
        truly = 100 * water * levels.pressure[inside] / saturation_pressure(temperature)
        assert np.max(np.abs(humidity(levels)[inside] - truly)) < 2.0, name


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_blanks_and_other_columns_are_passed_over(tmp_path, delimiter):
    """Rows without temperature go, humidity between two levels is interpolated, and missing codes are no readings."""
    rows = [
        "station,altitude[m],pressure[hPa],temperature[C],relative_humidity[%],wind[m/s]",
        "A,10,1010.0,20.0,60,",
        "A,400,965.3,,55,3",
        "A,800,920.6,14.2,,",
        "A,1500,846.4,10.0,-9999,///",
        "A,1590,837.3,9.4,40,5",
    ]
    levels = read_levels(saved(tmp_path, "\n".join(rows).replace(",", delimiter) + "\n", "air.csv"))
    assert levels.altitude == pytest.approx([10, 800, 1500, 1590])
    assert humidity(levels) == pytest.approx([60, 50, 60 - 20 * 1490 / 1580, 40])


def test_humidity_that_ends_below_the_top_goes_on_as_the_profile_has_it(tmp_path):
    text = "altitude[m],pressure[hPa],temperature[C],dew_point[C]\n10,1010,20,12\n1500,846.4,10,-2\n5600,505.5,-16,\n"
    levels = read_levels(saved(tmp_path, text, "air.csv"))
    assert np.isnan(levels.mole_fraction["H2O"][-1])
    assert levels.notes == ("has no humidity above 2 km; that of the profile is used there",)
    above = load_profile("us_standard")
    water = continued(levels, above).mole_fraction["H2O"]
    at = np.interp(5600.0, above.altitude, above.mole_fraction["H2O"])
    assert water[3] == pytest.approx(min(at, saturation_pressure(257.15) / 50550), rel=1e-9)
    assert np.all(np.isfinite(water))


def test_rows_of_a_balloon_that_sinks_are_left_out_and_counted(tmp_path):
    rows = plain_csv().splitlines()
    flown = ["time[s]," + rows[0], *(f"{n},{row}" for n, row in enumerate([*rows[1:3], rows[1], rows[2], *rows[3:]]))]
    levels = read_levels(saved(tmp_path, "\n".join(flown) + "\n", "air.csv"))
    assert levels.altitude == pytest.approx([row[0] for row in AIR])
    assert levels.notes == ("has 2 of 7 levels that do not rise above those before; they are not read",)


def test_altitudes_that_the_archive_lacks_follow_from_hydrostatic_balance(tmp_path):
    """By hand with R = 287.05 J/(kg K), Magnus' vapour pressure and the mean virtual temperature of each layer."""
    levels = read_levels(saved(tmp_path, igra_text(heights=False)))
    assert levels.altitude[1:] == pytest.approx([801.2, 1505.5, 3114.3, 5596.6], abs=2.0)


def test_archives_of_several_soundings_are_read_at_the_time_that_is_asked_for(tmp_path):
    warmer = [(z, p, t + 1, d) for z, p, t, d in AIR]
    for name, text in (
        ("igra.txt", igra_text() + igra_text(warmer, "2026 01 15 18 9999")),
        ("wyoming.txt", wyoming_text() + wyoming_text(warmer, "18Z 15 Jan 2026")),
    ):
        file = saved(tmp_path, text, name)
        evening = datetime(2026, 1, 15, 18, tzinfo=UTC)
        assert times_of(file) == [evening - timedelta(hours=12), evening]
        found = read_levels(file, Choice(time=evening + timedelta(hours=2)))
        assert (found.time, found.temperature[0]) == (evening, pytest.approx(294.15))
        day = (evening - timedelta(hours=6), evening + timedelta(hours=18))
        assert read_levels(file, Choice(day=day)).time == evening
        with pytest.raises(InputError, match=r"has 2 soundings, 0 of them on .* 2026-01-15 06:00 UTC"):
            read_levels(file)
        with pytest.raises(InputError, match="no sounding within 12 h of 2026-01-17 00:00 UTC"):
            read_levels(file, Choice(time=datetime(2026, 1, 17, tzinfo=UTC)))


def warmed(column, latitude, longitude, hour):
    return column + 2.0 * (latitude + 35) + 3.0 * (longitude % 360 - 138) + 0.1 * hour


@pytest.mark.parametrize("east", [138.25, 138.25 - 360])
def test_a_grid_is_interpolated_in_place_and_time_or_the_nearest_taken(tmp_path, east):
    grid = {"latitudes": (-34.75, -35.0, -35.25), "longitudes": (138.0, 138.5), "hours": (0, 6)}
    file = write_netcdf(tmp_path / "g.nc", **grid, change=warmed)
    moment = datetime(2026, 1, 15, 2, tzinfo=UTC)
    between = read_levels(file, Choice((-34.95, east), moment))
    assert between.temperature[0] == pytest.approx(293.15 + 2 * 0.05 + 3 * 0.25 + 0.2)
    assert between.time == moment
    nearest = read_levels(file, Choice((-34.95, east + 0.1), moment, interpolated=False))
    assert nearest.temperature[0] == pytest.approx(293.15 + 3 * 0.5)


@pytest.mark.parametrize(
    ("choice", "message"),
    [
        (
            Choice((-40.0, 138.2), datetime(2026, 1, 15, tzinfo=UTC)),
            "ends at -34.75; the site lies outside, at -40",
        ),
        (Choice((-35.0, 20.0), datetime(2026, 1, 15, tzinfo=UTC)), "the site lies outside, at 20"),
        (Choice((-35.0, 138.2)), "has 2 soundings, 0 of them"),
        (Choice((-35.0, 138.2), datetime(2026, 3, 1, tzinfo=UTC)), "no sounding within 12 h of 2026-03-01"),
        (Choice(time=datetime(2026, 1, 15, tzinfo=UTC)), "has columns at 2 nodes of latitude; allowed: one"),
    ],
)
def test_a_place_or_time_that_a_grid_does_not_hold_is_refused(tmp_path, choice, message):
    file = write_netcdf(tmp_path / "g.nc", latitudes=(-34.75, -35.0), longitudes=(138.0, 138.5), hours=(0, 6))
    with pytest.raises(InputError, match=message):
        read_levels(file, choice)


def test_underground_and_repeated_levels_of_a_grid_are_left_out(tmp_path):
    """Levels above the model's top that repeat its height."""
    rows = [*AIR, (5600, 400.0, -16.0, -30.0)]
    levels = read_levels(write_netcdf(tmp_path / "g.nc", rows))
    assert levels.pressure.size == len(AIR) and "1 of 6 levels" in levels.notes[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda data: data.renameVariable("t", "x") or data["x"].delncattr("standard_name"), "has no temperature"),
        (lambda data: data["t"].setncattr("units", "furlong"), "found the unit 'furlong' of t"),
        (lambda data: data["z"].setncattr("units", "kg"), "found the unit 'kg' of z"),
        (lambda data: data["pressure_level"].setncattr("units", "m"), "found the unit 'm' of pressure_level"),
        (lambda data: data["valid_time"].setncattr("units", "ages"), "is netCDF that cannot be read"),
        (lambda data: data["t"].__setitem__(slice(None), np.nan), "found 0 levels with pressure and temperature"),
        (lambda data: data["t"].__setitem__(slice(None), 1e30), "level 1: found 1e.30, which is 1e.30 K; allowed"),
        (lambda data: data["q"].__setitem__(slice(None), -1.0), "level 1: found -1"),
    ],
)
def test_wrong_netcdf_is_one_clear_line(tmp_path, change, message):
    netcdf = pytest.importorskip("netCDF4")
    file = write_netcdf(tmp_path / "g.nc")
    with netcdf.Dataset(file, "a") as data:
        change(data)
    with pytest.raises(InputError, match=message) as caught:
        read_levels(file)
    assert "\n" not in str(caught.value) and str(caught.value).startswith(str(file))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (igra_text().replace(" 101000B", " 1010x0B"), r"air.txt:2:10: pressure: found '1010x0'"),
        (igra_text().replace("    6 ncdc", "    9 ncdc"), r"air.txt:1:1: found no header of a sounding with as many"),
        (wyoming_text().replace("   20.0", "   2x.0"), r"air.txt:9:18: temperature: found '2x.0'"),
        (wyoming_text().replace("    hPa     m", "    hPa furlong"), r"air.txt:6:1: found the unit 'furlong' of HGHT"),
        (wyoming_text().replace(" 1010.0 ", "1010.00  "), r"air.txt:9:.*columns are not aligned with their names"),
        (wyoming_text().replace("    hPa", ""), r"air.txt:6:1: found 10 units below 11 names"),
        (
            wyoming_text().replace("   TEMP   DWPT", "   TEMP-  DWPT"),
            r"air.txt:5:1: the column of temperature is missing",
        ),
        ("", r"air.txt: found 0 rows of numbers; allowed: 2"),
        ("a,b\n1,2\n3,4\n", r"air.txt:1:1: the column 'altitude' is missing"),
        (plain_csv().replace("20.0", "1e9"), r"air.txt:2:11: found 1e\+09, which is 1e\+09 K; allowed: 140 to 335 K"),
        (plain_csv().replace("20.0", "inf"), r"air.txt:2:11: temperature: found 'inf'; allowed: a finite number"),
    ],
)
def test_wrong_texts_are_placed(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_levels(saved(tmp_path, text))


@pytest.mark.parametrize(
    "content", [b"\x89HDF\r\n\x1a\n" + bytes(200), b"CDF\x01" + bytes(90), bytes(range(256)), b"\xff" * 40]
)
def test_binary_garbage_is_one_clear_line(tmp_path, content):
    (tmp_path / "air.nc").write_bytes(content)
    with pytest.raises(InputError) as caught:
        read_levels(tmp_path / "air.nc")
    assert "\n" not in str(caught.value)
