"""The packaged table over its own lines in the thin air of the limb, and what two laws of CO2's head transmit.

``SKYSHINE_DATA=FOLDER python tests/validation/line_results.py GENERATED`` writes the results file beside this module
and its part of atmospheres/absorption.md; GENERATED is the folder of ``python -m mat.maintain.lines generate``, whose
ozone is compared with RFM at 50 km. The limb's rays and air are those of `limb_results`; CO2, H2O and CH4 radiate alone
otherwise, whose lines the other folder holds.
"""

import os
import sys
from pathlib import Path

import limb_results
import numpy as np
from limb_rays import C1, C2, air, emerging, shells
from result_blocks import keep

from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.radiometry.constants import BOLTZMANN

RESULTS = Path(__file__).with_name("line_results.json")
PAGE = limb_results.PAGE
GASES = ("CO2", "H2O", "CH4")
LIMB = [(tangent, low) for tangent in (10, 20, 50) for low in (760, 765, 790, 1260, 1275, 1300)]
# A hot target through air of the ground: Pa, K, mole fraction of CO2; km; lower edges of 5 cm-1.
GROUND, CO2, LENGTHS_KM, HEAD = (101325.0, 288.15), 4e-4, (0.2, 1.0, 5.0), range(2380, 2420, 5)


def limb(library, continua, table):
    """Of each window of `LIMB`, radiance of `GASES` alone [W m-2 sr-1 (cm-1)-1] by lines, and the table's over it."""
    from skyshine.mat.spectroscopy import linebyline

    rows = []
    for tangent, low in LIMB:
        ends = float(low), low + 5.0
        points, wavenumber = table.points(*ends), linebyline.interval_grid(*ends)
        altitude, length, _ = shells(tangent)
        pressure, temperature, water = air(altitude)
        amounts = limb_results.amounts_at(altitude) | {"H2O": water}
        sections = points.cross_sections(pressure, temperature, water, list(GASES))
        by_table, by_lines = np.zeros(()), np.zeros(())
        for name in GASES:
            fraction = np.broadcast_to(amounts[name], altitude.shape)
            of_lines = [
                library.interval_spectrum(name, *ends, pressure[[row]], temperature[[row]], fraction[row])[0, 0]
                for row in range(altitude.size)
            ]
            if name == "CO2":
                of_lines += continua.co2(wavenumber, pressure[:, None], temperature[:, None])
            molecules = (pressure / (BOLTZMANN * temperature) * length * fraction)[:, None]
            by_table, by_lines = by_table + molecules * sections[name], by_lines + molecules * np.array(of_lines)
        glow = [C1 * at**3 / np.expm1(C2 * at / temperature[:, None]) for at in (points.wavenumber, wavenumber)]
        of_table = float(np.average(emerging(by_table, glow[0]), weights=points.weight))
        of_lines = float(emerging(by_lines, glow[1]).mean())
        window = {"tangent_km": tangent, "low": low}
        rows.append({**window, "lines": float(f"{of_lines:.4g}"), "ratio": round(of_table / of_lines, 3)})
    return rows


def ozone(generated):
    """Of windows at 50 km, radiance of ozone alone by its generated lines over all that RFM has there."""
    from skyshine.mat.spectroscopy import linebyline

    rows, (altitude, length, _) = [], shells(50)
    pressure, temperature, _ = air(altitude)
    fraction = limb_results.amounts_at(altitude)["O3"]
    molecules = (pressure / (BOLTZMANN * temperature) * length * fraction)[:, None]
    for tangent, low, high, reference in limb_results.windows():
        if (tangent, high - low) == (50, 5) and 1000 < low < 1200:
            lines, wavenumber = generated.near("O3", float(low), float(high)), linebyline.interval_grid(low, high)
            states = zip(pressure[:, None], temperature[:, None], fraction, strict=True)
            section = [linebyline.interval_spectrum(lines, float(low), float(high), *air)[0, 0] for air in states]
            glow = C1 * wavenumber**3 / np.expm1(C2 * wavenumber / temperature[:, None])
            ratio = round(float(emerging(molecules * np.array(section), glow).mean()) / reference, 3)
            rows.append({"low": low, "ratio": ratio})
    return rows


