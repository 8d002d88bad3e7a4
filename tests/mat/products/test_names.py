"""Names of state, band and date in the files and in the catalogue."""

import json

import pytest

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.summary import state_attributes

SOUNDING = "altitude[km],pressure[hPa],temperature[C],relative_humidity[%]\n0,1013,25,50\n2,795,12,40\n10,265,-50,10\n"


def state(tmp_path, tiny_job, keys):
    (tmp_path / "kyoto.csv").write_text(SOUNDING, encoding="utf-8")
    file = tmp_path / "job.yaml"
    file.write_text(tiny_job().replace("  - profile: midlatitude_summer", f"  - {keys}"), encoding="utf-8")
    return load_job(file).trimmed.states[0]


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ("profile: tropical", {"state": "tropical", "air": "weather, day's mean"}),
        ("profile: tropical\n    air: profile", {"state": "tropical", "air": "profile"}),
        ("preset: desert_noon", {"state": "desert_noon", "air": "weather, day's mean"}),
        (
            "sounding: kyoto.csv\n    profile: tropical",
            {"state": "sounding", "sounding": "kyoto.csv", "air": "sounding"},
        ),
        (
            "profile: tropical\n    visibility_km: null\n    aerosol_optical_depth: 0.12\n    angstrom_exponent: 1.4",
            {
                "state": "tropical",
                "air": "weather, day's mean",
                "aerosol_optical_depth_550": "0.12",
                "angstrom_exponent": "1.4",
            },
        ),
    ],
)
def test_a_state_has_the_name_of_what_it_is_made_from(tmp_path, tiny_job, keys, expected):
    assert state_attributes(state(tmp_path, tiny_job, keys)) == expected


def test_files_name_state_band_and_date(small_build):
    for name in ("s01b01.atmq", "s01b01.lunar_atmq"):
        attributes = skyshine.mat.open(small_build / f"{name}.h5").attributes
        assert [attributes[key] for key in ("state", "band", "date")] == ["midlatitude_summer", "b01", "2026-06-28"]
    assert skyshine.mat.open(small_build / "b01.band.h5").attributes["band"] == "b01"
    assert skyshine.mat.open(small_build / "s01.htt.h5").attributes["date"] == "2026-06-28"


def test_the_catalogue_has_the_names_beside_the_numbers(small_build):
    catalogue = json.loads((small_build / "catalog.json").read_text(encoding="utf-8"))
    moon = next(entry for entry in catalogue["files"] if entry["file"] == "s01b01.lunar_atmq.h5")
    names = {key: moon[key] for key in ("state", "state_name", "band", "band_name", "date", "source")}
    assert names == {
        "state": 1,
        "state_name": "midlatitude_summer",
        "band": 1,
        "band_name": "b01",
        "date": "2026-06-28",
        "source": "moon",
    }
