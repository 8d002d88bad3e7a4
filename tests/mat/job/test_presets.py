"""Ready states: each makes air, keys beside a preset win, and the commands show them."""

import json

import pytest
from click.testing import CliRunner

from skyshine.mat.commands.check import command as check
from skyshine.mat.commands.info import command
from skyshine.mat.job.load import load_job
from skyshine.mat.job.presets import presets
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.summary import state_summaries
from skyshine.schemas.errors import InputError

JOB = """\
skyshine: 1
name: ready
site: {{latitude_deg: 48.1, longitude_deg: 11.6, date: 2026-06-21, utc_offset_h: 1, altitude_km: 0.5}}
states:
  - preset: {preset}
{more}bands: [{{wavenumber_cm: [800, 1250]}}]
materials: [concrete]
"""


def job(folder, preset, more=""):
    (folder / "job.yaml").write_text(JOB.format(preset=preset, more=more), encoding="utf-8")
    return load_job(folder / "job.yaml").trimmed


@pytest.mark.parametrize("name", presets())
def test_each_preset_is_a_state(tmp_path, name):
    ready = job(tmp_path, name)
    state = atmospheric_state(ready.site, ready.states[0])
    assert state.altitude[0] == 500.0 and state.particles
    assert bool(state.hydrometeors) == bool(ready.states[0].clouds or ready.states[0].rain)


def test_keys_beside_a_preset_win(tmp_path):
    state = job(tmp_path, "hazy_urban", "    visibility_km: 3\n    weather: {wind_speed_m_s: 9}\n").states[0]
    assert (state.visibility_km, state.aerosol, state.weather.wind_speed_m_s) == (3.0, "urban", 9.0)
    assert state.weather.air_temperature_c == (20.0, 32.0)
    measured = job(tmp_path, "hazy_urban", "    aerosol_optical_depth: 0.7\n").states[0]
    assert (measured.visibility_km, measured.aerosol_optical_depth) == (None, 0.7)


def test_weather_and_gases_are_joined_key_by_key(tmp_path):
    hours = (
        "{time: [00:00, 03:00, 06:00, 09:00, 12:00, 15:00, 18:00, 21:00], air_temperature_c: [20, 20, 20, 30, 40, 40,"
        " 30, 20]}"
    )
    more = f"    gases: {{H2O: {{scale: 0.5}}, O3: {{scale: 2}}}}\n    weather: {{hourly: {hours}}}\n"
    state = job(tmp_path, "desert_noon", more).states[0]
    assert (state.gases["H2O"].scale, state.gases["H2O"].column_mm, state.gases["O3"].scale) == (0.5, None, 2.0)
    assert state.weather.hourly is not None and state.weather.air_temperature_c is None
    assert state.weather.relative_humidity_percent == 15.0


def test_observers_stand_at_the_edges_of_cloud(tmp_path):
    clear, overcast = (job(tmp_path, name).observer_altitudes_km for name in ("hazy_urban", "overcast_stratus"))
    assert set(overcast) - set(clear) == {0.83, 1.5} - set(clear) and sorted(overcast) == overcast


def test_a_resolved_state_is_itself_again(tmp_path):
    first = job(tmp_path, "rain").states[0]
    again = type(first).model_validate(first.model_dump(mode="json"))
    assert again.model_dump() == first.model_dump()


def test_the_commands_show_presets_and_states(tmp_path):
    run = CliRunner().invoke
    assert "overcast_stratus" in run(command, ["--preset"]).output
    assert json.loads(run(command, ["--preset", "rain", "--json"], catch_exceptions=False).output)["rain"] == {
        "rate_mm_h": 5,
        "top_km": 0.6,
    }
    with pytest.raises(InputError, match="did you mean 'rain'"):
        run(command, ["--preset", "ran"], catch_exceptions=False)
    job(tmp_path, "rain")
    text = run(check, [str(tmp_path / "job.yaml")], catch_exceptions=False).output
    assert "water cloud 0.6 to 3 km above ground, optical depth 46" in text and "rain 5 mm/h below 0.6 km" in text
    shown = state_summaries(load_job(tmp_path / "job.yaml").trimmed)[0]
    assert shown["preset"] == "rain" and shown["clouds"][0]["optical_depth_550"]["value"] == pytest.approx(
        46.0, abs=0.1
    )


def test_a_changed_sounding_or_response_is_another_job(tmp_path):
    (tmp_path / "air.csv").write_text(
        "altitude[m],pressure[hPa],temperature[C],dew_point[C]\n400,970,15,8\n3000,705,0,-10\n"
    )
    (tmp_path / "phi.csv").write_text("wavelength[um],response\n8,1\n9,1\n")
    text = JOB.format(preset="rain", more="    sounding: air.csv\n").replace(
        "wavenumber_cm: [800, 1250]", "response: phi.csv"
    )
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    first = load_job(tmp_path / "job.yaml").trimmed.model_dump(mode="json")
    (tmp_path / "air.csv").write_text(
        "altitude[m],pressure[hPa],temperature[C],dew_point[C]\n400,970,15,9\n3000,705,0,-10\n"
    )
    second = load_job(tmp_path / "job.yaml").trimmed.model_dump(mode="json")
    assert first["states"] != second["states"] and first["bands"] == second["bands"]
    assert first["states"][0]["sounding"]["file"] == "air.csv"
