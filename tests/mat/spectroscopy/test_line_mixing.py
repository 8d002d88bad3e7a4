"""Relaxation matrices of CO2's bands against identities of angular momentum and against single lines."""

import dataclasses
import math
from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("hapi")

from skyshine.mat.radiometry.constants import C2
from skyshine.mat.spectroscopy import line_mixing, linebyline
from skyshine.mat.spectroscopy.continua import Continua
from skyshine.mat.spectroscopy.gases import LineLibrary
from skyshine.mat.spectroscopy.line_mixing import Band, MixedLines, _off_diagonal, moments, relaxation_matrix
from skyshine.mat.spectroscopy.lines import LineList

ORIGIN, LOWER_B, UPPER_B, BEND = 2349.143, 0.390219, 0.387141, 667.4
ATMOSPHERE, TEMPERATURE = 101325.0, 296.0


def band(momentum=0, highest=90):
    """A band like v3 of CO2, of the measured strength and a width that falls with J; even J only where l = 0."""
    low = np.arange(momentum, highest + 1, 2 if momentum == 0 else 1)
    lower = np.concatenate([low, low[low > momentum]])
    upper = np.concatenate([low + 1, low[low > momentum] - 1])
    energy = LOWER_B * lower * (lower + 1) + momentum * BEND
    place = ORIGIN + UPPER_B * upper * (upper + 1) - LOWER_B * lower * (lower + 1)
    strength = np.exp(-C2 * energy / TEMPERATURE) * np.maximum(lower, upper) * place
    order = np.argsort(place)
    values = [
        np.ones(place.size, int),
        place,
        9.2e-17 * strength / strength.sum(),
        0.1 * np.exp(-0.012 * lower),
        0.12 * np.exp(-0.012 * lower),
        energy,
        np.full(place.size, 0.7),
        np.full(place.size, -0.002),
    ]
    parity = (lower % 2 == 0) & (momentum > 0)
    return Band(LineList(2, *(v[order] for v in values)), lower[order], upper[order], parity[order], momentum)


def single(one, wavenumber, pressure, temperature):
    return linebyline.point_cross_sections(one.lines, wavenumber, [pressure], [temperature])[0, 0]


def mixed(bands, wavenumber, pressure, temperature):
    return MixedLines(bands).cross_sections(wavenumber, [pressure], [temperature])[0, 0]


@pytest.mark.parametrize("momentum", [0, 1, 2])
@pytest.mark.parametrize("level", [2, 4, 8])
def test_a_rate_of_one_level_keeps_the_sum_over_all_lines(momentum, level):
    """With sudden collisions of one L alone, what a line keeps and what it gives to the others is the rate, 2L + 1, for
    every line: the orthogonality of the 3j and 6j symbols.
    """
    low = np.arange(momentum, 24, 1 if momentum else 2)
    branches = (1, 0, -1) if momentum else (1, -1)
    pairs = [(j, j + step) for j in low for step in branches if j + step >= momentum]
    lower, upper = np.array(pairs).T
    parity = (lower % 2 == 0) & (momentum > 0)
    rate, ones = np.zeros(120), np.ones(120)
    rate[level] = 1.0
    matrix = _off_diagonal(lower, upper, parity, momentum, rate, ones, 2.0 * lower + 1)
    dipole = moments(lower, upper, momentum)
    whole = [j for j in np.unique(lower) if level <= j < 24 - level - 1]
    for k in [int(np.flatnonzero(lower == j)[0]) for j in whole[:4]]:
        a, b = int(lower[k]), int(upper[k])
        elastic = three_j(level, a, momentum) * three_j(level, b, momentum) * six_j(a, b, level)
        kept = (2 * level + 1) * (2 * a + 1) * (2 * b + 1) * elastic
        total = dipole @ matrix[:, k] / dipole[k] + kept
        assert abs(total) == pytest.approx(2 * level + 1, rel=1e-9)


def three_j(level, j, m):
    """(j L j; -m 0 m) by Racah's formula."""
    f = math.factorial
    root = math.sqrt(Fraction(f(level) ** 2 * f(2 * j - level), f(2 * j + level + 1))) * f(level) * f(j + m) * f(j - m)
    total = Fraction(0)
    for t in range(max(0, level - j - m), min(level, j - m) + 1):
        total += Fraction((-1) ** t, f(t) * f(level - t) * f(j - m - t) * f(level - t) * f(j + m - level + t) * f(t))
    return (-1) ** (j - m) * root * float(total)


