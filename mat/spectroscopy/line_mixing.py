"""Line mixing of CO2's bands at 4.3 um: collisions transfer intensity from the wings of a band to its centre.

Lines of a band are coupled by a relaxation matrix W (energy-corrected sudden approximation: rates of the rotational
levels from a power law, a correction for the rotation during a collision, and the sum rule that ties the matrix to the
measured widths). The spectrum is that of the whole matrix, not of its first order, so wings need neither a factor nor a
continuum. The matrix is diagonalised for each pressure and temperature; what results are lines of complex strength.

Sources: N. Rodrigues et al. 1999, JQSRT 61, 153 (matrix elements); F. Niro, C. Boulet and J.-M. Hartmann 2004, JQSRT
88, 483 (sum rule). The constants for N2 and O2 are those of Rodrigues and others, as the radiative transfer code ARTS
has them (its `ecs_dataAddRodrigues1997`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from numba import njit

from skyshine.mat.radiometry.constants import BOLTZMANN, C2
from skyshine.mat.spectroscopy.lines import LineList, column, parse_records, read_records
from skyshine.mat.spectroscopy.partition import REFERENCE_TEMPERATURE, molar_mass, partition_ratio
from skyshine.mat.spectroscopy.voigt import SQRT_PI, far_faddeeva, near_faddeeva
from skyshine.schemas.arrays import Booleans, Floats, Integers

Complexes = npt.NDArray[np.complex128]

CO2 = 2  # number in HITRAN
SOURCE = (
    "line mixing by a relaxation matrix (energy-corrected sudden approximation, Rodrigues et al. 1999, JQSRT 61, 153;"
    " Niro et al. 2004, JQSRT 88, 483)"
)
RANGE = (2230.0, 2550.0)  # cm^-1, where the matrix takes the place of the lines of these bands and of their continuum
WEAKEST_BAND = 5e-19  # cm^-1 / (molecule cm^-2), sum of the strengths of a band
WEAKEST_LINE = 1e-27  # weaker ones stay single
ROTATION = 0.39021  # cm^-1, B of CO2
MASS_CO2 = 44.0  # g/mol
ATOMIC_MASS = 1.66053907e-27  # kg
LIGHT = 2.99792458e10  # cm/s
ATMOSPHERE = 101325.0  # Pa
DOPPLER = 4.30140e-7  # as in `linebyline`
CM2_TO_M2 = 1e-4  # m2 per cm2


@dataclass(frozen=True)
class Partner:
    """Collisions with a molecule, at rates ``scale (296 / T)^scale_exponent (L (L + 1))^-power exp(-beta E / kT)``.

    Attributes
    ----------
    share : float
        Share in air.
    mass : float
        g/mol.
    scale, scale_exponent : float
        cm^-1/atm.
    power, power_exponent : float
        ``power (296 / T)^power_exponent`` is the exponent of L (L + 1).
    distance : float
        Distance of the collision, angstrom.
    """

    share: float
    mass: float
    scale: float
    scale_exponent: float
    power: float
    power_exponent: float
    beta: float
    distance: float


NITROGEN = Partner(0.79, 28.0, 0.0180, 0.85, 0.81, 0.0152, 0.008, 2.2)
OXYGEN = Partner(0.21, 32.0, 0.0168, 0.50, 0.82, -0.091, 0.007, 2.4)


@dataclass(frozen=True)
class Band:
    """Lines of one vibrational band of one isotopologue, of equal vibrational angular momentum above and below.

    Attributes
    ----------
    lines : LineList of N lines
    lower, upper : (N,) int arrays
        Rotational quantum numbers J.
    parity : (N,) bool array
        True where the lower level is an f level.
    momentum : int
        Vibrational angular momentum l.
    """

    lines: LineList
    lower: Integers
    upper: Integers
    parity: Booleans
    momentum: int


def read_bands(paths: Sequence[str | Path]) -> list[Band]:
    """The bands of HITRAN records of CO2 whose lines mix."""
    bands: list[Band] = []
    for path in paths:
        records, lines = read_records(Path(path)), parse_records(Path(path))
        near = np.flatnonzero((lines.wavenumber > RANGE[0] - 100) & (lines.wavenumber < RANGE[1]))
        above, below, local = (column(records[near], *span) for span in ((67, 82), (82, 97), (112, 127)))
        name = np.char.add(column(records[near], 2, 3), np.char.add(above, below))
        for label in np.unique(name):
            chosen = name == label
            if lines.strength[near[chosen]].sum() < WEAKEST_BAND or not _is_parallel(label[1:]):
                continue
            chosen &= lines.strength[near] > WEAKEST_LINE
            chosen &= np.char.find(local, b"Q") < 0  # a thousandth of the others
            branch = np.array([{b"P": -1, b"R": 1}[text[5:6]] for text in local[chosen]])
            lower = np.array([int(text[6:9]) for text in local[chosen]])
            parity = np.array([text[9:10] == b"f" for text in local[chosen]])
            bands.append(Band(lines.select(near[chosen]), lower, lower + branch, parity, int(label[26:28])))
    return bands


def _is_parallel(name: bytes) -> bool:
    """Whether one quantum of the antisymmetric stretch is all that the levels v1 v2 l v3 r of a name differ by."""
    upper, lower = ([int(name[start + k : start + k + 2]) for k in (6, 8, 10, 12)] for start in (0, 15))
    return upper[:3] == lower[:3] and upper[3] == lower[3] + 1


class MixedLines:
    """The spectrum of bands whose lines mix; the decompositions are kept by pressure and temperature."""

    def __init__(self, bands: Sequence[Band]) -> None:
        self.bands = list(bands)
        self._names = np.concatenate([np.zeros(0), *(_names(band.lines) for band in self.bands)])
        self._matrices: dict[float, list[tuple[Floats, Floats, Floats]]] = {}
        self._states: dict[tuple[float, float], tuple[Complexes, Complexes, Floats]] = {}

    def includes(self, lines: LineList) -> Booleans:
        """Which of some lines (N,) are lines of these bands."""
        return np.isin(_names(lines), self._names)

    def cross_sections(self, wavenumber: npt.ArrayLike, pressure: npt.ArrayLike, temperature: npt.ArrayLike) -> Floats:
        """Cross sections of all bands together.

        Parameters
        ----------
        wavenumber : (K,) array, cm^-1
        pressure : (P,) array, Pa
        temperature : (T,) array, K

        Returns
        -------
        (P, T, K) array, m2/molecule
        """
        wavenumber, pressure, temperature = (np.asarray(a, float) for a in (wavenumber, pressure, temperature))
        out = np.zeros((pressure.size, temperature.size, wavenumber.size))
        if not self.bands:
            return out
        for it, t in enumerate(temperature):
            emission = -wavenumber * np.expm1(-C2 * wavenumber / t)
            for ip, p in enumerate(pressure):
                _sum_lines(out[ip, it], wavenumber, *self._lines(float(p), float(t)))
                out[ip, it] *= emission
        return np.maximum(out, 0.0, out=out)

    def _lines(self, pressure: float, temperature: float) -> tuple[Complexes, Complexes, Floats]:
        """Complex positions (cm^-1), strengths and Doppler widths of the lines that the matrices make."""
        key = pressure, temperature
        if key not in self._states:
            if temperature not in self._matrices:
                self._matrices[temperature] = [_couplings(band, temperature) for band in self.bands]
            parts = []
            for band, (moment, matrix, doppler) in zip(self.bands, self._matrices[temperature], strict=True):
                atmospheres = pressure / ATMOSPHERE
                centre = band.lines.wavenumber + band.lines.shift * atmospheres
                values, vectors = np.linalg.eig(np.diag(centre) - 1j * atmospheres * matrix)
                strength = (moment @ vectors) * np.linalg.solve(vectors, moment.astype(complex))
                parts.append((values, strength, np.interp(values.real, *_by_wavenumber(centre, doppler))))
            position, strength, doppler = (np.concatenate(columns) for columns in zip(*parts, strict=True))
            self._states[key] = position, strength, doppler
        return self._states[key]


def _names(lines: LineList) -> Floats:
    """Isotopologue and position of lines in one number each: no two lines of an isotopologue agree in both digits and
    strength.
    """
    return lines.wavenumber + 1e4 * lines.isotopologue + 1e15 * lines.strength


def _by_wavenumber(centre: Floats, doppler: Floats) -> tuple[Floats, Floats]:
    order = np.argsort(centre)
    return centre[order], doppler[order]


def _couplings(band: Band, temperature: float) -> tuple[Floats, Floats, Floats]:
    """Moments (N,), symmetric relaxation matrix (N, N) in cm^-1/atm, Doppler widths (N,) of a band's lines."""
    lines, t = band.lines, temperature
    number = int(lines.isotopologue[0])
    ratio = partition_ratio(CO2, number, t)
    boltzmann = np.exp(-C2 * lines.lower_energy * (1 / t - 1 / REFERENCE_TEMPERATURE))
    strength = lines.strength * ratio * boltzmann / -np.expm1(-C2 * lines.wavenumber / REFERENCE_TEMPERATURE)
    population = (2 * band.lower + 1) * np.exp(-C2 * (lines.lower_energy - lines.lower_energy.min()) / t)
    sign = np.sign(moments(band.lower, band.upper, band.momentum))
    moment = sign * np.sqrt(strength * CM2_TO_M2 / lines.wavenumber)
    width = lines.air_width * (REFERENCE_TEMPERATURE / t) ** lines.temperature_exponent
    matrix = relaxation_matrix(band, t, population, moment / np.sqrt(population), width)
    symmetric = matrix * np.sqrt(population[None, :] / population[:, None])
    doppler = DOPPLER * lines.wavenumber * math.sqrt(t / molar_mass(CO2, number))
    return moment, 0.5 * (symmetric + symmetric.T), doppler


