"""Limb radiance of the packaged absorption table over RFM's line by line, and the gases it comes from.

The reference has rays of geometric tangent heights of 5, 10, 20 and 50 km; their lowest points are at 3.8, 9.4, 19.9
and 50 km.

``python tests/validation/limb_results.py`` writes the results file beside this module and the table of
atmospheres/absorption.md. Tests hold the page to the file, and the file to the table. The reference's spectra and air
are those of JURASSIC's validation (`test_limb_line_by_line`); its channels are 1 cm-1 wide, at whole wavenumbers: a
window's mean takes half of those at its ends.
"""

from pathlib import Path

import numpy as np
from limb_rays import C1, C2, CARBON_DIOXIDE, NITROGEN, air, emerging, shells
from result_blocks import keep

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable, default_water_continuum
from skyshine.mat.radiometry.constants import BOLTZMANN

RESULTS = Path(__file__).with_name("limb_results.json")
PAGE = Path(__file__).parents[2] / "atmospheres" / "absorption.md"
DATA = Path(__file__).parents[1] / "data"
OXYGEN = 0.20946
LOWEST_KM = {5: "3.8 km", 10: "9.4 km", 20: "19.9 km", 50: "50 km"}  # points of the rays, by their tangent heights
SMALLEST_SHARE = 0.05  # of a gas that is named


def _read(name):
    return np.genfromtxt(DATA / name, delimiter=",", names=True, deletechars="")


def windows():
    """Tangent height [km], edges [cm-1] and mean radiance [W m-2 sr-1 (cm-1)-1] of the reference's windows."""
    rows = _read("limb_windows.csv")
    return [(int(tangent), int(low), int(high), float(radiance)) for tangent, low, high, radiance in rows]


def amounts_at(altitude):
    """Mole fractions of the gases at altitudes [m], without water vapour."""
    profiles = _read("limb_gases.csv")
    amounts = {
        name: np.exp(np.interp(altitude, 1e3 * profiles["altitude_km"], np.log(profiles[name])))
        for name in profiles.dtype.names[1:]
    }
    return amounts | {"CO2": CARBON_DIOXIDE, "N2": NITROGEN, "O2": OXYGEN}


def by_gas(tangent, low, high, table):
    """Mean radiance of a window, W m-2 sr-1 (cm-1)-1, of all gases and without each of them."""
    points = table.points(low, high)
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
    for tangent, low, high, reference in windows():
        radiance, without = by_gas(tangent, low, high, table)
        shares = {name: round((radiance - rest) / reference, 2) for name, rest in without.items()}
        shares = {name: share for name, share in shares.items() if share >= SMALLEST_SHARE}
        named = dict(sorted(shares.items(), key=lambda item: -item[1]))
        ratio = round(radiance / reference, 3)
        window = {"tangent_km": tangent, "low": low, "high": high}
        rows.append({**window, "reference": reference, "ratio": ratio, "shares": named})
    return rows


def block(rows):
    """Text of the page between its marks: a row a window, ratios of all heights beside each other."""
    lines = [f"| cm-1 | {' | '.join(LOWEST_KM.values())} |", "|---" * (1 + len(LOWEST_KM)) + "|"]
    by_window = {(row["tangent_km"], row["low"], row["high"]): row for row in rows}
    for low, high in sorted({window[1:] for window in by_window}):
        cells = [f"{low}-{high}"]
        for tangent in LOWEST_KM:
            row = by_window.get((tangent, low, high))
            shares = ", ".join(f"{name} {share:.2f}" for name, share in row["shares"].items()) if row else ""
            cells.append(f"{row['ratio']:.2f}{f' ({shares})' if shares else ''}" if row else "")
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    keep(computed(), RESULTS, PAGE, block)
