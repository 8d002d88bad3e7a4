"""The head of CO2's band at 4.3 um in limb radiance, against RFM line by line.

The reference is that of JURASSIC's validation (github.com/slcs-jsc/jurassic, projects/validation/rfm_reference: RFM
5.21, HITRAN2020, a step of 0.0005 cm-1, bent rays of geometric tangent heights of 5, 10 and 20 km). What it sums is not
written there; it is met by CO2 as Voigt lines cut at 25 cm-1 with the continuum of MT_CKD, and nitrogen of MT_CKD.
"""

import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("hapi")

from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.spectroscopy import line_mixing, linebyline
from skyshine.mat.spectroscopy.continua import Continua
from skyshine.mat.spectroscopy.gases import LineLibrary
from skyshine.mat.spectroscopy.reference import water_continuum

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]  # 60 s

# Altitude km, pressure hPa, temperature K, water vapour ppm: the mid-latitude air of the reference.
AIR = """
3 702.227 268.30 3845;4 617.614 263.24 2770;5 541.644 256.55 1897;6 473.437 250.20 1272;7 412.288 242.82 827
8 357.603 236.17 539;9 308.960 229.87 346.9;10 265.994 225.04 157.9;11 228.348 221.19 31.34;12 195.619 218.85 13.41
13 167.351 217.19 6.764;14 143.039 216.20 4.498;15 122.198 215.68 3.703;16 104.369 215.42 3.724;17 89.141 215.55 3.899
18 76.1528 215.92 4.002;19 65.0804 216.40 4.122;20 55.641 216.93 4.277;21 47.591 217.45 4.438;22 40.7233 218.00 4.558
23 34.8637 218.68 4.673;24 29.8633 219.39 4.763;25 25.5956 220.25 4.809;26 21.9534 221.30 4.856;27 18.8445 222.41 4.936
28 16.1909 223.88 5.021;29 13.9258 225.42 5.114;30 11.9913 227.20 5.222;31 10.340 229.52 5.331;32 8.92988 231.89 5.414
33 7.72454 234.51 5.488;34 6.6924 236.85 5.563;35 5.80701 239.42 5.633;36 5.04654 241.94 5.704;37 4.39238 244.57 5.767
38 3.82902 247.36 5.819;39 3.34337 250.32 5.872;40 2.92413 253.34 5.914;42 2.2464 258.27 5.984;44 1.73384 262.03 6.044
46 1.34242 264.20 6.104;48 1.04086 264.67 6.167;50 0.806832 263.24 6.208;55 0.421507 253.28 6.114
60 0.213465 240.38 5.582
"""
CARBON_DIOXIDE, NITROGEN = 368.32e-6, 0.78084
EARTH = 6367.421e3  # m, as the reference has it
REFRACTIVITY = 77.6e-6 / 100  # K Pa^-1
WINDOWS = [(low, low + 5.0) for low in np.arange(2385.5, 2420.0, 5.0)]  # five channels of 1 cm-1 each
# By geometric tangent height, 1e-6 W m-2 sr-1 (cm-1)-1: means of the reference over the windows.
REFERENCE = {
    5: [np.nan, np.nan, 26.34, 32.27, 36.07, 38.53, 40.79],
    10: [29.04, 22.42, 22.19, 23.52, 23.95, 24.00, 23.95],
    20: [30.44, 17.45, 9.811, 6.986, 5.879, 5.237, 4.800],
}
C1, C2 = 1.191042972e-8, 1.438776877  # W m^-2 sr^-1 (cm^-1)^-4 and cm K (CODATA 2018)


def air(altitude):
    """Pressure [Pa], temperature [K] and water vapour at altitudes [m]."""
    rows = np.array([[float(v) for v in row.split()] for row in AIR.replace("\n", ";").split(";") if row.strip()])
    z = 1e3 * rows[:, 0]
    pressure = np.exp(np.interp(altitude, z, np.log(100 * rows[:, 1])))
    water = np.exp(np.interp(altitude, z, np.log(1e-6 * rows[:, 3])))
    return pressure, np.interp(altitude, z, rows[:, 2]), water


def radius_times_index(altitude):
    pressure, temperature, _ = air(altitude)
    return (EARTH + altitude) * (1 + REFRACTIVITY * pressure / temperature)


