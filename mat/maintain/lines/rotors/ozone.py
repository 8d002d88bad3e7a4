"""Infrared lines of ozone from published constants and band strengths."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import fsolve

from mat.maintain.lines.rotors.asymmetric import Levels, Moment, VibrationalState, levels, moments
from mat.maintain.lines.rotors.bands import BandLines, strength
from mat.maintain.lines.rotors.force_field import MASS, PERMANENT_MOMENT, normal_modes, rotation_ratio
from skyshine.mat.spectroscopy.partition import reference_sum
from skyshine.schemas.arrays import Floats, Integers

MOLECULE = 3  # number in HITRAN
LARGEST_J = 72  # rotational quantum number of the lower level
WEAKEST = 5e-25  # cm/molecule; weaker lines are omitted

# Constants of the ground state, cm^-1: J.-M. Flaud et al. 1990, Atlas of Ozone Spectral Parameters from Microwave to
# Medium Infrared (Academic Press); H. M. Pickett et al. 1985, J. Mol. Spectrosc. 110, 186; to the digits given.
GROUND = VibrationalState(
    "000", 0.0, (3.553666, 0.445283, 0.394752), (2.11774e-4, -1.84684e-6, 4.5408e-7, 3.2336e-6, 6.9790e-8)
)
# Origins: Flaud et al. 1990, as in HITRAN; that of 111 is the sum of two bands there.
ORIGINS = {
    "010": 700.931,
    "001": 1042.084,
    "100": 1103.137,
    "020": 1399.273,
    "011": 1726.522,
    "110": 1796.262,
    "002": 2057.891,
    "101": 2110.784,
    "200": 2201.155,
    "021": 2407.935,
    "111": 2785.239,
}
# Rotational constants: J.-M. Flaud et al. 1987, J. Mol. Spectrosc. 124, 209 (v1 and v3, freed of their Coriolis
# coupling); H. M. Pickett et al. 1988, J. Mol. Spectrosc. 128, 151 (v2); to four decimals, with the centrifugal
# distortion of the ground state. Those of other states are sums of the steps from the ground state.
FUNDAMENTALS = {"100": (3.5567, 0.4427, 0.3925), "010": (3.6071, 0.4440, 0.3925), "001": (3.5005, 0.4413, 0.3910)}
# Band strengths at 296 K, cm/molecule of the main isotopologue: Flaud et al. 1990; at 9.6 um also G. Wagner et al.
# 2002, J. Geophys. Res. 107 (D22), 4626.
STRENGTHS = {"001": 1.394e-17, "100": 6.7e-19, "010": 6.28e-19, "101": 1.134e-18, "002": 1.1e-19, "200": 3.0e-20}
# Half widths in air at 296 K, cm^-1 atm^-1: a straight line in J through the means over Ka of M. A. H. Smith et al.
# 1997 (J. Mol. Spectrosc. 182, 239) and Wagner et al. 2002, level beyond J = 50; exponent and shift are their means.
WIDTH, WIDTH_STEP, WIDTH_END = 0.0845, 0.00042, 50
SELF_WIDTH, TEMPERATURE_EXPONENT, SHIFT = 0.095, 0.76, -0.0008


@dataclass(frozen=True)
class Isotopologue:
    """What one isotopic species of ozone has of its own.

    Attributes
    ----------
    number : int
        Number in HITRAN.
    abundance : float
        Natural, of HITRAN.
    masses : (3,) tuple
        Masses of the inner atom and the two outer ones, u.
    origins : dict
        Origins of the fundamentals at 9.6 um, where they differ from those of the main species, cm^-1 (Flaud et al.
        1990).
    """

    number: int
    abundance: float
    masses: tuple[float, float, float]
    origins: Mapping[str, float]

    @property
    def symmetric(self) -> bool:
        """Whether the outer atoms are alike; else nuclear spin forbids no level."""
        return self.masses[1] == self.masses[2]


MAIN = Isotopologue(1, 0.992901, (MASS, MASS, MASS), {})
HEAVY_MASS = 17.9991596  # u, of 18O
OUTER_HEAVY = Isotopologue(2, 3.98194e-3, (MASS, MASS, HEAVY_MASS), {"001": 1028.112, "100": 1090.354})
INNER_HEAVY = Isotopologue(3, 1.99097e-3, (HEAVY_MASS, MASS, MASS), {"001": 1008.453, "100": 1074.308})
SOURCE = (
    "rotor levels and Honl-London factors from published constants (Flaud et al. 1990; Flaud et al. 1987; Pickett et"
    " al. 1985, 1988); band strengths Flaud et al. 1990 and Wagner et al. 2002"
)


@dataclass(frozen=True)
class Band:
    """Bands that share a lower state.

    Attributes
    ----------
    upper : tuple of str
        One state, or two that Coriolis coupling joins.
    operators : tuple of Moment
        Moments of each upper state.
    """

    lower: str
    upper: tuple[str, ...]
    operators: tuple[Moment, ...]


def state(name: str, species: Isotopologue = MAIN, *, interchanged: bool = False) -> VibrationalState:
    """Constants of a vibrational state by its quantum numbers v1 v2 v3.

    Parameters
    ----------
    species : Isotopologue
        Its rotational constants are those of the main species times the ratios of the geometry's moments of inertia.
    interchanged : bool
        Take the levels that nuclear spin forbids where the outer atoms are alike.
    """
    quanta = [int(character) for character in name]
    rotation = np.array(GROUND.rotation)
    for number, fundamental in zip(quanta, ("100", "010", "001"), strict=True):
        rotation = rotation + number * (np.array(FUNDAMENTALS[fundamental]) - GROUND.rotation)
    a, b, c = (float(value) for value in rotation * rotation_ratio(species.masses))
    origin = species.origins.get(name, ORIGINS.get(name, 0.0))
    return replace(GROUND, name=name, origin=origin, rotation=(a, b, c), odd=(quanta[2] % 2 == 1) != interchanged)


def operators(moment: Sequence[float] | Floats) -> dict[str, Moment]:
    """Moment operators of the three fundamentals with their first-order dependence on rotation.

    Parameters
    ----------
    moment : (3,)
        Vibrational moments of v1, v2 and v3, Debye, in the phases of `normal_modes`.
    """
    modes, (m1, m2, m3) = normal_modes(), (float(value) for value in moment)
    _, w2, w3 = (float(value) for value in modes.wavenumber)
    permanent = PERMANENT_MOMENT / 2**0.5
    ratio = (w3 / w2) ** 0.5
    coupling = GROUND.rotation[2] * float(modes.zeta[1, 2])
    gap = ORIGINS["001"] - ORIGINS["010"]
    near, far = coupling * (ratio + 1 / ratio) / gap, coupling * (ratio - 1 / ratio) / (w2 + w3)

    def squares(mode: int) -> tuple[float, float, float]:
        xx, yy, zz = (float(permanent / modes.wavenumber[mode] * value) for value in np.diag(modes.inertia[mode]))
        return xx, yy, zz

    return {
        "100": Moment(x=m1, squares_x=squares(0)),
        "010": Moment(x=m2, jy_z=-m3 * near, z_jy=m3 * far, squares_x=squares(1)),
        "001": Moment(z=m3, jy_x=-m2 * near, x_jy=m2 * far, xz_x=float(permanent / w3 * modes.inertia[2, 0, 2])),
    }


@functools.cache
def bands() -> list[Band]:
    """The bands, with moments that give the published strengths; hot bands have those of the harmonic oscillator."""
    fundamental = operators(_fundamental_moments())
    dyad = (fundamental["100"], fundamental["001"])
    others = {name: Moment(z=1.0) if state(name).odd else Moment(x=1.0) for name in ("101", "002", "200")}
    for name, operator in others.items():
        size = float(np.sqrt(STRENGTHS[name] / _sums(Band("000", (name,), (operator,)))[0]))
        others[name] = Moment(x=size * operator.x, z=size * operator.z)
    return [
        Band("000", ("100", "001"), dyad),
        Band("010", ("110", "011"), dyad),
        Band("001", ("002",), (Moment(z=fundamental["001"].z * 2**0.5),)),
        Band("100", ("101",), (fundamental["001"],)),
        Band("020", ("021",), (fundamental["001"],)),
        Band("000", ("010",), (fundamental["010"],)),
        Band("010", ("020",), (Moment(x=fundamental["010"].x * 2**0.5, jy_z=fundamental["010"].jy_z * 2**0.5),)),
        Band("000", ("101",), (others["101"],)),
        Band("010", ("111",), (others["101"],)),
        Band("000", ("002",), (others["002"],)),
        Band("000", ("200",), (others["200"],)),
    ]


def _fundamental_moments() -> tuple[float, float, float]:
    """Vibrational moments with which the three fundamentals have the published strengths, Debye.

    Signs are those of bond moments, but for v1: there parts cancel, and the sign is the one with which Coriolis
    coupling strengthens the R branch of v1, as the band parameters of LOWTRAN7 show it at 1125 cm^-1.
    """
    modes = normal_modes()
    sign = modes.moment_sign
    start = np.array([0.012 * sign[2] * np.sign(modes.zeta[0, 2]), 0.048 * sign[1], 0.188 * sign[2]])

    def excess(moment: Floats) -> Floats:
        by_mode = operators(moment)
        dyad = _sums(Band("000", ("100", "001"), (by_mode["100"], by_mode["001"])))
        bend = _sums(Band("000", ("010",), (by_mode["010"],)))
        ratios = [dyad[0] / STRENGTHS["100"], bend[0] / STRENGTHS["010"], dyad[1] / STRENGTHS["001"]]
        return np.array(ratios) - 1

    m1, m2, m3 = fsolve(excess, start, xtol=1e-4, epsfcn=1e-4)
    return float(m1), float(m2), float(m3)


def _sums(band: Band) -> list[float]:
    """Sum of the line strengths of each upper state, cm/molecule of the main isotopologue."""
    columns = _columns(band)
    return [float(columns["strength"][columns["state"] == number].sum()) for number in range(len(band.upper))]


def band_lines(band: Band, species: Isotopologue = MAIN) -> list[BandLines]:
    """Lines of each upper state of a band."""
    columns = _columns(band, species)
    columns["strength"] *= species.abundance
    strong = columns["strength"] > WEAKEST
    return [
        _labelled(
            {key: values[strong & (columns["state"] == number)] for key, values in columns.items()},
            name,
            band.lower,
            species.number,
        )
        for number, name in enumerate(band.upper)
    ]


@functools.lru_cache(maxsize=64)
def _levels(names: tuple[str, ...], number: int, *, interchanged: bool) -> list[Levels]:
    species = {isotopologue.number: isotopologue for isotopologue in (MAIN, OUTER_HEAVY, INNER_HEAVY)}[number]
    states = tuple(state(name, species, interchanged=interchanged) for name in names)
    return [levels(states, j, coriolis() if len(names) == 2 else 0.0) for j in range(LARGEST_J + 2)]


def coriolis() -> float:
    """Coefficient of i Jy between v1 + 1 and v3 + 1, cm^-1."""
    modes = normal_modes()
    ratio = (modes.wavenumber[2] / modes.wavenumber[0]) ** 0.5
    return float(GROUND.rotation[2] * modes.zeta[0, 2] * (ratio + 1 / ratio))


def _columns(band: Band, species: Isotopologue = MAIN) -> dict[str, Floats]:
    """All lines of a band, one array an entry; strengths without natural abundance."""
    parts = []
    for interchanged in (False,) if species.symmetric else (False, True):
        lower = _levels((band.lower,), species.number, interchanged=interchanged)
        upper = _levels(band.upper, species.number, interchanged=interchanged)
        parts += [
            _pair(lower[j], upper[k], band.operators)
            for j in range(LARGEST_J + 1)
            for k in (j - 1, j, j + 1)
            if k >= 0 and not j == k == 0
        ]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    columns["strength"] = strength(
        columns["wavenumber"],
        columns["lower_energy"],
        columns["moment"] ** 2,
        reference_sum(MOLECULE, species.number),
        1.0,
    )
    return columns


def _pair(lower: Levels, upper: Levels, by_state: tuple[Moment, ...]) -> dict[str, Floats]:
    """Lines between all levels of two J, one array an entry."""
    moment = moments(lower, upper, by_state)
    up, low = (index.ravel() for index in np.indices(moment.shape))
    return {
        "wavenumber": upper.energy[up] - lower.energy[low],
        "lower_energy": lower.energy[low],
        "moment": moment.ravel(),
        "state": upper.state[up].astype(float),
        **{f"upper_{key}": value for key, value in _numbers(upper, up).items()},
        **{f"lower_{key}": value for key, value in _numbers(lower, low).items()},
    }


def _numbers(state_levels: Levels, index: Integers) -> dict[str, Floats]:
    """Rotational quantum numbers of levels."""
    return {
        "j": np.full(index.size, float(state_levels.j)),
        "ka": state_levels.ka[index].astype(float),
        "kc": state_levels.kc[index].astype(float),
    }


def _labelled(part: dict[str, Floats], upper: str, lower: str, isotopologue: int) -> BandLines:
    label = {}
    for end in ("upper", "lower"):
        numbers = zip(*(part[f"{end}_{key}"].astype(int) for key in ("j", "ka", "kc")), strict=True)
        label[end] = np.array([f"{j:3d}{ka:3d}{kc:3d}      " for j, ka, kc in numbers], dtype="U15")
    j = np.minimum(part["lower_j"], WIDTH_END)
    return BandLines(
        molecule=MOLECULE,
        isotopologue=isotopologue,
        upper=upper,
        lower=lower,
        wavenumber=part["wavenumber"],
        strength=part["strength"],
        lower_energy=part["lower_energy"],
        air_width=WIDTH - WIDTH_STEP * j,
        self_width=np.full(j.size, SELF_WIDTH),
        temperature_exponent=np.full(j.size, TEMPERATURE_EXPONENT),
        shift=np.full(j.size, SHIFT),
        upper_rotation=label["upper"],
        lower_rotation=label["lower"],
        source=SOURCE,
    )


def all_bands() -> list[BandLines]:
    """The lines of all bands and isotopologues."""
    lists = [lines for band in bands() for lines in band_lines(band)]
    for species in (OUTER_HEAVY, INNER_HEAVY):
        lists += band_lines(bands()[0], species)
    return lists
