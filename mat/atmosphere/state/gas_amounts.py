"""How much of a gas there is: factors on the gases of a profile, and columns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.mat.atmosphere.state.humidity import WATER_MOLAR_MASS
from skyshine.mat.radiometry.constants import AVOGADRO, BOLTZMANN
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError, nearest

DOBSON_UNIT = 2.6867e20  # molecules m^-2: 10 um of ozone at 0 C and 1 atm (Loschmidt constant, CODATA)
# Where neither job nor command says otherwise: the mean over the Earth in 2023 was 419 ppm, and grows by 2.4 ppm a year
# (NOAA Global Monitoring Laboratory, marine surface). The profiles have the 330 ppm of their report's time.
CARBON_DIOXIDE_PPM = 420.0
_LARGEST_FACTOR = 1e6  # beyond it every level is saturated


@dataclass(frozen=True)
class GasAmounts:
    """Amounts of gases in the air, where that differs from its profile.

    Attributes
    ----------
    scale : mapping of str to float
        Gas to factor. Water vapour stops at saturation over water where its factor is above 1.
    ppm : mapping of str to float
        Gas to parts per million at the ground, its profile scaled.
    water_column, ozone_column : float, optional
        Above the ground, kg m^-2 (mm of water) and Dobson units, the profile scaled; water vapour stops at saturation.
    """

    scale: Mapping[str, float] = field(default_factory=dict)
    ppm: Mapping[str, float] = field(default_factory=dict)
    water_column: float | None = None
    ozone_column: float | None = None


def scaled_gases(
    gases: Mapping[str, Floats],
    amounts: GasAmounts,
    altitude: Floats,
    pressure: Floats,
    temperature: Floats,
    in_water_cloud: Booleans,
) -> dict[str, Floats]:
    """Mole fractions of a profile with the amounts that are asked for.

    Air in water cloud is saturated, as in LOWTRAN7 (SUBROUTINE AERNSM), unless a water column asks for less.

    Parameters
    ----------
    gases : mapping of str to (N,) array
        Mole fractions from the ground up.
    altitude, pressure, temperature : (N,) arrays
        m, Pa, K.
    in_water_cloud : (N,) bool array

    Returns
    -------
    dict of str to (N,) array

    Raises
    ------
    InputError
        As `gas_factors`, `ozone_factor` and `water_factor`.
    """
    factors = gas_factors(gases, amounts.scale, amounts.ppm)
    scaled = {gas: fraction * factors.get(gas, 1.0) for gas, fraction in gases.items()}
    density = pressure / (BOLTZMANN * temperature)
    if amounts.ozone_column is not None:
        scaled["O3"] = scaled["O3"] * ozone_factor(altitude, density * scaled["O3"], amounts.ozone_column)
    saturated = saturation_pressure(temperature) / pressure
    scaled["H2O"] = np.where(in_water_cloud, np.maximum(scaled["H2O"], saturated), scaled["H2O"])
    factor = 1.0
    if amounts.water_column is not None:
        factor = water_factor(altitude, density, scaled["H2O"], saturated, amounts.water_column)
    if amounts.water_column is not None or factors.get("H2O", 1.0) > 1:
        scaled["H2O"] = np.minimum(scaled["H2O"] * factor, saturated)
    return scaled


def gas_factors(gases: Mapping[str, Floats], scale: Mapping[str, float], ppm: Mapping[str, float]) -> dict[str, float]:
    """Factor on each gas.

    Parameters
    ----------
    gases : mapping of str to (N,) array
        Mole fractions from the ground up.
    scale, ppm : mappings of str to float
        Amounts as in `GasAmounts`.

    Raises
    ------
    InputError
        For a gas that the profile does not have, is named twice or is 0 at the ground, and for a negative or infinite
        amount.
    """
    for gas, amount in [*scale.items(), *ppm.items()]:
        if gas not in gases:
            raise InputError(f"no gas '{gas}' in this profile; {nearest(gas, gases)}")
        if not (np.isfinite(amount) and amount >= 0):
            raise InputError(f"amount {amount} of {gas} is not allowed; give a finite number of at least 0")
    factors = dict(scale)
    for gas, parts in ppm.items():
        if factors.get(gas, 1.0) != 1.0:
            raise InputError(f"{gas} has both a scale and an amount; give one of them")
        if gases[gas][0] <= 0:
            raise InputError(
                f"the profile has no {gas} at the ground, so that none can be scaled to {parts:g} ppm; give a scale"
            )
        factors[gas] = parts * 1e-6 / gases[gas][0]
    return factors


def mean_exponential(start: npt.ArrayLike, stop: npt.ArrayLike) -> Floats:
    """Mean of a quantity that runs exponentially from `start` to `stop`; linear where one of them is 0."""
    start, stop = np.asarray(start, dtype=float), np.asarray(stop, dtype=float)
    high, low = np.maximum(start, stop), np.minimum(start, stop)
    usable = low > 0
    ratio = np.where(usable, high / np.where(usable, low, 1.0), 2.0)
    log = np.log(ratio)
    close = log < 1e-4
    exact = (high - low) / np.where(close, 1.0, log)
    mean: Floats = np.where(usable & ~close, exact, 0.5 * (start + stop))
    return mean


def layer_columns(altitude: Floats, density: Floats) -> Floats:
    """Integral across each layer of a density (N,) [x m^-3], exponential between levels (N,) [m]: (N-1,) [x m^-2]."""
    column: Floats = mean_exponential(density[:-1], density[1:]) * np.diff(altitude)
    return column


def columns_above(levels: Floats, density: Floats, per_molecule: Floats, altitude: npt.ArrayLike) -> Floats:
    """Integral of density times a property per molecule from altitudes to the highest level, as lines of sight count
    it: between levels the density is exponential and the property linear in altitude.

    Parameters
    ----------
    levels, density, per_molecule : (N,) arrays
        m, m^-3, x per molecule.
    altitude : array_like
        m, any shape; below the lowest level the whole column.

    Returns
    -------
    array, x m^-2
    """
    abscissa, weight = np.polynomial.legendre.leggauss(8)
    log_density, depth = np.log(density), np.diff(levels)

    def upper_part(layer: Integers, passed: Floats) -> Floats:
        """From a share of a layer's depth to its top."""
        remaining = 1.0 - passed
        share = passed[..., None] + remaining[..., None] * 0.5 * (abscissa + 1)
        air = np.exp((1 - share) * log_density[layer][..., None] + share * log_density[layer + 1][..., None])
        value = (1 - share) * per_molecule[layer][..., None] + share * per_molecule[layer + 1][..., None]
        part: Floats = depth[layer] * remaining * (air * value @ (0.5 * weight))
        return part

    layer_columns = upper_part(np.arange(depth.size), np.zeros(depth.size))
    above = np.append(np.cumsum(layer_columns[::-1])[::-1], 0.0)
    inside: Floats = np.clip(np.asarray(altitude, dtype=float), levels[0], levels[-1])
    layer = np.clip(np.searchsorted(levels, inside, side="right") - 1, 0, depth.size - 1)
    column: Floats = above[layer + 1] + upper_part(layer, (inside - levels[layer]) / depth[layer])
    return column


