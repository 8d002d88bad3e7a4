"""Lines along which light travels through spherical shells to the levels, under a low Sun: their geometry alone.

Under a low Sun the light at a place comes from air above which the Sun is higher or lower than at the place itself.
A field of light therefore depends on the elevation of the source too, and lines of sight cross it along this axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.geometry import Shells, scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates
from skyshine.mat.atmosphere.transfer.segments import Segments
from skyshine.mat.atmosphere.transfer.source_nodes import elevation_weights
from skyshine.schemas.arrays import Floats, Integers, Singles

# Azimuths of lines at a level, in the middle of equal parts of half a circle, and azimuthal moments of the source
# function along them: one scattering by molecules leaves three, by particles little more.
AZIMUTHS, MOMENTS = 5, 3
# Angles from the vertical between which the source function along lines is linear, rad.
DIRECTIONS = np.linspace(0.0, np.pi, 16)
# Elevations of the source between which its direct light is linear, degree.
BEAM_ELEVATIONS = np.concatenate([np.arange(-13, 6, 0.25), np.arange(6, 23.0)])
# Levels at which the field is computed are this far apart, m, and this part of their height above the ground.
_LEAST_STEP, _STEP = 1e3, 0.15


@dataclass(frozen=True, eq=False)
class Line:
    """A line of sight from a level, at A azimuths and under U elevations of the source: S = A U cases, A slower.

    Attributes
    ----------
    segments : Segments
        K of them.
    deflection : (S,) array
        Cosine of the scattering angle of the source's light.
    direction, next_direction : (K,) int, (K, 1, 1, 1) arrays
        Place of the light's direction among `DIRECTIONS`, and weight of the next.
    beam, next_beam : (S, K) int, (S, K, 1) arrays
        Place of the source's elevation among `BEAM_ELEVATIONS`, counted on from segment to segment, and weight of the
        next.
    across : (S, K * MOMENTS * U) array
        What each azimuthal moment of a source function at each elevation of the source adds; single precision.
    ground : (S, U) array
        What the ground's radiance at each elevation of the source adds; None for a line that does not meet it.
    """

    segments: Segments
    deflection: Floats
    direction: Integers
    next_direction: Singles
    beam: Integers
    next_beam: Singles
    across: Singles
    ground: Singles | None


@dataclass(frozen=True, eq=False)
class SphericalPaths:
    """Lines of sight from some levels along the nodes of discrete ordinates.

    Attributes
    ----------
    level : (Z,) int array
        Levels of the shells at which they begin, from the ground up.
    sine : (U,) array
        Sine of the source's elevation at the levels, increasing.
    azimuth : (A,) array
        Azimuth of the light from the direction in which the beam travels, rad.
    lines : tuple of tuples of Line
        Lines by level, then by node: light going up, then light going down.
    """

    level: Integers
    sine: Floats
    azimuth: Floats
    lines: tuple[tuple[Line, ...], ...]

    @classmethod
    def of(cls, shells: Shells, ordinates: Ordinates, elevations: Floats) -> SphericalPaths:
        """The lines in shells, under a source at elevations (U,) [degree]."""
        level = _levels(shells.altitude)
        azimuth = (np.arange(AZIMUTHS) + 0.5) * np.pi / AZIMUTHS
        node = np.arcsin(ordinates.node)
        look = np.concatenate([-node, node])  # light goes up along a line of sight that goes down
        source = np.tile(np.radians(elevations), AZIMUTHS), np.repeat(azimuth, elevations.size)
        sine = np.sin(np.radians(elevations))
        rays = trace(shells, np.repeat(shells.altitude[level], look.size), np.tile(look, level.size))
        cosine, deflection = source_cosine(rays, *source), scattering_cosine(rays, *source)
        lines = []
        for row in range(level.size * look.size):
            segments = Segments.of(rays, row)
            ends = segments.ends
            hits = bool(rays.ground[row])
            lines.append(_line(segments, cosine[row, ends], deflection[row, ends], sine, hits))
        grouped = tuple(tuple(lines[start : start + look.size]) for start in range(0, len(lines), look.size))
        return cls(level, sine, azimuth, grouped)


def _line(segments: Segments, cosine: Floats, deflection: Floats, sine: Floats, hits: bool) -> Line:
    """A line from the cosines (K+1, S) of the source's zenith angle and of the scattering angle."""
    middle = 0.5 * (cosine[1:] + cosine[:-1])
    count, cases = middle.shape
    rise = segments.upward_cosine[:, None]
    angle = 0.5 * (deflection[1:] + deflection[:-1])
    across = np.sqrt(np.maximum((1 - rise**2) * (1 - middle**2), 1e-12))
    azimuth = np.arccos(np.clip((angle + rise * middle) / across, -1.0, 1.0))
    moments = np.cos(azimuth[..., None] * np.arange(MOMENTS))  # (K, S, M)
    weights = elevation_weights(sine, middle)  # (K, S, U)
    table = (moments[..., None] * weights[:, :, None]).astype(np.float32)
    beam = np.interp(np.degrees(np.arcsin(np.clip(middle, -1, 1))), BEAM_ELEVATIONS, np.arange(BEAM_ELEVATIONS.size))
    lower = np.minimum(beam.astype(int), BEAM_ELEVATIONS.size - 2)
    direction = np.arccos(np.clip(segments.upward_cosine, -1.0, 1.0)) / DIRECTIONS[1]
    first_direction = np.minimum(direction.astype(int), DIRECTIONS.size - 2)
    return Line(
        segments,
        deflection[0] if count else np.zeros(cases),
        first_direction,
        (direction - first_direction).astype(np.float32).reshape(-1, 1, 1, 1),
        (lower + BEAM_ELEVATIONS.size * np.arange(count)[:, None]).T,
        (beam - lower).astype(np.float32).T[..., None],
        np.ascontiguousarray(table.transpose(1, 0, 2, 3)).reshape(cases, -1),
        elevation_weights(sine, cosine[-1]).astype(np.float32) if hits else None,
    )


def _levels(altitude: Floats) -> Integers:
    """Some of the levels, with the lowest and the highest."""
    chosen = [0]
    for number, height in enumerate(altitude - altitude[0]):
        highest = altitude[chosen[-1]] - altitude[0]
        if height - highest >= _LEAST_STEP + _STEP * highest:
            chosen.append(number)
    if chosen[-1] != altitude.size - 1:
        chosen.append(altitude.size - 1)
    return np.array(chosen)
