"""`air` and `air_times` of a state: what the air near the ground follows, by day and at stated times."""

import numpy as np
import pytest

from skyshine.mat.job.load import load_job
from skyshine.mat.scene.atmosphere import air_key, air_text, atmospheric_state
from skyshine.mat.scene.surface import scene_inputs
from skyshine.mat.scene.weather import near_surface_air, sun_path
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.errors import InputError

DAY = {"air_temperature_c": [12, 30], "relative_humidity_percent": 40}
HOURLY = {
    "hourly": {
        "time": [f"{hour:02d}:00" for hour in range(0, 24, 3)],
        "air_temperature_c": [14, 12, 13, 20, 26, 30, 25, 18],
        "relative_humidity_percent": [80, 85, 80, 50, 40, 30, 45, 60],
        "pressure_hpa": [818, 818, 818, 819, 819, 819, 818, 818],
        "altitude_km": 1.829,
    }
}


def job_of(*states, **more):
    site = {"latitude_deg": 39.7, "longitude_deg": -105.2, "date": "2026-06-22", "utc_offset_h": -7, "altitude_km": 1.8}
    document = {"skyshine": 1, "name": "air", "site": site, "states": list(states), **more}
    return load_job(document | {"bands": [{"wavelength_um": [8, 12]}], "materials": ["concrete"]}).trimmed


def air_of(state):
    job = job_of(state)
    return [atmospheric_state(job.site, one) for one in job.states]


def relative_humidity(air):
    return 100 * air.mole_fraction["H2O"][0] * air.pressure[0] / saturation_pressure(air.temperature[0])


@pytest.fixture
def sounding(tmp_path, monkeypatch):
    rows = "1800,820,20,40\n3000,710,8,40\n"
    (tmp_path / "s.csv").write_text("altitude[m],pressure[hPa],temperature[C],relative_humidity[%]\n" + rows)
    monkeypatch.chdir(tmp_path)
    return "s.csv"


def test_the_ground_has_the_day_s_mean_of_the_weather():
    (air,) = air_of({"weather": DAY})
    assert air.temperature[0] == pytest.approx(294.15) and air.surface_temperature == pytest.approx(294.15)
    assert relative_humidity(air) == pytest.approx(40)
    (constant,) = air_of({"weather": {"air_temperature_c": 21, "relative_humidity_percent": 40}})
    assert constant.temperature == pytest.approx(air.temperature)


def test_a_sounding_is_believed_before_the_weather_unless_the_job_says_otherwise(sounding):
    job = job_of(
        *[{"weather": DAY, "sounding": sounding} | more for more in ({}, {"air": "weather"})], {"weather": DAY}
    )
    assert [state.air for state in job.states] == ["profile", "weather", "weather"]
    assert [air_text(state) for state in job.states] == ["sounding", "weather, day's mean", "weather, day's mean"]
    kelvin = [atmospheric_state(job.site, state).temperature[0] for state in job.states]
    assert kelvin == pytest.approx([293.15, 294.15, 294.15])


def test_the_profile_stays_where_it_is_asked_for():
    job = job_of(
        *[{"profile": "us_standard", "air": "profile", "weather": w} for w in (DAY, {"air_temperature_c": -20})]
    )
    airs = [atmospheric_state(job.site, state) for state in job.states]
    assert airs[0].temperature[0] == pytest.approx(288.2 - 1.8 * 6.5) and airs[0].surface_temperature == 294.15
    assert np.array_equal(airs[0].temperature, airs[1].temperature)
    assert air_key(job.states[0]) == air_key(job.states[1])


def test_each_time_makes_a_state_with_the_air_of_that_time():
    """The heat balance of each has the day's mean air in its sky, and the whole day's weather."""
    job = job_of({"weather": DAY, "air_times": ["05:00", "14:00"]}, {"weather": DAY})
    assert [state.air_time for state in job.states] == [5.0, 14.0, None]
    assert [air_text(state) for state in job.states][:2] == ["weather at 05:00", "weather at 14:00"]
    assert len({air_key(state) for state in job.states}) == 3
    weather = near_surface_air(sun_path(job.site), job.states[0].weather)
    for state in job.states[:2]:
        air = atmospheric_state(job.site, state)
        assert air.temperature[0] == pytest.approx(np.interp(state.air_time, sun_hours(), weather.air_temperature))
        assert air.surface_temperature == air.temperature[0]
    night, noon = (atmospheric_state(job.site, state) for state in job.states[:2])
    assert (
        night.temperature_at(2000.0) > night.temperature[0] and noon.temperature_at(2000.0) < noon.temperature[0] - 1.9
    )
    skies = [scene_inputs(job, number)[2].emissivity for number in (1, 2, 3)]
    assert np.array_equal(skies[0], skies[1]) and np.array_equal(skies[0], skies[2])