def head(library, continua):
    """Mean transmittance of CO2 over some lengths of air at the ground: by the table, whose lines mix, and by the law
    that meets RFM's limb, Voigt lines cut at 25 cm-1 with MT_CKD's continuum.
    """
    from skyshine.mat.spectroscopy import line_mixing, linebyline

    rows, (pressure, temperature) = [], GROUND
    state = np.array([pressure]), np.array([temperature])
    molecules = pressure / (BOLTZMANN * temperature) * CO2 * 1e3 * np.array(LENGTHS_KM)[:, None]
    mixing, line_mixing.RANGE = line_mixing.RANGE, (1.0, 1.0)  # of the continuum, which is none where lines mix
    try:
        for low in HEAD:
            points = AbsorptionTable.open().points(low, low + 5)
            section = points.cross_sections(*state, np.array([0.0]), ["CO2"])["CO2"][0]
            table = np.average(np.exp(-molecules * section), axis=1, weights=points.weight)
            wavenumber = linebyline.interval_grid(float(low), low + 5.0)
            lines = library.near("CO2", float(low), low + 5.0)
            section = linebyline.interval_spectrum(lines, float(low), low + 5.0, *state, CO2)[0, 0]
            section = section + continua.co2(wavenumber, pressure, temperature, 0.0)
            other = np.exp(-molecules * section).mean(axis=1)
            rows.append({"low": low, "table": np.round(table, 3).tolist(), "other": np.round(other, 3).tolist()})
    finally:
        line_mixing.RANGE = mixing
    return rows


def computed(data):
    """Both parts."""
    # Not needed for the page, and of an extra.
    from skyshine.mat.spectroscopy.continua import Continua
    from skyshine.mat.spectroscopy.gases import LineLibrary

    library, continua = LineLibrary(data / "lines"), Continua(data / "continua")
    return {"limb": limb(library, continua, AbsorptionTable.open()), "head": head(library, continua)}


def block(results):
    """Text of the page between its marks."""
    tangents = dict.fromkeys(row["tangent_km"] for row in results["limb"])
    heights = " | ".join(limb_results.LOWEST_KM[tangent] for tangent in tangents)
    lines = [f"| cm-1 | {heights} |", "|---" * (1 + len(tangents)) + "|"]
    for low in dict.fromkeys(row["low"] for row in results["limb"]):
        cells = [f"{row['ratio']:.2f}" for row in results["limb"] if row["low"] == low]
        lines.append(f"| {low}-{low + 5} | " + " | ".join(cells) + " |")
    by_lines = [(f"{row['low']}-{row['low'] + 5}", f"{row['ratio']:.2f}") for row in results["ozone"]]
    lines += ["", "| ozone by its lines, 50 km | " + " | ".join(window for window, _ in by_lines) + " |"]
    lines += ["|---" * (1 + len(by_lines)) + "|", "| over RFM | " + " | ".join(ratio for _, ratio in by_lines) + " |"]
    lengths = " | ".join(f"{length:g} km" for length in LENGTHS_KM)
    lines += ["", f"| cm-1 | {lengths} |", "|---" * (1 + len(LENGTHS_KM)) + "|"]
    for row in results["head"]:
        cells = [f"{table:.2f} / {other:.2f}" for table, other in zip(row["table"], row["other"], strict=True)]
        lines.append(f"| {row['low']}-{row['low'] + 5} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    from skyshine.mat.spectroscopy.gases import LineLibrary

    keep(
        computed(Path(os.environ["SKYSHINE_DATA"])) | {"ozone": ozone(LineLibrary(Path(sys.argv[1])))},
        RESULTS,
        PAGE,
        block,
    )
