"""Names of state, band and date in the files and in the catalogue."""

import json

import pytest
from matplotlib.figure import Figure

import skyshine.mat
from skyshine.mat.job.load import load_job
from skyshine.mat.scene.summary import state_attributes
from skyshine.schemas.errors import InputError

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


def test_a_state_bears_the_name_that_the_job_gives(tmp_path, tiny_job):
    named = state(tmp_path, tiny_job, "name: storm\n    preset: desert_noon")
    assert {"state": "storm", "made_from": "desert_noon"}.items() <= state_attributes(named).items()
    measured = state(tmp_path, tiny_job, "name: kyoto\n    sounding: kyoto.csv\n    profile: tropical")
    expected = {"state": "kyoto", "made_from": "sounding", "sounding": "kyoto.csv"}
    assert expected.items() <= state_attributes(measured).items()


def test_two_states_of_one_name_are_refused_at_their_place(tmp_path, tiny_job):
    twice = "  - {name: dawn, profile: tropical, weather: {air_temperature_c: [22, 33]}}\n"
    text = tiny_job().replace("states:\n", "states:\n" + twice).replace("  - profile:", "  - name: dawn\n    profile:")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"job\.yaml:6:11: found the state 'dawn' twice"):
        load_job(tmp_path / "job.yaml")


def test_names_find_databases_and_stand_over_their_pictures(tmp_path, tiny_job, build_inline, monkeypatch):
    text = tiny_job().replace("  - profile:", "  - name: calm\n    profile:")
    text = text.replace("  - wavelength_um", "  - name: lwir\n    wavelength_um").replace(
        "pictures: false", "pictures: true"
    )
    text = text.replace("output: {folder: built, pictures: true}", "output: {folder: built}")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    titles = []
    drawn = Figure.suptitle
    monkeypatch.setattr(Figure, "suptitle", lambda self, text, **how: (titles.append(text), drawn(self, text, **how)))
    build_inline(load_job(tmp_path / "job.yaml"), jobs=1)
    catalogue = skyshine.mat.open_catalog(tmp_path / "built")
    table = catalogue.open("atmq", band="lwir", state="calm", date="2026-06-28")
    assert table.path.name == "s01b01.atmq.h5" and table.attributes["made_from"] == "midlatitude_summer"
    assert [entry.state for entry in catalogue.find("htt", state="calm")] == [1]
    assert any("s01b01.atmq.h5" in title and title.endswith("calm, lwir, 2026-06-28, sun") for title in titles)
    for file in (tmp_path / "built").glob("*.h5"):
        picture = (tmp_path / "built" / "pictures" / file.name).with_suffix(".png")
        assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and picture.stat().st_size > 10_000
