"""Infrared lines of nitrous oxide at 17, 8.6 and 7.8 um from level constants and published band strengths."""

from __future__ import annotations

import numpy as np

from mat.maintain.lines.rotors.bands import BandLines, strength
from mat.maintain.lines.rotors.linear import LinearState, transitions
from skyshine.mat.spectroscopy.partition import reference_sum
from skyshine.schemas.arrays import Floats

MOLECULE = 4  # number in HITRAN
LARGEST_J = 80  # rotational quantum number of the lower level
WEAKEST = 2e-25  # cm/molecule; weaker lines are omitted
ABUNDANCE = 0.990333  # abundance of 14N2 16O, HITRAN
NUCLEAR_SPIN = 9.0  # weight that the partition sums of HITRAN contain

# Constants fitted to the energies of HITRAN2012's levels up to J = 70 (to 3e-4 cm^-1), which are those of R. A. Toth
# 1986 and 1991 (J. Opt. Soc. Am. B 3, 1263; Appl. Opt. 30, 5289).
STATES = {
    state.name: state
    for state in (
        LinearState("0000", (0.0, 0.41901096, 1.76077e-07, -1.842e-14)),
        LinearState(
            "0110", (589.1871, 0.41917757, 1.78327e-07, -1.669e-14), (589.1878, 0.41996949, 1.79306e-07, -1.740e-14)
        ),
        LinearState("0200", (1168.1323, 0.41992099, 2.49214e-07, 2.958e-12)),
        LinearState(
            "0220", (1179.4253, 0.42012363, 1.18992e-07, -3.198e-12), (1179.4252, 0.42012452, 1.81494e-07, -6.708e-15)
        ),
        LinearState("1000", (1284.9033, 0.41725525, 1.72745e-07, 1.635e-13)),
        LinearState(
            "0310", (1749.4849, 0.41958315, 2.10571e-07, 1.042e-12), (1749.4862, 0.42107897, 2.18140e-07, -2.004e-13)
        ),
        LinearState(
            "1110", (1880.6832, 0.41746430, 1.74827e-07, 1.032e-13), (1880.6841, 0.41837268, 1.71971e-07, 2.194e-13)
        ),
        LinearState("1200", (2461.9965, 0.41814746, 2.42576e-07, 2.438e-12)),
        LinearState(
            "1220", (2476.4729, 0.41852930, 1.20490e-07, -2.753e-12), (2476.4728, 0.41853020, 1.75495e-07, 2.202e-13)
        ),
        LinearState("2000", (2563.3394, 0.41560573, 1.64006e-07, 6.587e-13)),
    )
}
# Strengths at 296 K, cm/molecule: R. A. Toth 1984, Appl. Opt. 23, 1825 (204 and 7.5 cm^-2 atm^-1); J. W. C. Johns et
# al. 1996, J. Mol. Spectrosc. 175, 99 (24.4 cm^-2 atm^-1).
STRENGTHS = {"1000": 8.24e-18, "0200": 3.03e-19, "0110": 9.84e-19}
# Lower state, upper state, the fundamental or overtone whose moment it has, and the square of the factor on that moment
# (harmonic oscillator).
BANDS = (
    ("0000", "1000", "1000", 1.0),
    ("0110", "1110", "1000", 1.0),
    ("0200", "1200", "1000", 1.0),
    ("0220", "1220", "1000", 1.0),
    ("1000", "2000", "1000", 2.0),
    ("0000", "0200", "0200", 1.0),
    ("0110", "0310", "0200", 2.0),
    ("0000", "0110", "0110", 1.0),
    ("0110", "0200", "0110", 1.0),
    ("0110", "0220", "0110", 2.0),
    ("1000", "1110", "0110", 1.0),
)
# Half width in air, in N2O, exponent and shift by |m|: those of HITRAN2012 (Toth 2000, JQSRT 66, 285).
WIDTHS = np.array(
    [
        (1, 0.0962, 0.117, 0.69, -0.0011),
        (3, 0.0923, 0.114, 0.70, -0.0014),
        (5, 0.0893, 0.111, 0.71, -0.0016),
        (8, 0.0860, 0.108, 0.71, -0.0017),
        (12, 0.0812, 0.103, 0.72, -0.0020),
        (15, 0.0785, 0.100, 0.72, -0.0021),
        (20, 0.0755, 0.096, 0.73, -0.0022),
        (25, 0.0733, 0.092, 0.74, -0.0022),
        (30, 0.0716, 0.088, 0.79, -0.0023),
        (35, 0.0701, 0.085, 0.81, -0.0023),
        (40, 0.0689, 0.082, 0.79, -0.0023),
        (50, 0.0670, 0.077, 0.75, -0.0022),
        (60, 0.0654, 0.072, 0.73, -0.0022),
        (70, 0.0642, 0.069, 0.70, -0.0021),
        (80, 0.0631, 0.065, 0.69, -0.0021),
    ]
)
SOURCE = (
    "levels of HITRAN2012 (Toth 1986, 1991) as polynomials, Honl-London factors; band strengths Toth 1984 and Johns et"
    " al. 1996, hot bands by the harmonic oscillator; widths Toth 2000"
)


def band_lines() -> list[BandLines]:
    """The lines of all bands."""
    squared = {name: STRENGTHS[name] / float(_columns("0000", name, 1.0)["strength"].sum()) for name in STRENGTHS}
    return [_labelled(lower, upper, factor * squared[model]) for lower, upper, model, factor in BANDS]


def _columns(lower: str, upper: str, squared_moment: float) -> dict[str, Floats]:
    """Lines of a band of the main isotopologue alone."""
    columns = transitions(STATES[lower], STATES[upper], LARGEST_J)
    columns["strength"] = strength(
        columns["wavenumber"],
        columns["lower_energy"],
        NUCLEAR_SPIN * squared_moment * columns["factor"],
        reference_sum(MOLECULE, 1),
        1.0,
    )
    return columns


def _labelled(lower: str, upper: str, squared_moment: float) -> BandLines:
    columns = _columns(lower, upper, squared_moment)
    columns["strength"] *= ABUNDANCE
    part = {name: values[columns["strength"] > WEAKEST] for name, values in columns.items()}
    number = np.where(part["step"] == 1, part["j"] + 1, part["j"])
    width, self_width, exponent, shift = (np.interp(number, WIDTHS[:, 0], values) for values in WIDTHS.T[1:])
    label = [
        f"{' ' * 5}{'PQR'[int(step) + 1]}{int(j):3d}{'f' if f else 'e'}     "
        for j, step, f in zip(part["j"], part["step"], part["f"], strict=True)
    ]
    return BandLines(
        molecule=MOLECULE,
        isotopologue=1,
        upper=upper,
        lower=lower,
        wavenumber=part["wavenumber"],
        strength=part["strength"],
        lower_energy=part["lower_energy"],
        air_width=width,
        self_width=self_width,
        temperature_exponent=exponent,
        shift=shift,
        upper_rotation=np.full(len(label), " " * 15),
        lower_rotation=np.array(label, dtype="U15"),
        source=SOURCE,
    )
