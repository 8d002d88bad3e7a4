"""Parts of a table: packed within half a step, kept whole, and built again when anything they follow from changes."""

import numpy as np
import pytest

from skyshine.mat.spectroscopy.intervals import FLOOR, IntervalPoints
from skyshine.mat.spectroscopy.table import LOG_OFFSET, LOG_STEP, pack, part_is_done, part_path, write_part

SECTIONS = np.array([[[1e-24, 3e-28]], [[0.0, 7e-21]]])


@pytest.fixture
def points():
    humid = {"H2O": np.array([[[[0.25]]], [[[-9.0]]]])}
    weight, error = np.array([0.4, 0.6]), np.array([1e-4, 5e-4, 0.0, 0.0])
    wavenumber, continuum = np.array([700.1, 700.9]), np.zeros((3, 2))
    return IntervalPoints(
        700.0, 701.0, wavenumber, weight, {"H2O": SECTIONS}, humid, continuum, error, {"H2O": 2e-4, "CO2": 1.0}
    )


def test_packed_values_come_back_within_half_a_step():
    values = np.random.default_rng(4).uniform(-80, -45, 1000)
    packed = pack(values, LOG_STEP, LOG_OFFSET)
    assert packed.dtype == np.int16
    assert np.abs(packed * LOG_STEP + LOG_OFFSET - values).max() <= 0.5 * LOG_STEP * (1 + 1e-9)


@pytest.mark.parametrize("value", [3.2768, -3.2768])
def test_values_beyond_16_bits_are_refused(value):
    assert abs(pack(np.array([np.sign(value) * 3.2767]), 1e-4, 0.0)[0]) == 32767
    with pytest.raises(ValueError, match="do not fit 16-bit steps of 0.0001"):
        pack(np.array([0.0, value]), 1e-4, 0.0)


def test_a_part_holds_its_cross_sections_to_a_few_ten_thousandths(points, tmp_path):
    write_part(tmp_path / "parts", points, "a key")
    with np.load(part_path(tmp_path / "parts", 700.0)) as part:
        found = np.exp(part["dry_H2O"] * LOG_STEP + LOG_OFFSET)
        np.testing.assert_allclose(found, np.where(SECTIONS == 0, FLOOR, SECTIONS), rtol=3.3e-4)
        assert part["humid_H2O"].ravel().tolist() == [2500, -30000]  # steps of 1e-4, cut at 3
        assert part["gases"].tolist() == ["H2O"] and part["gas_error"].tolist() == [2e-4]
        assert part["weight"].sum() == 1.0
    assert [file.suffix for file in (tmp_path / "parts").iterdir()] == [".npz"]


def test_only_a_whole_part_of_the_same_key_is_done(points, tmp_path):
    assert not part_is_done(tmp_path, 700.0, "a key")
    write_part(tmp_path, points, "a key")
    assert part_is_done(tmp_path, 700.0, "a key")
    assert not part_is_done(tmp_path, 700.0, "another") and not part_is_done(tmp_path, 701.0, "a key")
    path = part_path(tmp_path, 700.0)
    path.write_bytes(path.read_bytes()[:-40])
    assert not part_is_done(tmp_path, 700.0, "a key")
