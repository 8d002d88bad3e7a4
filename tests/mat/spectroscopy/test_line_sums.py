"""Line-by-line sums against closed forms and against themselves by another road."""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("hapi")

from skyshine.mat.spectroscopy import linebyline
from skyshine.mat.spectroscopy.lines import LineList

CO2, H2O = 2, 1


def lines(wavenumber, strength=1e-20, molecule=CO2, width=0.07, energy=100.0, shift=0.0, isotopologue=1):
    wavenumber = np.atleast_1d(np.asarray(wavenumber, float))
    full = np.ones(wavenumber.size)
    return LineList(
        molecule,
        isotopologue * full.astype(int),
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
    assert at(lines(1000.0), [1000.5])[0] == pytest.approx(expected, rel=2e-4, abs=0)


def test_lines_narrow_with_temperature_by_the_exponent_of_their_record():
    # Rothman et al. 2005, equation A12: gamma(T) = (296 / T)^n gamma, with n = 0.7.
    temperature = 220.0
    strength = linebyline.line_parameters(lines(1000.0), np.array([temperature]))[0][0, 0]
    width = 0.07 * (296.0 / temperature) ** 0.7
    wing = strength * width / np.pi / (1.0 + width**2)
    assert at(lines(1000.0), [1001.0], temperature=temperature)[0] == pytest.approx(wing, rel=2e-4, abs=0)


@pytest.mark.parametrize("temperature", [200.0, 320.0])
@pytest.mark.parametrize(
    ("molecule", "isotopologue", "wavenumber", "energy"), [(H2O, 4, 60.0, 500.0), (CO2, 2, 660.0, 1500.0)]
)
def test_strengths_are_those_of_the_hitran_package(molecule, isotopologue, wavenumber, energy, temperature):
    """HAPI's own change of a strength with temperature: partition sums, lower level, stimulated emission."""
    hapi = pytest.importorskip("hapi")
    one = lines(wavenumber, molecule=molecule, energy=energy, isotopologue=isotopologue)
    sums = [hapi.partitionSum(molecule, isotopologue, t) for t in (temperature, 296.0)]
    theirs = hapi.EnvironmentDependency_Intensity(1e-20, temperature, 296.0, *sums, energy, wavenumber)
    ours = linebyline.line_parameters(one, np.array([temperature]))[0][0, 0]
    assert ours == pytest.approx(theirs * 1e-4, rel=5e-4, abs=0)


@pytest.mark.parametrize(("isotopologue", "mass"), [(1, 43.98983), (2, 44.993185)])
def test_doppler_line_at_vanishing_pressure(isotopologue, mass):
    # Doppler 1/e half width nu sqrt(2 k T / m) / c of 12C16O2 and 13C16O2 at 250 K and 2000 cm-1.
    k, u, c = 1.380649e-23, 1.66053907e-27, 299792458.0
    half = 2000.0 * np.sqrt(2 * k * 250.0 / (mass * u)) / c
    line = lines(2000.0, isotopologue=isotopologue)
    centre, side = at(line, [2000.0, 2000.0 + half], pressure=1e-3, temperature=250.0)
    assert side / centre == pytest.approx(np.exp(-1), rel=1e-3)


@pytest.mark.parametrize("pressure", [1.0, 1e3, 1e5])
def test_integral_is_the_line_strength(pressure):
    low, high = 1000.0, 1005.0
    grid = linebyline.interval_grid(low, high)
    section = linebyline.interval_spectrum(lines(1002.5), low, high, [pressure], [296.0])[0, 0]
    wings = 1 - 2 * 0.07 * pressure / 101325 / np.pi / 2.5  # the Lorentz wings beyond the interval
    assert np.sum(section) * (grid[1] - grid[0]) == pytest.approx(1e-24 * wings, rel=2e-4, abs=0)


@pytest.mark.parametrize("shape", [linebyline.PLAIN, linebyline.PEDESTAL_REMOVED, linebyline.SUB_LORENTZIAN])
@pytest.mark.parametrize("low", [350.0, 1000.0, 2350.0, 4800.0])
def test_nested_grids_agree_with_the_direct_sum(shape, low):
    rng = np.random.default_rng(3)
    many = lines(np.sort(rng.uniform(low - 25, low + 30, 300)), strength=10 ** rng.uniform(-24, -19, 300), shift=-0.02)
    pressure, temperature = np.array([10.0, 3e3, 1e5]), np.array([200.0, 300.0])
    grid = linebyline.interval_grid(low, low + 5)
    some = rng.choice(grid.size, 200, replace=False)
    nested = linebyline.interval_spectrum(many, low, low + 5, pressure, temperature, 0.3, shape)[..., some]
    direct = linebyline.point_cross_sections(many, grid[some], pressure, temperature, 0.3, shape)
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
    assert values[1] > values[0] == pytest.approx(values[2], rel=1e-3, abs=0)


def test_the_grids_shift_and_broaden_a_line_as_its_record_says():
    # Half way up its wing at 1 atm a line of half width 0.07 (1 - 0.1) + 0.28 * 0.1 = 0.091 is 0.091 from its centre.
    line = lines(1002.5, shift=-0.1)
    grid = linebyline.interval_grid(1000.0, 1005.0)
    section = linebyline.interval_spectrum(line, 1000.0, 1005.0, [101325.0], [296.0], 0.1)[0, 0]
    above = grid[section > section.max() / 2]
    assert above.mean() == pytest.approx(1002.4, abs=1e-3)
    assert above[-1] - above[0] == pytest.approx(2 * 0.091, rel=0.015)


def test_no_lines_give_zero_and_extremes_stay_finite():
    none = lines(1000.0).select(slice(0, 0))
    assert np.all(linebyline.interval_spectrum(none, 1000.0, 1005.0, [1e5], [300.0]) == 0)
    extreme = linebyline.interval_spectrum(lines(1002.0), 1000.0, 1005.0, [1e-3, 1.1e5], [150.0, 350.0])
    assert np.all(np.isfinite(extreme)) and extreme.min() >= 0
