"""Line-by-line absorption cross sections: on a fine grid by nested grids, and at given wavenumbers directly.

Near a line centre the profile changes within a Doppler width, far from it within its distance from the centre. So the
profile is split: each grid has the part that the next coarser grid cannot resolve, the coarser grid holding
the profile with its centre replaced by an even quartic that matches value, slope and curvature at the radius of the
split (the idea of Clough, Kneizys and Davies 1989, Atmos. Res. 23, 229). Coarse grids are interpolated with cubics.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import njit

from skyshine.mat.radiometry.constants import C2
from skyshine.mat.spectroscopy.lines import LineList
from skyshine.mat.spectroscopy.partition import REFERENCE_TEMPERATURE, molar_mass, partition_ratio, per_line
from skyshine.mat.spectroscopy.voigt import chi_co2, chi_decay, far_voigt, voigt
from skyshine.schemas.arrays import Floats, Integers

CUT_OFF = 25.0  # cm^-1, the convention that MT_CKD is built on (Mlawer et al. 2012)
ATMOSPHERE = 101325.0  # Pa
DOPPLER = 4.30140e-7  # 1/e half width: DOPPLER * wavenumber * sqrt(T [K] / M [g/mol]); sqrt(2 R) / c, CODATA 2018
CM2_TO_M2 = 1e-4  # m2 per cm2

# Line shapes: Voigt; with the value at 25 cm^-1 taken off (H2O: MT_CKD includes that pedestal); with CO2's chi factor.
PLAIN, PEDESTAL_REMOVED, SUB_LORENTZIAN = 0, 1, 2

_COARSEST = 256  # the number of fine points is a multiple of it
_PAD = 2  # cells of a coarse grid beyond the interval, for the cubic interpolation


def line_parameters(lines: LineList, temperature: npt.ArrayLike) -> tuple[Floats, Floats, Floats]:
    """What depends on temperature alone.

    Parameters
    ----------
    lines : LineList of N lines
    temperature : (T,) array, K

    Returns
    -------
    strength : (T, N), m2 cm^-1 / molecule
    doppler : (T, N), 1/e half width, cm^-1
    width_factor : (T, N), factor of the pressure-broadened width, (296 / T)^n
    """
    t = np.asarray(temperature, float)[:, None]
    nu, energy = lines.wavenumber, lines.lower_energy
    ratio = np.array([per_line(partition_ratio, lines.molecule, lines.isotopologue, float(value)) for value in t[:, 0]])
    reference = REFERENCE_TEMPERATURE
    boltzmann = np.exp(-C2 * energy * (1 / t - 1 / reference))
    emission = np.expm1(-C2 * nu / t) / np.expm1(-C2 * nu / reference)
    mass = per_line(molar_mass, lines.molecule, lines.isotopologue)
    strength = lines.strength * ratio * boltzmann * emission * CM2_TO_M2
    doppler = DOPPLER * nu * np.sqrt(t / mass)
    return strength, doppler, (reference / t) ** lines.temperature_exponent


def fine_step(wavenumber: float) -> float:
    """Step of the reference grid at a wavenumber, cm^-1.

    1e-6 of the wavenumber is 1.0 to 1.2 Doppler half widths of CO2 and O3 between 200 and 300 K, and 0.8 of H2O: the
    sum over such a grid integrates a Gaussian to better than 1e-5. Below 330 cm^-1 the step stays 3.3e-4 cm^-1: lines
    are there narrower than that above 55 km only.
    """
    return 1e-6 * max(wavenumber, 330.0)


def interval_grid(low: float, high: float) -> Floats:
    """Midpoints of the reference grid of an interval, cm^-1; their number is a multiple of the nested grids' ratio."""
    count = _COARSEST * math.ceil((high - low) / fine_step(low) / _COARSEST)
    return np.asarray(low + (np.arange(count) + 0.5) * (high - low) / count)


