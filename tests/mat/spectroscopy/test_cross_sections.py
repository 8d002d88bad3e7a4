"""Measured cross sections: published strengths and peaks, behaviour at the ends of temperature, distribution over
points.
"""

import gzip

import numpy as np
import pytest

pytest.importorskip("numba")

from skyshine.mat.spectroscopy.cross_sections import Fit, Measurements, read_cross_sections, read_table, spread
from skyshine.schemas.errors import InputError


@pytest.fixture(scope="module")
def sources(shared_data):
    return {source.name: source for source in read_cross_sections(shared_data / "cross_sections")}


def at_wavelength(source, nanometres, temperature=293.0):
    return source.at(np.array([1e7 / nanometres]), temperature)[0, 0] * 1e4  # cm2


def strength(source, low, high, temperature=293.0):
    grid = np.linspace(low, high, 100_001)
    return np.trapezoid(source.at(grid, temperature)[0], grid) * 1e4  # cm2 cm-1


@pytest.mark.shared_data
@pytest.mark.parametrize(
    "gas, nanometres, expected, tolerance",
    [
        # Hartley peak at 255 nm, Chappuis peak at 602 nm, edge of Huggins: Gorshelev et al. 2014 (Atmos. Meas. Tech. 7,
        # 609).
        ("O3", 255.0, 1.15e-17, 0.03),
        ("O3", 602.0, 5.1e-21, 0.06),
        ("O3", 325.0, 1.65e-20, 0.06),
        # Vandaele et al. 1998 (JQSRT 59, 171) near 400 nm; Vandaele et al. 2009 (JQSRT 110, 2115) near 300 nm.
        ("NO2", 400.0, 6.4e-19, 0.06),
        ("SO2", 300.0, 5.2e-19, 0.15),
    ],
)
def test_ultraviolet_and_visible_peaks(sources, gas, nanometres, expected, tolerance):
    assert at_wavelength(sources[gas], nanometres) == pytest.approx(expected, rel=tolerance, abs=0)


@pytest.mark.shared_data
@pytest.mark.parametrize(
    "gas, expected",
    # Whole infrared strengths, 1e-17 cm molecule-1: Harrison 2018 (Atmos. Meas. Tech. 11, 5827) for CFC-11 (710 to 1290
    # cm-1), Harrison 2015 (Atmos. Meas. Tech. 8, 3197) for CFC-12 (800 to 1270 cm-1); the tables here hold the two
    # strong bands.
    [("CFC-11", 10.0), ("CFC-12", 13.6)],
)
def test_strengths_of_the_chlorofluorocarbons(sources, gas, expected):
    value = strength(sources[gas], 700.0, 1300.0) / 1e-17
    assert 0.8 * expected < value < 1.02 * expected


@pytest.mark.shared_data
def test_cross_sections_stay_bounded_outside_the_measured_temperatures(sources):
    for source in sources.values():
        low, high = min(b.wavenumber[0] for b in source.bands), max(b.wavenumber[-1] for b in source.bands)
        grid = np.linspace(low - 50, high + 50, 5000)
        values = source.at(grid, [150.0, 203.0, 250.0, 296.0, 350.0])
        assert np.all(np.isfinite(values)) and values.min() >= 0
        np.testing.assert_array_equal(values[0], values[1])
        np.testing.assert_array_equal(values[3], values[4])
        assert values[:, 0].max() == 0 and values[:, -1].max() == 0


def test_temperatures_are_interpolated_between_tables():
    band = Measurements(np.array([100.0, 101.0]), np.array([200.0, 300.0]), np.array([[1.0, 3.0], [2.0, 6.0]]))
    np.testing.assert_allclose(band.at([100.5, 99.0], [250.0, 400.0]), [[3.0, 0.0], [4.0, 0.0]])


def test_fits_never_fall_below_zero():
    fit = Fit(np.array([100.0, 200.0]), np.array([[1.0, 1.0], [0.1, 0.1], [0.0, 0.0]]))
    assert fit.at([150.0], [203.0])[0, 0] == 0.0 and fit.at([150.0], [293.0])[0, 0] > 2.9


def test_spread_keeps_the_mean_and_the_distribution():
    rng = np.random.default_rng(3)
    grid = np.linspace(0.0025, 4.9975, 1000)
    section = np.exp(rng.normal(size=(2, 1000)))
    wavenumber, weight = np.sort(rng.uniform(0, 5, 12)), rng.uniform(0.1, 1.0, 12)
    few = spread(section, grid, wavenumber, weight)
    share = weight / weight.sum()
    np.testing.assert_allclose(share @ few, section.mean(axis=1), rtol=1e-12)
    for depth in (0.01, 0.3, 3.0):
        expected = np.exp(-depth * section).mean(axis=1)
        np.testing.assert_allclose(share @ np.exp(-depth * few), expected, atol=0.01)
    constant = spread(np.full((2, 1000), 7.0), grid, wavenumber, weight)
    np.testing.assert_allclose(constant, 7.0)


@pytest.mark.parametrize(
    "text", ["", "too short", f"{'CCl4':>10}{800.0:10.4f}{801.0:10.4f}{9:10d}{296.0:10.4f}\n 1.0E-18\n"]
)
def test_damaged_tables_are_refused(tmp_path, text):
    path = tmp_path / "CCL4.gz"
    with gzip.open(path, "wt") as file:
        file.write(text)
    with pytest.raises(InputError, match="is not a table of cross sections"):
        read_table(path)


def test_folder_without_tables_is_refused(tmp_path):
    with pytest.raises(InputError, match="--cross-sections needs"):
        read_cross_sections(tmp_path)
