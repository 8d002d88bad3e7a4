"""Limb radiance of the packaged absorption table over RFM's line by line, and the gases it comes from.

``python tests/validation/limb_results.py`` writes the results file beside this module and the table of
atmospheres/absorption.md. Tests hold the page to the file, and the file to the table. The reference's spectra and air
are those of JURASSIC's validation (`test_limb_line_by_line`); its channels are 1 cm-1 wide, at whole wavenumbers: a
window's mean takes half of those at its ends.
"""

import json
from pathlib import Path

import numpy as np
from limb_rays import C1, C2, CARBON_DIOXIDE, NITROGEN, air, emerging, shells
from result_blocks import with_block

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable, default_water_continuum
from skyshine.mat.radiometry.constants import BOLTZMANN

RESULTS = Path(__file__).with_name("limb_results.json")
PAGE = Path(__file__).parents[2] / "atmospheres" / "absorption.md"
DATA = Path(__file__).parents[1] / "data"
OXYGEN = 0.20946
WIDTH = 5.0  # cm-1, of a window
SMALLEST_SHARE = 0.05  # of a gas that is named


def _read(name):
    return np.genfromtxt(DATA / name, delimiter=",", names=True, deletechars="")


def windows():
    """Tangent height [km], lower edge [cm-1] and mean radiance [W m-2 sr-1 (cm-1)-1] of the reference's windows."""
    return [(int(tangent), int(low), float(radiance)) for tangent, low, radiance in _read("limb_windows.csv")]


def amounts_at(altitude):
    """Mole fractions of the gases at altitudes [m], without water vapour."""
    profiles = _read("limb_gases.csv")
    amounts = {
        name: np.exp(np.interp(altitude, 1e3 * profiles["altitude_km"], np.log(profiles[name])))
        for name in profiles.dtype.names[1:]
    }
    return amounts | {"CO2": CARBON_DIOXIDE, "N2": NITROGEN, "O2": OXYGEN}


def by_gas(tangent, low, table):
    """Mean radiance of a window, W m-2 sr-1 (cm-1)-1, of all gases and without each of them."""
    points = table.points(low, low + WIDTH)
    altitude, length, _ = shells(tangent)
    pressure, temperature, water = air(altitude)
    amounts = amounts_at(altitude) | {"H2O": water, "H2O_continuum": water}
    molecules = pressure / (BOLTZMANN * temperature) * length
    sections = points.cross_sections(pressure, temperature, water, list(amounts))
    depths = {name: (molecules * amount)[:, None] * sections[name] for name, amount in amounts.items()}
    depths["H2O"] = depths["H2O"] + depths.pop("H2O_continuum")
    planck = C1 * points.wavenumber**3 / np.expm1(C2 * points.wavenumber / temperature[:, None])

    def mean(depth):
        return float(np.average(emerging(depth, planck), weights=points.weight))

    total = sum(depths.values())
    return mean(total), {name: mean(total - depth) for name, depth in depths.items()}


def computed(table=None):
    """Each window's reference, ratio, and the shares of the reference's radiance that leave with a gas."""
    table = table or AbsorptionTable.open(water_continuum=default_water_continuum())
    rows = []
    for tangent, low, reference in windows():
        radiance, without = by_gas(tangent, low, table)
        shares = {name: round((radiance - rest) / reference, 2) for name, rest in without.items()}
        shares = {name: share for name, share in shares.items() if share >= SMALLEST_SHARE}
        named = dict(sorted(shares.items(), key=lambda item: -item[1]))
        ratio = round(radiance / reference, 3)
        rows.append({"tangent_km": tangent, "low": low, "reference": reference, "ratio": ratio, "shares": named})
    return rows


def block(rows):
    """Text of the page between its marks: a row a window, ratios of both heights beside each other."""
    lines = ["| cm-1 | 9.4 km | gases | 19.9 km | gases |", "|---" * 5 + "|"]
    for low in sorted({row["low"] for row in rows}):
        cells = [f"{low}-{low + WIDTH:.0f}"]
        for tangent in (10, 20):
            row = next((row for row in rows if (row["tangent_km"], row["low"]) == (tangent, low)), None)
            shares = row["shares"] if row else {}
            cells += [
                f"{row['ratio']:.2f}" if row else "",
                ", ".join(f"{name} {share:.2f}" for name, share in shares.items()),
            ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    found = computed()
    RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    PAGE.write_text(with_block(PAGE.read_text(encoding="utf-8"), RESULTS.name, block(found)), encoding="utf-8")