def interval_spectrum(
    lines: LineList,
    low: float,
    high: float,
    pressure: npt.ArrayLike,
    temperature: npt.ArrayLike,
    self_fraction: float = 0.0,
    shape: int = PLAIN,
) -> Floats:
    """Cross sections on `interval_grid(low, high)` for every pressure and temperature.

    Parameters
    ----------
    lines : LineList
        All lines from ``low - 25`` to ``high + 25`` cm^-1.
    pressure : (P,) array, Pa
    temperature : (T,) array, K
    self_fraction : float
        Mole fraction of the gas itself, for self broadening.
    shape : int
        PLAIN, PEDESTAL_REMOVED or SUB_LORENTZIAN.

    Returns
    -------
    (P, T, K) array, m2/molecule
    """
    pressure, temperature = np.asarray(pressure, float), np.asarray(temperature, float)
    out = np.zeros((pressure.size, temperature.size, interval_grid(low, high).size))
    if not len(lines):
        return out
    strength, doppler, factor = line_parameters(lines, temperature)
    atmospheres = pressure / ATMOSPHERE
    width = lines.air_width * (1 - self_fraction) + lines.self_width * self_fraction
    _nested(
        out, low, high, lines.wavenumber, lines.shift, width, strength, doppler, factor, atmospheres, temperature, shape
    )
    return np.maximum(out, 0.0, out=out)


def point_cross_sections(
    lines: LineList,
    wavenumber: npt.ArrayLike,
    pressure: npt.ArrayLike,
    temperature: npt.ArrayLike,
    self_fraction: float = 0.0,
    shape: int = PLAIN,
) -> Floats:
    """Cross sections at given wavenumbers, summed line by line without any grid.

    Parameters and result as in `interval_spectrum`, with `wavenumber` (K,) in cm^-1 -> (P, T, K) m2/molecule.
    """
    wavenumber, pressure, temperature = (np.asarray(a, float) for a in (wavenumber, pressure, temperature))
    out = np.zeros((pressure.size, temperature.size, wavenumber.size))
    if not len(lines):
        return out
    strength, doppler, factor = line_parameters(lines, temperature)
    atmospheres = pressure / ATMOSPHERE
    width = lines.air_width * (1 - self_fraction) + lines.self_width * self_fraction
    _direct(
        out,
        wavenumber,
        lines.wavenumber,
        lines.shift,
        width,
        strength,
        doppler,
        factor,
        atmospheres,
        temperature,
        shape,
    )
    return out


@njit(cache=True, fastmath=True)
def _wing(distance: float, inverse_doppler: float, y: float, b1: float, shape: int) -> float:
    """Profile per unit strength far from the centre, without pedestal; distance > 0 in cm^-1."""
    x = distance * inverse_doppler
    value = far_voigt(x * x, y) * inverse_doppler * 0.5641895835477563
    if shape == SUB_LORENTZIAN:
        value *= chi_co2(distance, b1)
    return value


@njit(cache=True)
def _direct(
    out: Floats,
    nu: Floats,
    center: Floats,
    shift: Floats,
    width: Floats,
    strength: Floats,
    doppler: Floats,
    factor: Floats,
    pressure: Floats,
    temperature: Floats,
    shape: int,
) -> None:
    """Add the lines at wavenumbers `nu` (K,) to `out` (P, T, K); pressure in atm, the rest as `line_parameters`."""
    for ip in range(pressure.size):
        for it in range(temperature.size):
            b1 = chi_decay(temperature[it])
            for j in range(center.size):
                inverse = 1.0 / doppler[it, j]
                y = width[j] * factor[it, j] * pressure[ip] * inverse
                s = strength[it, j]
                c = center[j] + shift[j] * pressure[ip]
                pedestal = _wing(CUT_OFF, inverse, y, b1, shape) if shape == PEDESTAL_REMOVED else 0.0
                for k in range(nu.size):
                    distance = abs(nu[k] - c)
                    if distance > CUT_OFF:
                        continue
                    x = distance * inverse
                    if x + y > 15.0:
                        value = _wing(distance, inverse, y, b1, shape)
                    else:
                        value = voigt(x, y) * inverse * 0.5641895835477563
                    out[ip, it, k] += s * (value - pedestal)


@njit(cache=True, fastmath=True)
def _quartic(
    radius: float, half_width: float, inverse: float, y: float, b1: float, shape: int
) -> tuple[float, float, float]:
    """Coefficients a, b, c of a + b d^2 + c d^4 that continues a wing inside its radius."""
    value = _wing(radius, inverse, y, b1, shape)
    r2 = radius * radius
    u = r2 / (r2 + half_width * half_width)
    return value * (1 + u + u * u), -value * (u + 2 * u * u) / r2, value * u * u / (r2 * r2)


