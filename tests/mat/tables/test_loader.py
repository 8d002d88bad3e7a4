"""Opening databases and their flat export: lazily, from several threads, per-axis policies, clear refusals."""

import json
import re
import shutil
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables import loader
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.loader import open_as
from skyshine.mat.tables.raw import export_raw, read_raw
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import read_file
from skyshine.schemas.hdf5_gate import settled_stamp

FILES = ["b01.band.h5", "s01.htt.h5", "s01b01.atmq.h5", "s01b01.lunar_atmq.h5"]
PLACE = {"altitude": 0.3, "azimuth": 100.0, "slope": 20.0, "time": 7.0}


@pytest.fixture
def copied(small_build, tmp_path):
    """A copy of a temperature table that may be changed."""
    return shutil.copyfile(small_build / "s01.htt.h5", tmp_path / "s01.htt.h5")


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("engine", ["netcdf4", "h5netcdf"])
def test_xarray_opens_every_file_and_group_without_a_warning(small_build, name, engine):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("netCDF4")
    with h5py.File(small_build / name) as file:
        groups = ["/", *(f"/{key}" for key, item in file.items() if isinstance(item, h5py.Group))]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for group in groups:
            with xarray.open_dataset(small_build / name, engine=engine, group=group) as data:
                data.load()


def test_arrays_are_read_when_first_asked_for(copied):
    table = skyshine.mat.open(copied)
    assert "temperature" in table.quantities and "data" not in vars(table.root.variables["temperature"])
    first = table.temperature(material="asphalt_road", **PLACE)
    copied.unlink()
    assert table.temperature(material="asphalt_road", **PLACE) == first


def test_a_file_is_listed_once_until_it_changes(copied, monkeypatch):
    while settled_stamp(copied) is None:
        time.sleep(0.01)
    first = skyshine.mat.open(copied)
    hour = first.root.axes["time"].values[0]
    first.temperature(material="asphalt_road", **PLACE)
    first.root.variables.clear()
    with pytest.raises(ValueError, match="read-only"):
        first.root.axes["time"].values[0] = 1

    with monkeypatch.context() as patch:
        patch.setattr(loader, "read_file", None)
        again = skyshine.mat.open(copied)
    assert again.root.axes["time"].values[0] == hour
    assert "data" not in vars(again.root.variables["temperature"])

    with h5py.File(copied, "r+") as file:
        file["time"][0] = 0.5
    assert skyshine.mat.open(copied).root.axes["time"].values[0] == 0.5


def test_a_path_that_no_file_has_is_one_line():
    with pytest.raises(InputError, match="cannot be read"):
        skyshine.mat.open("a\0b")


def test_a_file_built_again_since_it_was_opened_is_not_mixed_with_the_old_one(copied):
    table = skyshine.mat.open(copied)
    with h5py.File(copied, "r+") as file:
        file.attrs["content_sha256"] = "0" * 64
    with pytest.raises(InputError, match="built again since it was opened"):
        table.temperature(material="asphalt_road", **PLACE)


def test_threads_share_a_table(small_build):
    table = skyshine.mat.open(small_build / "s01.htt.h5")
    times = np.linspace(-50, 50, 5000)
    expected = skyshine.mat.open(small_build / "s01.htt.h5").value(
        "temperature", material="grass_green", **PLACE | {"time": times}
    )
    with ThreadPoolExecutor(8) as pool:
        found = list(
            pool.map(lambda _: table.value("temperature", material="grass_green", **PLACE | {"time": times}), range(32))
        )
    for each in found:
        np.testing.assert_array_equal(each, expected)


def test_out_of_range_is_chosen_for_each_axis(small_build):
    table = skyshine.mat.open(small_build / "s01.htt.h5")
    high, steep = PLACE | {"altitude": 5.0}, PLACE | {"altitude": 5.0, "slope": 80.0}
    inside = table.temperature(material=1 * table.materials["asphalt_road"], **PLACE | {"altitude": 1.0})
    clamped = table.clamped("altitude")
    assert clamped.temperature(material="asphalt_road", **high) == inside
    with pytest.raises(InputError, match="slope: found 80"):
        clamped.temperature(material="asphalt_road", **steep)
    nearest = table.clamped().temperature(material="asphalt_road", **steep)
    assert nearest == table.temperature(material="asphalt_road", **PLACE | {"altitude": 1.0, "slope": 45.0})
    with pytest.raises(InputError, match="found the axis 'altitud'.*did you mean 'altitude'"):
        table.clamped("altitud")


def test_a_file_of_another_type_says_what_is_meant(small_build):
    assert open_as(BandTable, small_build / "b01.band.h5", "build again").blackbody_radiance(300.0) > 0
    with pytest.raises(InputError, match="is of the file type 'band'; allowed: atmq, lunar_atmq; build again"):
        open_as(AtmosphereTable, small_build / "b01.band.h5", "build again")


