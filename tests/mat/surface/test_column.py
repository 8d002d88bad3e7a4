"""One surface under a measured record, by the command: closed forms of conduction, closing fluxes, finer steps."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from skyshine.mat.commands.temperature import command
from skyshine.mat.surface.weather_readings import read_record
from skyshine.schemas.errors import InputError

HEADER = "time,sw_down,lw_down,air_temperature[C],relative_humidity,wind_speed,pressure[hPa]"
MATERIAL = """
skin:
  thickness: {value: 0.002, source: test}
  conductivity: {value: 1.0, source: test}
  density: {value: 2000, source: test}
  heat_capacity: {value: 1000, source: test}
layers:
  - {thickness: {value: 0.1, source: test}, conductivity: {value: 1.0, source: test},
     density: {value: 2000, source: test}, heat_capacity: {value: 1000, source: test}}
  - {thickness: {value: 5.0, source: test}, conductivity: {value: 1.0, source: test},
     density: {value: 2000, source: test}, heat_capacity: {value: 1000, source: test}}
back:
  kind: {value: adiabatic, source: test}
surface:
  roughness_length: {value: 0.005, source: test}
  wetness: {value: 0, source: test}
  surface_resistance: {value: 0, source: test}
  canopy: {value: false, source: test}
  snow: {value: false, source: test}
"""


def write(folder, *rows, header=HEADER):
    file = folder / "weather.csv"
    file.write_text("\n".join(["# a record", header, *rows]) + "\n")
    return file


def hourly(days=1, row="{sun:.1f},300,20,40,2.0,950"):
    for hour in range(24 * days):
        sun = 800 * max(0.0, np.sin(np.pi * (hour % 24 - 6) / 12))
        yield f"2026-06-{21 + hour // 24:02d}T{hour % 24:02d}:00:00Z," + row.format(sun=sun)


def run(tmp_path, *extra, rows=None, header=HEADER):
    material = tmp_path / "solid.yaml"
    material.write_text(MATERIAL)
    file = write(tmp_path, *(rows or hourly()), header=header)
    optical = ["--absorptance", "1", "--emissivity", "1"]
    return CliRunner().invoke(command, ["--material", str(material), *optical, "--forcing", str(file), *extra])


def test_command_gives_temperature_and_closing_fluxes(tmp_path):
    result = run(tmp_path, "--json")
    assert result.exit_code == 0, result.output
    output = json.loads(result.output)
    flux = {
        name: np.array(part["values"])
        for name, part in output.items()
        if isinstance(part, dict) and part["units"] == "W m^-2" and "values" in part
    }
    assert set(flux) == {
        *("shortwave_absorbed", "longwave_absorbed", "longwave_emitted"),
        *("convection", "evaporation", "conduction", "melt"),
    }
    assert output["time"]["values"][0] == "2026-06-21T00:00:00Z" and output["temperature"]["units"] == "K"
    gain = flux["shortwave_absorbed"] + flux["longwave_absorbed"]
    assert np.allclose(gain, sum(flux[name] for name in flux if not name.endswith("absorbed")))
    assert abs(output["energy_closure"]["value"]) < 1e-3 and abs(output["residual"]["value"]) < 1e-3
    assert np.ptp(output["temperature"]["values"]) > 10


def test_command_over_a_steady_record_is_in_equilibrium(tmp_path):
    """A black surface under a black sky at air temperature stays there."""
    rows = [f"2026-06-21T{hour:02d}:00:00Z,0,418.766,20,40,2.0,950" for hour in range(24)]
    output = json.loads(run(tmp_path, "--json", rows=rows).output)
    assert output["temperature"]["values"] == pytest.approx([293.15] * 24, abs=1e-3)


def test_command_over_two_days(tmp_path):
    output = json.loads(run(tmp_path, "--json", rows=list(hourly(2))).output)
    values = np.array(output["temperature"]["values"])
    assert len(values) == 48 and np.allclose(values[:24], values[24:], atol=1e-3)


def test_hourly_record_is_solved_in_finer_steps(tmp_path):
    """The same weather written every hour and every 15 minutes (linear between) gives the same temperatures."""
    series = read_record(write(tmp_path, *hourly())).refined(4)
    rows = [
        f"{time},{sun:.4f},300,20,40,2.0,950" for time, sun in zip(series.times, series.values["sw_down"], strict=True)
    ]
    hour, quarter = (json.loads(run(tmp_path, "--json", rows=r).output)["temperature"]["values"] for r in (None, rows))
    assert hour == pytest.approx(quarter[::4], abs=1e-3)


def test_shade_of_a_record_is_in_utc_and_needs_the_sun(tmp_path):
    place = ("--latitude", "40", "--longitude", "0", "--json")
    sunlit, shaded = (
        np.array(json.loads(run(tmp_path, *place, *shade).output)["shortwave_absorbed"]["values"])
        for shade in (
            ("--sky-view", "0.99"),
            ("--sky-view", "0.99", "--shade", "09:40-14:20", "--shade", "23:00-01:00"),
        )
    )
    hours = np.arange(24)
    inside = (hours >= 10) & (hours <= 14)
    assert np.all(shaded[inside] < 0.8 * sunlit[inside]) and np.all(shaded[inside] > 0)
    assert np.array_equal(shaded[~inside], sunlit[~inside])
    assert "give latitude and longitude" in str(run(tmp_path, "--shade", "10:00-14:00").exception)


def test_a_wall_under_a_dull_sky_that_sees_none_of_it_is_dark(tmp_path):
    rows = [f"2026-06-21T{hour:02d}:00Z,{40 if 9 <= hour <= 15 else 0},300,20,40,2.0,950" for hour in range(24)]
    place = ("--latitude", "40", "--longitude", "0", "--slope", "90", "--azimuth", "0", "--ground-albedo", "0")
    light = [
        np.array(json.loads(run(tmp_path, *place, *sky, "--json", rows=rows).output)["shortwave_absorbed"]["values"])
        for sky in ((), ("--sky-view", "0"))
    ]
    assert light[0].max() > 15 and np.abs(light[1]).max() < 1e-9


def minutes(wave):
    for minute in range(1440):
        value = wave(2 * np.pi * minute / 1440)
        yield f"2026-06-21T{minute // 60:02d}:{minute % 60:02d}:00Z,{value:.6f},300,20,40,0,0"


def first_harmonic(values):
    return np.fft.rfft(values)[1] * 2 / len(values)


def vacuum_wave(tmp_path, material, *extra):
    """The command under a 24 h flux wave of 100 W/m2 on a body that does not radiate, without air."""
    (tmp_path / "body.yaml").write_text(material)
    file = write(tmp_path, *minutes(lambda angle: 150 + 100 * np.cos(angle)))
    arguments = ["--material", str(tmp_path / "body.yaml"), "--forcing", str(file), "--json", *extra]
    result = CliRunner().invoke(command, [*arguments, "--absorptance", "1", "--emissivity", "0"])
    assert result.exit_code == 0, result.exception
    return json.loads(result.output)


def test_command_on_the_semi_infinite_solid(tmp_path):
    """Flux wave: amplitude 100 / 12.0600 K, lag 3 h; wave at 0.10 m: ratio 0.426232, lag 3.2574 h (5 m is 43 damping
    depths; the 2 mm skin is made of nothing here)."""
    body = MATERIAL.replace(
        "{value: adiabatic, source: test}", "{value: fixed, source: test}\n  temperature: {value: 280, source: test}"
    )
    body = body.replace("thickness: {value: 0.002", "thickness: {value: 1.0e-6", 1)
    output = vacuum_wave(tmp_path, body, "--depth", "0.1")
    surface, below = (first_harmonic(output[name]["values"]) for name in ("temperature", "temperature_at_depth"))
    assert abs(surface) == pytest.approx(100 / 12.0600, rel=5e-5)
    assert -np.angle(surface) * 12 / np.pi == pytest.approx(3.0, abs=5e-4)
    assert abs(below / surface) == pytest.approx(0.426232, abs=2e-6)
    assert -np.angle(below / surface) * 12 / np.pi == pytest.approx(3.2574, abs=5e-5)


WALL = """
skin: {thickness: {value: 1.0e-6, source: t}, conductivity: {value: 1, source: t}, density: {value: 1, source: t},
  heat_capacity: {value: 1000, source: t}}
