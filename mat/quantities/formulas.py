"""beta* and the band mean of transmittance: equations (8) and (9) of DSTO-TN-0193."""

from __future__ import annotations

import numpy as np

# Exponent of equations (8) and (9).
BETA_FACTOR = 5.5


# Largest beta*, where the path holds no air or next to none: transmittance is right to 5.5e-12 per km.
BETA_CAP_KM = 1e12


def beta_star(length, ln_tau, extinction):
    """beta* [km], equation (8), at most `BETA_CAP_KM`; arguments broadcast against each other.

    Parameters
    ----------
    length : array
        Of the path, m; what is behind the ground counts as going on through the air above it, so that beta* of
        neighbours in a table differ no more than their lines do.
    ln_tau : array
        Logarithm of its transmittance.
    extinction : array
        Of the air at the observer, m^-1: where the length is 0, beta* is the limit.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        beta = np.where(length > 0, BETA_FACTOR * length / np.abs(ln_tau), BETA_FACTOR / extinction) * 1e-3
    return np.minimum(beta, BETA_CAP_KM)


def band_transmittance(depth, weight):
    """ln(transmittance) and 1 - transmittance of a band, both (R,), from optical depths (R, P): exact near 0 and near
    1.
    """
    absorbed = -np.expm1(-depth) @ weight / weight.sum()
    least = depth.min(axis=1)
    thick = np.log(np.exp(least[:, None] - depth) @ weight / weight.sum()) - least
    return np.where(absorbed < 0.5, np.log1p(-np.minimum(absorbed, 0.5)), thick), absorbed
