"""Tables in xarray: materials by name, the same numbers, a short repr."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables.axes import EXACT, PERIODIC, table_axis
from skyshine.mat.tables.files import HTT
from skyshine.mat.tables.named_materials import with_names
from skyshine.schemas.hdf5 import Group, Header, Variable, read_file, write_file

xarray = pytest.importorskip("xarray")
HEADER = Header(HTT.name, "data", "job", "Temperatures")
DIMS = ("material", "altitude", "azimuth", "slope", "time")


@pytest.fixture
def file(tmp_path):
    codes = table_axis(np.array([3, 5], np.int32), "1", "material code", interpolation=EXACT)
    variables = {
        "temperature": Variable(DIMS, np.reshape([280.0, 281.0, 290.0, 292.0], (2, 2, 1, 1, 1)), "K", "temperature"),
        "material_name": Variable(("material",), np.array(["sea_water", "asphalt_road"], object), "1", "name"),
    }
    axes = {
        "material": codes,
        "altitude": table_axis([0.0, 1.0], "km", "altitude"),
        "azimuth": table_axis([0.0], "degree", "azimuth", interpolation=PERIODIC, period=360.0),
        "slope": table_axis([0.0], "degree", "slope"),
        "time": table_axis([0.0], "h", "local time", interpolation=PERIODIC, period=24.0),
    }
    write_file(tmp_path / "s01.htt.h5", Group(axes, with_names(variables)), HEADER)
    return tmp_path / "s01.htt.h5"


def test_a_material_is_selected_by_name(file):
    from skyshine.mat.tables.xarray_engine import SkyshineEngine

    for data in (skyshine.mat.open(file).to_xarray(), xarray.open_dataset(file, engine=SkyshineEngine)):
        chosen = data.sel(material="asphalt_road")
        np.testing.assert_array_equal(chosen["temperature"].squeeze(), [290.0, 292.0])
        assert int(chosen["material_code"]) == 5 and chosen["temperature"].attrs["units"] == "K"
        assert data["temperature"].sel(material="asphalt_road").interp(altitude=0.5).item() == 291.0
        assert data.attrs["filetype"] == "htt" and data["altitude"].attrs["interpolation"] == "linear"


def test_days_are_joined_along_a_time_axis(file):
    pytest.importorskip("dask.array")
    from skyshine.mat.tables.xarray_engine import SkyshineEngine

    paths = []
    for day in ("2026-07-28", "2026-01-02"):
        paths.append(file.with_name(f"{day}.htt.h5"))
        root, _ = read_file(file)
        write_file(paths[-1], replace(root, attributes={**root.attributes, "date": day}), HEADER)
    joined = xarray.open_mfdataset(paths, engine=SkyshineEngine, combine="nested", concat_dim="date").sortby("date")
    assert joined["date"].dtype.kind == "M" and joined.sizes["date"] == 2
    july = joined.sel(date="2026-07", material="asphalt_road", altitude=0.0)["temperature"]
    assert july.squeeze().compute().item() == 290.0
    assert "date" not in skyshine.mat.open(file).to_xarray().coords


@pytest.mark.parametrize("engine", ["netcdf4", "h5netcdf"])
def test_the_names_are_a_coordinate_to_the_engines_of_netcdf(file, engine):
    with xarray.open_dataset(file, engine=engine) as data:
        by_name = data.set_xindex("material_name").sel(material_name="asphalt_road")
        np.testing.assert_array_equal(by_name["temperature"].squeeze(), [290.0, 292.0])
        np.testing.assert_array_equal(data["temperature"].sel(material=5).squeeze(), [290.0, 292.0])


def test_the_engine_is_an_entry_point_of_the_package():
    import tomllib
    from importlib import import_module
    from pathlib import Path

    project = tomllib.loads((Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    module, name = project["entry-points"]["xarray.backends"]["skyshine"].split(":")
    assert issubclass(getattr(import_module(module), name), xarray.backends.BackendEntrypoint)


def test_repr_takes_a_few_lines(file):
    table = skyshine.mat.open(file)
    assert repr(table) == (
        f"<TemperatureTable htt 1.0 '{file}'\n"
        "  axes: material 2, altitude 2, azimuth 1, slope 1, time 1\n  quantities: temperature [K]>"
    )


def test_arrays_that_are_not_wanted_are_left_out(file):
    from skyshine.mat.tables.xarray_engine import SkyshineEngine

    assert "temperature" not in xarray.open_dataset(file, engine=SkyshineEngine, drop_variables="temperature")


def test_the_clock_of_a_day_is_of_instants_to_netcdf_and_of_hours_here(small_build):
    """The site is five hours behind UTC."""
    from skyshine.mat.tables.xarray_engine import SkyshineEngine

    path = small_build / "s01.htt.h5"
    with xarray.open_dataset(path, engine="netcdf4") as data:
        instants = np.array(data["time"].values, "datetime64[h]")
    midnight = np.datetime64("2026-06-28T05", "h")
    np.testing.assert_array_equal(instants, midnight + np.array([0, 6, 12, 18]).astype("timedelta64[h]"))
    hours = xarray.open_dataset(path, engine=SkyshineEngine)["time"]
    np.testing.assert_array_equal(hours, [0.0, 6.0, 12.0, 18.0])
    assert hours.attrs["units"] == "h" and "standard_name" not in hours.attrs