def shells(tangent):
    """Middles and lengths of half the ray [m] through shells above its lowest point, and that point's altitude."""
    impact = EARTH + 1e3 * tangent
    fine = np.linspace(3e3, 60e3, 57_001)
    lowest = np.interp(impact, radius_times_index(fine), fine)
    edges = np.unique(
        np.concatenate(
            [
                lowest + np.array([0, 0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4, 5, 6, 8]) * 1e3,
                np.arange(lowest + 10e3, 60e3, 3e3),
            ]
        )
    )
    length = np.sqrt(np.maximum(radius_times_index(edges) ** 2 - impact**2, 0.0))
    middle = 0.5 * (edges[1:] + edges[:-1])
    index = radius_times_index(middle) / (EARTH + middle)
    return middle, np.diff(length) / index, lowest


@pytest.fixture(scope="module")
def library(shared_data):
    return LineLibrary(shared_data / "lines")


@pytest.fixture(scope="module")
def continua(shared_data):
    return Continua(shared_data / "continua")


def radiance(tangent, window, library, continua):
    """Mean radiance of a window at the observer, W m-2 sr-1 (cm-1)-1."""
    low, high = window
    wavenumber = linebyline.interval_grid(low, high)
    middle, length, _ = shells(tangent)
    depths, planck = [], []
    for z, metres in zip(middle, length, strict=True):
        pressure, temperature, water = (np.array([float(v)]) for v in air(z))
        state = pressure[0], temperature[0], water[0]
        molecules = pressure[0] / (BOLTZMANN * temperature[0]) * metres
        lines = library.near("CO2", low, high)
        section = linebyline.interval_spectrum(lines, low, high, pressure, temperature, CARBON_DIOXIDE)[0, 0]
        depth = CARBON_DIOXIDE * (section + continua.co2(wavenumber, *state))
        depth += NITROGEN * continua.n2(wavenumber, *state)
        if water[0] > 1e-4:
            section = library.interval_spectrum("H2O", low, high, pressure, temperature, water[0])[0, 0]
            coefficients = continua.water_coefficients(wavenumber)
            depth += water[0] * (section + water_continuum(*coefficients, wavenumber, pressure, temperature, water)[0])
        depths.append(molecules * depth)
        planck.append(C1 * wavenumber**3 / np.expm1(C2 * wavenumber / temperature[0]))
    total, passed = np.zeros_like(wavenumber), np.zeros_like(wavenumber)
    for number in [*range(len(depths) - 1, -1, -1), *range(len(depths))]:  # inwards to the lowest point, then outwards
        total += planck[number] * np.exp(-passed) * -np.expm1(-depths[number])
        passed += depths[number]
    return float(total.mean())


def test_rays_bend_to_their_lowest_points():
    """By Edlen's refractivity in the air of the reference: 1.2, 0.6 and 0.1 km below their geometric heights."""
    assert shells(5)[2] == pytest.approx(3.8e3, abs=50)
    assert shells(10)[2] == pytest.approx(9.4e3, abs=50)
    assert shells(20)[2] == pytest.approx(19.9e3, abs=60)


# Largest departures from 2395.5 cm-1 on. Near the head and beyond 2415 cm-1 they are larger at 20 km: there the
# continuum is that of mixing lines cut off for another air, and nitrogen is colder than any that was measured (228 K).
@pytest.mark.parametrize(("tangent", "limit"), [(5, 0.07), (10, 0.03), (20, 0.11)])
def test_the_reference_is_voigt_lines_and_a_continuum(tangent, limit, library, continua, monkeypatch):
    monkeypatch.setattr(line_mixing, "RANGE", (1.0, 1.0))  # no line mixing: the continuum is given at all wavenumbers
    reference = np.array(REFERENCE[tangent])
    computed = [
        np.nan if np.isnan(value) else 1e6 * radiance(tangent, window, library, continua)
        for window, value in zip(WINDOWS, reference, strict=True)
    ]
    ratio = np.array(computed) / reference
    print(f"\n{tangent} km: {np.round(ratio, 3)}")
    assert np.nanmax(np.abs(ratio[2:] - 1)) <= limit