def six_j(a, b, level):
    """{a b 1; b a L} by Racah's formula."""
    f = math.factorial
    delta = Fraction(f(a + b - 1) * f(a - b + 1) * f(b - a + 1), f(a + b + 2))
    pair = [Fraction(f(2 * j - level) * f(level) ** 2, f(2 * j + level + 1)) for j in (a, b)]
    total = Fraction(0)
    for t in range(max(a + b + 1, 2 * a + level, 2 * b + level), min(2 * a + 2 * b, a + b + 1 + level) + 1):
        below = f(t - a - b - 1) ** 2 * f(t - 2 * a - level) * f(t - 2 * b - level)
        below *= f(2 * a + 2 * b - t) * f(a + b + 1 + level - t) ** 2
        total += Fraction((-1) ** t * f(t + 1), below)
    return float(delta * total) * math.sqrt(pair[0] * pair[1])


def test_rates_of_nitrogen_are_the_published_power_law():
    """By hand: 0.0180 * 6^-0.81 * exp(-0.008 * 1.438777 * 0.39021 * 6 / 296) = 4.2163e-3 at L = 2 and 296 K; between
    J = 18 and 20 lie 2 pi c 0.39021 (4 * 20 - 2) = 5.7332e12 rad/s, 2.0841 in 2.2 angstrom / 605.2 m/s: 0.7170.
    """
    rate, correction = line_mixing.rates(line_mixing.NITROGEN, 40, 296.0)
    assert rate[0] == 0
    assert rate[2] == pytest.approx(4.2163e-3, rel=1e-4)
    assert correction[20] == pytest.approx(0.7170, rel=1e-4)
    assert np.all(np.diff(correction) <= 0) and correction[0] == 1


def test_moments_are_those_of_hoenl_and_london():
    lower = np.array([2, 2, 10, 40])
    upper = np.array([3, 1, 11, 39])
    expected = np.maximum(lower, upper) / (2 * lower + 1)
    assert moments(lower, upper, 0) ** 2 == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("momentum", [0, 1])
@pytest.mark.parametrize("temperature", [200.0, 296.0])
def test_the_matrix_obeys_detailed_balance_and_the_sum_rule(momentum, temperature):
    one = band(momentum)
    population = (2 * one.lower + 1) * np.exp(-C2 * one.lines.lower_energy / temperature)
    dipole = moments(one.lower, one.upper, momentum)
    matrix = relaxation_matrix(one, temperature, population, dipole, one.lines.air_width)
    assert np.allclose(matrix * population, (matrix * population).T, rtol=1e-12, atol=0)
    assert np.diag(matrix) == pytest.approx(one.lines.air_width)
    inner = (one.lower > 2) & (one.lower < 75)
    assert np.abs(dipole @ matrix[:, inner]).max() < 1e-10
    assert np.median(np.abs(matrix - np.diag(np.diag(matrix)))[np.ix_(inner, inner)]) > 1e-6


def test_thin_air_shows_single_lines():
    one = band()
    near = one.lines.wavenumber[20:24]
    wavenumber = np.concatenate([near, near + 2e-3])
    assert mixed([one], wavenumber, 50.0, 250.0) == pytest.approx(single(one, wavenumber, 50.0, 250.0), rel=3e-3)


def test_mixing_moves_absorption_but_keeps_its_sum():
    one = band()
    wavenumber = np.arange(1800.0, 2900.0, 0.02)
    total = mixed([one], wavenumber, ATMOSPHERE, TEMPERATURE).sum() * 0.02
    # Lines keep the sum of S / (nu (1 - exp)), so that of S but for the change of these across the band.
    assert total == pytest.approx(one.lines.strength.sum() * 1e-4, rel=2e-3)


def test_wings_fall_far_below_those_of_single_lines_and_the_middle_grows():
    one = band()
    head = one.lines.wavenumber.max()
    beyond = head + np.array([5.0, 10.0, 20.0])
    lines = one.lines
    lorentz = lines.air_width / math.pi / ((beyond[:, None] - lines.wavenumber) ** 2 + lines.air_width**2)
    plain = lorentz @ lines.strength * 1e-4
    ratio = mixed([one], beyond, ATMOSPHERE, TEMPERATURE) / plain
    assert np.all(ratio > 0.02) and np.all(ratio < 0.1)
    gap = np.array([ORIGIN])
    assert mixed([one], gap, ATMOSPHERE, TEMPERATURE)[0] < single(one, gap, ATMOSPHERE, TEMPERATURE)[0]


def test_wings_grow_with_the_square_of_pressure_as_columns_do():
    # Cross section far outside in proportion to pressure.
    one, beyond = band(), np.array([2450.0])
    thin, thick = (mixed([one], beyond, p, 260.0)[0] for p in (2e4, 1e5))
    assert thick / thin == pytest.approx(5.0, rel=0.02)