def ozone_factor(altitude: Floats, density: Floats, column: float) -> float:
    """Factor that gives ozone of a number density (N,) [m^-3] a column [DU].

    Raises
    ------
    InputError
        For a column that is negative or not finite, or where there is no ozone to scale.
    """
    present = float(layer_columns(altitude, density).sum()) / DOBSON_UNIT
    if not (np.isfinite(column) and column >= 0):
        raise InputError(f"ozone column {column} DU is not allowed; give a finite number of at least 0")
    if present <= 0:
        raise InputError("the profile has no ozone that could be scaled to a column")
    return column / present


def water_factor(
    altitude: Floats,
    density: Floats,
    fraction: Floats,
    saturated: Floats,
    column: float,
) -> float:
    """Factor that gives water vapour a column, where no level has more than saturated air does.

    Parameters
    ----------
    altitude, density : (N,) arrays
        m; of air, m^-3.
    fraction, saturated : (N,) arrays
        Mole fraction of water vapour, and that at saturation.
    column : float
        kg m^-2.

    Raises
    ------
    InputError
        For a column that is negative or not finite, or that is more than saturated air contains.
    """

    def column_at(factor: float) -> float:
        vapour = density * np.minimum(fraction * factor, saturated)
        return float(layer_columns(altitude, vapour).sum() * WATER_MOLAR_MASS / AVOGADRO)

    if not (np.isfinite(column) and column >= 0):
        raise InputError(f"water column {column} mm is not allowed; give a finite number of at least 0")
    if column == 0:
        return 0.0
    saturated_column = column_at(_LARGEST_FACTOR)
    if column > saturated_column:
        raise InputError(
            f"water column {column:g} mm is more than saturated air of this profile has, {saturated_column:.4g} mm;"
            " give less"
        )
    return float(
        scipy.optimize.brentq(lambda factor: column_at(factor) - column, 0.0, _LARGEST_FACTOR, xtol=1e-12, rtol=1e-12)
    )
