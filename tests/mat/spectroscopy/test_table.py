"""Parts of a table: packed within half a step, kept whole, and built again when anything they follow from changes; a
table of parts gives back what they hold.
"""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import OFFSET, STEP, AbsorptionTable, _unpacked
from skyshine.mat.spectroscopy import nodes
from skyshine.mat.spectroscopy.intervals import FLOOR, IntervalPoints
from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua
from skyshine.mat.spectroscopy.sources import GasSources
from skyshine.mat.spectroscopy.table import (
    LOG_OFFSET,
    LOG_STEP,
    Builder,
    Settings,
    along_pressure,
    assemble,
    build,
    pack,
    part_is_done,
    part_path,
    write_part,
)

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


def test_differences_along_pressure_give_back_all_numbers_of_16_bits():
    """Of neighbours as far apart as they can be too, whose difference needs 17 bits."""
    numbers = np.random.default_rng(7).integers(-32768, 32768, (3, 2, 12, 8)).astype(np.int16)
    numbers[0, 0, :4, 0] = -32768, 32767, -32768, 0
    with h5py.File("memory", "w", driver="core", backing_store=False) as file:
        stored = file.create_dataset("x", data=along_pressure(numbers))
        stored.attrs.update({STEP: 1.0, OFFSET: 0.0})
        np.testing.assert_array_equal(_unpacked(stored, 1, 3, np.arange(2)), numbers[1:].reshape(2, -1))
        np.testing.assert_array_equal(_unpacked(stored, 0, 3, np.array([2])), numbers[2:].reshape(1, -1))
        assert _unpacked(stored, 1, 1, np.arange(0)).shape == (0, 2 * 12 * 8)


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


def gas(name, lowest):
    """A gas whose only source begins at `lowest` cm^-1."""
    covers = lambda low, high: low >= lowest  # noqa: E731
    return GasSources(name, [SimpleNamespace(name=name, provenance=f"{name} of a test", terms="free", covers=covers)])


def test_a_table_gives_back_the_cross_sections_of_its_parts(tmp_path):
    """Water in both intervals, CO2 in the second alone: at a node of pressure and temperature, packed to 3.2e-4."""
    generator = np.random.default_rng(8)
    shape, humid = (nodes.PRESSURE.size, nodes.TEMPERATURE.size), nodes.PRESSURE.size - nodes.HUMID_PRESSURE
    sections, parts = {}, []
    for low in (700.0, 701.0):
        names = ["H2O"] if low == 700.0 else ["H2O", "CO2"]
        sections[low] = {name: np.exp(generator.uniform(-60, -50, (2, *shape))) for name in names}
        moist = {"H2O": generator.uniform(-0.5, 0.5, (2, nodes.H2O_FRACTION.size - 1, humid, shape[1]))}
        points = IntervalPoints(
            low, low + 1, low + np.array([0.2, 0.8]), np.array([0.25, 0.75]), sections[low], moist,
            np.full((3, 2), 1e-30), np.array([1e-4, 5e-4, 2e-4, 1e-3]), dict.fromkeys(names, 3e-4),
        )  # fmt: skip
        write_part(tmp_path / "parts", points, "a key")
        parts.append(dict(np.load(part_path(tmp_path / "parts", low))))
    sources = [gas("H2O", 700.0), gas("CO2", 701.0), gas("O3", 800.0)]
    assemble(parts, tmp_path / "table.h5", sources=sources, continua=LowtranContinua(), settings=Settings())
    table = AbsorptionTable.open(tmp_path / "table.h5")
    assert table.coverage == [(700.0, 702.0)] and table.size == 4
    assert [text for _, _, text in table.provenance("CO2")][-1] == "CO2 of a test"
    chosen = table.points(700.0, 702.0)
    assert chosen.weight == pytest.approx([0.25, 0.75, 0.25, 0.75])
    pressure, temperature = nodes.PRESSURE[20], nodes.TEMPERATURE[4]
    read = chosen.cross_sections([pressure], [temperature], [0.0], gases=["H2O", "CO2", "O3"])
    water = np.concatenate([sections[low]["H2O"][:, 20, 4] for low in (700.0, 701.0)])
    assert read["H2O"][0] == pytest.approx(water, rel=3.5e-4, abs=0)
    assert read["CO2"][0] == pytest.approx([0, 0, *sections[701.0]["CO2"][:, 20, 4]], rel=3.5e-4, abs=0)
    assert not np.any(read["O3"])


@pytest.mark.validation  # half a minute of sums of lines
@pytest.mark.shared_data
def test_an_interrupted_build_takes_up_its_finished_intervals(shared_data, tmp_path, monkeypatch):
    settings = Settings(tolerance=0.05, max_points=3)
    ranges, lines = [(2400.0, 2405.0), (2600.0, 2605.0)], shared_data / "lines"
    compute, known, computed = Builder.interval, {}, []

    def interval(self, low, high):
        """Computed once: the test is of which intervals are asked for."""
        if low not in known:
            known[low] = compute(self, low, high)
        return known[low]

    monkeypatch.setattr(Builder, "interval", interval)
    whole = build(ranges, tmp_path / "whole.h5", lines, "lowtran7", settings=settings)

    def interrupted(self, low, high):
        if computed:
            raise KeyboardInterrupt
        computed.append(low)
        return interval(self, low, high)

    monkeypatch.setattr(Builder, "interval", interrupted)
    with pytest.raises(KeyboardInterrupt):
        build(ranges, tmp_path / "stopped.h5", lines, "lowtran7", settings=settings)
    assert not (tmp_path / "stopped.h5").exists() and computed == [2400.0]
    monkeypatch.setattr(Builder, "interval", lambda self, low, high: computed.append(low) or interval(self, low, high))
    assert build(ranges, tmp_path / "stopped.h5", lines, "lowtran7", settings=settings) == whole
    assert computed[1:] == [2600.0]
