"""Transmittance of the light that surfaces emit: weighted by emissivity and Planck's law, for classes of materials,
equation (5).

A band mean of transmittance over wavelength alone is wrong for emitted light wherever transmittance and emission vary
together. With tau weighted by phi (1 - rho) L_bb, and (1 - rho) weighted by phi L_bb, equation (6) is the integral (5).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer import line_of_sight
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.quantities.formulas import beta_star, mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.schemas.arrays import Booleans, Floats, Integers


def emission_weights(band: BandPoints, reflectance: Floats, temperature: float) -> Floats:
    """Share of each spectral point in the light that materials emit into a band, (M, P), each row of sum 1.

    Parameters
    ----------
    band : BandPoints
        All points of the band: compiled ones stand for absorption alone.
    reflectance : (M, P) array
        At the points; a material that reflects everything counts as black.
    temperature : float
        K, above 0.
    """
    blackbody = band.radiance_weight * planck_wavenumber(band.wavenumber, temperature)
    emitted = (1.0 - reflectance) * blackbody
    emitted[emitted.sum(axis=1) <= 0.0] = blackbody
    weights: Floats = emitted / emitted.sum(axis=1, keepdims=True)
    return weights


@dataclass(frozen=True, eq=False)
class EmissionClasses:
    """Classes of materials whose emitted light the air transmits alike.

    Attributes
    ----------
    number : (M,) int array
        Class of each material, counted from 1 in the order of their first materials.
    difference : (M,) array
        Largest difference of a material's transmittance from its class's on the lines of sight it was grouped by.
    """

    number: Integers
    difference: Floats

    @classmethod
    def of(cls, transmittance: Floats, tolerance: float) -> EmissionClasses:
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
        distance = np.array(
            [np.abs(transmittance - column[:, None]).max(axis=0, initial=0.0) for column in transmittance.T]
        )
        labels = (
            fcluster(linkage(squareform(distance, checks=False), "complete"), tolerance, "distance")
            if count > 1
            else np.ones(1, int)
        )
        order = {label: place for place, label in enumerate(dict.fromkeys(labels.tolist()), 1)}
        number = np.array([order[label] for label in labels.tolist()])
        difference = np.empty(count)
        for of_class in range(1, len(order) + 1):
            inside = number == of_class
            mean = transmittance[:, inside].mean(axis=1, keepdims=True)
            difference[inside] = np.abs(transmittance[:, inside] - mean).max(axis=0, initial=0.0)
        return cls(number, difference)

    @property
    def count(self) -> int:
        """Number of classes, C."""
        return int(self.number.max())

    def means(self, values: Floats) -> Floats:
        """Means (C, ...) over the materials of each class, of values (M, ...)."""
        return np.array([values[self.number == number].mean(axis=0) for number in range(1, self.count + 1)])


def lines_of_sight(
    air: SpectralAir, range_km: Floats, altitude_km: Floats, elevation_deg: Floats
) -> Iterator[LineOfSight]:
    """`line_of_sight.lines_of_sight` of ranges (n, R) [km] from observers at altitudes (n,) [km] and elevations (n,)
    [degree].
    """
    ranges, altitude, elevation = np.asarray(range_km) * 1e3, np.asarray(altitude_km) * 1e3, np.radians(elevation_deg)
    return line_of_sight.lines_of_sight(air, ranges, altitude, elevation)


def emission_beta_star(air: SpectralAir, path: LineOfSight, weights: Floats) -> Floats:
    """beta* [km] of each range of a line of sight for weights (K, P), (R, K), equation (8).

    Its limit at a range of 0; behind the ground as through the air above it: the rules of `formulas.beta_star`.
    """
    ln_tau, _ = mean_transmittance(path.depth + path.depth_behind(air), weights)
    return beta_star((path.length + path.beyond)[:, None], ln_tau, weights @ path.local_extinction)


def beta_star_table(air: SpectralAir, grid: PathGrid, weights: Floats) -> tuple[Floats, Booleans]:
    """beta* [km] for weights (K, P) on the path axes of a grid, (K, R, A, E), and whether the range ends in air, (R, A,
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
