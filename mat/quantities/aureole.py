"""Diffuse sunlight from around the Sun, which goes where something stands before it.

A beam from the Sun and a sky of even brightness stand for the light of the whole sky. The beam has what the radiative
transfer of the state finds within `RADIUS_DEG` of the Sun, above the mean brightness of the rest. By this radius what
walls, buildings and trees before the Sun take is right to a third of the error of an even sky, and of that of the split
of Hay and Davies (1980): `tests/mat/quantities/test_aureole.py`.
"""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.schemas.arrays import Floats

RADIUS_DEG = 30.0
DIRECTIONS = Directions.of(8, 12)  # twice as many each way change no share by more than 0.01
_POINTS = 24  # with the most sunlight: 0.8 of all of it; the others change no share by more than 0.014


def sunlit_sky(
    state: AtmosphericState, points: SpectralPoints, source_elevation: Floats, directions: Directions = DIRECTIONS
) -> Floats:
    """Sunlight from the sky at the state's ground, by direction.

    Parameters
    ----------
    state : AtmosphericState
        With the ground's albedo for sunlight.
    points : SpectralPoints
        With weights in the unit of the irradiance outside the atmosphere.
    source_elevation : (S,) array
        Of the Sun, geometric [degree].
    directions : Directions

    Returns
    -------
    (S, D, A) array
        Radiance of the upper D cells of zenith angle, in the unit of the weights per steradian.
    """
    air, elevation = SpectralAir.of(state, points), np.radians(source_elevation)
    reflection = GroundReflection.of(air, elevation)
    phases = cell_phases(air, directions, elevation)
    field = RadianceField.at(air, state.surface_altitude, elevation, reflection, directions, phases)
    return np.swapaxes(field.scattered[directions.cosine > 0] @ points.weight, 0, 1)


def aureole_shares(
    state: AtmosphericState, points: SpectralPoints, source_elevation: Floats, directions: Directions = DIRECTIONS
) -> Floats:
    """Share of the diffuse light on level ground that comes from around the Sun, (S,); arguments as of `sunlit_sky`.

    With h of the diffuse irradiance from within `RADIUS_DEG`, of which an even sky would have s: (h - s) / (1 - s).
    """
    strongest = np.sort(np.argsort(points.weight)[-_POINTS:])
    sky = sunlit_sky(state, points.subset(strongest, points.weight[strongest]), source_elevation, directions)
    up = directions.cosine > 0
    level = (directions.solid_angle * directions.cosine[:, None])[up]
    elevation = np.radians(source_elevation)
    sun = np.stack([np.cos(elevation), np.zeros_like(elevation), np.sin(elevation)], axis=-1)
    near = np.cos(np.radians(RADIUS_DEG)) < directions.samples[up] @ sun.T  # (D, A, N, S)
    inside = level * np.moveaxis(near.mean(axis=2), -1, 0)
    cells = np.broadcast_to(level, inside.shape)
    even = inside.sum(axis=(1, 2)) / cells.sum(axis=(1, 2))
    whole = np.sum(level * sky, axis=(1, 2))
    share = np.divide(np.sum(inside * sky, axis=(1, 2)), whole, out=even.copy(), where=whole > 0)
    result: Floats = np.maximum((share - even) / (1 - even), 0.0)
    return result
