"""Keys of air without a job: the same as those of a state, and what needs a job is refused."""

import inspect

import pytest

import skyshine.mat
from skyshine.mat.job.air import KEYS, WIND, described_state
from skyshine.mat.job.atmosphere import State
from skyshine.schemas.errors import InputError

NOT_OF_AIR = {  # keys of a state that need a day or a surface
    "name",
    "series",
    "air",
    "air_times",
    "ground_material",
    "surroundings",
    "date",
    "weather",
}


def test_every_key_of_a_state_is_of_the_air_or_needs_a_job():
    assert {*KEYS} - {WIND} == {*State.model_fields} - NOT_OF_AIR


@pytest.mark.parametrize("function", ["spectrum", "fluxes"])
def test_functions_name_the_keys(function):
    parameters = inspect.signature(getattr(skyshine.mat, function)).parameters
    assert {*KEYS} <= {*parameters} and "air" not in parameters
    assert parameters["co2_ppm"].default == State.model_fields["co2_ppm"].default


def test_values_are_those_of_a_job(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    _, state = described_state({"preset": "rain", "visibility_km": 3, WIND: 7, "gases": {"O3": {"scale": 2}}})
    assert (state.visibility_km, state.weather.wind_speed_m_s, state.gases["O3"].scale) == (3.0, 7.0, 2.0)
    assert state.rain is not None and state.air == "profile"
    text = "altitude[m],pressure[hPa],temperature[C],dew_point[C]\n1600,835,20,10\n4000,625,4,-5\n"
    (tmp_path / "high.csv").write_text(text)
    site, state = described_state({"sounding": "../" + tmp_path.name + "/high.csv"})
    assert site.altitude_km == 1.6 and state.profile == "us_standard"


@pytest.mark.parametrize(
    ("air", "message"),
    [
        ({"visibility": 5}, "found the key 'visibility' of air; did you mean 'visibility_km'"),
        ({"weather": {}}, "found the key 'weather'"),
        ({"aerosol_optical_depth": "typical"}, "need a place and a date"),
        ({"profile": "auto"}, "need a place and a date"),
        ({"sounding": {"file": "a.csv", "time": "12:00"}}, "is no file"),
        ({"clouds": ["stratus"]}, r"^clouds\.0: found 'stratus'"),
    ],
)
def test_what_does_not_fit_is_one_line_without_a_file(air, message):
    with pytest.raises(InputError, match=message) as raised:
        described_state(air)
    assert raised.value.file is None


def test_an_unknown_argument_is_answered_with_the_nearest():
    with pytest.raises(InputError, match="found the argument 'visibility'; did you mean 'visibility_km'"):
        skyshine.mat.spectrum(wavelength=(8, 9), visibility=5)
