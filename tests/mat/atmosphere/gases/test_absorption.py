"""The packaged absorption table: agreement with line by line, behaviour at the ends, errors."""

from pathlib import Path

import numpy as np
import pytest

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.gases.lagrange import lagrange_weights
from skyshine.mat.atmosphere.gases.spectral_points import CONTINUUM, water_continuum
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.errors import InputError

REFERENCE = Path(__file__).parents[3] / "data" / "line_by_line_tropical_5km.csv"
BOLTZMANN = 1.380649e-23  # J/K


@pytest.fixture(scope="module")
def table():
    return AbsorptionTable.open()


@pytest.fixture(scope="module")
def points(table):
    return table.points(1000, 1050)


def interval_means(points, transmittance):
    return np.bincount(points.interval, points.weight * transmittance) / np.bincount(points.interval, points.weight)


def reference_path():
    text = REFERENCE.read_text(encoding="utf-8").splitlines()[1].removeprefix("# ")
    return {name: float(value) for name, value in (item.split("=") for item in text.split())}


@pytest.mark.parametrize("gas", ["H2O", CONTINUUM, "CO2", "CH4"])
def test_each_gas_agrees_with_line_by_line(table, gas):
    expected, path = read_csv(REFERENCE), reference_path()
    points = table.points(expected["low[cm-1]"][0], expected["high[cm-1]"][-1])
    np.testing.assert_allclose(points.interval_edges[:, 0], expected["low[cm-1]"])
    sections = points.cross_sections(path["pressure_Pa"], path["temperature_K"], path["H2O"], gases=[gas])[gas][0]
    density = path["pressure_Pa"] / (BOLTZMANN * path["temperature_K"])
    depth = sections * path[gas.split("_")[0]] * density * path["length_m"]
    error = interval_means(points, np.exp(-depth)) - expected[gas]
    assert np.sqrt(np.mean(error**2)) <= 0.003
    assert np.abs(error).max() <= 0.015


def test_error_on_unseen_paths_is_within_the_goal(table):
    low, high = table.interval_edges.T
    infrared = (low >= 330) & (high <= 5000)
    rms, largest = np.sqrt(np.mean(table.error[infrared, 0] ** 2)), table.error[infrared, 1].max()
    assert rms <= 0.0015 and largest <= 0.015
    # Beyond, intervals of 10 to 100 cm-1 with fewer points.
    assert np.sqrt(np.mean(table.error[~infrared, 0] ** 2)) <= 0.0015 and table.error[~infrared, 1].max() <= 0.02


def test_covers_everything_from_30_um_to_300_nm(table):
    assert table.coverage[0][0] <= 1e4 / 30 and table.coverage[-1][1] >= 1e4 / 0.3 and len(table.coverage) == 1


def test_covers_the_thermal_windows(table):
    for low, high in ((695, 1305), (1900, 3400)):
        assert any(first <= low and high <= last for first, last in table.coverage)
    assert {"H2O", "CO2", "CH4"} <= set(table.gases)


def test_weights_sum_to_the_width_of_each_interval(table):
    points = table.points(2000, 2500)
    sums = np.bincount(points.interval, points.weight)
    np.testing.assert_allclose(sums, np.diff(points.interval_edges, axis=1)[:, 0], rtol=1e-12)
    assert points.weight.min() > 0
    inside = points.interval_edges[points.interval]
    assert np.all((inside[:, 0] <= points.wavenumber) & (points.wavenumber <= inside[:, 1]))


def test_range_is_widened_to_whole_intervals(table):
    points = table.points(1001, 1006)
    np.testing.assert_array_equal(points.interval_edges, [[1000, 1005], [1005, 1010]])


def test_cross_sections_are_finite_and_never_negative(points):
    pressure = np.array([1e-9, 1e-3, 1.0, 1e4, 1.1e5])
    for temperature in (150.0, 250.0, 350.0):
        for gas, values in points.cross_sections(pressure, np.full(5, temperature), np.full(5, 0.02)).items():
            assert values.shape == (5, points.wavenumber.size), gas
            assert np.all(np.isfinite(values)) and values.min() >= 0, gas


