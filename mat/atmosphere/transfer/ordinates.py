"""Discrete-ordinate equations of scattering layers under a distant source, by azimuthal moment; layers joined by
adding.

Radiances travel at the Gauss nodes of each hemisphere and are kept as sqrt(weight * cosine) times themselves, which
makes the operators of a layer symmetric. Depth runs downwards; every layer is homogeneous, and the beam falls
exponentially inside it.

References
----------
Stamnes, Tsay, Wiscombe and Jayaweera 1988, Appl. Opt. 27, 2502 (equations, reduction to half the order).
Nakajima and Tanaka 1986, J. Quant. Spectrosc. Radiat. Transfer 35, 13 (symmetric form, adding).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.special import lpmv

from skyshine.mat.atmosphere.transfer.segments import mean_attenuation, source_weights

# Nodes of each hemisphere; as many moments of the phase function as there are nodes in both.
NODES = 4
MOMENTS = 2 * NODES
# Azimuthal moments of light scattered more than once.
AZIMUTHAL = 6
_NODE, _WEIGHT = (
    0.5 * np.polynomial.legendre.leggauss(NODES)[0] + 0.5,
    0.5 * np.polynomial.legendre.leggauss(NODES)[1],
)
_UNIT = np.sqrt(_WEIGHT * _NODE)
# As in `multiple`: pure scattering has no decay, which the closed form of a layer divides by.
_LARGEST_ALBEDO = 1 - 1e-12
_SMALLEST_SQUARE = 1e-14


def legendre(cosine):
    """Associated Legendre functions with unit norm factor, sqrt((l - m)! / (l + m)!) P_l^m, (AZIMUTHAL, MOMENTS, X)."""
    cosine = np.asarray(cosine, dtype=float)
    result = np.zeros((AZIMUTHAL, MOMENTS, cosine.size))
    for m in range(AZIMUTHAL):
        for order in range(m, MOMENTS):
            result[m, order] = np.sqrt(math.factorial(order - m) / math.factorial(order + m)) * lpmv(m, order, cosine)
    return result


_AT_NODES = legendre(_NODE)
# Whether a moment is the same up and down.
_EVEN = (np.add.outer(np.arange(AZIMUTHAL), np.arange(MOMENTS)) % 2 == 0)[..., None]
_FACTOR = 2 * np.arange(MOMENTS) + 1


def radiances(depth, scattering, beam, sine, albedo):
    """Diffuse radiances at the levels under a source of unit irradiance, none entering from above.

    Parameters
    ----------
    depth : (N-1, P) array
        Optical depth of the layers, from the ground up.
    scattering : (N-1, P, MOMENTS) array
        That of scattering times the Legendre moments of the phase function, the first of which is 1.
    beam : (N, P, U) array
        Optical depth from the source to each level.
    sine : (U,) array
        Of the source's elevation.
    albedo : float
        Of the ground, Lambertian.

    Returns
    -------
    rising, falling : (N, P, AZIMUTHAL, NODES, U) arrays
        sr^-1; coefficients of the cosines of multiples of the azimuth from the direction in which the beam travels.
    """
    reflection, transmission, upward, downward = _layers(depth, scattering, beam, sine)
    count = len(depth)
    shape = (count + 1, *upward.shape[1:])
    source, below = np.empty(shape), np.zeros((count + 1, *reflection.shape[1:]))
    below[0, :, 0] = 2 * albedo * np.outer(_UNIT, _UNIT)
    source[0] = 0.0
    source[0, :, 0] = albedo / np.pi * _UNIT[:, None] * (np.maximum(sine, 0.0) * np.exp(-beam[0]))[:, None]
    one = np.eye(NODES)
    for k in range(count):
        bounce = np.swapaxes(
            np.linalg.solve(np.swapaxes(one - below[k] @ reflection[k], -1, -2), np.swapaxes(transmission[k], -1, -2)),
            -1,
            -2,
        )
        below[k + 1] = reflection[k] + bounce @ below[k] @ transmission[k]
        source[k + 1] = upward[k] + bounce @ (source[k] + below[k] @ downward[k])
    falling = np.zeros(shape)
    for k in range(count - 1, -1, -1):
        arriving = transmission[k] @ falling[k + 1] + downward[k] + reflection[k] @ source[k]
        falling[k] = np.linalg.solve(one - reflection[k] @ below[k], arriving)
    return (source + below @ falling) / _UNIT[:, None], falling / _UNIT[:, None]


def _layers(depth, scattering, beam, sine):
    """Reflection and transmission (N-1, P, M, n, n) of the layers, what each sends up and down of the beam (N-1, P, M,
    n, U).
    """
    some = depth > 0
    share = scattering / np.where(some, depth, 1.0)[..., None]
    share = share * np.minimum(_LARGEST_ALBEDO / np.maximum(share[..., :1], _LARGEST_ALBEDO), 1.0)
    weighted = share[..., None, :] * _FACTOR  # (N-1, P, 1, L)
    even, odd = (_half_operator(weighted, kind) for kind in (_EVEN, ~_EVEN))
    lower = np.linalg.cholesky(odd)
    upper = np.swapaxes(lower, -1, -2)
    square, mode = np.linalg.eigh(upper @ even @ lower)
    decay = np.sqrt(np.maximum(square, _SMALLEST_SQUARE))[..., None, :]  # (N-1, P, M, 1, n)
    total, net = lower @ mode, np.linalg.solve(upper, mode)  # of a mode: sum and difference of rising and falling light
    vertical = decay * depth[..., None, None, None]
    left = np.exp(-vertical)
    gone = -np.expm1(-vertical)
    a, b = total * (1 + left), net * (decay * gone)
    symmetric = (a - b) @ np.linalg.inv(a + b)
    a, b = total * (gone / decay), net * (1 + left)
    contrary = (a - b) @ np.linalg.inv(a + b)
    reflection, transmission = 0.5 * (symmetric + contrary), 0.5 * (symmetric - contrary)

    from_source = legendre(-sine)  # (M, L, U)
    twice = np.where(np.arange(AZIMUTHAL) == 0, 1.0, 2.0)[:, None, None] / (4 * np.pi)
    scale = -2 * np.sqrt(_WEIGHT / _NODE)[:, None] * twice  # (M, n, 1)
    both = [scale * _scattered(weighted, np.where(kind, _AT_NODES, 0.0), from_source) for kind in (~_EVEN, _EVEN)]
    turned = np.swapaxes(mode, -1, -2)
    first = turned @ np.linalg.solve(lower, both[0])
    second = turned @ (upper @ both[1])
    decay, vertical = (np.swapaxes(part, -1, -2) for part in (decay, vertical))
    fall = np.maximum(beam[:-1] - beam[1:], 0.0)[:, :, None, None]
    lit = np.exp(-beam[1:])[:, :, None, None] * depth[..., None, None, None]
    zero, wide = np.zeros_like(vertical + fall), vertical + fall
    grown = -(decay * first + second) * mean_attenuation(zero, wide) * lit  # at the top
    faded = (
        (decay * first - second)
        * mean_attenuation(np.broadcast_to(vertical, wide.shape), np.broadcast_to(fall, wide.shape))
        * lit
    )
    top = total @ (grown / decay), net @ grown
    bottom = total @ (faded / decay), -(net @ faded)
    rises, falls = ([0.25 * (s + sign * d) for s, d in (top, bottom)] for sign in (1, -1))
    upward = rises[0] - reflection @ falls[0] - transmission @ rises[1]
    downward = falls[1] - reflection @ rises[1] - transmission @ falls[0]
    return reflection, transmission, upward, downward


def _half_operator(weighted, kind):
    """1 / cosine less what is scattered into the node, for the sum or the difference of rising and falling light."""
    part = np.where(kind, _AT_NODES, 0.0) * np.sqrt(_WEIGHT / _NODE)  # (M, L, n)
    return np.diag(1 / _NODE) - np.swapaxes(part, -1, -2) @ (weighted[..., None] * part)


def _scattered(weighted, here, there):
    """Phase function by moments from directions to directions: (N-1, P, M, n, U)."""
    return np.swapaxes(here, -1, -2) @ (weighted[..., None] * there)


def scattered_into(scattering, rising, falling, cosine):
    """What radiances scatter into directions, per length in which `scattering` counts.

    Parameters
    ----------
    scattering : (N, P, MOMENTS) array
        At the levels.
    rising, falling : (N, P, AZIMUTHAL, NODES, U) arrays
    cosine : (X,) array
        Of the directions, positive up.

    Returns
    -------
    (N, P, AZIMUTHAL, X, U) array
        Coefficients of the cosines of multiples of azimuth.
    """
    weights = _AT_NODES * _WEIGHT  # (M, L, n)
    moments = weights @ (rising + falling) * _EVEN + weights @ (rising - falling) * ~_EVEN  # (N, P, M, L, U)
    moments *= 0.5 * (scattering * _FACTOR)[:, :, None, :, None]
    return np.swapaxes(legendre(cosine), -1, -2) @ moments


def along_directions(lower, upper, source, ground, cosine):
    """Radiances at the levels in any direction, from the source function.

    Parameters
    ----------
    lower, upper : (N-1, P) arrays
        Optical depth of the layers from the ground up, the part by the properties of each one's lower and upper level.
    source : (N, P, AZIMUTHAL, X, U) array
        Source function at the levels.
    ground : (P, U) array
        Radiance that leaves the ground.
    cosine : (X,) array
        Of the directions, positive up; not 0.

    Returns
    -------
    (N, P, AZIMUTHAL, X, U) array
    """
    result = np.zeros_like(source)
    up, down = cosine > 0, cosine < 0
    result[0, :, 0, up] = ground
    depth = lower + upper
    share = (upper / np.where(depth > 0, depth, 1.0))[:, :, None]
    weights = source_weights(depth[..., None] / np.abs(cosine))
    near, far = (part[:, :, None, :, None] for part in weights)
    through = np.exp(-depth[..., None] / np.abs(cosine))[:, :, None, :, None]
    # The source's mean counts each level by its extinction; its slope is limited so that no weight is negative.
    above = np.clip(
        (near + far) * share[..., None, None] + 0.5 * (far - near) * np.where(up, -1.0, 1.0)[:, None], 0.0, near + far
    )
    below = near + far - above
    for k in range(len(depth)):
        into = below[k][:, :, up] * source[k][:, :, up] + above[k][:, :, up] * source[k + 1][:, :, up]
        result[k + 1][:, :, up] = result[k][:, :, up] * through[k][:, :, up] + into
    for k in range(len(depth) - 1, -1, -1):
        into = below[k][:, :, down] * source[k][:, :, down] + above[k][:, :, down] * source[k + 1][:, :, down]
        result[k][:, :, down] = result[k + 1][:, :, down] * through[k][:, :, down] + into
    return result


def flux(radiance):
    """Flux through a level of the radiances of one hemisphere (..., AZIMUTHAL, NODES, U), (..., U)."""
    return 2 * np.pi * np.einsum("i,...iu->...u", _WEIGHT * _NODE, radiance[..., 0, :, :])
