"""Building a job: what it leaves in the folder, what it keeps, same job same bytes, failures leave nothing."""

import json
import shutil
import subprocess

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5_digest import as_text

FILES = ["b01.band.h5", "s01.htt.h5", "s01b01.atmq.h5", "s01b01.lunar_atmq.h5"]


def test_every_file_is_there_and_holds(small_build):
    assert sorted(p.name for p in small_build.glob("*.h5")) == FILES
    for name in FILES:
        assert problems(small_build / name) == []
    assert not list(small_build.rglob(".*part*"))


def test_the_catalogue_names_every_file_with_type_versions_and_hash(small_build):
    catalog = json.loads((small_build / "catalog.json").read_text(encoding="utf-8"))
    assert [entry["file"] for entry in catalog["files"]] == FILES
    by_name = {entry["file"]: entry for entry in catalog["files"]}
    assert by_name["s01b01.lunar_atmq.h5"]["filetype"] == "lunar_atmq"
    assert (by_name["s01b01.atmq.h5"]["state"], by_name["s01b01.atmq.h5"]["band"]) == (1, 1)
    assert "state" not in by_name["b01.band.h5"]
    for name, entry in by_name.items():
        with h5py.File(small_build / name) as file:
            assert entry["content_sha256"] == file.attrs["content_sha256"]


def test_the_cost_stands_beside_the_files_and_not_in_them(small_build):
    cost = json.loads((small_build / "build.json").read_text(encoding="utf-8"))
    for name in FILES:
        assert cost["files"][name]["seconds"] > 0 and cost["files"][name]["peak_memory_bytes"] > 1e7


def test_the_same_job_gives_the_same_bytes_and_a_second_build_keeps_them(build_inline, tiny_job, contents, tmp_path):
    """By two builds; of temperatures: an atmosphere's bytes are in `validation`."""
    text = tiny_job().replace("bands:\n  - wavelength_um: [10.0, 10.2]\n", "bands: []\n")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    loaded, other = load_job(tmp_path / "job.yaml"), tmp_path / "other"
    build_inline(loaded, out=other)
    build_inline(loaded, out=tmp_path / "again")
    assert len(contents(other)) == 1 and contents(other) == contents(tmp_path / "again")
    made = json.loads((other / "build.json").read_text(encoding="utf-8"))["files"]
    report = build_inline(loaded, out=other)
    assert all(entry["kept"] for entry in report["files"].values())
    # What a kept file cost is what it took to make it.
    assert {name: entry["stages"] for name, entry in report["files"].items()} == {
        name: entry["stages"] for name, entry in made.items()
    }


def test_only_what_changed_is_built_again(build_inline, small_job, small_build, tmp_path):
    shutil.copytree(small_build, tmp_path / "built")
    text = small_job.read_text(encoding="utf-8").replace("slope_deg: [0, 45]", "slope_deg: [0, 60]")
    (tmp_path / "job.yaml").write_text(text, encoding="utf-8")
    report = build_inline(load_job(tmp_path / "job.yaml"), jobs=1)
    assert {name: entry["kept"] for name, entry in report["files"].items()} == {
        "b01.band.h5": True,
        "s01.htt.h5": False,
        "s01b01.atmq.h5": True,
        "s01b01.lunar_atmq.h5": True,
    }


def test_a_damaged_file_is_built_again(build_inline, small_job, small_build, tmp_path):
    shutil.copytree(small_build, tmp_path / "built")
    damaged = tmp_path / "built" / "b01.band.h5"
    damaged.write_bytes(damaged.read_bytes()[:5000])
    with pytest.raises(InputError, match="not a readable HDF5"):
        problems(damaged)
    build_inline(load_job(small_job), out=tmp_path / "built", jobs=1)
    assert problems(damaged) == []


def test_a_changed_value_is_found(small_build, tmp_path):
    changed = tmp_path / "s01.htt.h5"
    shutil.copyfile(small_build / "s01.htt.h5", changed)
    with h5py.File(changed, "r+") as file:
        file["temperature"][0, 0, 0, 0, 0] += 1
        file["temperature"].attrs["units"] = "degC"
    found = " / ".join(problems(changed))
    assert "content_sha256 does not match" in found and "variables/temperature/units" in found


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("engine", ["netcdf4", "h5netcdf"])
def test_xarray_opens_every_file(small_build, name, engine):
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(small_build / name, engine=engine) as data:
        for variable in data.variables.values():
            # xarray reads the units of instants, and keeps them aside.
            assert "units" in variable.attrs | variable.encoding and variable.attrs["long_name"]
            variable.load()


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("tool", [["ncdump", "-h"], ["h5dump", "-H"]], ids=["ncdump", "h5dump"])
def test_the_dump_tools_open_every_file(small_build, name, tool):
    if shutil.which(tool[0]) is None:
        pytest.skip(f"{tool[0]} is not installed")
    done = subprocess.run([*tool, small_build / name], capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr


def test_the_stated_errors_are_there_for_every_quantity(small_build):
    for name, quantities in {
        "s01.htt.h5": ["temperature"],
        "s01b01.atmq.h5": ["beta_star", "path_radiance_ratio", "ambient_radiance", "direct_radiance"],
    }.items():
        table = skyshine.mat.open(small_build / name)
        for quantity in quantities:
            stated = table.error(quantity)
            assert 0 < stated["rms"] <= stated["maximum"] and 0 < stated["p95_kelvin"] <= stated["maximum_kelvin"]


def test_columns_state_how_they_were_solved(small_build):
    with h5py.File(small_build / "s01.htt.h5") as file:
        assert np.max(file["diagnostics/residual"]) < 0.01
        assert np.max(np.abs(file["diagnostics/energy_closure"])) < 0.05
        assert np.max(file["diagnostics/bound_excess"]) <= 0.1
        assert "spectral" in as_text(file["diagnostics/method"].attrs["comment"])


def test_level_surfaces_are_the_same_for_every_azimuth(small_build):
    table = skyshine.mat.open(small_build / "s01.htt.h5")
    level = table.root.variables["temperature"].data[:, :, :, 0]
    assert (
        np.ptp(level, axis=2).max() == 0
        and np.ptp(table.root.variables["temperature"].data[:, :, :, 1], axis=2).max() > 1
    )


def test_an_output_folder_that_cannot_be_made_is_one_clear_line(small_job, tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(InputError, match="name another output folder"):
        build(load_job(small_job), out=tmp_path / "file", jobs=1)