# Of each region, where absorption is strongest and weakest.
@pytest.mark.parametrize(
    "low, high", [(150, 200), (650, 700), (5300, 5500), (7850, 7950), (13000, 13200), (17000, 18000), (30000, 33333)]
)
def test_extreme_air_stays_finite_and_monotone_in_every_region(table, low, high):
    points = table.points(low, high)
    pressure, temperature = (
        a.ravel() for a in np.meshgrid([1e-3, 1e-1, 1e2, 5e4, 1.1e5], [150.0, 200.0, 273.0, 350.0])
    )
    for fraction in (0.0, 1e-9, 0.08):
        sections = points.cross_sections(pressure, temperature, np.full(pressure.size, fraction))
        for gas, values in sections.items():
            assert np.all(np.isfinite(values)) and values.min() >= 0, gas
            amounts = np.array([0.0, 1e12, 1e20, 1e24, 1e28])[:, None, None]
            transmittance = np.exp(-amounts * values)
            assert np.all(transmittance[0] == 1) and np.all(np.diff(transmittance, axis=0) <= 0), gas
            assert transmittance.min() >= 0, gas


@pytest.mark.parametrize(
    "low, high, pressure, expected",
    # Strengths of the O2 bands at 762 nm and 1.27 um, cm molecule-1 (HITRAN2012: sums over their lines).
    [(12880, 13220, 1e5, 2.24e-22), (7700, 8100, 1e3, 3.23e-24)],
)
def test_strength_of_oxygen_bands(table, low, high, pressure, expected):
    points = table.points(low, high)
    sections = points.cross_sections(pressure, 296.0, 0.0, gases=["O2"])["O2"][0] * 1e4
    assert sections @ points.weight == pytest.approx(expected, rel=0.08, abs=0)


def test_ozone_of_the_chappuis_band(table):
    points = table.points(16500, 16700)
    section = points.cross_sections(5e4, 250.0, 0.0, gases=["O3"])["O3"] * 1e4
    assert section.mean() == pytest.approx(5.1e-21, rel=0.06, abs=0)  # near 602 nm (Gorshelev et al. 2014)


def test_lines_keep_their_doppler_shape_below_the_lowest_pressure(points):
    low, lower = (points.cross_sections(p, 250.0, 0.0, gases=["CO2"])["CO2"] for p in (1e-3, 1e-9))
    np.testing.assert_array_equal(low, lower)


def test_water_broadens_its_own_lines(points):
    dry, moist = (points.cross_sections(101300.0, 300.0, q, gases=["H2O"])["H2O"][0] for q in (0.0, 0.04))
    ratio = moist / dry
    # The self width of water vapour is three to seven times its air width: wings grow by 8 to 24 %, centres shrink
    # alike.
    assert 0.75 < ratio.min() < 0.97 < 1.06 < np.median(ratio) < 1.25


def test_saturated_air_at_45_degrees_is_inside_the_table(points):
    # 95.9 hPa over water (CRC Handbook). Wings of H2O grow almost as 1 + 4 q, from one node to the other and on.
    pressure, temperature = 101300.0, 318.15
    fraction = np.array([0.0, 0.06, 0.0946])
    values = points.cross_sections(np.full(3, pressure), np.full(3, temperature), fraction)
    assert all(np.all(np.isfinite(v)) and v.min() >= 0 for v in values.values())
    growth = np.median(values["H2O"] / values["H2O"][0], axis=1) - 1
    assert growth[2] / growth[1] == pytest.approx(0.0946 / 0.06, rel=0.05)


def test_interpolation_is_smooth_between_the_nodes(points):
    temperature = np.linspace(200.0, 320.0, 400)
    values = np.log(points.cross_sections(np.full(400, 8e4), temperature, np.full(400, 0.01), gases=["H2O"])["H2O"])
    steps = np.diff(values, axis=0)
    assert np.abs(np.diff(steps, axis=0)).max() < 0.1 * np.abs(steps).max()


def test_continuum_is_quadratic_in_the_amount_of_water():
    # The self continuum alone (no foreign): absorption coefficient goes with the square of the water density.
    arguments = np.array([1e-28]), np.zeros(1), np.array([5.0]), np.array([1000.0])
    one, two = (water_continuum(*arguments, [1e5], [290.0], [q])[0, 0] * q for q in (0.01, 0.02))
    assert two / one == pytest.approx(4.0)


def test_continuum_in_the_window_weakens_with_warmth(points):
    values = points.cross_sections(np.full(2, 1e5), np.array([280.0, 310.0]), np.full(2, 0.01), gases=[CONTINUUM])[
        CONTINUUM
    ]
    assert np.all(values[0] > 1.3 * values[1])


