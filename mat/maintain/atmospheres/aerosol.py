"""Derive aerosol optical properties, phase functions and vertical profiles from the LOWTRAN7 source.

    python -m mat.maintain.atmospheres.aerosol lowtran7.f --out atmospheres/aerosol

The tables are in BLOCK DATA EXTDTA, DSTDTA, MARDTA, PHSDTA and PRFDTA (Kneizys et al. 1988, AFGL-TR-88-0177); the
models are those of Shettle and Fenn 1979, AFGL-TR-79-0214, Longtin et al. 1988, AFGL-TR-88-0112 (desert), and Gathman
1983 (Navy maritime).
"""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from mat.maintain.atmospheres.fortran import block_data
from skyshine.schemas.arrays import Floats
from skyshine.schemas.csv_table import write_csv

HUMIDITIES = (0, 70, 80, 99)  # percent, of LOWTRAN7's tables
# Model to the prefix of its arrays in EXTDTA and the rows of the phase function index in PHSDTA (the list of models in
# the comment of SUBROUTINE PHASEF). With humidity: four rows, four arrays each of extinction, absorption, asymmetry.
HUMID_MODELS = {"rural": ("RUR", 1), "maritime": ("OCN", 5), "urban": ("URB", 9), "tropospheric": ("TRO", 17)}
# The fogs by that list (radiation 24, advection 25), which the asymmetries bear out; SUBROUTINE PHASEF takes them the
# other way round.
DRY_MODELS = {
    "stratospheric_background": ("BST", 21),
    "volcanic_aged": ("AVO", 22),
    "volcanic_fresh": ("FVO", 23),
    "fog_radiation": ("FG2", 24),
    "fog_advection": ("FG1", 25),
    "meteoric_dust": ("DME", 26),
}
# Axes of the phase functions, from the DATA statements of SUBROUTINE PHASEF.
PHASE_ANGLES = np.array(
    [
        0,
        2,
        4,
        6,
        8,
        10,
        12,
        16,
        20,
        24,
        28,
        32,
        36,
        40,
        50,
        60,
        70,
        80,
        90,
        100,
        110,
        120,
        125,
        130,
        135,
        140,
        145,
        150,
        155,
        160,
        165,
        170,
        175,
        180,
    ],
    dtype=float,
)
_SHORTWAVE = (0.2, 0.3, 0.55, 0.6943, 1.06, 1.536, 2.0, 2.5, 2.7, 3.0, 3.2, 3.39)
_LONGWAVE = (5.0, 6.0, 7.2, 7.9, 8.7, 9.2, 10.0, 10.59, 12.5, 15.0, 17.2, 18.5, 21.3, 30.0, 40.0)
PHASE_WAVELENGTHS = (*_SHORTWAVE, *_LONGWAVE)  # um
DESERT_WINDS = (0, 10, 20, 30)  # m/s, of the arrays DESEX1 to DESEX4
# Stratosphere laden by volcanoes: prefix of the arrays of PRFDTA, which end in the season.
LOADINGS = {"moderate": "VUMO", "high": "HIVU", "extreme": "EXVU"}
VISIBILITIES = (50, 23, 10, 5, 2)  # km, of LOWTRAN7's profiles
# The last wavelength of EXTDTA (300 um) is a placeholder of zeros that LOWTRAN7 fills at run time.
TABULATED = slice(0, 46)
PROVENANCE = (
    "LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177), a work of the US Government; models of Shettle and Fenn 1979,",
    "AFGL-TR-79-0214. Derived by mat.maintain.atmospheres.aerosol.",
)


