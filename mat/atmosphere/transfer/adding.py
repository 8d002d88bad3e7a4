"""Layers of any optical depth joined by adding from the ground up."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.transfer.layer_modes import LayerModes
from skyshine.mat.atmosphere.transfer.ordinates import Ordinates
from skyshine.schemas.arrays import Floats


def sunlight(
    ordinates: Ordinates, depth: Floats, weighted: Floats, beam: Floats, sine: Floats, albedo: Floats
) -> tuple[Floats, Floats]:
    """Diffuse radiances at the levels under a source of unit irradiance, none entering from above.

    Parameters
    ----------
    depth : (N-1, P) array
        Optical depth of the layers, from the ground up.
    weighted : (N-1, L, P) array
        Their single-scattering albedo times 2 l + 1 times the moments of the phase function.
    beam : (N, U, P) array
        Optical depth from the source to each level.
    sine : (U,) array
        Sine of the source's elevation.
    albedo : (P,) array
        Albedo of the ground, Lambertian.

    Returns
    -------
    rising, falling : (N, M, n, U, P) arrays
        sr^-1; coefficients of the cosines of multiples of the azimuth from the direction in which the beam travels.
    """
    modes = LayerModes.of(ordinates, depth, weighted)
    operators = modes.reflection_and_transmission()
    beam = np.swapaxes(beam, 1, 2)
    ground = (albedo / np.pi)[:, None] * np.maximum(sine, 0.0) * np.exp(-beam[0])
    return _joined(ordinates, *operators, *modes.scattered_beam(*operators, beam, sine), ground, albedo)


def thermal(
    ordinates: Ordinates, depth: Floats, weighted: Floats, emission: Floats, ground: Floats, albedo: Floats
) -> tuple[Floats, Floats]:
    """Thermal radiances at the levels; arguments as of `sunlight`.

    Parameters
    ----------
    ordinates : Ordinates
        Ordinates of light that does not depend on azimuth.
    depth, weighted
    emission : (N, P) array
        Blackbody radiance at the levels.
    ground : (P,) array
        Radiance that the ground emits.
    albedo

    Returns
    -------
    rising, falling : (N, 1, n, 1, P) arrays
        In the unit of the emission.
    """
    modes = LayerModes.of(ordinates, depth, weighted)
    operators = modes.reflection_and_transmission()
    return _joined(ordinates, *operators, *modes.emitted(*operators, emission), ground[:, None], albedo)


def _joined(
    ordinates: Ordinates,
    reflection: Floats,
    transmission: Floats,
    upward: Floats,
    downward: Floats,
    ground: Floats,
    albedo: Floats,
) -> tuple[Floats, Floats]:
    """Radiances (N, M, n, U, P) between layers that send out light (N-1, P, M, n, U) over a ground that sends out a
    radiance (P, U).
    """
    count, unit = len(reflection), np.sqrt(ordinates.weight * ordinates.node)
    shape = (count + 1, *upward.shape[1:])
    source, below = np.zeros(shape), np.zeros((count + 1, *reflection.shape[1:]))
    below[0, :, 0] = 2 * albedo[:, None, None] * np.outer(unit, unit)
    source[0, :, 0] = unit[:, None] * ground[:, None]
    identity = np.eye(unit.size)
    for k in range(count):
        closed = np.swapaxes(identity - below[k] @ reflection[k], -1, -2)
        bounce = np.swapaxes(np.linalg.solve(closed, np.swapaxes(transmission[k], -1, -2)), -1, -2)
        below[k + 1] = reflection[k] + bounce @ below[k] @ transmission[k]
        source[k + 1] = upward[k] + bounce @ (source[k] + below[k] @ downward[k])
    falling = np.zeros(shape)
    for k in range(count - 1, -1, -1):
        arriving = transmission[k] @ falling[k + 1] + downward[k] + reflection[k] @ source[k]
        falling[k] = np.linalg.solve(identity - reflection[k] @ below[k], arriving)
    rising = (source + below @ falling) / unit[:, None]
    return np.moveaxis(rising, 1, -1), np.moveaxis(falling / unit[:, None], 1, -1)
