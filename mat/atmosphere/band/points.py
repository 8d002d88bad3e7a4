"""The spectral points of a band with their weights, before any are chosen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

# Samples of the response inside an interval.
_RESPONSE_SAMPLES = 200


@dataclass(frozen=True, eq=False)
class BandPoints:
    """Spectral points of a band, with the sensor's response in their weights.

    Attributes
    ----------
    points : SpectralPoints
    weight : (P,) array
        um; sum(weight) is the integral of phi dlambda, and sum(weight * f) that of phi f dlambda.
    gases : tuple of str or None
        Absorbing gases that are taken into account; None for all.
    """

    points: SpectralPoints
    weight: Floats
    gases: tuple[str, ...] | None = None

    @property
    def wavenumber(self) -> Floats:
        """Middle of each point's interval, (P,) cm^-1."""
        wavenumber: Floats = self.points.interval_edges.mean(axis=1)[self.points.interval]
        return wavenumber

    @property
    def width(self) -> Floats:
        """Width of each point's interval, (P,) cm^-1."""
        width: Floats = np.diff(self.points.interval_edges, axis=1)[self.points.interval, 0]
        return width

    @property
    def radiance_weight(self) -> Floats:
        """(P,) cm^-1; sum(radiance_weight * radiance per cm^-1) is the band's radiance."""
        return self.weight * self.wavenumber**2 * 1e-4


def band_points(points: SpectralPoints, response: SpectralResponse) -> BandPoints:
    """All points of a band.

    Parameters
    ----------
    points : SpectralPoints
        Points of every interval that the response overlaps.
    response : SpectralResponse

    Returns
    -------
    BandPoints
        The points whose interval has a response above 0.

    Raises
    ------
    InputError
        If the response is 0 in all of them.
    """
    low, high = points.interval_edges.T
    seen_low, seen_high = low, high
    band_low, band_high = response.wavenumber_range
    if band_high - band_low < np.max(high - low):
        # Samples of a whole interval would miss a band narrower than it, or meet it a few times.
        seen_low, seen_high = np.clip(band_low, low, high), np.clip(band_high, low, high)
    seen = seen_high - seen_low
    sample = seen_low[:, None] + seen[:, None] * (np.arange(_RESPONSE_SAMPLES) + 0.5) / _RESPONSE_SAMPLES
    # Points of an interval stand for its distribution of absorption, not for their own place: each sees the interval's
    # mean.
    micron = np.mean(response.at_wavenumber(sample) * 1e4 / sample**2, axis=1) * (seen / (high - low))
    weight = points.weight * micron[points.interval]
    inside = np.flatnonzero(weight > 0)
    if not inside.size:
        raise InputError(
            "the response is 0 in every interval of these spectral points; ask for the points of its own range"
        )
    points = points.subset(inside)
    return BandPoints(points, weight[inside], tuple(points.absorbing))
