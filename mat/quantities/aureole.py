"""Circumsolar diffuse sunlight, which an obstacle before the Sun removes.

A beam from the Sun and a sky of uniform brightness approximate the light of the whole sky. The beam has what the
radiative transfer of the state finds within `RADIUS_DEG` of the Sun, above the mean brightness of the rest. By this
radius what walls, buildings and trees before the Sun take is right to a third of the error of an even sky, and of that
of the split of Hay and Davies (1980): `tests/mat/quantities/test_aureole.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.schemas.arrays import Booleans, Floats, Integers

RADIUS_DEG = 30.0  # degree from the Sun
DIRECTIONS = Directions.of(8, 12)  # twice as many each way change no share by more than 0.01
_POINTS = 24  # with the most sunlight: 0.8 of all of it; the others change no share by more than 0.014
# Azimuthal moments of light scattered more than once; six, and spherical layers under a low Sun, change no share by
# more than 0.003. Degrees by which the Sun is lower or higher at the far end of long lines.
_AZIMUTHAL, _FARTHEST = 3, 2.0


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


def strongest(weight: Floats, count: int) -> Integers:
    """Places of so many points that have most of the sunlight, by their weights (P,)."""
    return np.sort(np.argsort(weight)[-count:])


def sunlit_sky(air: SpectralAir, weight: Floats, elevation: Floats, directions: Directions = DIRECTIONS) -> SunlitSky:
    """The sky of an air by those of its points that have most of the sunlight; arguments as of `SunlitSky.of`."""
    few, ends = strongest(weight, _POINTS), (np.min(elevation) - _FARTHEST, min(np.max(elevation) + _FARTHEST, 90.0))
    solved = tuple(np.unique([*elevation, *ends]).tolist())
    reduced = replace(air.part(few), elevations=solved, azimuthal=_AZIMUTHAL, spherical=False)
    return SunlitSky.of(reduced, weight[few], elevation, directions)
