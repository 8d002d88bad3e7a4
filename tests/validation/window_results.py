"""What the continua absorb in the windows at 2.1 and 4 um: coefficients of MT_CKD 4.3 over those of 2.4, and
transmittance of 5 km of humid air.

``python tests/validation/window_results.py`` writes the results file beside this module and the table of
atmospheres/continuum/README.md. A test holds the page to the file, and the file to the tables. What measurements of
others say of the windows is text of the page: their figures are not in the file.
"""

from pathlib import Path

import numpy as np
from result_blocks import keep

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.radiometry.constants import BOLTZMANN

RESULTS = Path(__file__).with_name("window_results.json")
PAGE = Path(__file__).parents[2] / "atmospheres" / "continuum" / "README.md"
WINDOWS = [(2450, 2500), (2500, 2600), (2600, 2850), (4200, 4400), (4400, 4600), (4600, 4800), (4800, 5000)]  # cm-1
NEW, OLD = "mt_ckd_4.3", "mt_ckd_2.4"
# The ground of the tropical standard atmosphere: Pa, K, mole fraction of water, and of gases with lines in the windows.
PRESSURE, TEMPERATURE, WATER = 101300.0, 299.7, 0.0259
LENGTH = 5e3  # m
LOWTRAN7_N2 = PAGE.with_name("lowtran7_n2.csv")
GASES = {"CO2": 4.2e-4, "CH4": 1.9e-6, "N2O": 3.4e-7, "CO": 1.5e-7, "O2": 0.209, "N2": 0.7808}


def coefficients(points):
    """Self and foreign cross sections (P,) of the continuum, m2 per molecule at 1013 hPa of either, and 296 K."""
    air = np.array([PRESSURE]), np.array([296.0])
    pure, dry = (
        points.cross_sections(*air, np.array([fraction]), ["H2O_continuum"])["H2O_continuum"][0]
        for fraction in (0.02, 1e-9)
    )
    return (pure - dry * (1 - 0.02)) / 0.02, dry


def depths(points):
    """Optical depths (P,) of 5 km by gas: of lines with N2's bands, and of the self and the foreign continuum."""
    molecules = PRESSURE / (BOLTZMANN * TEMPERATURE) * LENGTH
    air = np.array([PRESSURE]), np.array([TEMPERATURE])
    sections = points.cross_sections(*air, np.array([WATER]), ["H2O", "H2O_continuum", *GASES])
    dry = points.cross_sections(*air, np.array([1e-9]), ["H2O_continuum"])["H2O_continuum"][0]
    foreign = WATER * (1 - WATER) * dry
    depth = {name: amount * sections[name][0] for name, amount in GASES.items()}
    continuum = WATER * sections["H2O_continuum"][0]
    depth |= {"H2O": WATER * sections["H2O"][0], "foreign": foreign, "self": continuum - foreign}
    return {name: molecules * values for name, values in depth.items()}


def nitrogen_of_lowtran7(wavenumber):
    """Optical depth (P,) of the same air by LOWTRAN7's band of N2 at 4.3 um, which it has at 273.15 K and 1013 hPa."""
    table = np.genfromtxt(LOWTRAN7_N2, delimiter=",", skip_header=4)
    section = np.interp(wavenumber, *table.T, right=0.0) * 273.15 / TEMPERATURE * PRESSURE / 101325
    return PRESSURE / (BOLTZMANN * TEMPERATURE) * LENGTH * GASES["N2"] * section


def computed():
    """Each window's ratios of coefficients, its transmittance, and what that would be with parts changed."""
    rows = []
    for low, high in WINDOWS:
        new, old = (AbsorptionTable.open(water_continuum=name).points(low, high) for name in (NEW, OLD))
        ratio = [
            float(np.average(a, weights=new.weight) / np.average(b, weights=old.weight))
            for a, b in zip(coefficients(new), coefficients(old), strict=True)
        ]
        depth, before = depths(new), depths(old)

        def transmittance(changed, depth=depth, weight=new.weight):
            return float(np.average(np.exp(-sum((depth | changed).values())), weights=weight))

        today = transmittance({})
        row = {"low": low, "high": high, "self": round(ratio[0], 1), "foreign": round(ratio[1], 1)}
        row["transmittance"] = round(today, 3)
        for name, changed in (
            ("with_old_self", {"self": before["self"]}),
            ("with_old_foreign", {"foreign": before["foreign"]}),
            ("without_n2", {"N2": 0.0}),
            ("with_n2_of_lowtran7", {"N2": nitrogen_of_lowtran7(new.wavenumber)}),
        ):
            row[name] = round(transmittance(changed) - today, 3)
        rows.append(row)
    return rows


def block(rows):
    """Text of the page between its marks."""
    heads = ("cm-1", "self, 4.3 over 2.4", "foreign, 4.3 over 2.4", "transmittance", "with the self of 2.4")
    heads += ("with the foreign of 2.4", "without nitrogen", "with nitrogen of LOWTRAN7")
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for row in rows:
        cells = [
            f"{row['low']}-{row['high']}",
            f"{row['self']:.1f}",
            f"{row['foreign']:.1f}",
            f"{row['transmittance']:.3f}",
        ]
        changes = ("with_old_self", "with_old_foreign", "without_n2", "with_n2_of_lowtran7")
        cells += [f"{row[name]:+.3f}" if abs(row[name]) >= 5e-4 else "0" for name in changes]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    keep(computed(), RESULTS, PAGE, block)
