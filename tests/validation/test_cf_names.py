"""CF conventions: what the IOOS compliance checker (extra `validation`) finds in each type of database."""

import shutil

import pytest

import skyshine.mat

pytestmark = pytest.mark.validation
checker = pytest.importorskip("compliance_checker.runner")


def errors(path, folder):
    """Messages of high priority of the checker, by section."""
    copy = folder / f"{path.name}.nc"  # it goes by the ending
    shutil.copy(path, copy)
    suite = checker.CheckSuite()
    suite.load_all_available_checkers()
    scores = suite.run_all(suite.load_dataset(str(copy)), ["cf:1.11"])
    groups, _ = scores["cf:1.11"]
    high = [result for result in groups if result.weight == 3 and result.value[0] != result.value[1]]
    return [message for result in high for message in leaves(result)]


def leaves(result):
    return [*result.msgs, *(message for child in result.children or () for message in leaves(child))]


@pytest.mark.parametrize("name", ["s01.htt.h5", "s01b01.atmq.h5", "s01b01.lunar_atmq.h5", "b01.band.h5"])
def test_a_database_has_no_error(small_build, tmp_path, name):
    assert not errors(small_build / name, tmp_path)


def test_a_table_in_channels_has_no_error(channel_atmosphere, tmp_path):
    assert not errors(channel_atmosphere, tmp_path)


def test_a_spectrum_has_no_error(tmp_path):
    skyshine.mat.spectrum(wavelength=(10, 11), range=1).save(tmp_path / "line.h5")
    assert not errors(tmp_path / "line.h5", tmp_path)


def test_a_texture_has_no_error(tmp_path):
    from PIL import Image

    from skyshine.materials.library import load_library
    from skyshine.tmm import TextureJob, map_texture, write_texture

    Image.new("RGB", (8, 4), (90, 90, 90)).save(tmp_path / "road.png")
    job = TextureJob(image="road.png", material="asphalt_road")
    write_texture(map_texture(job, tmp_path, load_library()), tmp_path / "road.tmm.h5")
    assert not errors(tmp_path / "road.tmm.h5", tmp_path)


def test_a_look_up_table_has_no_error(tmp_path):
    from skyshine.mat.exchange.isofit import Lut, write_lut

    write_lut(Lut((870.0,), (20.0,), (1.0,), (0.1,)), tmp_path / "lut.h5")
    assert not errors(tmp_path / "lut.h5", tmp_path)
