"""A layer of aerosol of its own, beside the models of the column."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.particles import SpectralModel
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

LARGEST_OPTICAL_DEPTH = 100.0  # vertical
HIGHEST = 80e3  # m above the ground
THINNEST = 20.0  # m
SCALE_HEIGHTS = (50.0, 20e3)  # m
# Base and top fade out over this part of the thickness, at most this far, m.
_EDGE_SHARE, _EDGE = 0.05, 50.0
_END = 10.0  # m beyond the heights of a profile in which it ends
# Scale heights at which levels are placed, between which extinction is linear.
_LEVELS = (0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)


@dataclass(frozen=True, eq=False)
class AerosolLayer:
    """Particles of one kind over a profile of extinction.

    Attributes
    ----------
    model : AerosolModel or SpectralModel
    height : (K,) array
        Above the ground, m, increasing.
    extinction : (K,) array
        Extinction at 0.55 um, linear between the heights, 0 beyond the last and, unless the first is the ground, below
        it.
    optical_depth : float or None
        Vertical, at 0.55 um, to which the profile is scaled; None for a profile in m^-1.
    """

    model: AerosolModel | SpectralModel
    height: Floats
    extinction: Floats
    optical_depth: float | None

    def __post_init__(self) -> None:
        depth = self.optical_depth
        if depth is not None and not 0 <= depth <= LARGEST_OPTICAL_DEPTH:
            raise InputError(f"optical depth {depth:g} of an aerosol layer is outside 0 to {LARGEST_OPTICAL_DEPTH:g}")
        if not (np.all(np.diff(self.height) > 0) and self.height[0] >= 0 and self.height[-1] <= HIGHEST + _END):
            raise InputError(f"heights of an aerosol layer must rise from 0 to {HIGHEST / 1e3:g} km at most")

    @classmethod
    def even(cls, model: AerosolModel | SpectralModel, bottom: float, top: float, optical_depth: float) -> AerosolLayer:
        """The same extinction between two heights [m]."""
        if not (bottom >= 0 and bottom + THINNEST <= top <= HIGHEST):
            raise InputError(
                f"aerosol layer from {bottom / 1e3:g} to {top / 1e3:g} km above the ground is not allowed; give a"
                f" bottom of at least 0 and a top at least {THINNEST / 1e3:g} km higher, at most {HIGHEST / 1e3:g} km"
            )
        fade = min(_EDGE, _EDGE_SHARE * (top - bottom))
        below = ([bottom, bottom + fade], [0.0, 1.0]) if bottom > 0 else ([0.0], [1.0])
        height, extinction = [*below[0], top - fade, top], [*below[1], 1.0, 0.0]
        return cls(model, np.array(height), np.array(extinction), optical_depth)

    @classmethod
    def exponential(
        cls, model: AerosolModel | SpectralModel, scale_height: float, optical_depth: float
    ) -> AerosolLayer:
        """Extinction that falls from the ground on, to 1/e in a scale height [m]."""
        low, high = SCALE_HEIGHTS
        if not low <= scale_height <= high:
            raise InputError(
                f"scale height {scale_height / 1e3:g} km of an aerosol layer is outside {low / 1e3:g} to"
                f" {high / 1e3:g} km"
            )
        height = np.append(0.0, scale_height * np.array(_LEVELS))
        height = height[height <= HIGHEST]
        extinction = np.exp(-height / scale_height)
        return cls(model, height, np.append(extinction[:-1], 0.0), optical_depth)

    @classmethod
    def measured(
        cls, model: AerosolModel | SpectralModel, height: Floats, extinction: Floats, optical_depth: float | None
    ) -> AerosolLayer:
        """Extinction [m^-1] at heights above the ground [m] that increase; it ends within 10 m beyond them."""
        if height[0] > 0 and extinction[0] > 0:
            height = np.append(max(height[0] - _END, 0.5 * height[0]), height)
            extinction = np.append(0.0, extinction)
        if extinction[-1] > 0:
            height, extinction = np.append(height, height[-1] + _END), np.append(extinction, 0.0)
        return cls(model, height, extinction, optical_depth)

    @property
    def edges(self) -> tuple[float, ...]:
        """Heights above the ground at which levels must be, m."""
        return tuple(map(float, self.height))

    def extinction_550(self, height: npt.ArrayLike) -> Floats:
        """At heights above the ground [m], of the profile as it is given."""
        below = self.extinction[0] if self.height[0] == 0 else 0.0
        profile: Floats = np.interp(np.asarray(height, dtype=float), self.height, self.extinction, below, 0.0)
        return profile
