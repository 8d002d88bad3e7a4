"""beta* and the band mean of transmittance: equations (8) and (9) of DSTO-TN-0193."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.schemas.arrays import Floats, Reals

# Exponent of equations (8) and (9).
BETA_FACTOR = 5.5
# Largest beta*, of paths with little or no air: transmittance is then exact to 5.5e-12 per km.
BETA_CAP_KM = 1e12
# Below this a mean of transmittances over the largest of them is computed from logarithms.
_UNDERFLOW = 1e-280


def beta_star(length: npt.ArrayLike, ln_tau: Floats, extinction: npt.ArrayLike) -> Floats:
    """beta* [km], equation (8), at most `BETA_CAP_KM`; arguments broadcast against each other.

    Parameters
    ----------
    length : array
        Length of the path, m; behind the ground it continues through the air above the ground, so that beta* of
        neighbours in a table differs no more than their lines do.
    ln_tau : array
        Logarithm of its transmittance.
    extinction : array
        Extinction of the air at the observer, m^-1: the limit of beta* at a length of 0.
    """
    length, extinction = np.asarray(length), np.asarray(extinction)
    with np.errstate(divide="ignore", invalid="ignore"):
        beta = np.where(length > 0, BETA_FACTOR * length / np.abs(ln_tau), BETA_FACTOR / extinction) * 1e-3
    capped: Floats = np.minimum(beta, BETA_CAP_KM)
    return capped


def mean_transmittance(depth: Reals, weights: Floats, total: float = 1.0) -> tuple[Floats, Floats]:
    """Weighted mean of transmittance: ln(transmittance) and 1 - transmittance, exact near 0 and near 1.

    Parameters
    ----------
    depth : (R, P) array
        Optical depths.
    weights : (P,) or (K, P) array
    total : float
        Sum of each row of the weights.

    Returns
    -------
    ln_transmittance, absorptance : (R,) or (R, K) arrays
    """
    absorptance: Floats = -np.expm1(-depth) @ weights.T / total
    smallest = depth.min(axis=1, keepdims=True)
    relative = np.exp(smallest - depth) @ weights.T / total
    if weights.ndim == 1:
        smallest = smallest[:, 0]
    with np.errstate(divide="ignore"):
        thick = np.log(relative) - smallest
    for path, *kind in np.argwhere(relative < _UNDERFLOW):
        thick[path, *kind] = scipy.special.logsumexp(-depth[path], b=weights[tuple(kind)]) - np.log(total)
    return np.where(absorptance < 0.5, np.log1p(-np.minimum(absorptance, 0.5)), thick), absorptance