def relaxation_matrix(band: Band, temperature: float, population: Floats, dipole: Floats, width: Floats) -> Floats:
    """The relaxation matrix of air, cm^-1/atm; element [k', k] leads from line k to line k'.

    Parameters
    ----------
    band : Band of N lines
    temperature : float, K
    population, dipole : (N,) arrays
        Populations of the lower levels, degeneracy included; reduced moments with their signs.
    width : (N,) array
        Pressure-broadened half widths at that temperature, cm^-1/atm: the diagonal.

    Returns
    -------
    (N, N) array
        Obeys detailed balance and ``sum over k' of dipole[k'] W[k', k] = 0``, but for the lines of weakest population.
    """
    largest = 2 * int(max(band.lower.max(), band.upper.max())) + 2
    total = np.zeros((population.size, population.size))
    for partner in (NITROGEN, OXYGEN):
        rate, correction = rates(partner, largest, temperature)
        total += partner.share * _off_diagonal(
            band.lower, band.upper, band.parity, band.momentum, rate / correction, correction, population
        )
    order = np.argsort(-population * dipole**2)
    return _with_sum_rule(total, order, population, dipole, width)


def rates(partner: Partner, largest: int, temperature: float) -> tuple[Floats, Floats]:
    """Rates (cm^-1/atm) and adiabatic corrections of the levels 0 to `largest`; the rate of level 0 is zero."""
    level = np.arange(largest + 1.0)
    energy = ROTATION * level * (level + 1)
    ratio = REFERENCE_TEMPERATURE / temperature
    power = partner.power * ratio**partner.power_exponent
    factor = np.maximum(level * (level + 1), 1.0) ** -power * np.exp(-partner.beta * C2 * energy / temperature)
    rate = np.where(level > 0, partner.scale * ratio**partner.scale_exponent * factor, 0.0)
    reduced = ATOMIC_MASS / (1 / MASS_CO2 + 1 / partner.mass)
    speed = math.sqrt(8 * BOLTZMANN * temperature / (math.pi * reduced))
    spacing = 2 * math.pi * LIGHT * ROTATION * np.maximum(4 * level - 2, 0.0)  # from J - 2 to J, rad/s
    correction = (1 + (spacing * partner.distance * 1e-10 / speed) ** 2 / 24) ** -2
    return rate, correction


