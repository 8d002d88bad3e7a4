"""Line-by-line sums against closed forms and against themselves by another road."""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("hapi")

from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.lines import LineList

CO2, H2O = 2, 1


def lines(wavenumber, strength=1e-20, molecule=CO2, width=0.07, energy=100.0, shift=0.0):
    wavenumber = np.atleast_1d(np.asarray(wavenumber, float))
    full = np.ones(wavenumber.size)
    return LineList(
        molecule,
        full.astype(int),
        wavenumber,
        strength * full,
        width * full,
        4 * width * full,
        energy * full,
        0.7 * full,
        shift * full,
    )


def at(line_list, wavenumber, pressure=101325.0, temperature=296.0, **settings):
    return linebyline.point_cross_sections(line_list, wavenumber, [pressure], [temperature], **settings)[0, 0]


def test_lorentz_line_at_reference_conditions():
    # At 296 K and 1 atm, 0.5 cm-1 from the centre, a line of half width 0.07 cm-1 is Lorentzian: S g / pi / (d^2 +
    # g^2).
    expected = 1e-20 * 1e-4 * 0.07 / np.pi / (0.5**2 + 0.07**2)
    assert at(lines(1000.0), [1000.5])[0] == pytest.approx(expected, rel=2e-4)


def test_doppler_line_at_vanishing_pressure():
    # Doppler 1/e half width nu sqrt(2 k T / m) / c of 12C16O2 (43.98983 u) at 250 K and 2000 cm-1: 2.0512e-3 cm-1.
    k, u, c = 1.380649e-23, 1.66053907e-27, 299792458.0
    half = 2000.0 * np.sqrt(2 * k * 250.0 / (43.98983 * u)) / c
    centre, side = at(lines(2000.0), [2000.0, 2000.0 + half], pressure=1e-3, temperature=250.0)
    assert side / centre == pytest.approx(np.exp(-1), rel=1e-3)


@pytest.mark.parametrize("pressure", [1.0, 1e3, 1e5])
def test_integral_is_the_line_strength(pressure):
    low, high = 1000.0, 1005.0
    grid = linebyline.interval_grid(low, high)
    section = linebyline.interval_spectrum(lines(1002.5), low, high, [pressure], [296.0])[0, 0]
    wings = 1 - 2 * 0.07 * pressure / 101325 / np.pi / 2.5  # the Lorentz wings beyond the interval
    assert np.sum(section) * (grid[1] - grid[0]) == pytest.approx(1e-24 * wings, rel=2e-4)


@pytest.mark.parametrize("shape", [linebyline.PLAIN, linebyline.PEDESTAL_REMOVED, linebyline.SUB_LORENTZIAN])
@pytest.mark.parametrize("low", [350.0, 1000.0, 2350.0, 4800.0])
def test_nested_grids_agree_with_the_direct_sum(shape, low):
    rng = np.random.default_rng(3)
    many = lines(np.sort(rng.uniform(low - 25, low + 30, 300)), strength=10 ** rng.uniform(-24, -19, 300))
    pressure, temperature = np.array([10.0, 3e3, 1e5]), np.array([200.0, 300.0])
    grid = linebyline.interval_grid(low, low + 5)
    some = rng.choice(grid.size, 200, replace=False)
    nested = linebyline.interval_spectrum(many, low, low + 5, pressure, temperature, 0.0, shape)[..., some]
    direct = linebyline.point_cross_sections(many, grid[some], pressure, temperature, 0.0, shape)
    thickness = np.log(2) / np.median(direct, axis=-1, keepdims=True)
    assert np.abs(np.exp(-thickness * nested) - np.exp(-thickness * direct)).max() < 1e-3


def test_pedestal_makes_the_profile_end_at_zero():
    inside, outside = at(lines(1000.0, molecule=H2O), [1024.9999, 1025.001], shape=linebyline.PEDESTAL_REMOVED)
    plain = at(lines(1000.0, molecule=H2O), [1024.9999])[0]
    assert outside == 0.0 and 0.0 <= inside < 1e-4 * plain


def test_self_broadening_widens_the_wings():
    dry, moist = (at(lines(1000.0, molecule=H2O), [1001.0], self_fraction=x)[0] for x in (0.0, 0.04))
    assert moist / dry == pytest.approx(1 + 3 * 0.04, rel=3e-3)  # self width four times the air width


def test_pressure_shift_moves_the_centre():
    shifted = lines(1000.0, shift=-0.01)
    values = at(shifted, [999.98, 999.99, 1000.0])
    assert values[1] > values[0] == pytest.approx(values[2], rel=1e-3)


def test_no_lines_give_zero_and_extremes_stay_finite():
    none = lines(1000.0).select(slice(0, 0))
    assert np.all(linebyline.interval_spectrum(none, 1000.0, 1005.0, [1e5], [300.0]) == 0)
    extreme = linebyline.interval_spectrum(lines(1002.0), 1000.0, 1005.0, [1e-3, 1.1e5], [150.0, 350.0])
    assert np.all(np.isfinite(extreme)) and extreme.min() >= 0
