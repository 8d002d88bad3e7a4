"""The days of a folder as cubes in netCDF, beside the databases that they are read from."""

from dataclasses import replace

import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables.catalog import CATALOG, catalog_entry, write_catalog
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Header, read_file, write_file

xarray = pytest.importorskip("xarray")
pytest.importorskip("netCDF4")
DAYS = ("2026-01-10", "2026-07-10")


def of_another_day(path, target, day, warmer):
    """The file of a state as one of another day, some kelvin warmer."""
    root, attributes = read_file(path)
    variables = dict(root.variables)
    if "temperature" in variables:
        kelvin = variables["temperature"]
        variables["temperature"] = replace(kelvin, data=np.asarray(kelvin.data) + warmer)
    root = replace(root, variables=variables, attributes={**root.attributes, "date": day})
    write_file(target, root, Header(*(attributes[name] for name in ("filetype", "data_version", "job", "title"))))


@pytest.fixture(scope="module")
def built(tmp_path_factory, tiny_build):
    """Two days, the later one as the first state."""
    folder = tmp_path_factory.mktemp("cube")
    names = []
    for path in tiny_build.glob("s01*.h5"):
        for state, day in enumerate(reversed(DAYS), 1):
            names.append(path.name.replace("s01", f"s{state:02d}"))
            of_another_day(path, folder / names[-1], day, warmer=10.0 * state)
    write_catalog(folder, [catalog_entry(folder, name) for name in names])
    return folder


def test_cubes_have_the_numbers_of_the_databases_in_the_order_of_dates(built, tmp_path):
    paths = skyshine.mat.export(built, "netcdf", tmp_path)
    assert sorted(path.name for path in paths) == ["b01.atmq.nc", "htt.nc"]
    catalog = skyshine.mat.open_catalog(built)
    with xarray.open_mfdataset([tmp_path / "htt.nc"]) as surface, xarray.open_dataset(tmp_path / "b01.atmq.nc") as air:
        for cube in (surface, air):
            assert [str(day)[:10] for day in cube["date"].values] == list(DAYS)
        for day in DAYS:
            table = catalog.open("htt", date=day)
            cell = surface["temperature"].sel(date=day, material="asphalt_road", altitude=0, azimuth=180, slope=45)
            own = table.temperature(material="asphalt_road", altitude=0, azimuth=180, slope=45, time=np.arange(24))
            assert cell.values == pytest.approx(own, abs=1e-4)
            line = {"altitude": 1.0, "elevation": -30.0, "source_elevation": 60.0, "source_azimuth": 90.0}
            node = {name: air[name].sel({name: value}, method="nearest").item() for name, value in line.items()}
            node["range"] = float(air["range"][4])
            own = catalog.open("atmq", date=day)
            for name in ("beta_star", "path_radiance_ratio", "ambient_radiance"):
                place = {axis: value for axis, value in node.items() if axis in air[name].dims}
                assert float(air[name].sel(date=day, **place)) == pytest.approx(
                    float(own.value(name, **place)), rel=1e-5
                )


def test_a_day_on_nodes_of_its_own_is_read_on_those_of_the_first_day(built, tmp_path):
    target = tmp_path / "s01.htt.h5"  # the later day
    root, attributes = read_file(built / target.name)
    slope, kelvin = root.axes["slope"], root.variables["temperature"]
    nodes, values, along = np.asarray(slope.values), np.asarray(kelvin.data), kelvin.dims.index("slope")
    between = (values.take(range(1, nodes.size), along) + values.take(range(nodes.size - 1), along)) / 2
    order = np.argsort(np.concatenate([nodes, (nodes[1:] + nodes[:-1]) / 2]))
    finer = np.concatenate([values, between], along).take(order, along)
    axes = {**root.axes, "slope": replace(slope, values=np.sort(np.concatenate([nodes, (nodes[1:] + nodes[:-1]) / 2])))}
    variables = {**root.variables, "temperature": replace(kelvin, data=finer)}
    header = Header(*(attributes[name] for name in ("filetype", "data_version", "job", "title")))
    write_file(target, replace(root, axes=axes, variables=variables), header)
    (tmp_path / "s02.htt.h5").write_bytes((built / "s02.htt.h5").read_bytes())
    write_catalog(tmp_path, [catalog_entry(tmp_path, f"s0{state}.htt.h5") for state in (1, 2)])
    skyshine.mat.export(tmp_path, "netcdf", tmp_path / "cubes")
    skyshine.mat.export(built, "netcdf", tmp_path / "equal")
    with (
        xarray.open_dataset(tmp_path / "cubes/htt.nc") as cube,
        xarray.open_dataset(tmp_path / "equal/htt.nc") as equal,
    ):
        assert cube["slope"].values == pytest.approx(nodes)
        assert cube["temperature"].values == pytest.approx(equal["temperature"].values, abs=1e-3)


def test_paths_through_the_ground_have_no_number(built, tmp_path):
    skyshine.mat.export(built, "netcdf", tmp_path)
    with xarray.open_dataset(tmp_path / "b01.atmq.nc") as air:
        down = air["beta_star"].sel(elevation=-90, altitude=1.0)
        assert np.isnan(down.isel(range=-1)).all() and np.isfinite(down.isel(range=0)).all()


def test_two_states_of_one_date_and_a_folder_without_days_are_refused(built, tmp_path):
    text = (built / CATALOG).read_text().replace(DAYS[1], DAYS[0])
    (tmp_path / CATALOG).write_text(text)
    with pytest.raises(InputError, match=f"two states on {DAYS[0]}"):
        skyshine.mat.export(tmp_path, "netcdf", tmp_path / "out")
    with pytest.raises(InputError, match="contains no catalog.json"):
        skyshine.mat.export(tmp_path / "no" / "where", "netcdf", tmp_path / "out")