@njit(cache=True, fastmath=True)
def _nested(
    out: Floats,
    low: float,
    high: float,
    center: Floats,
    shift: Floats,
    width: Floats,
    strength: Floats,
    doppler: Floats,
    factor: Floats,
    pressure: Floats,
    temperature: Floats,
    shape: int,
) -> None:
    """Set `out` (P, T, K) to the sum of the lines by nested grids; arguments as `_direct`."""
    count = out.shape[2]
    step = (high - low) / count
    radius = np.array([64 * step, 512 * step, min(4096 * step, 3.0), CUT_OFF])
    # Steps in units of the finest; the last grid has at least eight within its inner radius, where that is possible.
    ratios = np.array([1, 8, 64, 256 if 8 * 256 * step <= radius[2] else 128])
    levels = ratios.size
    longest = count + 2 * _PAD + 1
    grid = np.zeros((levels, longest))
    for ip in range(pressure.size):
        for it in range(temperature.size):
            grid[:] = 0.0
            b1 = chi_decay(temperature[it])
            for j in range(center.size):
                c = center[j] + shift[j] * pressure[ip]
                inverse = 1.0 / doppler[it, j]
                gamma = width[j] * factor[it, j] * pressure[ip]
                y = gamma * inverse
                s = strength[it, j]
                start = 1 if gamma > 48.0 * step else 0  # the second grid then resolves the line itself
                ia, ib, ic = 0.0, 0.0, 0.0  # quartic inside the inner radius
                for level in range(start, levels):
                    outer = radius[level]
                    is_coarsest = level == levels - 1
                    if c + outer < low - _PAD * step * ratios[level] or c - outer > high + _PAD * step * ratios[level]:
                        if not is_coarsest:
                            ia, ib, ic = _quartic(outer, gamma, inverse, y, b1, shape)
                        continue
                    h = step * ratios[level]
                    origin = low + 0.5 * step if level == 0 else low - _PAD * h
                    points = count if level == 0 else count // ratios[level] + 2 * _PAD + 1
                    oa, ob, oc = 0.0, 0.0, 0.0
                    if is_coarsest:
                        if shape == PEDESTAL_REMOVED:
                            oa = _wing(CUT_OFF, inverse, y, b1, shape)
                    else:
                        oa, ob, oc = _quartic(outer, gamma, inverse, y, b1, shape)
                    inner = radius[level - 1] if level > start else 0.0
                    lowest = max(0, math.ceil((c - outer - origin) / h))
                    highest = min(points - 1, math.floor((c + outer - origin) / h))
                    for i in range(lowest, highest + 1):
                        d = abs(origin + i * h - c)
                        d2 = d * d
                        if d < inner:
                            value = ia + d2 * (ib + d2 * ic)
                        elif d * inverse + y > 15.0:
                            value = _wing(d, inverse, y, b1, shape)
                        else:
                            value = voigt(d * inverse, y) * inverse * 0.5641895835477563
                        grid[level, i] += s * (value - oa - d2 * (ob + d2 * oc))
                    ia, ib, ic = oa, ob, oc
            _sum_grids(out[ip, it], grid, ratios)


@njit(cache=True, fastmath=True)
def _sum_grids(out: Floats, grid: Floats, ratios: Integers) -> None:
    """Set `out` (K,) to the sum of the grids (G, ...), the coarse ones interpolated."""
    count = out.size
    for i in range(count):
        out[i] = grid[0, i]
    for level in range(1, ratios.size):
        ratio = ratios[level]
        for r in range(ratio):
            f = (r + 0.5) / ratio  # cubic Lagrange weights at fraction f between the second and third of four points
            w0 = -f * (f - 1) * (f - 2) / 6
            w1 = (f + 1) * (f - 1) * (f - 2) / 2
            w2 = -(f + 1) * f * (f - 2) / 2
            w3 = (f + 1) * f * (f - 1) / 6
            for cell in range(count // ratio):
                j = cell + _PAD - 1
                out[cell * ratio + r] += (
                    w0 * grid[level, j] + w1 * grid[level, j + 1] + w2 * grid[level, j + 2] + w3 * grid[level, j + 3]
                )
