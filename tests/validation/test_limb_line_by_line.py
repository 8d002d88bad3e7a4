"""CO2's head at 4.3 um and N2O at 4.5 um in limb radiance, against RFM line by line.

The reference is that of JURASSIC's validation (github.com/slcs-jsc/jurassic, projects/validation/rfm_reference: RFM
5.21, HITRAN2020, a step of 0.0005 cm-1, bent rays of geometric tangent heights of 5, 10 and 20 km). What it sums is not
written there; it is met by CO2 as Voigt lines cut at 25 cm-1 with the continuum of MT_CKD, and nitrogen of MT_CKD.
"""

import json
from dataclasses import replace

import limb_results
import line_results
import numpy as np
import pytest

pytest.importorskip("numba")
pytest.importorskip("hapi")

from limb_rays import C1, C2, CARBON_DIOXIDE, NITROGEN, air, emerging, shells
from line_by_line_reference import water_continuum

from skyshine.mat.radiometry.constants import BOLTZMANN
from skyshine.mat.spectroscopy import line_mixing, linebyline
from skyshine.mat.spectroscopy.continua import Continua
from skyshine.mat.spectroscopy.gases import LineLibrary

pytestmark = [pytest.mark.validation, pytest.mark.shared_data]  # 60 s

WINDOWS = [(low, low + 5.0) for low in np.arange(2385.5, 2420.0, 5.0)]  # five channels of 1 cm-1 each
# By geometric tangent height, 1e-6 W m-2 sr-1 (cm-1)-1: means of the reference over the windows.
REFERENCE = {
    5: [np.nan, np.nan, 26.34, 32.27, 36.07, 38.53, 40.79],
    10: [29.04, 22.42, 22.19, 23.52, 23.95, 24.00, 23.95],
    20: [30.44, 17.45, 9.811, 6.986, 5.879, 5.237, 4.800],
}


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
    return float(emerging(depths, planck).mean())


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


# Origins of v3 below that of the main isotopologue (2223.8 cm-1) and abundances of 14N14N18O, 15N14N16O and 14N15N16O
# (HITRAN).
RARE = [(7.0, 0.00199), (22.2, 0.00364), (46.1, 0.00364)]
COMMON = 0.99033


def test_rare_isotopologues_are_what_n2o_lacks_at_4_5_um(library):
    """The packaged table is 0.954 of the reference at 19.9 km; bands of the main one, displaced, give the rest."""
    low, high = 2220.0, 2225.0
    kept = library.near("N2O", low - 60, high + 60)

    def displaced(below, factor):
        lines = replace(kept, wavenumber=kept.wavenumber - below, strength=kept.strength * factor)
        return lines.select((lines.wavenumber > low - 25) & (lines.wavenumber < high + 25))

    main, carbon_dioxide = displaced(0, 1), library.near("CO2", low, high)
    rare = [displaced(below, abundance / COMMON) for below, abundance in RARE]
    altitude, length, _ = shells(20)
    amounts = limb_results.amounts_at(altitude)
    wavenumber = linebyline.interval_grid(low, high)
    without, added, planck = [], [], []
    for number, (pressure, temperature, _) in enumerate(zip(*air(altitude), strict=True)):
        state = np.array([pressure]), np.array([temperature])
        molecules = pressure / (BOLTZMANN * temperature) * length[number]
        n2o = amounts["N2O"][number]

        def section(lines, fraction, state=state):
            return linebyline.interval_spectrum(lines, low, high, *state, fraction)[0, 0]

        depth = n2o * section(main, n2o) + CARBON_DIOXIDE * section(carbon_dioxide, CARBON_DIOXIDE)
        without.append(molecules * depth)
        added.append(without[-1] + molecules * n2o * sum(section(lines, n2o) for lines in rare))
        planck.append(C1 * wavenumber**3 / np.expm1(C2 * wavenumber / temperature))
    reference = next(value for tangent, start, _, value in limb_results.windows() if (tangent, start) == (20, low))
    gain = (emerging(added, planck).mean() - emerging(without, planck).mean()) / reference
    ratio = next(row["ratio"] for row in limb_results.computed() if (row["tangent_km"], row["low"]) == (20, low))
    print(f"\n{gain:.3f} of the radiance; with it {ratio + gain:.3f} of the reference")
    assert gain == pytest.approx(0.048, abs=0.003)
    assert ratio + gain == pytest.approx(1, abs=0.01)


def test_the_results_of_lines_are_what_lines_and_table_give(shared_data):
    kept, found = json.loads(line_results.RESULTS.read_text(encoding="utf-8")), line_results.computed(shared_data)
    for part in ("limb", "head"):
        for row, old in zip(found[part], kept[part], strict=True):
            assert list(row) == list(old)
            for name, value in old.items():
                assert row[name] == pytest.approx(value, abs=0.003), row
