"""Tables of temperatures with the season of the ground: what the file says, and that it is built anew for another."""

import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job

JOB = {
    "skyshine": 1,
    "name": "ground",
    "site": {"latitude_deg": 50, "longitude_deg": 10, "date": "2026-01-20", "utc_offset_h": 1},
    "states": [{"profile": "midlatitude_winter", "weather": {"air_temperature_c": [8, 12]}}],
    "bands": [],
    "materials": ["soil_loam_brown", "brick_red"],
    "surface_grid": {"altitude_km": [0], "azimuth_deg": [0, 180], "slope_deg": [0, 90], "time": ["00:00", "12:00"]},
    "needs": {"shade": False},
    "output": {"pictures": False},
}


def test_a_warm_winter_day_lies_over_cold_ground(build_surface, tmp_path):
    """10 C of the day against some 1 C a metre below in January, by a conductance of 1 W/m2/K: half a kelvin."""
    files = []
    for name, ground in (("air", None), ("season", {"mean_c": 9, "amplitude_c": 9})):
        weather = JOB["states"][0]["weather"] | ({} if ground is None else {"ground": ground})
        job = JOB | {"states": [JOB["states"][0] | {"weather": weather}]}
        (tmp_path / name).mkdir()
        files.append(skyshine.mat.open(build_surface(load_job(job, folder=tmp_path), tmp_path / name)))
    air, season = files
    assert "ground" not in air.attributes
    assert season.attributes["ground"] == "mean 9 C, amplitude 9 K, coldest on day 15"
    where = {"altitude": 0, "azimuth": 0, "slope": 0, "time": 0.0}
    cooler = [float(each.temperature(material="soil_loam_brown", **where)) for each in files]
    assert 0.2 < cooler[0] - cooler[1] < 1.5
    walls = [float(each.temperature(material="brick_red", **where)) for each in files]
    assert walls[0] == pytest.approx(walls[1], abs=1e-3)  # its back is a room
