"""Sizes of errors: as equivalent temperature, and as mean, rms, percentiles and maximum."""

from __future__ import annotations

import numpy as np

from skyshine.mat.budget.budget import Budget
from skyshine.mat.radiometry.blackbody import SpectralResponse, brightness_temperature
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST
from skyshine.schemas.arrays import Floats

RADIANCE = "W m^-2 sr^-1"
FEWEST = 200  # errors of which a 95th or 99th percentile is given: two of them lie beyond the latter


def kelvin(budget: Budget, error: Floats) -> Floats:
    """Errors of radiance as differences of equivalent blackbody temperature, K; not a number below 2.5 um."""
    return kelvin_of(budget.response, budget.radiance[..., None] if error.ndim == 3 else budget.radiance, error)


def kelvin_of(response: SpectralResponse, radiance: Floats, error: Floats) -> Floats:
    """Errors of a radiance [W m^-2 sr^-1] as differences of equivalent blackbody temperature, K; not a number below
    2.5 um.
    """
    if response.upper < SHORTEST:
        return np.full(error.shape, np.nan)
    with_error = brightness_temperature(response, np.maximum(radiance + error, 0.0))
    return with_error - brightness_temperature(response, radiance)


def in_kelvin(budget: Budget) -> bool:
    """Whether the band's radiances have an equivalent temperature of use."""
    return budget.response.upper >= SHORTEST


def measures(values: Floats, weight: Floats | None = None) -> dict[str, float]:
    """Mean, rms, 95th and 99th percentile and largest size of errors, each counted by its weight."""
    size = np.abs(values).ravel()
    share = np.ones(size.size) if weight is None else np.broadcast_to(weight, values.shape).ravel()
    order = np.argsort(size)
    reached = np.cumsum(share[order]) / share.sum()
    return {
        "mean": float(np.sum(values.ravel() * share) / share.sum()),
        "rms": float(np.sqrt(np.sum(size**2 * share) / share.sum())),
        **{
            f"p{percent}": float(size[order][min(int(np.searchsorted(reached, percent / 100)), size.size - 1)])
            for percent in (95, 99)
        },
        "maximum": float(size[share > 0].max()),
    }


def reported(values: Floats, weight: Floats | None = None) -> dict[str, float]:
    """`measures` without percentiles, not a number, where fewer than `FEWEST` errors count."""
    sizes = measures(values, weight)
    count = values.size if weight is None else np.count_nonzero(np.broadcast_to(weight, values.shape))
    return sizes if count >= FEWEST else sizes | {"p95": np.nan, "p99": np.nan}
