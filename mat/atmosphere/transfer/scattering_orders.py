"""Light by orders of scattering, at the nodes of discrete ordinates: for layers that scatter little, of any absorption.

Each order is scattered out of the one before it. It lies between the radiances at the levels, so that the source
function of a layer is linear in optical depth; that of the beam falls exponentially.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from skyshine.mat.atmosphere.transfer.ordinates import Ordinates
from skyshine.mat.atmosphere.transfer.segments import mean_attenuation, source_weights
from skyshine.schemas.arrays import Floats, Reals

# Orders are computed until one adds less than this part of the light so far, each being a small part of the one before.
_TOLERANCE, _MOST_ORDERS = 1e-4, 60


def sunlight(
    ordinates: Ordinates, depth: Floats, weighted: Floats, beam: Floats, sine: Floats, albedo: Floats
) -> tuple[Reals, Reals]:
    """Diffuse radiances at the levels; arguments and results as of `adding.sunlight`, in single precision."""
    return _sum(_orders(ordinates, depth, weighted, *_once_scattered(ordinates, depth, weighted, beam, sine, albedo)))


def first_orders(
    ordinates: Ordinates,
    depth: Floats,
    weighted: Floats,
    beam: Floats,
    sine: Floats,
    albedo: Floats,
    count: int,
) -> list[tuple[Reals, Reals]]:
    """The first orders alone, each as `sunlight` returns their sum; fewer where nothing scatters."""
    once = _once_scattered(ordinates, depth, weighted, beam, sine, albedo)
    return list(islice(_orders(ordinates, depth, weighted, *once), count))


def _once_scattered(
    ordinates: Ordinates, depth: Floats, weighted: Floats, beam: Floats, sine: Floats, albedo: Floats
) -> tuple[Reals, Reals, Reals, Reals]:
    """Light of the beam that layers send up and down and that the ground reflects, with its albedo; arguments as of
    `sunlight`.
    """
    nodes = ordinates.node.size
    slant = _slant(ordinates, depth)[:, None, :, None]  # (N-1, 1, n, 1, P)
    fall = np.maximum(beam[:-1] - beam[1:], 0.0)[:, None, None]
    light = ordinates.out_of_beam(weighted, sine)
    light *= (np.exp(-beam[1:])[:, None, None] * slant)[:, :, np.r_[:nodes, :nodes]]
    upward, downward = light[:, :, :nodes], light[:, :, nodes:]
    upward *= mean_attenuation(np.zeros_like(slant + fall), slant + fall)
    downward *= mean_attenuation(*np.broadcast_arrays(slant, fall))
    ground = (albedo / np.pi) * np.maximum(sine, 0.0)[:, None] * np.exp(-beam[0])
    up, down, sent, reflected = (part.astype(np.float32) for part in (upward, downward, ground, albedo))
    return up, down, sent, reflected


def thermal(
    ordinates: Ordinates, depth: Floats, weighted: Floats, emission: Floats, ground: Floats, albedo: Floats
) -> tuple[Reals, Reals]:
    """Thermal radiances at the levels; arguments and results as of `adding.thermal`."""
    absorbed = 1 - weighted[:, :1]
    bottom, top = (absorbed * part[:, None] for part in (emission[:-1], emission[1:]))  # (N-1, 1, P)
    near, far = source_weights(_slant(ordinates, depth))
    upward, downward = (part[:, None, :, None] for part in (near * top + far * bottom, near * bottom + far * top))
    return _sum(_orders(ordinates, depth, weighted, upward, downward, ground[None], albedo))


def _slant(ordinates: Ordinates, depth: Floats) -> Floats:
    """Optical depth of the layers along the nodes, (N-1, n, P)."""
    slant: Floats = depth[:, None] / ordinates.node[:, None]
    return slant


def _orders(
    ordinates: Ordinates,
    depth: Floats,
    weighted: Floats,
    upward: Reals,
    downward: Reals,
    ground: Reals,
    albedo: Reals,
) -> Iterator[tuple[Reals, Reals]]:
    """Orders of the light (N-1, M, n, U, P) that layers send out and of a ground's radiance (U, P)."""
    slant = _slant(ordinates, depth)
    transmittance = np.exp(-slant)[:, None, :, None].astype(upward.dtype)
    near, far = (part[:, None, :, None].astype(upward.dtype) for part in source_weights(slant))
    # Weights of the mean of the source at both ends of a layer and of half its change, in the light that leaves it.
    total, slope = near + far, near - far
    rising, falling = _travelled(ordinates, transmittance, upward, downward, ground, albedo)
    yield rising, falling
    if not np.any(weighted):
        return
    scattering, no_light = weighted.astype(upward.dtype), np.zeros_like(ground)
    while True:
        even, odd = ordinates.moments_at_levels(rising, falling)
        upward, downward = ordinates.from_moments(scattering, 0.5 * (even[1:] + even[:-1]), 0.5 * (odd[1:] + odd[:-1]))
        upward *= total
        downward *= total
        up_change, down_change = ordinates.from_moments(
            scattering, 0.5 * (even[1:] - even[:-1]), 0.5 * (odd[1:] - odd[:-1])
        )
        upward += slope * up_change
        downward -= slope * down_change
        rising, falling = _travelled(ordinates, transmittance, upward, downward, no_light, albedo)
        yield rising, falling


def _sum(orders: Iterator[tuple[Reals, Reals]]) -> tuple[Reals, Reals]:
    """Sum of all orders."""
    all_rising, all_falling = next(orders)
    for rising, falling in islice(orders, _MOST_ORDERS):
        all_rising, all_falling = all_rising + rising, all_falling + falling
        if np.all(_largest(rising, falling) <= _TOLERANCE * _largest(all_rising, all_falling)):
            break
    return all_rising, all_falling


def _largest(rising: Reals, falling: Reals) -> Reals:
    """Largest radiance at each point, (P,)."""
    largest: Reals = np.maximum(*(np.max(np.abs(part), axis=(0, 1, 2, 3)) for part in (rising, falling)))
    return largest


def _travelled(
    ordinates: Ordinates, transmittance: Reals, upward: Reals, downward: Reals, ground: Reals, albedo: Reals
) -> tuple[Reals, Reals]:
    """Radiances (N, M, n, U, P) at the levels of light that is not scattered again but by the ground."""
    count = len(upward)
    rising, falling = (np.zeros((count + 1, *upward.shape[1:]), upward.dtype) for _ in range(2))
    for k in range(count - 1, -1, -1):
        np.multiply(falling[k + 1], transmittance[k], out=falling[k])
        falling[k] += downward[k]
    rising[0, 0] = ground + albedo * ordinates.flux(falling[:1])[0] / np.pi
    for k in range(count):
        np.multiply(rising[k], transmittance[k], out=rising[k + 1])
        rising[k + 1] += upward[k]
    return rising, falling
