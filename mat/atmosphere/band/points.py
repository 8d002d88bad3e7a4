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


@dataclass(frozen=True)
class LineByLineError:
    """Error of a band's points against line-by-line spectra on paths through standard atmospheres.

    Attributes
    ----------
    transmittance_rms, transmittance_max : float
        Root mean square that another atmosphere is below with a likelihood of 95 %; largest error of all.
    radiance_rms, radiance_max : float
        The same of thermal path radiance, over that of a black body as warm as the warmest air.
    """

    transmittance_rms: float
    radiance_rms: float
    transmittance_max: float
    radiance_max: float

    @property
    def text(self) -> str:
        """As files state it."""
        return (
            f"transmittance {self.transmittance_rms:.1e} rms, {self.transmittance_max:.1e} at most; thermal path"
            f" radiance {self.radiance_rms:.1e} rms, {self.radiance_max:.1e} at most of a black body's"
        )


@dataclass(frozen=True, eq=False)
class BandPoints:
    """Spectral points of a band, with the sensor's response in their weights.

    Attributes
    ----------
    weight : (P,) array
        um; sum(weight) is the integral of phi dlambda, and sum(weight * f) that of phi f dlambda.
    gases : tuple of str or None
        Absorbing gases that are taken into account; None for all.
    line_by_line : LineByLineError or None
        Error of all points of the band, where there are spectra to compare with.
    """

    points: SpectralPoints
    weight: Floats
    gases: tuple[str, ...] | None = None
    line_by_line: LineByLineError | None = None

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


def micron_response(
    response: SpectralResponse, low: Floats, width: float | Floats, samples: int = _RESPONSE_SAMPLES
) -> Floats:
    """Mean of a response over intervals that begin at `low` (I,) [cm^-1], in um per cm^-1."""
    # Samples of a whole interval would miss the ends of a band inside it, or meet them a few times.
    lower, upper = (np.clip(end, low, low + width) for end in response.wavenumber_range)
    covered = upper - lower
    sample = lower[:, None] + covered[:, None] * (np.arange(samples) + 0.5) / samples
    micron: Floats = np.mean(response.at_wavenumber(sample) * 1e4 / sample**2, axis=1) * (covered / width)
    return micron


def point_weights(points: SpectralPoints, response: SpectralResponse) -> Floats:
    """Weights (P,) of points in a band [um]; 0 where an interval has no response."""
    low, high = points.interval_edges.T
    # Points of an interval represent its distribution of absorption, not their own place: each has the interval's mean.
    weight: Floats = points.weight * micron_response(response, low, high - low)[points.interval]
    return weight


def band_points(points: SpectralPoints, response: SpectralResponse) -> BandPoints:
    """All points of a band.

    Parameters
    ----------
    points : SpectralPoints
        Points of every interval that the response overlaps.

    Returns
    -------
    BandPoints
        The points whose interval has a response above 0.

    Raises
    ------
    InputError
        If the response is 0 in all of them.
    """
    weight = point_weights(points, response)
    inside = np.flatnonzero(weight > 0)
    if not inside.size:
        raise InputError(
            "the response is 0 in every interval of these spectral points; ask for the points of its own range"
        )
    points = points.subset(inside)
    return BandPoints(points, weight[inside], tuple(points.absorbing))
