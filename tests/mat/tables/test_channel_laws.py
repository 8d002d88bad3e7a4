"""What a file in channels must state and hold: each fault is one line when the file is opened."""

import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import skyshine.mat
from skyshine.mat.tables.verify import problems
from skyshine.schemas.errors import InputError

sys.path.insert(0, str(Path(__file__).parents[2] / "fuzz"))
import good_databases

WRONG_NUMBERS = ["high", np.nan, np.inf, True, h5py.Empty("f8"), [12.0, 13.0], [[12.0]], -5.0, 2e3]
WRONG_SPANS = ["far", np.nan, 5.0, [1.0, 2.0, 3.0], [2.0, 1.0], [0.5, np.nan], [-9.0, 1.0], [True, True], [[0.0, 1.0]]]


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return good_databases.write_all(tmp_path_factory.mktemp("good"))["atmosphere"]


@pytest.fixture
def refused(good, tmp_path):
    """The message by which a changed copy of the file is refused, when it is opened."""

    def message(edit):
        path = tmp_path / "changed.atmq.h5"
        path.write_bytes(good.read_bytes())
        with h5py.File(path, "r+") as file:
            edit(file)
        with pytest.raises(InputError) as found:
            skyshine.mat.open(path)
        assert len(str(found.value).splitlines()) == 1
        return str(found.value)

    return message


def test_the_file_that_others_are_made_from_has_nothing_wrong(good):
    assert problems(good) == []
    assert skyshine.mat.open(good).value("beta_star", range=1.0, altitude=0.5, elevation=-3.0) > 0


@pytest.mark.parametrize("name", ["ground_altitude_km", "scale_height_km"])
@pytest.mark.parametrize("value", [*WRONG_NUMBERS, None], ids=str)
def test_a_number_that_no_ground_and_no_air_has_is_refused(refused, name, value):
    assert name in refused(lambda file: _state(file, name, value))


def test_a_scale_height_of_0_is_refused(refused):
    assert "above 0" in refused(lambda file: _state(file, "scale_height_km", 0.0))


@pytest.mark.parametrize("name", ["range_km", "altitude_km"])
@pytest.mark.parametrize("value", [*WRONG_SPANS, None], ids=str)
def test_ends_that_are_not_two_ascending_numbers_are_refused(refused, name, value):
    assert name in refused(lambda file: _state(file, name, value))


def _state(file, name, value):
    del file.attrs[name]
    if value is not None:
        file.attrs[name] = value


@pytest.mark.parametrize("kind", ["path", "harmonics"])
def test_an_array_that_is_missing_is_named(refused, kind):
    name = {"path": "absorber_factor", "harmonics": "ground_emission"}[kind]
    assert f"'{name}' is missing" in refused(lambda file: file.pop(name))


def test_the_end_of_twilight_must_be_stated(refused):
    assert "dark_below" in refused(lambda file: file["source_elevation"].attrs.pop("dark_below"))


@pytest.mark.parametrize(
    ("name", "edit"),
    [
        ("share", lambda file: file["share"].attrs.create("period", 1.0)),
        ("channel", lambda file: file["channel"].write_direct(file["channel"][()] - 1)),
        ("harmonic", lambda file: file["harmonic"].write_direct(file["harmonic"][()] + 1)),
        ("zonal_harmonic", lambda file: file["zonal_harmonic"].write_direct(file["zonal_harmonic"][()] + 1)),
    ],
)
def test_numbers_and_codes_are_those_of_the_format(refused, name, edit):
    assert f"{name}: found" in refused(edit) or f"{name}: the numbers" in refused(edit)


def test_weights_that_do_not_sum_to_1_are_refused_and_reported(refused, good, tmp_path):
    def heavier(file):
        file["channel_weight"][...] = file["channel_weight"][()] * 1.01

    assert "sum to 1.01" in refused(heavier)
    assert any("sum to 1.01" in line for line in problems(tmp_path / "changed.atmq.h5"))


@pytest.mark.parametrize("name", ["thermal_wavelength_share", "source_wavelength_share"])
def test_shares_of_wavelengths_stand_together_and_sum_to_1(refused, good, tmp_path, name):
    def scaled(factor):
        return lambda file: file[name].write_direct((file[name][()] * factor).astype(np.float32))

    assert f"'{name}' is missing" in refused(lambda file: file.pop(name))
    assert f"{name}: the shares" in refused(scaled(1 + 3e-5)) and f"{name}: the shares" in refused(scaled(1 - 3e-5))
    rounded = tmp_path / "rounded.atmq.h5"
    rounded.write_bytes(good.read_bytes())
    with h5py.File(rounded, "r+") as file:
        scaled(1 + 3e-6)(file)
    assert skyshine.mat.open(rounded).quantities


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("channel_weight", -0.1),
        ("effective_radius", 0.0),
        ("thermal_reference", -1.0),
        ("source_reference", -1.0),
        ("log_mean_extinction", 300.0),
        ("source_rise", 95.0),
    ],
)
def test_a_value_that_no_air_has_is_refused_when_it_is_read(good, tmp_path, name, value):
    path = tmp_path / "changed.atmq.h5"
    path.write_bytes(good.read_bytes())
    with h5py.File(path, "r+") as file:
        values = file[name][()]
        values.flat[:2] = value, values.flat[:2].sum() - value  # the sum stays
        file[name][...] = values
    with pytest.raises(InputError, match=name):
        np.size(skyshine.mat.open(path).root.variables[name].data)
    assert any(line.startswith(name) for line in problems(path))
