"""`sounding` of a state and the series of a folder: what is read, what identifies the air, and what is warned of."""

import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.atmosphere import air_key, atmospheric_state
from skyshine.schemas.errors import InputError

DAY = {"air_temperature_c": 20}
CSV = "altitude[m],pressure[hPa],temperature[C],relative_humidity[%]\n10,1010,{},60\n1500,846.4,10,50\n"


def igra(celsius, *hours):
    text = ""
    for hour in hours:
        text += f"#ASM00094672 2026 01 15 {hour:02d} 9999    2 ncdc6310 ncdc6310 -349500  1385300\n"
        text += f"21     0 101000B   10B{10 * celsius + hour:5d}B-9999    80   220    30 \n"
        text += "20   240  84640B 1500B  100B-9999    80   220    30 \n"
    return text


def job_of(folder, *states, date="2026-01-15"):
    site = {"latitude_deg": -34.95, "longitude_deg": 138.53, "date": date, "utc_offset_h": 10.5}
    document = {"skyshine": 1, "name": "air", "site": site, "states": [{"weather": DAY} | state for state in states]}
    return load_job(document | {"bands": [{"wavelength_um": [8, 12]}], "materials": ["concrete"]}, folder=folder)


def ground(loaded):
    job = loaded.trimmed
    return [round(float(atmospheric_state(job.site, state).temperature[0]) - 273.15, 2) for state in job.states]


def test_a_folder_of_soundings_makes_a_state_of_each_in_order_of_time(tmp_path):
    folder = tmp_path / "air"
    folder.mkdir()
    (folder / "igra.txt").write_text(igra(20, 6, 18), encoding="utf-8")
    (folder / "sonde_20260114.csv").write_text(CSV.format(25), encoding="utf-8")
    (folder / ".hidden").write_text("no sounding", encoding="utf-8")
    loaded = job_of(tmp_path, {"series": {"soundings": "air"}})
    states = loaded.trimmed.states
    # 18 UTC is 04:30 of the next day in Adelaide.
    assert [str(state.date) for state in states] == ["2026-01-14", "2026-01-15", "2026-01-16"]
    assert [state.sounding.choice.time for state in states] == [None, 16.5, 4.5]
    assert ground(loaded) == [25.0, 20.6, 21.8]
    assert len({air_key(state) for state in states}) == 3


def test_the_time_of_a_sounding_chooses_it_and_identifies_the_air(tmp_path):
    (tmp_path / "igra.txt").write_text(igra(20, 0, 6), encoding="utf-8")
    states = [{"sounding": {"file": "igra.txt", "time": clock}} for clock in ("10:30", "11:00", "16:00")]
    loaded = job_of(tmp_path, *states)
    assert ground(loaded) == [20.0, 20.0, 20.6]
    first, same, other = (air_key(state) for state in loaded.trimmed.states)
    assert first == same != other
    with pytest.raises(InputError, match="igra.txt: has 2 soundings, 2 of them on the state's day"):
        job_of(tmp_path, {"sounding": "igra.txt"})


def test_what_is_missing_or_of_another_season_is_warned_of(tmp_path):
    (tmp_path / "igra.txt").write_text(igra(20, 6), encoding="utf-8")
    (tmp_path / "dry.csv").write_text(CSV.format(20) + "5600,505.5,-16,\n", encoding="utf-8")
    loaded = job_of(tmp_path, {"sounding": "igra.txt"}, {"sounding": "dry.csv"}, date="2026-07-15")
    assert loaded.warnings == (
        "state 1: sounding igra.txt is of 2026-01-15 06:00 UTC, 181 days from the state's date (warned beyond 7)",
        "state 2: sounding dry.csv has no humidity above 2 km; that of the profile is used there",
    )
    assert job_of(tmp_path, {"sounding": "igra.txt"}, date="2026-01-20").warnings == ()


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"sounding": "none.csv"}, "found 'none.csv', which is no file"),
        ({"sounding": "../a.csv"}, "leads out of the job's folder"),
        ({"sounding": {"file": "igra.txt", "hour": 6}}, "unknown key 'hour'"),
        ({"sounding": {"file": "igra.txt", "time": "25:00"}}, "found '25:00'"),
        ({"sounding": {"file": "plain.csv", "time": "06:00"}}, "does not say when it was measured"),
        ({"sounding": 7}, "sounding"),
        ({"series": {"soundings": "nowhere"}}, "nowhere: is no folder"),
        ({"series": {"soundings": "empty"}}, "empty: contains 0 soundings; allowed: 1 to"),
        ({"series": {"soundings": "../.."}}, "leads out of the job's folder"),
        ({"series": {"soundings": "bad"}}, "notes.txt:1:1: the column 'altitude' is missing"),
    ],
)
def test_a_wrong_sounding_is_one_clear_line(tmp_path, state, message):
    (tmp_path / "igra.txt").write_text(igra(20, 6), encoding="utf-8")
    (tmp_path / "plain.csv").write_text(CSV.format(20), encoding="utf-8")
    for name in ("empty", "bad"):
        (tmp_path / name).mkdir()
    (tmp_path / "bad" / "notes.txt").write_text("notes\nof\nmine\n", encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        job_of(tmp_path, state)
    assert "\n" not in str(caught.value)
