"""The catalogue of a folder: an entry for each database, with the numbers in its name and what its header says."""

import json
from datetime import date

import numpy as np
import pytest

from skyshine.mat.tables import catalog
from skyshine.mat.tables.catalog import catalog_entry, open_catalog
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file


def write_catalog(folder, names):
    return catalog.write_catalog(folder, [catalog_entry(folder, name) for name in names])


def database(path, filetype="band", values=(1.0, 2.0)):
    axes = {"wavelength": Axis(np.arange(float(len(values))), "um", "w")}
    group = Group(axes, {"response": Variable(("wavelength",), np.array(values), "1", "r")})
    write_file(path, group, Header(filetype, "data 7", "a job"))


def test_entries_say_type_state_band_and_versions(tmp_path):
    names = ["s012b03.atmq.h5", "b02.band.h5", "s01.htt.h5", "grass.tmm.h5"]
    for name in names:
        database(tmp_path / name, name.split(".")[1])
    catalogue = json.loads(write_catalog(tmp_path, names).read_text(encoding="utf-8"))
    entries = {entry["file"]: entry for entry in catalogue["files"]}
    assert list(entries) == sorted(names) and catalogue["format_version"] == "1.0"
    numbers = {name: (entry.get("state"), entry.get("band")) for name, entry in entries.items()}
    assert numbers == {
        "s012b03.atmq.h5": (12, 3),
        "b02.band.h5": (None, 2),
        "s01.htt.h5": (1, None),
        "grass.tmm.h5": (None, None),
    }
    assert [entries[name]["filetype"] for name in names] == ["atmq", "band", "htt", "tmm"]
    assert {(entry["format_version"], entry["data_version"]) for entry in entries.values()} == {("1.0", "data 7")}


def test_the_hash_is_that_of_the_content(tmp_path):
    for name, values in (("b01.band.h5", (1.0, 2.0)), ("b02.band.h5", (1.0, 2.0)), ("b03.band.h5", (1.0, 3.0))):
        database(tmp_path / name, values=values)
    path = write_catalog(tmp_path, ["b01.band.h5", "b02.band.h5", "b03.band.h5"])
    one, same, other = (entry["content_sha256"] for entry in json.loads(path.read_text(encoding="utf-8"))["files"])
    assert one == same != other and len(one) == 64


@pytest.fixture
def year(tmp_path):
    """Three days of one band, the second with a named state, under Sun and Moon."""
    entries = [
        {"file": f"s{k:02}b01.{kind}.h5", "filetype": kind, "state": k, "band": 1, "band_name": "window", "date": day}
        | {"source": "moon" if kind == "lunar_atmq" else "sun"}
        for k, day in enumerate(("2026-01-01", "2026-01-02", "2026-07-28"), 1)
        for kind in ("atmq", "lunar_atmq")
    ]
    entries[2]["state_name"] = entries[3]["state_name"] = "dry"
    entries += [{"file": "b01.band.h5", "filetype": "band", "band": 1, "band_name": "window"}]
    (tmp_path / "catalog.json").write_text(json.dumps({"files": entries}), encoding="utf-8")
    return open_catalog(tmp_path)


def files(entries):
    return [entry.file for entry in entries]


def test_databases_are_found_by_what_they_hold(year):
    assert len(year.find()) == 7 and "7 databases" in repr(year)
    assert files(year.find("atmq", date="2026-07-28")) == ["s03b01.atmq.h5"]
    assert files(year.find(date=date(2026, 7, 28), source="moon")) == ["s03b01.lunar_atmq.h5"]
    assert files(year.find(state="dry")) == files(year.find(state=2)) == ["s02b01.atmq.h5", "s02b01.lunar_atmq.h5"]
    assert len(year.find(band="window")) == len(year.find(band=1)) == 7
    assert year.find("band", source="moon") == ()
    assert year.find("band")[0].date is None


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"date": "2026-07-29"}, r"contains no date '2026-07-29'; did you mean '2026-07-28'\? allowed: 2026-01-01, "),
        ({"band": "windw"}, "contains no band 'windw'; did you mean 'window'"),
        ({"filetype": "htt"}, "contains no filetype 'htt'; .*allowed: atmq, lunar_atmq, band"),
        ({"source": "star"}, "contains no source 'star'.*allowed: sun, moon"),
    ],
)
def test_what_no_database_has_is_refused_with_what_there_is(year, wanted, words):
    with pytest.raises(InputError, match=words):
        year.find(**wanted)


def test_only_one_database_is_opened(tmp_path):
    database(tmp_path / "b01.band.h5")
    database(tmp_path / "b02.band.h5")
    write_catalog(tmp_path, ["b01.band.h5", "b02.band.h5"])
    entries = json.loads((tmp_path / "catalog.json").read_text(encoding="utf-8"))
    for entry in entries["files"]:
        entry["band_name"] = entry["file"][:3]
    (tmp_path / "catalog.json").write_text(json.dumps(entries), encoding="utf-8")
    catalog = open_catalog(tmp_path)
    with pytest.raises(
        InputError, match=r"has 2 databases of filetype band: b01\.band\.h5, b02\.band\.h5; allowed: one"
    ):
        catalog.open("band")
    assert catalog.open("band", band=2).path == tmp_path / "b02.band.h5"


def test_the_table_that_is_opened_is_that_of_the_folder(small_build):
    catalog = open_catalog(small_build)
    table = catalog.open("htt", date="2026-06-28")
    assert table.path.name == "s01.htt.h5" and table.attributes["date"] == "2026-06-28"
    assert catalog.open(source="moon", band=1).path.name == "s01b01.lunar_atmq.h5"


@pytest.mark.parametrize("text", ["no JSON", "[]", '{"files": [{"file": "s01.htt.h5", "filetype": "htt"}]}'])
def test_what_is_no_catalogue_is_refused(tmp_path, text):
    with pytest.raises(InputError, match=r"contains no catalog\.json"):
        open_catalog(tmp_path)
    (tmp_path / "catalog.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"catalog\.json: is no catalogue of databases"):
        open_catalog(tmp_path)


def test_a_missing_database_is_named_and_leaves_no_catalogue(tmp_path):
    with pytest.raises(InputError, match="b01.band.h5"):
        write_catalog(tmp_path, ["b01.band.h5"])
    assert list(tmp_path.iterdir()) == []