def test_subset_gives_the_same_cross_sections(points):
    index = np.array([40, 3, 17])
    few = points.subset(index, weight=[1.0, 2.0, 3.0])
    np.testing.assert_array_equal(few.wavenumber, points.wavenumber[index])
    np.testing.assert_array_equal(few.weight, [1.0, 2.0, 3.0])
    all_sections, some = (p.cross_sections(5e4, 260.0, 0.003) for p in (points, few))
    for gas, values in some.items():
        # Logarithms near -65 in single precision, whose last place is 8e-6.
        np.testing.assert_allclose(values, all_sections[gas][:, index], rtol=5e-5)


def test_subset_keeps_gases_that_only_some_points_have(table):
    points = table.points(2000, 2600)
    full = points.cross_sections(5e4, 260.0, 0.003)
    index = np.arange(0, points.wavenumber.size, 7)
    some = points.subset(index).cross_sections(5e4, 260.0, 0.003)
    for gas in full:
        np.testing.assert_allclose(some[gas], full[gas][:, index], rtol=1e-5)


def test_gases_without_data_in_a_range_do_not_absorb(table):
    points = table.points(1000, 1020)
    assert {"H2O", "O3", CONTINUUM} <= set(points.absorbing) and "SO2" not in points.absorbing
    sections = points.cross_sections(1e5, 290.0, 0.01)
    assert set(sections) == set(points.gases)
    assert all(sections[gas].max() == 0 for gas in set(points.gases) - set(points.absorbing))


def test_every_interval_of_a_gas_names_its_source(table):
    for gas in table.gases:
        ranges = table.provenance(gas)
        assert sum(high - low for low, high, _ in ranges) == pytest.approx(sum(b - a for a, b in table.coverage))
    assert any("HITRAN2012" in text for _, _, text in table.provenance("CO2"))


@pytest.mark.parametrize(
    "pressure, temperature, fraction, message",
    [
        (1.2e5, 290.0, 0.01, "pressure 1200 hPa"),
        (-1.0, 290.0, 0.01, "pressure"),
        (1e5, 149.0, 0.01, "temperature 149 K"),
        (1e5, 290.0, 0.2, "mole fraction 0.2"),
        (1e5, np.nan, 0.01, "temperature nan K"),
    ],
)
def test_values_outside_the_table_are_refused(points, pressure, temperature, fraction, message):
    with pytest.raises(InputError, match=message):
        points.cross_sections(pressure, temperature, fraction)


def test_unknown_gas_is_refused(points):
    with pytest.raises(InputError, match="no gas 'XYZ'"):
        points.cross_sections(1e5, 290.0, 0.01, gases=["XYZ"])


@pytest.mark.parametrize(
    "low, high, message", [(1000, 1000, "no range"), (1200, 1100, "no range"), (2, 20, "not covered")]
)
def test_ranges_that_cannot_be_are_refused(table, low, high, message):
    with pytest.raises(InputError, match=message):
        table.points(low, high)


def test_other_files_are_refused(tmp_path):
    path = tmp_path / "text.h5"
    path.write_text("not a table")
    with pytest.raises(InputError, match="not a readable HDF5 file"):
        AbsorptionTable.open(path)
    with pytest.raises(InputError, match="does not exist"):
        AbsorptionTable.open(tmp_path / "absent.h5")


@pytest.mark.parametrize("count", [3, 4, 9])
def test_lagrange_weights_reproduce_polynomials(count):
    nodes = np.sort(np.random.default_rng(1).uniform(0, 10, count))
    x = np.linspace(nodes[0], nodes[-1], 50)
    weights = lagrange_weights(nodes, x)
    for degree in range(min(4, count)):
        np.testing.assert_allclose(weights @ nodes**degree, x**degree, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    "gas, low, high",
    [("CFC-11", 845, 850), ("CFC-12", 920, 925), ("HCFC-22", 805, 815), ("CCl4", 790, 800), ("HNO3", 870, 900)],
)
def test_heavy_molecules_absorb_in_the_window(table, gas, low, high):
    points = table.points(low, high)
    values = points.cross_sections([1e3, 1e5], [220.0, 290.0], [0.0, 0.01], gases=[gas])[gas] * 1e4
    # Strong bands of molecules of five atoms: 1e-19 to 2e-17 cm2 (HITRAN).
    assert values.mean() > 1e-19 and values.max() < 2e-17
    assert any("measured" in text for _, _, text in table.provenance(gas)) and table.terms(gas)