@njit(cache=True)
def _three_j(j2: int, j3: int, momentum: int, out: Floats) -> None:
    """Set out[L] to the 3j symbol (L first second; 0 l -l), by recursion downwards (Schulten and Gordon 1975)."""
    highest, lowest = j2 + j3, abs(j2 - j3)
    out[:] = 0.0
    value, before = 1.0, 0.0
    total = 0.0
    for level in range(highest, lowest - 1, -1):
        out[level] = value
        total += (2 * level + 1) * value * value
        if level == lowest:
            break
        up = math.sqrt(max(0.0, ((level + 1.0) ** 2 - lowest**2) * ((highest + 1.0) ** 2 - (level + 1.0) ** 2)))
        down = math.sqrt((float(level) ** 2 - lowest**2) * ((highest + 1.0) ** 2 - float(level) ** 2))
        # Divided by L (L + 1): up f(L + 1) + middle f(L) + down f(L - 1) = 0.
        value, before = (2.0 * momentum * (2 * level + 1) * value - up * before) / down, value
    scale = 1.0 / math.sqrt(total)
    if (j2 - j3) % 2:
        scale = -scale
    for level in range(lowest, highest + 1):
        out[level] *= scale


@njit(cache=True)
def _triangle(a: int, b: int, c: int, logs: Floats) -> float:
    return float(0.5 * (logs[a + b - c] + logs[a - b + c] + logs[-a + b + c] - logs[a + b + c + 1]))


@njit(cache=True)
def _six_j(a: int, b: int, d: int, e: int, f: int, logs: Floats) -> float:
    """6j symbol {a b 1; d e f} by Racah's sum, which has few terms as one momentum is 1."""
    c = 1
    outer = _triangle(a, b, c, logs) + _triangle(a, e, f, logs) + _triangle(d, b, f, logs) + _triangle(d, e, c, logs)
    total = 0.0
    start = max(a + b + c, a + e + f, d + b + f, d + e + c)
    final = min(a + b + d + e, b + c + e + f, c + a + f + d)
    for t in range(start, final + 1):
        term = (
            logs[t + 1]
            - logs[t - a - b - c]
            - logs[t - a - e - f]
            - logs[t - d - b - f]
            - logs[t - d - e - c]
            - logs[a + b + d + e - t]
            - logs[b + c + e + f - t]
            - logs[c + a + f + d - t]
        )
        total += (-1.0 if t % 2 else 1.0) * math.exp(outer + term)
    return total


