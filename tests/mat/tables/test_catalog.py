"""The catalogue of a folder: an entry for each database, with the numbers in its name and what its header says."""

import json

import numpy as np
import pytest

from skyshine.mat.tables.catalog import write_catalog
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Axis, Group, Header, Variable, write_file


def database(path, filetype="band", values=(1.0, 2.0)):
    axes = {"wavelength": Axis(np.arange(float(len(values))), "um", "w")}
    group = Group(axes, {"response": Variable(("wavelength",), np.array(values), "1", "r")})
    write_file(path, group, Header(filetype, "1.2.3", "data 7", "a job"))


def test_entries_say_type_state_band_and_versions(tmp_path):
    names = ["s012b03.atmq.h5", "b02.band.h5", "s01.htt.h5", "grass.tmm.h5"]
    for name in names:
        database(tmp_path / name, name.split(".")[1])
    catalogue = json.loads(write_catalog(tmp_path, names).read_text(encoding="utf-8"))
    entries = {entry["file"]: entry for entry in catalogue["files"]}
    assert list(entries) == sorted(names) and catalogue["format_version"] == "1.1.0"
    numbers = {name: (entry.get("state"), entry.get("band")) for name, entry in entries.items()}
    assert numbers == {
        "s012b03.atmq.h5": (12, 3),
        "b02.band.h5": (None, 2),
        "s01.htt.h5": (1, None),
        "grass.tmm.h5": (None, None),
    }
    assert [entries[name]["filetype"] for name in names] == ["atmq", "band", "htt", "tmm"]
    assert {(entry["format_version"], entry["data_version"]) for entry in entries.values()} == {("1.2.3", "data 7")}


def test_the_hash_is_that_of_the_content(tmp_path):
    for name, values in (("b01.band.h5", (1.0, 2.0)), ("b02.band.h5", (1.0, 2.0)), ("b03.band.h5", (1.0, 3.0))):
        database(tmp_path / name, values=values)
    path = write_catalog(tmp_path, ["b01.band.h5", "b02.band.h5", "b03.band.h5"])
    one, same, other = (entry["content_sha256"] for entry in json.loads(path.read_text(encoding="utf-8"))["files"])
    assert one == same != other and len(one) == 64


def test_a_missing_database_is_named_and_leaves_no_catalogue(tmp_path):
    with pytest.raises(InputError, match="b01.band.h5"):
        write_catalog(tmp_path, ["b01.band.h5"])
    assert list(tmp_path.iterdir()) == []