@click.command(help=__doc__)
@click.argument("source", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--out", type=click.Path(file_okay=False, path_type=Path), required=True, help="Folder to write to.")
def main(source: Path, out: Path) -> None:
    write_optics(block_data(source, "EXTDTA"), out)
    write_desert(block_data(source, "DSTDTA"), block_data(source, "EXTDTA")["VX2"], out)
    write_navy_maritime(block_data(source, "MARDTA"), out)
    write_phase_functions(block_data(source, "PHSDTA"), out)
    write_vertical(block_data(source, "PRFDTA"), out)
    write_stratosphere(block_data(source, "PRFDTA"), out)


def write_optics(data: dict[str, Floats], out: Path) -> None:
    """One CSV a model: extinction and absorption relative to extinction at 0.55 um, and asymmetry."""
    columns = ("relative_humidity[percent]", "wavelength[um]", "extinction", "absorption", "asymmetry")
    for name, (prefix, _) in {**HUMID_MODELS, **DRY_MODELS}.items():
        rows = []
        for number, humidity in enumerate(HUMIDITIES, start=1):
            if name in HUMID_MODELS:
                arrays = [data[f"{prefix}{letter}{number}"] for letter in "EAG"]
            elif number == 1:
                arrays = [data[f"{prefix}{suffix}"] for suffix in ("EXT", "ABS", "SYM")]
            else:
                break
            rows += [
                (humidity, *row) for row in zip(data["VX2"][TABULATED], *(a[TABULATED] for a in arrays), strict=True)
            ]
        note = () if name in HUMID_MODELS else ("The model does not depend on humidity.",)
        write_csv(out / f"{name}.csv", (f"Aerosol model: {name}", *PROVENANCE, *note), columns, rows)


def write_desert(data: dict[str, Floats], wavelengths: Floats, out: Path) -> None:
    """The desert aerosol at four wind speeds: extinction and absorption in km^-1, and asymmetry."""
    columns = ("wind_speed[m/s]", "wavelength[um]", "extinction[km-1]", "absorption[km-1]", "asymmetry")
    rows = []
    for number, wind in enumerate(DESERT_WINDS, start=1):
        arrays = [data[f"{prefix}{number}"][TABULATED] for prefix in ("DESEX", "DESAB", "DESG")]
        rows += [(wind, *row) for row in zip(wavelengths[TABULATED], *arrays, strict=True)]
    header = (
        "Aerosol model: desert, by wind speed at 10 m",
        "LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177), a work of the US Government; model of Longtin et al. 1988,",
        "AFGL-TR-88-0112. Derived by mat.maintain.atmospheres.aerosol.",
    )
    write_csv(out / "desert.csv", header, columns, rows)


def write_navy_maritime(data: dict[str, Floats], out: Path) -> None:
    """The three parts of the Navy maritime aerosol: logarithms of extinction and absorption by humidity."""
    logarithms = [f"log_{kind}_{part}" for kind in ("extinction", "absorption") for part in (1, 2, 3)]
    columns = ("relative_humidity[percent]", "wavelength[um]", *logarithms)
    rows = []
    for number, humidity in enumerate(data["AREL"], start=1):
        # A, B, C are extinction of the three parts, D, E, F their absorption (EQUIVALENCE in BLOCK DATA MARDTA).
        rows += [
            (humidity, *row)
            for row in zip(data["ALAM"], *(data[f"{letter}{number}"] for letter in "ABCDEF"), strict=True)
        ]
    header = (
        (
            "Aerosol model: Navy maritime; decimal logarithms for unit amounts of continental particles and of two"
            " sizes of sea spray"
        ),
        (
            "LOWTRAN7 (Kneizys et al. 1988, AFGL-TR-88-0177), a work of the US Government; model of Gathman 1983, Opt."
            " Eng. 22, 57."
        ),
        "Derived by mat.maintain.atmospheres.aerosol.",
    )
    write_csv(out / "navy_maritime.csv", header, columns, rows)


def write_phase_functions(data: dict[str, Floats], out: Path) -> None:
    """The 70 phase functions (mean over the sphere 1) and the index that says which belongs to which model."""
    functions = np.array([normalised(PHASE_ANGLES, 4 * np.pi * data[f"PHSF{number}"]) for number in range(1, 71)])
    columns = ("angle[degree]", *(f"p{number}" for number in range(1, 71)))
    note = (
        "Phase functions, mean over the sphere 1, logarithm linear in angle between the nodes.",
        (
            "Where the table's mean is more than 1 % off, the value at 0 (in an unresolved forward peak) carries the"
            " correction."
        ),
    )
    write_csv(out / "phase_functions.csv", (*note, *PROVENANCE), columns, np.column_stack([PHASE_ANGLES, functions.T]))
    rows = []
    for name, (_, model_number) in HUMID_MODELS.items():
        rows += [(name, humidity, *data[f"MUM{model_number + i}"]) for i, humidity in enumerate(HUMIDITIES)]
    rows += [(name, 0, *data[f"MUM{row}"]) for name, (_, row) in DRY_MODELS.items()]
    columns = ("model", "relative_humidity[percent]", *(f"{wavelength:g}" for wavelength in PHASE_WAVELENGTHS))
    about = "Number of the phase function (phase_functions.csv) by model, humidity and wavelength [um]."
    write_csv(out / "phase_index.csv", (about, *PROVENANCE), columns, rows)


def write_vertical(data: dict[str, Floats], out: Path) -> None:
    """Extinction at 0.55 um against altitude: by visibility below 2 km, by visibility and season to 10 km, by season
    above.
    """
    levels = slice(0, 33)  # the 34th altitude represents infinity
    columns = {"altitude[km]": data["ZHT"][levels]}
    for season, middle, upper in (("spring_summer", "SPSU", "SS"), ("fall_winter", "FAWI", "FW")):
        for number, visibility in enumerate(VISIBILITIES, start=1):
            boundary = np.array([data[f"HZ2K({level},{number})"][0] for level in (1, 2, 3)])
            # Between 2 and 10 km LOWTRAN7 has 50 and 23 km; lower visibilities take the 23 km profile (SUBROUTINE
            # AERPRF).
            troposphere = data[f"{middle}{50 if visibility == 50 else 23}"][3:11]
            stratosphere = data[f"BAST{upper}"][11:27]
            above_30_km = data["UPNATM"][27:33]
            columns[f"{season}_{visibility}"] = np.concatenate([boundary, troposphere, stratosphere, above_30_km])
    note = (
        "Aerosol extinction at 0.55 um [km-1] against altitude by season and visibility [km]; background stratosphere.",
    )
    write_csv(out / "vertical.csv", (*note, *PROVENANCE), columns, zip(*columns.values(), strict=True))


def write_stratosphere(data: dict[str, Floats], out: Path) -> None:
    """Extinction at 0.55 um above 10 km where volcanoes have laden the stratosphere, by season."""
    levels = slice(11, 33)
    columns = {"altitude[km]": data["ZHT"][levels]}
    for season, ending in (("spring_summer", "SS"), ("fall_winter", "FW")):
        for name, prefix in LOADINGS.items():
            # Above 30 km LOWTRAN7 has one profile for all of them (SUBROUTINE AERPRF).
            columns[f"{season}_{name}"] = np.concatenate([data[f"{prefix}{ending}"][11:27], data["VUTONO"][27:33]])
    note = ("Aerosol extinction at 0.55 um [km-1] above 10 km by season and volcanic loading of the stratosphere.",)
    write_csv(out / "stratosphere.csv", (*note, *PROVENANCE), columns, zip(*columns.values(), strict=True))


def normalised(angles: Floats, values: Floats) -> Floats:
    """Phase function with mean 1 over the sphere.

    Most of the table is normalised to within 1 %, the error of interpolating between its nodes, and is simply scaled.
    Where the mean is further off, the cause is the forward peak: between its nodes at 0 and 2 degrees the diffraction
    peak of large particles falls by up to powers of ten. There the value at 0 carries the correction, within the value
    at 2 degrees and twice the tabulated one, so that the other angles keep their values.
    """
    values = values.copy()
    if abs(sphere_mean(angles, values) - 1) > 0.01:
        outside = sphere_mean(angles[1:], values[1:])
        low, high = values[1], 2 * values[0]
        for _ in range(60):  # bisection in the logarithm, to the precision of a double
            values[0] = np.sqrt(low * high)
            if sphere_mean(angles[:2], values[:2]) + outside > 1:
                high = values[0]
            else:
                low = values[0]
    return values / sphere_mean(angles, values)


def sphere_mean(angles: Floats, values: Floats) -> float:
    """Exact part of the mean over the sphere of a function whose logarithm is linear in angle between nodes
    [degree].
    """
    theta = np.radians(angles)
    slope = np.diff(np.log(values)) / np.diff(theta)
    # Primitive of exp(a + b theta) sin(theta).
    upper = values[1:] * (slope * np.sin(theta[1:]) - np.cos(theta[1:]))
    lower = values[:-1] * (slope * np.sin(theta[:-1]) - np.cos(theta[:-1]))
    return float(0.5 * np.sum((upper - lower) / (slope**2 + 1)))


if __name__ == "__main__":
    main()
