"""Files of a spectrum: what is written is what was computed, with units, and `mat verify` knows the format."""

import csv

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.cli import main
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5_digest import as_text


@pytest.fixture(scope="module")
def line():
    return skyshine.mat.spectrum(wavenumber=(900, 920), range=2, source="sun")


def test_hdf5_holds_every_column_with_its_unit(line, tmp_path):
    line.save(tmp_path / "line.h5")
    with h5py.File(tmp_path / "line.h5") as file:
        assert file.attrs["filetype"] == "spectrum" and file.attrs["format_version"] == "1.0"
        assert file.attrs["range_km"] == "2" and file.attrs["ends_at_ground"] == "false"
        for name, (unit, values) in line.columns.items():
            assert as_text(file[name].attrs["units"]) == unit
            np.testing.assert_allclose(file[name][()], values, rtol=1e-6)
        np.testing.assert_allclose(file["wavelength"][()], 1e4 / line.wavenumber, rtol=1e-6)


def test_xarray_reads_it_by_wavenumber(line, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    line.save(tmp_path / "line.h5")
    with xarray.open_dataset(tmp_path / "line.h5", engine="h5netcdf") as opened:
        assert opened.transmittance.dims == ("wavenumber",)
        assert float(opened.transmittance.sel(wavenumber=902.5)) == pytest.approx(line.transmittance[0], rel=1e-6)


def run(*arguments):
    with pytest.raises(SystemExit) as stop:
        main.main([str(argument) for argument in arguments])
    return stop.value.code


def test_the_command_writes_what_verify_accepts(tmp_path, capsys):
    place = ("--wavenumber", "900:920", "--range", 2)
    assert run("spectrum", *place, "--out", tmp_path / "a.h5") == 0
    assert run("verify", tmp_path / "a.h5") == 0
    assert "OK" in capsys.readouterr().out


def test_verify_notices_a_column_of_another_unit(line, tmp_path, capsys):
    line.save(tmp_path / "line.h5")
    with h5py.File(tmp_path / "line.h5", "r+") as file:
        file["path_thermal"].attrs["units"] = "W"
    assert run("verify", tmp_path / "line.h5") != 0


def test_csv_has_attributes_as_comments_and_the_printed_columns(line, tmp_path):
    line.save(tmp_path / "line.csv")
    text = (tmp_path / "line.csv").read_text(encoding="utf-8").splitlines()
    comments = [row for row in text if row.startswith("# ")]
    assert "# absorption: band model, hitran2012-mtckd4.3" in comments and "# range_km: 2" in comments
    rows = list(csv.DictReader(row for row in text if not row.startswith("#")))
    for name, (unit, values) in line.columns.items():
        np.testing.assert_allclose([float(row[f"{name}[{unit}]"]) for row in rows], values, rtol=1e-7)


@pytest.mark.parametrize("name", ["line.txt", "line"])
def test_other_names_are_refused(line, tmp_path, name):
    with pytest.raises(InputError, match=r"\.h5 or \.csv"):
        line.save(tmp_path / name)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [(("--out", "a.txt"), ".h5, .csv or .png"), (("--continua", "lowtran7"), "without --line-by-line")],
)
def test_bad_options_are_refused_before_anything_is_computed(arguments, message, capsys):
    assert run("spectrum", "--wavenumber", "900:920", *arguments) == 2
    assert message in capsys.readouterr().err
