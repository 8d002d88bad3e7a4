"""The points of a band at which scattered light of a source is computed, with their weights in the band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.schemas.arrays import Floats, Integers

_WORST = 5.0  # times the allowed rms error, which no single row may exceed


@dataclass(frozen=True, eq=False)
class ScatteringPoints:
    """K of a band's points that give scattered light in the band.

    Attributes
    ----------
    air : SpectralAir
        Air at these points.
    index : (K,) int array
        Their places among the points of the band.
    weight : (K,) array
        W m^-2; the sum of weight times light per unit of irradiance [sr^-1] is that in the band.
    """

    air: SpectralAir
    index: Integers
    weight: Floats

    @classmethod
    def every(cls, air: SpectralAir, band: BandPoints, irradiance: Floats) -> ScatteringPoints:
        """All points, under the irradiance (P,) of a source [W m^-2 (cm^-1)^-1]."""
        return cls(air, np.arange(irradiance.size), band.radiance_weight * irradiance)

    def fewest(self, light: Floats, allowed: float) -> ScatteringPoints:
        """The fewest of these points that give the light of sample lines in the band; none where it is too faint.

        They are chosen by QR with pivoting; their weights, 0 or above, by least squares.

        Parameters
        ----------
        light : (n, K) array
            Light at the points, per unit of irradiance, sr^-1. Rows with odd numbers are for testing only.
        allowed : float
            Root mean square error on the rows that only test, W m^-2 sr^-1; the largest is within `_WORST` times.
        """
        parts = light * self.weight
        fit, test = parts[::2], parts[1::2]
        if not (np.any(fit > 0) and len(test)):
            return self
        order = scipy.linalg.qr(fit, mode="r", pivoting=True)[1]
        scale = float(np.abs(fit).max())  # moonlight is too faint for the thresholds of least squares
        for count in range(self.index.size):
            chosen = np.sort(order[:count])
            factor = scipy.optimize.nnls(fit[:, chosen] / scale, fit.sum(axis=1) / scale)[0] if count else np.zeros(0)
            error = test[:, chosen] @ factor - test.sum(axis=1)
            if np.sqrt(np.mean(error**2)) <= allowed and np.abs(error).max() <= _WORST * allowed:
                return ScatteringPoints(self.air.part(chosen), self.index[chosen], self.weight[chosen] * factor)
        return self

    def depths(self, depths: Depths) -> Depths:
        """Optical depths of segments at these points, of those at all points of the band."""
        if self.index.size == depths.per_segment.shape[1]:
            return depths
        return Depths(np.ascontiguousarray(depths.per_segment[:, self.index]), depths.starts)