@njit(cache=True)
def _off_diagonal(
    lower: Integers,
    upper: Integers,
    parity: Booleans,
    momentum: int,
    rate: Floats,
    correction: Floats,
    population: Floats,
) -> Floats:
    """Elements between different lines (Rodrigues et al. 1999), before the sum rule; `rate` is divided by `correction`.

    Symmetric collisions (even L) keep the parity of the whole molecule: e and f levels mix where J changes by an odd
    number.
    """
    count = lower.size
    size = rate.size
    logs = np.zeros(4 * size + 10)
    for k in range(1, logs.size):
        logs[k] = logs[k - 1] + math.log(k)
    matrix = np.zeros((count, count))
    below, above = np.zeros(2 * size), np.zeros(2 * size)
    for k in range(count):
        for m in range(count):
            # From k down to the other line; upwards by detailed balance.
            if m == k or lower[m] > lower[k] or (lower[m] == lower[k] and m > k):
                continue
            if (parity[k] != parity[m]) != ((lower[k] - lower[m]) % 2 != 0):
                continue
            _three_j(lower[k], lower[m], momentum, below)
            _three_j(upper[k], upper[m], momentum, above)
            lowest_rank = max(abs(lower[k] - lower[m]), abs(upper[k] - upper[m]), 2)
            total = 0.0
            for level in range(lowest_rank + lowest_rank % 2, min(lower[k] + lower[m], upper[k] + upper[m]) + 1, 2):
                six = _six_j(lower[k], upper[k], upper[m], lower[m], level, logs)
                total += (2 * level + 1) * below[level] * above[level] * six * rate[level]
            total *= (2 * lower[m] + 1) * correction[lower[k]]
            total *= math.sqrt((2.0 * upper[k] + 1) * (2.0 * upper[m] + 1))
            matrix[m, k] = total
            matrix[k, m] = total * population[k] / population[m]
    return matrix


@njit(cache=True)
def _with_sum_rule(matrix: Floats, order: Integers, population: Floats, dipole: Floats, width: Floats) -> Floats:
    """The matrix with the widths as diagonal, off-diagonal elements scaled line by line, strongest first, so that the
    sum rule is satisfied (Niro et al. 2004).
    """
    result = np.zeros_like(matrix)
    count = order.size
    for rank in range(count):
        k = order[rank]
        scaled_sum, unscaled_sum = width[k] * dipole[k], 0.0
        result[k, k] = width[k]
        for i in range(count):
            m = order[i]
            if i < rank:
                scaled_sum += dipole[m] * result[m, k]
            elif i > rank:
                unscaled_sum += dipole[m] * matrix[m, k]
        if unscaled_sum == 0.0:
            continue
        factor = max(-scaled_sum / unscaled_sum, 0.0)
        for i in range(rank + 1, count):
            m = order[i]
            result[m, k] = factor * matrix[m, k]
            result[k, m] = result[m, k] * population[k] / population[m]
    return result


@njit(cache=True)
def moments(lower: Integers, upper: Integers, momentum: int) -> Floats:
    """Reduced rotational moments of lines, ``sqrt(2 J' + 1) (1 J' J; 0 l -l)``, whose signs go with the matrix."""
    out = np.zeros(lower.size)
    symbol = np.zeros(2 * (lower.max() + upper.max()) + 2)
    for k in range(lower.size):
        _three_j(upper[k], lower[k], momentum, symbol)
        out[k] = math.sqrt(2.0 * upper[k] + 1) * symbol[1]
    return out


@njit(cache=True, fastmath=True)
def _sum_lines(out: Floats, nu: Floats, position: Complexes, strength: Complexes, doppler: Floats) -> None:
    """Add lines of complex position and strength at wavenumbers `nu` (K,) to `out` (K,), over the radiation term."""
    for j in range(position.size):
        inverse = 1.0 / doppler[j]
        y = max(-position[j].imag * inverse, 1e-9)
        unmixed, mixed = strength[j].real * inverse / SQRT_PI, strength[j].imag * inverse / SQRT_PI
        for k in range(nu.size):
            x = (nu[k] - position[j].real) * inverse
            if abs(x) + y > 15.0:
                real, imaginary = far_faddeeva(x, y)
            else:
                near = near_faddeeva(x, y)
                real, imaginary = near.real, near.imag
            out[k] += unmixed * real - mixed * imaginary