layers:
  - {thickness: {value: 0.1, source: t}, conductivity: {value: 1.4, source: t}, density: {value: 2100, source: t},
     heat_capacity: {value: 880, source: t}}
  - {thickness: {value: 0.05, source: t}, conductivity: {value: 0.035, source: t}, density: {value: 30, source: t},
     heat_capacity: {value: 1400, source: t}}
back: {kind: {value: convective, source: t}, temperature: {value: 293, source: t}, coefficient: {value: 8, source: t}}
surface:
  roughness_length: {value: 0.005, source: test}
  wetness: {value: 0, source: test}
  surface_resistance: {value: 0, source: test}
  canopy: {value: false, source: test}
  snow: {value: false, source: test}
"""


def test_command_on_the_two_layer_wall(tmp_path):
    """Transfer matrix: |Y1| = 12.3128 at 70.519 degrees, U = 0.61538 W/m2K."""
    output = vacuum_wave(tmp_path, WALL)
    temperature = np.array(output["temperature"]["values"])
    wave = first_harmonic(temperature)
    assert abs(wave) == pytest.approx(100 / 12.3128, rel=5e-5)
    assert -np.degrees(np.angle(wave)) == pytest.approx(70.519, abs=5e-3)
    assert temperature.mean() == pytest.approx(293 + 150 / 0.61538, abs=3e-3)


def test_slope_without_a_place_is_refused(tmp_path):
    result = run(tmp_path, "--slope", "30")
    assert isinstance(result.exception, InputError) and "latitude" in str(result.exception)


def test_slope_takes_the_sun_of_its_place(tmp_path):
    """Near noon in June at 40 N a steep north face gets less than a level one, a south face at 25 degrees more."""
    place = ["--latitude", "40", "--longitude", "0", "--json"]
    level = json.loads(run(tmp_path, "--json").output)["shortwave_absorbed"]["values"][12]
    north = json.loads(run(tmp_path, "--slope", "70", "--azimuth", "0", *place).output)["shortwave_absorbed"]["values"][
        12
    ]
    south = json.loads(run(tmp_path, "--slope", "25", "--azimuth", "180", *place).output)["shortwave_absorbed"][
        "values"
    ][12]
    assert north < 0.6 * level and south > level


def test_material_file_needs_its_optical_values(tmp_path):
    material = tmp_path / "solid.yaml"
    material.write_text(MATERIAL)
    forcing = write(tmp_path, *hourly())
    result = CliRunner().invoke(command, ["--material", str(material), "--forcing", str(forcing)])
    assert isinstance(result.exception, InputError) and "no absorptance" in str(result.exception)


def test_job_and_forcing_exclude_each_other(tmp_path):
    result = CliRunner().invoke(command, ["--material", "concrete"])
    assert isinstance(result.exception, InputError) and "both or neither" in str(result.exception)


def test_temperature_at_depth_lies_on_the_line_to_a_steady_back(tmp_path):
    """At rest the profile is straight: a surface in vacuum that takes up 150 W/m2 through 0.1 m and 5 m of 1 W/mK is
    280 + 150 x 5.1 K warm, and 280 + 150 x 5 K at the bottom of the first layer, 15 K less."""
    fixed = "{value: fixed, source: test}\n  temperature: {value: 280, source: test}"
    (tmp_path / "body.yaml").write_text(MATERIAL.replace("{value: adiabatic, source: test}", fixed))
    file = write(tmp_path, *minutes(lambda angle: 150.0))
    arguments = ["--material", str(tmp_path / "body.yaml"), "--forcing", str(file), "--json", "--depth", "0.1"]
    result = CliRunner().invoke(command, [*arguments, "--absorptance", "1", "--emissivity", "0"])
    output = json.loads(result.output)
    assert output["temperature"]["values"] == pytest.approx(1440 * [280 + 150 * 5.1], abs=1e-2)
    assert output["temperature_at_depth"]["values"] == pytest.approx(1440 * [280 + 150 * 5.0], abs=1e-2)


def test_direct_and_diffuse_light_of_a_record_need_the_sun_and_are_taken_as_they_are(tmp_path):
    """Level ground under a total that is all diffuse is as under that total."""
    plain = json.loads(run(tmp_path, "--json").output)
    rows = [f"{row},0" for row in hourly()]
    header = HEADER.replace("sw_down", "diffuse") + ",direct_normal"
    refused = run(tmp_path, rows=rows, header=header)
    assert isinstance(refused.exception, InputError) and "give latitude and longitude" in str(refused.exception)
    parts = json.loads(run(tmp_path, "--latitude", "47", "--longitude", "8", "--json", rows=rows, header=header).output)
    assert parts["temperature"]["values"] == pytest.approx(plain["temperature"]["values"], abs=1e-6)
    without = run(tmp_path, rows=rows, header=HEADER.replace("sw_down", "diffuse") + ",cloud_fraction")
    assert "the column 'sw_down' is missing; add it, or direct_normal and diffuse" in str(without.exception)


def test_what_a_record_lacks_is_noted(tmp_path):
    rows = [",".join(row.split(",")[:2] + row.split(",")[3:6]) for row in hourly()]
    header = "time,sw_down,air_temperature[C],relative_humidity,wind_speed"
    result = run(tmp_path, "--altitude", "2", rows=rows, header=header)
    assert "note: no pressure: 795 hPa is taken" in result.output and "note: no lw_down" in result.output
    notes = json.loads(run(tmp_path, "--json", rows=rows, header=header).output)["notes"]
    assert len(notes) == 3 and "1013 hPa" in notes[0]


def test_the_end_of_a_record_does_not_warm_its_begin(tmp_path):
    """Two days of 20 C, then one of 45: the first night is that of a first day that repeats, and the notes say so."""
    rows = [row.replace(",300,20,", ",300,45,") if "-23T" in row else row for row in hourly(days=3)]
    outputs = [json.loads(run(tmp_path, "--json", rows=each).output) for each in (rows, list(hourly()))]
    record, day = (np.array(output["temperature"]["values"]) for output in outputs)
    assert record.size == 72 and outputs[0]["time"]["values"][0].startswith("2026-06-21T00:00:00")
    assert record[:48] == pytest.approx(np.tile(day, 2), abs=0.5) and record[60:].mean() > day[12:].mean() + 5
    notes = [" ".join(output["notes"]) for output in outputs]
    assert (
        "the first day, 7 times, is repeated for them (spin-up)" in notes[0] and "the record, 24 h, repeats" in notes[1]
    )