def test_extremes_stay_finite_and_positive():
    wavenumber = np.linspace(2200.0, 2560.0, 500)
    for pressure in (1e-3, 1.1e5):
        for temperature in (150.0, 350.0):
            values = mixed([band(), band(1)], wavenumber, pressure, temperature)
            assert np.all(np.isfinite(values)) and values.min() >= 0
    assert np.all(mixed([], wavenumber, 1e5, 250.0) == 0)


def record(one, k, upper="       0 0 0 11", lower="       0 0 0 01"):
    """HITRAN's 160 columns of a line."""
    lines, branch = one.lines, "P" if one.upper[k] < one.lower[k] else "R"
    text = (
        f" 21{lines.wavenumber[k]:12.6f}{lines.strength[k]:10.3E}{1:10.3E}"
        + f"{lines.air_width[k]:.4f}"[1:]
        + f"{lines.self_width[k]:5.3f}{lines.lower_energy[k]:10.4f}{lines.temperature_exponent[k]:4.2f}"
        + f"{lines.shift[k]:8.5f}".replace("-0.", "-0.")[:8]
        + upper
        + lower
        + " " * 15
        + f"     {branch}{one.lower[k]:3d}e     "
    )
    return text.ljust(160)


@pytest.fixture
def library(tmp_path):
    one = band()
    rows = [record(one, k) for k in range(len(one.lines))]
    alone = dataclasses.replace(one, lines=one.lines)
    rows.append(record(alone, 3, lower="       0 1 1 01"))  # not of a parallel band
    rows.sort(key=lambda text: float(text[3:15]))
    (tmp_path / "02_some.par").write_text("\n".join(rows) + "\n")
    return LineLibrary(tmp_path)


def test_records_give_the_bands_whose_lines_mix(library):
    bands = line_mixing.read_bands([library.folder / "02_some.par"])
    assert len(bands) == 1
    found, one = bands[0], band()
    strong = one.lines.strength > 1e-27
    assert found.momentum == 0
    assert found.lower.tolist() == one.lower[strong].tolist()
    assert found.upper.tolist() == one.upper[strong].tolist()


def test_a_library_mixes_lines_inside_the_range_and_sums_them_outside(library):
    low, high = line_mixing.RANGE
    wavenumber = np.array([low - 1.0, 2397.0, high + 1.0])
    ours = library.point_cross_sections("CO2", wavenumber, [ATMOSPHERE], [260.0], 4e-4)[0, 0]
    bands = line_mixing.read_bands([library.folder / "02_some.par"])
    inside = mixed(bands, wavenumber[1:2], ATMOSPHERE, 260.0)[0]
    assert ours[1] == pytest.approx(inside, rel=0.05)  # and the line that is single
    near = linebyline.point_cross_sections(
        library.near("CO2", low - 1, low - 1), wavenumber[:1], [ATMOSPHERE], [260.0], 4e-4, linebyline.SUB_LORENTZIAN
    )
    assert ours[0] == pytest.approx(near[0, 0, 0], rel=1e-12)
    assert ours[2] == 0.0
    on_grid = library.interval_spectrum("CO2", 2395.0, 2400.0, [ATMOSPHERE], [260.0], 4e-4)[0, 0]
    grid = linebyline.interval_grid(2395.0, 2400.0)
    points = library.point_cross_sections("CO2", grid[::300], [ATMOSPHERE], [260.0], 4e-4)[0, 0]
    assert on_grid[::300] == pytest.approx(points, rel=1e-3)


def test_an_interval_across_the_edge_has_either(library):
    low = line_mixing.RANGE[0]
    grid = linebyline.interval_grid(low - 2, low + 3)
    both = library.interval_spectrum("CO2", low - 2, low + 3, [1e5], [260.0], 4e-4)[0, 0]
    some = np.arange(0, grid.size, 400)
    points = library.point_cross_sections("CO2", grid[some], [1e5], [260.0], 4e-4)[0, 0]
    assert both[some] == pytest.approx(points, rel=2e-2)
    assert math.isfinite(both.sum())


@pytest.mark.shared_data
def test_there_is_no_continuum_where_lines_mix(shared_data):
    continua = Continua(shared_data / "continua")
    low, high = line_mixing.RANGE
    values = continua.co2(np.array([low - 5.0, 0.5 * (low + high), high + 5.0]), 1e5, 260.0)
    assert values[1] == 0 and values[0] > 0 and values[2] > 0