def test_weather_by_hour_reaches_the_air_with_its_altitude_and_pressure():
    """A station 29 m above the ground: .19 K warmer there, the pressure measured."""
    mean = np.mean(np.interp(np.arange(0, 24, 0.25), range(0, 24, 3), HOURLY["hourly"]["air_temperature_c"], period=24))
    (air,) = air_of({"weather": HOURLY})
    assert air.temperature[0] == pytest.approx(mean + 273.15 + 6.5 * 0.029)
    assert air.pressure_at(1829.0) == pytest.approx(818.4e2, abs=60.0)
    (scaled,) = air_of({"weather": HOURLY, "humidity_scale": 0.5})
    assert scaled.pressure[0] == pytest.approx(air.pressure[0], rel=1e-9)
    (noon,) = air_of({"weather": HOURLY, "air_times": ["15:00"]})
    assert noon.temperature[0] == pytest.approx(303.15 + 6.5 * 0.029)
    vapour = 0.3 * saturation_pressure(303.15)
    assert noon.mole_fraction["H2O"][0] == pytest.approx(vapour / 818.375e2, rel=1e-3)


def test_states_share_their_air_where_what_it_follows_is_the_same():
    dry, wind = {"relative_humidity_percent": 20}, {"wind_speed_m_s": 9, "ground_albedo": 0.5}
    keys = [air_key(job_of({"weather": DAY | change}).states[0]) for change in ({}, wind, dry)]
    assert keys[0] == keys[1] != keys[2]
    by_hour = HOURLY["hourly"]
    colder, breeze = {"air_temperature_c": [10] * 8}, {"wind_speed_m_s": [3] * 8}
    thinner = {"pressure_hpa": [800] * 8}
    keys = [
        air_key(job_of({"weather": {"hourly": by_hour | change}}).states[0]) for change in ({}, breeze, colder, thinner)
    ]
    assert keys[0] == keys[1] and len(set(keys)) == 3
    days = [{"weather": DAY, "profile": "tropical"} | date for date in ({}, {"date": "2026-07-01"})]
    assert len({air_key(job_of(day).states[0]) for day in days}) == 1


@pytest.mark.parametrize("amount", [{"humidity_scale": 0.5}, {"gases": {"H2O": {"column_mm": 8}}}])
def test_an_amount_of_water_that_the_job_states_stays(amount):
    """Its mole fractions where it is a factor: warmer air holds fewer molecules. A column to the last digit."""
    (air,) = air_of({"profile": "us_standard", "weather": DAY, **amount})
    (dry,) = air_of({"profile": "us_standard", "air": "profile", "weather": DAY, **amount})
    assert air.temperature[0] == pytest.approx(294.15)
    assert float(air.precipitable_water(1800.0)) == pytest.approx(float(dry.precipitable_water(1800.0)), rel=0.05)
    if "gases" in amount:
        assert float(air.precipitable_water(1800.0)) == pytest.approx(8.0)


@pytest.mark.validation  # 6 s
def test_sky_longwave_follows_the_humidity_at_the_ground():
    """Brutsaert (1975): emissivity 1.24 (e / T)^(1/7); air at 1.8 km emits less, for pressure broadens its lines."""
    emissivity = []
    for percent in (10, 40, 90):
        job = job_of({"weather": {"air_temperature_c": 21, "relative_humidity_percent": percent}})
        emissivity.append(scene_inputs(job, 1)[2].emissivity[0])
    vapour = np.array([0.1, 0.4, 0.9]) * saturation_pressure(294.15) / 100
    assert emissivity == pytest.approx(1.24 * (vapour / 294.15) ** (1 / 7), rel=0.06)
    assert emissivity[2] - emissivity[0] > 0.15


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"weather": DAY, "air": "wether"}, "states.0.air: .*allowed: 'weather' or 'profile'|states.0.air.*weather"),
        ({"weather": DAY, "air": "profile", "air_times": ["05:00"]}, "found air_times and the air of the profile"),
        ({"weather": DAY, "air_times": []}, "air_times"),
        ({"weather": DAY, "air_times": ["14:00", "05:00"]}, "air_times"),
        ({"weather": DAY, "air_times": ["25:00"]}, "air_times"),
    ],
)
def test_other_airs_are_refused(state, message):
    with pytest.raises(InputError, match=message) as refusal:
        job_of(state)
    assert "\n" not in str(refusal.value)
