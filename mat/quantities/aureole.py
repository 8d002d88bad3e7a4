"""Circumsolar diffuse sunlight, which an obstacle before the Sun removes.

A beam from the Sun and a sky of uniform brightness approximate the light of the whole sky. The beam has what the
radiative transfer of the state finds within `RADIUS_DEG` of the Sun, above the mean brightness of the rest. By this
radius what walls, buildings and trees before the Sun take is right to a third of the error of an even sky, and of that
of the split of Hay and Davies (1980): `tests/mat/quantities/test_aureole.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.schemas.arrays import Booleans, Floats

RADIUS_DEG = 30.0  # degree from the Sun
DIRECTIONS = Directions.of(8, 12)  # twice as many each way change no share by more than 0.01
_POINTS = 24  # with the most sunlight: 0.8 of all of it; the others change no share by more than 0.014


@dataclass(frozen=True, eq=False)
class SunlitSky:
    """Sunlight from the sky at the ground of a state, by direction, under a Sun at S elevations.

    Attributes
    ----------
    elevation : (S,) array
        Geometric [degree].
    radiance : (S, D, A) array
        Radiance of the upper D cells of zenith angle, by azimuth from the Sun, in the unit of the weights per
        steradian.
    """

    elevation: Floats
    radiance: Floats
    directions: Directions

    @classmethod
    def of(cls, air: SpectralAir, weight: Floats, elevation: Floats, directions: Directions = DIRECTIONS) -> SunlitSky:
        """Compute it.

        Parameters
        ----------
        air : SpectralAir
            Air of a state with the ground's albedo for this light.
        weight : (P,) array
            Weights of the points, times the Sun's irradiance outside the atmosphere.
        elevation : (S,) array
            Geometric elevation of the Sun [degree].
        """
        angle = np.radians(elevation)
        reflection = GroundReflection.of(air, angle)
        phases = cell_phases(air, directions, angle)
        field = RadianceField.at(air, air.state.surface_altitude, angle, reflection, directions, phases)
        radiance = field.scattered[directions.cosine > 0] @ weight
        return cls(np.asarray(elevation, float), np.swapaxes(radiance, 0, 1), directions)

    @property
    def weights(self) -> Floats:
        """Weights of the cells on a level surface, (D, A) [sr]."""
        up = self.directions.cosine > 0
        level = (self.directions.solid_angle * self.directions.cosine[:, None])[up]
        return np.broadcast_to(level, self.radiance.shape[1:])

    @property
    def irradiance(self) -> Floats:
        """Irradiance of a level surface, (S,)."""
        total: Floats = np.sum(self.weights * self.radiance, axis=(1, 2))
        return total

    def within(self, hides: Callable[[Floats, Floats], Booleans]) -> tuple[Floats, Floats]:
        """Share of the irradiance that an obstacle takes, and what it would take of an even sky, (S,) each.

        Parameters
        ----------
        hides : callable
            Whether it hides unit vectors (..., 3) from a Sun in the direction (3,), x being the Sun's azimuth, z up.
        """
        angle = np.radians(self.elevation)
        suns = np.stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)], axis=-1)
        samples = self.directions.samples[self.directions.cosine > 0]
        covered = self.weights * np.stack([hides(samples, sun).mean(axis=-1) for sun in suns])
        even: Floats = covered.sum(axis=(1, 2)) / self.weights.sum()
        light, total = np.sum(covered * self.radiance, axis=(1, 2)), self.irradiance
        return np.divide(light, total, out=even.copy(), where=total > 0), even

    @property
    def aureole(self) -> Floats:
        """Share of the irradiance that comes from around the Sun, (S,).

        With h of it from within `RADIUS_DEG`, of which an even sky would have s: (h - s) / (1 - s).
        """
        share, even = self.within(lambda directions, sun: directions @ sun > np.cos(np.radians(RADIUS_DEG)))
        circumsolar: Floats = np.maximum((share - even) / (1 - even), 0.0)
        return circumsolar


def sunlit_sky(
    state: AtmosphericState, points: SpectralPoints, elevation: Floats, directions: Directions = DIRECTIONS
) -> SunlitSky:
    """The sky of a state by those of the points that have most of the sunlight; arguments as of `SunlitSky.of`.

    The weights of the points have the unit of the irradiance outside the atmosphere.
    """
    strongest = np.sort(np.argsort(points.weight)[-_POINTS:])
    air = SpectralAir.of(state, points.subset(strongest, points.weight[strongest]))
    return SunlitSky.of(air, points.weight[strongest], elevation, directions)
