"""Two-stream equations of scattering layers: one layer in closed form, and layers joined by adding from the ground up.

dF+/dtau = gamma1 F+ - gamma2 F- - S+ and dF-/dtau = gamma2 F+ - gamma1 F- + S- for the upward and downward flux F+, F-
against optical depth tau counted downwards. The closure (hemispheric mean, Eddington ...) is in gamma1 and gamma2.

References
----------
Toon et al. 1989, J. Geophys. Res. 94, 16287, equations 11 to 25; the letters are theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class TwoStreamLayers:
    """Homogeneous layers, all arrays of one shape.

    Attributes
    ----------
    tau : array
        Optical depth.
    lambda_ : array
        Diffusion exponent per optical depth, equation 21.
    Gamma : array
        Reflection of an infinitely deep layer, equation 22.
    exp_lambda_tau : array
        exp(-lambda tau).
    """

    tau: Floats
    lambda_: Floats
    Gamma: Floats
    exp_lambda_tau: Floats

    @classmethod
    def of(cls, gamma1: Floats, gamma2: Floats, tau: Floats) -> TwoStreamLayers:
        """Layers of two-stream coefficients and optical depths; gamma1 must be above gamma2 (some absorption)."""
        lambda_ = np.sqrt((gamma1 - gamma2) * (gamma1 + gamma2))
        return cls(tau, lambda_, gamma2 / (gamma1 + lambda_), np.exp(-lambda_ * tau))

    @property
    def reflection(self) -> Floats:
        """Fraction of diffuse flux that a layer reflects."""
        reflection: Floats = (
            -self.Gamma * np.expm1(-2 * self.lambda_ * self.tau) / (1 - (self.Gamma * self.exp_lambda_tau) ** 2)
        )
        return reflection

    @property
    def transmission(self) -> Floats:
        """Fraction of diffuse flux that a layer transmits."""
        transmission: Floats = (1 - self.Gamma**2) * self.exp_lambda_tau / (1 - (self.Gamma * self.exp_lambda_tau) ** 2)
        return transmission


def add_layers(
    reflection: Floats, transmission: Floats, upward: Floats, downward: Floats, albedo: float, ground: Floats
) -> tuple[Floats, Floats]:
    """Fluxes at the levels between layers, none entering from above.

    Parameters
    ----------
    reflection, transmission : (N-1, ...) arrays
        Of the layers, from the ground up.
    upward, downward : (N-1, ...) arrays
        Flux that each layer itself sends out at its top and bottom.
    albedo : float
        Of the ground.
    ground : array
        Flux that the ground itself sends up.

    Returns
    -------
    rising, falling : (N, ...) arrays
    """
    count = len(reflection)
    below = np.empty((count + 1, *reflection.shape[1:]))  # albedo of everything under a level
    source = np.empty((count + 1, *upward.shape[1:]))  # flux that everything under a level sends up
    below[0], source[0] = albedo, ground
    for k in range(count):
        bounce = transmission[k] / (1 - reflection[k] * below[k])
        below[k + 1] = reflection[k] + transmission[k] * bounce * below[k]
        source[k + 1] = upward[k] + bounce * (source[k] + below[k] * downward[k])
    falling = np.zeros_like(source)
    for k in range(count - 1, -1, -1):
        arriving = transmission[k] * falling[k + 1] + downward[k] + reflection[k] * source[k]
        falling[k] = arriving / (1 - reflection[k] * below[k])
    return source + below * falling, falling
