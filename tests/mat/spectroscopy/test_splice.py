"""A table with some intervals built again: those are the new ones, all others stay bit for bit."""

from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from mat.maintain.lines.splice import splice
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.spectroscopy import nodes
from skyshine.mat.spectroscopy.intervals import IntervalPoints
from skyshine.mat.spectroscopy.lowtran_continua import LowtranContinua
from skyshine.mat.spectroscopy.sources import GasSources
from skyshine.mat.spectroscopy.table import Settings, assemble, part_path, write_part
from skyshine.schemas.errors import InputError

SHAPE = (nodes.PRESSURE.size, nodes.TEMPERATURE.size)
HUMID = nodes.PRESSURE.size - nodes.HUMID_PRESSURE


def table(folder, name, lows, gases, seed, text):
    """A table of intervals of 5 cm^-1 with random cross sections; three points in each if the seed is odd, else two."""
    generator, parts = np.random.default_rng(seed), []
    count = 2 + seed % 2
    for low in lows:
        continuum = generator.uniform(1e-30, 2e-30, (3, count))
        sections = {gas: np.exp(generator.uniform(-60, -50, (count, *SHAPE))) for gas in gases}
        moist = {"H2O": generator.uniform(-0.5, 0.5, (count, nodes.H2O_FRACTION.size - 1, HUMID, SHAPE[1]))}
        place = low + 5 * (np.arange(count) + 0.5) / count
        points = IntervalPoints(
            low, low + 5, place, np.full(count, 5 / count), sections, moist, continuum,
            np.full(4, seed * 1e-4), dict.fromkeys(gases, seed * 1e-4),
        )  # fmt: skip
        write_part(folder / name, points, "key")
        parts.append(dict(np.load(part_path(folder / name, low))))
    sources = [
        GasSources(gas, [SimpleNamespace(name=gas, provenance=f"{gas} {text}", terms="free", covers=lambda *_: True)])
        for gas in gases
    ]
    path = folder / f"{name}.h5"
    assemble(parts, path, sources=sources, continua=LowtranContinua(), settings=Settings())
    return path


def arrays(path):
    """All datasets of a file by name."""
    found = {}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return found


@pytest.fixture
def base(tmp_path):
    return table(tmp_path, "base", (700.0, 705.0, 710.0), ("CO2", "H2O"), 2, "of old")


def test_a_table_spliced_with_its_own_part_is_the_same(base, tmp_path):
    splice(base, base, tmp_path / "same.h5")
    one, two = arrays(base), arrays(tmp_path / "same.h5")
    assert one.keys() == two.keys()
    for name, values in one.items():
        assert np.array_equal(values, two[name]), name
        assert values.dtype == two[name].dtype


def test_new_intervals_replace_old_ones_and_the_rest_stays(base, tmp_path):
    part = table(tmp_path, "part", (705.0,), ("H2O", "O3"), 3, "anew")
    splice(base, part, tmp_path / "out.h5")
    old, new, out = (AbsorptionTable.open(path) for path in (base, part, tmp_path / "out.h5"))
    assert out.count.tolist() == [2, 3, 2]
    pressure, temperature, humidity = [5e4, 100.0], [270.0, 230.0], [0.01, 0.0]
    for source, low in ((old, 700.0), (new, 705.0), (old, 710.0)):
        expected = source.points(low, low + 5).cross_sections(pressure, temperature, humidity)
        got = out.points(low, low + 5).cross_sections(pressure, temperature, humidity)
        for gas in ("H2O", "CO2", "O3", "H2O_continuum"):
            if gas in expected and np.any(expected[gas]):
                assert np.array_equal(got[gas], expected[gas])
            else:
                assert not np.any(got.get(gas, 0.0))
    texts = [text for _, _, text in out.provenance("H2O")]
    assert texts == ["H2O of old", "H2O anew", "H2O of old"]
    assert [text for _, _, text in out.provenance("O3") if "anew" in text] == ["O3 anew"]


def test_a_part_beside_the_table_is_refused(base, tmp_path):
    part = table(tmp_path, "part", (720.0,), ("H2O",), 3, "anew")
    with pytest.raises(InputError, match="has intervals that .* lacks"):
        splice(base, part, tmp_path / "out.h5")
    (tmp_path / "no.h5").write_bytes(b"nothing")
    with pytest.raises(InputError, match="cannot be read"):
        splice(base, tmp_path / "no.h5", tmp_path / "out.h5")
