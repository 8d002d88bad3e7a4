"""Two-stream equations of scattering layers: one layer in closed form, and layers joined by adding from the ground up.

dF+/dt = same F+ - other F- - source, dF-/dt = other F+ - same F- + source for the upward and downward flux F+, F-
against optical depth t counted downwards; the closure (hemispheric mean, Eddington ...) is in the coefficients `same`
and `other`.

References
----------
Toon et al. 1989, J. Geophys. Res. 94, 16287, equations 11 to 25.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import trace


@dataclass(frozen=True, eq=False)
class Slabs:
    """Homogeneous layers, all arrays of one shape.

    Attributes
    ----------
    decay : array
        Diffusion exponent per optical depth.
    deep : array
        Reflection of an infinitely deep layer.
    left : array
        exp(-decay * depth).
    """

    depth: np.ndarray
    decay: np.ndarray
    deep: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, same, other, depth):
        """Layers of two-stream coefficients and optical depths; `same` must be above `other` (a little absorption)."""
        decay = np.sqrt((same - other) * (same + other))
        return cls(depth, decay, other / (same + decay), np.exp(-decay * depth))

    @property
    def reflection(self):
        """Share of diffuse flux sent back."""
        return -self.deep * np.expm1(-2 * self.decay * self.depth) / (1 - (self.deep * self.left) ** 2)

    @property
    def transmission(self):
        """Share of diffuse flux let through."""
        return (1 - self.deep**2) * self.left / (1 - (self.deep * self.left) ** 2)


def vertical_column(shells, per_molecule):
    """Integral of a property (N, P) [m^2 per molecule] across each layer, (N-1, P)."""
    return np.add(*vertical_parts(shells, per_molecule))


def vertical_parts(shells, per_molecule):
    """The two parts of `vertical_column`: what counts by the property of the layer's lower level, and of its upper
    one.
    """
    zenith = trace(shells, shells.altitude[:1], np.array([np.pi / 2]))
    count = shells.altitude.size - 1
    lower, upper = (part[0, count:, None] for part in (zenith.lower, zenith.upper))  # the segments on the way up
    return lower * per_molecule[:-1], upper * per_molecule[1:]


def join(reflection, transmission, upward, downward, albedo, ground):
    """Fluxes at the levels between layers, none entering from above.

    Parameters
    ----------
    reflection, transmission : (N-1, ...) arrays
        Of the layers, from the ground up.
    upward, downward : (N-1, ...) arrays
        Flux each layer sends out by itself at its top and bottom.
    albedo : float
        Of the ground.
    ground : array
        Flux the ground sends up by itself.

    Returns
    -------
    rising, falling : (N, ...) arrays
    """
    count = len(reflection)
    below = np.empty((count + 1, *reflection.shape[1:]))  # albedo of all that lies under a level
    source = np.empty((count + 1, *upward.shape[1:]))  # what it sends up by itself
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