def test_no_module_asks_a_table_for_its_class():
    """What differs between file types is a method of the class that is opened by the file's type."""
    asks = re.compile(r"^(?! *>>>).*isinstance\(.*Table\b", re.MULTILINE)
    modules = Path(skyshine.mat.__file__).parent.rglob("*.py")
    assert [module.name for module in modules if asks.search(module.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize("version", ["2.1", "0.9", "", "10.0"])
def test_another_version_is_refused(copied, version):
    with h5py.File(copied, "r+") as file:
        file.attrs["format_version"] = version
    with pytest.raises(InputError, match=f"has format_version '{version}'; allowed: 1.x; build it again"):
        skyshine.mat.open(copied)


def test_a_forged_size_is_refused_before_it_is_allocated(copied):
    with h5py.File(copied, "r+") as file:
        del file["temperature"]
        forged = file.create_dataset("temperature", (10**6, 10**6), "f4", chunks=(1000, 1000))
        forged.attrs["units"], forged.attrs["long_name"] = "K", "surface temperature"
    with pytest.raises(InputError, match="claims 4000000000000 bytes"):
        read_file(copied)


@pytest.mark.parametrize("name", FILES)
def test_the_flat_export_gives_every_array_back(small_build, tmp_path, name):
    root, attributes = read_file(small_build / name)
    again, kept = read_raw(export_raw(small_build / name, tmp_path))
    assert kept == {key: value.tolist() if hasattr(value, "tolist") else value for key, value in attributes.items()}

    def compare(one, other):
        assert list(one.axes) == list(other.axes) and list(one.variables) == list(other.variables)
        for key, item in one.axes.items():
            np.testing.assert_array_equal(item.values, other.axes[key].values)
            assert item.values.dtype == other.axes[key].values.dtype and item.attributes == other.axes[key].attributes
        for key, item in one.variables.items():
            found = other.variables[key]
            np.testing.assert_array_equal(item.data, found.data)
            assert (item.dims, item.units, item.data.dtype) == (found.dims, found.units, found.data.dtype)
        for key, child in one.groups.items():
            compare(child, other.groups[key])

    compare(root, again)


def test_the_flat_export_is_what_its_page_says_and_is_queried_like_the_database(small_build, tmp_path):
    header_file = export_raw(small_build / "s01.htt.h5", tmp_path)
    header = json.loads(header_file.read_text(encoding="utf-8"))
    entry = header["groups"][""]["arrays"]["temperature"]
    flat = np.fromfile(tmp_path / header["data"], "<f4", offset=entry["offset"], count=int(np.prod(entry["shape"])))
    with h5py.File(small_build / "s01.htt.h5") as file:
        np.testing.assert_array_equal(flat.reshape(entry["shape"]), file["temperature"][()])
    table, same = skyshine.mat.open(header_file), skyshine.mat.open(small_build / "s01.htt.h5")
    assert isinstance(table.root.variables["temperature"].data.base, np.memmap)
    assert table.temperature(material="grass_green", **PLACE) == same.temperature(material="grass_green", **PLACE)


@pytest.mark.parametrize(
    "change", [{"bytes": 7}, {"data": "gone.bin"}, {"format_version": "2.0.0"}, {"groups": {}}, {"groups": []}]
)
def test_a_flat_export_that_does_not_fit_is_refused(small_build, tmp_path, change):
    file = export_raw(small_build / "b01.band.h5", tmp_path)
    file.write_text(json.dumps(json.loads(file.read_text(encoding="utf-8")) | change), encoding="utf-8")
    with pytest.raises(InputError):
        skyshine.mat.open(file)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "needs 'time'; give time, 0 to 18 h"),
        ({"altitude": 0.5}, "needs 'time'; give time, 0 to 18 h"),
        ({"altitude": 0.5, "time": 12, "slope": 30}, "needs 'azimuth'; give azimuth, 0 to 270 degree"),
    ],
)
def test_a_temperature_asks_for_what_it_needs(small_build, given, words):
    table = skyshine.mat.open(small_build / "s01.htt.h5")
    with pytest.raises(InputError, match=words):
        table.temperature(material="asphalt_road", **given)


def test_by_default_a_surface_lies_at_the_lowest_altitude(small_build):
    table = skyshine.mat.open(small_build / "s01.htt.h5")
    lowest = table.temperature(material="asphalt_road", altitude=0, time=12)
    assert table.temperature(material="asphalt_road", time=12) == lowest


def test_a_level_face_has_no_azimuth(small_build):
    table = skyshine.mat.open(small_build / "s01.htt.h5")
    level = table.temperature(material="asphalt_road", altitude=0.5, time=12)
    assert level == table.temperature(material="asphalt_road", altitude=0.5, time=12, azimuth=200)