def test_another_water_continuum_changes_that_alone_and_only_in_its_range():
    own, older = AbsorptionTable.open(), AbsorptionTable.open(water_continuum="mt_ckd_2.4")
    assert own.content != older.content
    for low, high, factor in (
        (1000.0, 1010.0, (1.2, 1.5)),
        (2490.0, 2510.0, (0.25, 0.32)),
        (4400.0, 4500.0, (0.1, 0.9)),
        (5100.0, 5110.0, (1.0, 1.0)),
    ):
        ours, theirs = (
            table.points(low, high).cross_sections([1e5], [296.0], [0.02], gases=["H2O", "H2O_continuum"])
            for table in (own, older)
        )
        assert np.array_equal(ours["H2O"], theirs["H2O"])
        # Mlawer et al. 2012 and 2023: raised at 2500 cm-1 by MT_CKD 2.5, lowered at 1000 cm-1 by MT_CKD 4, which raised
        # it between 2 and 2.4 um.
        ratio = theirs["H2O_continuum"] / ours["H2O_continuum"]
        assert np.all((ratio >= factor[0]) & (ratio <= factor[1])), (low, ratio)


def test_the_continuum_for_closure_changes_the_foreign_part_of_the_window_alone():
    """for_closure_absco_ref over for_absco_ref of MT_CKD 4.3 at 1000 cm-1: 5.946e-28 over 2.451e-28."""
    own, closure = (
        AbsorptionTable.open(water_continuum=name).points(995.0, 1005.0) for name in (None, "mt_ckd_4.3_closure")
    )
    foreign = [
        points.cross_sections([1e5], [296.0], [0.0], gases=["H2O_continuum"])["H2O_continuum"]
        for points in (own, closure)
    ]
    assert foreign[1] / foreign[0] == pytest.approx(np.full_like(foreign[0], 2.426), rel=0.04)
    by_water = [
        points.cross_sections([1e5], [296.0], [0.02], gases=["H2O_continuum"])["H2O_continuum"] - 0.98 * dry
        for points, dry in zip((own, closure), foreign, strict=True)
    ]
    np.testing.assert_allclose(by_water[0], by_water[1], rtol=1e-9)


def test_the_lowtran7_continuum_is_near_the_measured_self_continuum_of_the_window():
    """The fit of Roberts, Selby and Biberman 1976 (Appl. Opt. 15, 2085) to measurements at 296 K, g^-1 cm^2 atm^-1."""
    points = AbsorptionTable.open(water_continuum="lowtran7").points(800.0, 1200.0)
    humid = points.cross_sections([101325.0], [296.0], [0.02], gases=["H2O_continuum"])["H2O_continuum"][0]
    # Without water vapour what is left is the foreign continuum.
    dry = points.cross_sections([101325.0], [296.0], [0.0], gases=["H2O_continuum"])["H2O_continuum"][0]
    per_atmosphere = (humid - 0.98 * dry) / 0.02 * 1e4  # cm2/molecule
    measured = (4.18 + 5578 * np.exp(-7.87e-3 * points.wavenumber)) * 18.0153 / 6.02214e23
    ratio = per_atmosphere / measured
    assert np.all((ratio > 0.75) & (ratio < 1.1)), (ratio.min(), ratio.max())


def test_the_lowtran7_continuum_reaches_over_the_whole_table():
    own, public = AbsorptionTable.open(), AbsorptionTable.open(water_continuum="lowtran7")
    for low, high in ((100.0, 110.0), (4000.0, 4010.0), (10000.0, 10050.0)):
        ours, theirs = (
            table.points(low, high).cross_sections([1e5], [296.0], [0.02], gases=["H2O_continuum"])["H2O_continuum"]
            for table in (own, public)
        )
        assert np.all(ours != theirs) and np.all((theirs / ours > 0.3) & (theirs / ours < 6.0)), theirs / ours


def test_an_unknown_water_continuum_is_named():
    with pytest.raises(
        InputError,
        match="found water vapour continuum 'ckd_2'; allowed: mt_ckd_4.3, mt_ckd_4.3_closure, mt_ckd_2.4, lowtran7$",
    ):
        AbsorptionTable.open(water_continuum="ckd_2")
