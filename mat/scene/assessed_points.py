"""A few hundred points of a band, with which `mat check` assesses what a build computes at all of them."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints, band_points
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table

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
    table = absorption_table().with_own_continuum()
    everything = band_points(table.points(*response.wavenumber_range), response)
    count = everything.weight.size
    index = np.unique(np.linspace(0, count - 1, min(count, COUNT)).round().astype(int))
    weight = everything.weight[index] * (everything.weight.sum() / everything.weight[index].sum())
    points = everything.points.subset(index)
    return BandPoints(points, weight, tuple(points.absorbing))
