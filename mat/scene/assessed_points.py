"""A few hundred points of a band, with which `mat check` assesses what a build computes at all of them."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints, band_points, micron_response, point_weights
from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.schemas.arrays import Integers

COUNT = 400  # spectral points, evenly among all


def assessed_points(response: SpectralResponse, water_continuum: str | None = None) -> BandPoints:
    """At most `COUNT` points of a band, evenly among those of the table, with the weight of all.

    Where a response cuts intervals of the table, these points count the lines of all of the interval: good for bounds,
    not for tables.
    """
    chosen = _chosen(response.wavelength.tobytes(), response.response.tobytes())
    return replace(chosen, points=absorption_table(water_continuum).in_continuum(chosen.points))


@lru_cache(maxsize=16)
def _chosen(wavelength: bytes, values: bytes) -> BandPoints:
    """The points in the table's own continuum."""
    response = SpectralResponse(np.frombuffer(wavelength), np.frombuffer(values))
    table = absorption_table().with_continuum()

    def evenly(points: SpectralPoints) -> Integers:
        inside = np.flatnonzero(point_weights(points, response) > 0)
        chosen: Integers = inside[np.linspace(0, inside.size - 1, min(inside.size, COUNT)).round().astype(int)]
        return chosen

    band = band_points(table.points(*response.wavenumber_range, evenly), response)
    low, high = band.points.interval_edges.T
    total = float(micron_response(response, low, high - low) @ (high - low))
    return replace(band, weight=band.weight * (total / band.weight.sum()))
