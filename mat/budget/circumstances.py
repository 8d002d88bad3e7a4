"""Random shadows and walls around the faces of an error budget."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.surface.surroundings import Interval, Surroundings
from skyshine.schemas.arrays import Booleans, Floats

SHADED_NOW = 0.4  # share of the faces that lie in a shadow, as in a street
SHADED_BEFORE = 0.2  # fraction of the faces that a shadow has left
WALLED = 0.3  # fraction of the faces beside a wall, in a shadow or not
SHADE_H = (0.5, 6.0)  # length of a shadow up to now, or of one that has left
LEFT_H = (0.25, 6.0)  # how long ago it left
SKY_VIEWS = (0.3, 0.9)
WALL_EXCESS_K = (-5.0, 20.0)  # excess of a wall over the day's mean of the air
WALL_EMISSIVITIES = (0.85, 0.97)  # plaster, brick, concrete, paint and leaves in the bands, from side to side
WALLS_LIT = 0.5  # share of the walls on which the Sun shines


@dataclass(frozen=True, eq=False)
class Circumstances:
    """Surroundings of each of n faces.

    Attributes
    ----------
    surroundings : tuple of n Surroundings
    in_shade : (n,) bool array
        Whether no light comes from the direction of the Sun at the time of the view.
    wall_beam : (n,) array
        Share of the direct light of the Sun on a surface across it that falls on the wall at the time of the view.
    """

    surroundings: tuple[Surroundings, ...]
    in_shade: Booleans
    wall_beam: Floats

    @property
    def shadows_alone(self) -> tuple[Surroundings, ...]:
        """The same shadows without walls."""
        return tuple(Surroundings(face.shade) for face in self.surroundings)

    @property
    def shaded(self) -> Booleans:
        """Faces with a shadow at any time of the day."""
        return np.array([bool(face.shade) for face in self.surroundings], bool)

    @property
    def walled(self) -> Booleans:
        """Faces beside a wall."""
        return self.sky_view < 1

    @property
    def sky_view(self) -> Floats:
        """Open share of the sky above each face."""
        return np.array([face.sky_view for face in self.surroundings])

    @property
    def wall_temperature(self) -> Floats:
        """K; of faces beside no wall any, here 300."""
        return np.array([300.0 if face.facing is None else face.facing for face in self.surroundings])

    @property
    def wall_emissivity(self) -> Floats:
        """For thermal infrared."""
        return np.array([face.facing_emissivity for face in self.surroundings])

    @classmethod
    def none(cls, count: int) -> Circumstances:
        """Faces in the open, in the Sun all day."""
        return cls((Surroundings(),) * count, np.zeros(count, bool), np.zeros(count))


def random_circumstances(time: Floats, air_temperature: float, generator: np.random.Generator) -> Circumstances:
    """Draw random surroundings of faces.

    Parameters
    ----------
    time : (n,) array
        Local clock of the views [h].
    air_temperature : float
        Mean of the day [K].
    """
    count = time.size
    kind, walled = generator.random(count), generator.random(count) < WALLED
    length, gap, ahead = (generator.uniform(*limits, count) for limits in (SHADE_H, LEFT_H, SHADE_H))
    sky_view = generator.uniform(*SKY_VIEWS, count)
    facing = air_temperature + generator.uniform(*WALL_EXCESS_K, count)
    emissivity = generator.uniform(*WALL_EMISSIVITIES, count)
    cosine, wall_lit = generator.random(count), generator.random(count) < WALLS_LIT
    in_shade = kind < SHADED_NOW
    before = ~in_shade & (kind < SHADED_NOW + SHADED_BEFORE)
    surroundings = []
    for row in range(count):
        face = Surroundings()
        if in_shade[row]:
            face = Surroundings((_interval(time[row] - length[row], time[row] + ahead[row]),))
        elif before[row]:
            end = time[row] - gap[row]
            face = Surroundings((_interval(end - length[row], end),))
        if walled[row]:
            face = replace(
                face,
                sky_view=float(sky_view[row]),
                facing=float(facing[row]),
                facing_emissivity=float(emissivity[row]),
            )
        surroundings.append(face)
    return Circumstances(tuple(surroundings), in_shade, np.where(walled & wall_lit, cosine, 0.0))


def _interval(start: float, stop: float) -> Interval:
    return float(start % 24.0), float(stop % 24.0)
