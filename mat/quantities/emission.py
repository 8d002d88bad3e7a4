"""Transmittance of the light that surfaces emit: weighted by emissivity and Planck's law, for classes of materials,
equation (5).

A band mean of transmittance over wavelength alone is wrong for emitted light wherever transmittance and emission vary
together. With tau weighted by phi (1 - rho) L_bb, and (1 - rho) weighted by phi L_bb, equation (6) is the integral (5).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform
from scipy.special import logsumexp

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import trace
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.quantities.formulas import beta_star
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import planck_wavenumber

# Below this a sum of transmittances over the largest of them is taken again from logarithms.
_UNDERFLOW = 1e-280


def emission_weights(band: BandPoints, reflectance: np.ndarray, temperature: float) -> np.ndarray:
    """Share of each spectral point in what materials emit into a band, (M, P), each row of sum 1.

    Parameters
    ----------
    band : BandPoints
        All points of the band: compiled ones stand for absorption alone.
    reflectance : (M, P) array
        At the points; a material that reflects everything counts as black.
    temperature : float
        K, above 0.
    """
    glow = band.radiance_weight * planck_wavenumber(band.wavenumber, temperature)
    emitted = (1.0 - reflectance) * glow
    dark = emitted.sum(axis=1) <= 0.0
    emitted[dark] = glow
    return emitted / emitted.sum(axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class EmissionClasses:
    """Materials whose emitted light the same air lets through alike.

    Attributes
    ----------
    number : (M,) int array
        Class of each material, counted from 1 in the order of their first materials.
    difference : (M,) array
        Largest difference of a material's transmittance from its class's on the lines of sight it was grouped by.
    """

    number: np.ndarray
    difference: np.ndarray

    @classmethod
    def of(cls, transmittance: np.ndarray, tolerance: float) -> EmissionClasses:
        """Group materials so that no two of a class differ by more than a tolerance; a class has the mean of its
        materials.

        Parameters
        ----------
        transmittance : (n, M) array
            Of each material's emitted light, on n paths and temperatures.
        tolerance : float
            Of transmittance.
        """
        count = transmittance.shape[1]
        apart = np.array([np.abs(transmittance - one[:, None]).max(axis=0, initial=0.0) for one in transmittance.T])
        found = (
            fcluster(linkage(squareform(apart, checks=False), "complete"), tolerance, "distance")
            if count > 1
            else np.ones(1, int)
        )
        order = {label: place for place, label in enumerate(dict.fromkeys(found.tolist()), 1)}
        number = np.array([order[label] for label in found.tolist()])
        difference = np.empty(count)
        for one in range(1, len(order) + 1):
            inside = number == one
            mean = transmittance[:, inside].mean(axis=1, keepdims=True)
            difference[inside] = np.abs(transmittance[:, inside] - mean).max(axis=0, initial=0.0)
        return cls(number, difference)

    @property
    def count(self) -> int:
        return int(self.number.max())

    def means(self, values: np.ndarray) -> np.ndarray:
        """Means (C, ...) over the materials of each class, of values (M, ...)."""
        return np.array([values[self.number == one].mean(axis=0) for one in range(1, self.count + 1)])


def lines_of_sight(
    air: SpectralAir, range_km: np.ndarray, altitude_km: np.ndarray, elevation_deg: np.ndarray
) -> Iterable[LineOfSight]:
    """The lines of sight from n observers to the ranges (n, R) of each, one after the other."""
    ranges, altitude, elevation = np.asarray(range_km) * 1e3, np.asarray(altitude_km) * 1e3, np.radians(elevation_deg)
    rays = trace(air.shells, altitude, elevation, ranges)
    for row in range(altitude.size):
        yield LineOfSight.of(air, rays, row, altitude[row], elevation[row], ranges[row])


def ln_transmittance(depth: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Logarithm of transmittance (R, K) of optical depths (R, P) for weights (K, P) of sum 1: exact near 0 and near
    1.
    """
    absorbed = -np.expm1(-depth) @ weights.T
    least = depth.min(axis=1, keepdims=True)
    seen = np.exp(least - depth) @ weights.T
    with np.errstate(divide="ignore"):
        thick = np.log(seen) - least
    for path, kind in np.argwhere(seen < _UNDERFLOW):
        thick[path, kind] = logsumexp(-depth[path], b=weights[kind])
    return np.where(absorbed < 0.5, np.log1p(-np.minimum(absorbed, 0.5)), thick)


def emission_beta_star(air: SpectralAir, path: LineOfSight, weights: np.ndarray) -> np.ndarray:
    """beta* [km] of each range of a line of sight for weights (K, P), (R, K), equation (8).

    Where the range is 0, its limit; behind the ground, as through the air above it: the rules of the classic beta*.
    """
    ln_tau = ln_transmittance(path.depth + path.depth_behind(air), weights)
    return beta_star((path.length + path.beyond)[:, None], ln_tau, weights @ path.local_extinction)


def beta_star_table(air: SpectralAir, grid: PathGrid, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """beta* [km] for weights (K, P) on the path axes of a grid, (K, R, A, E), and where the range ends in air, (R, A,
    E).
    """
    shape = grid.shape[:3]
    beta, valid = np.empty((len(weights), *shape)), np.empty(shape, dtype=bool)
    reach = np.broadcast_to(grid.range_km, (shape[2], shape[0]))
    for place, altitude in enumerate(grid.altitude_km):
        for row, path in enumerate(lines_of_sight(air, reach, np.full(shape[2], altitude), grid.elevation_deg)):
            beta[:, :, place, row] = emission_beta_star(air, path, weights).T
            valid[:, place, row] = path.valid
    return beta, valid
