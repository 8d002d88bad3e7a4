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
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import lpmv

from skyshine.mat.atmosphere.transfer.segments import mean_attenuation, source_weights
from skyshine.schemas.arrays import Booleans, Floats, Reals

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
# As in `two_stream_light`: without absorption an eigenvalue is 0, by which the closed form of a layer divides.
_LARGEST_ALBEDO = 1 - 1e-12
_SMALLEST_SQUARE = 1e-14


def legendre(cosine: npt.ArrayLike) -> Floats:
    """Associated Legendre functions with unit norm factor, sqrt((l - m)! / (l + m)!) P_l^m, (AZIMUTHAL, MOMENTS, X) at
    cosines (X,).
    """
    cosine = np.asarray(cosine, dtype=float)
    result = np.zeros((AZIMUTHAL, MOMENTS, cosine.size))
    for m in range(AZIMUTHAL):
        for order in range(m, MOMENTS):
            result[m, order] = np.sqrt(math.factorial(order - m) / math.factorial(order + m)) * lpmv(m, order, cosine)
    return result


_AT_NODES = legendre(_NODE)
# Whether an associated Legendre function is even in the cosine: l + m even.
_EVEN = (np.add.outer(np.arange(AZIMUTHAL), np.arange(MOMENTS)) % 2 == 0)[..., None]
_FACTOR = 2 * np.arange(MOMENTS) + 1


def radiances(
    depth: Floats, scattering: Floats, beam: Floats, sine: Floats, albedo: float | Floats
) -> tuple[Floats, Floats]:
    """Diffuse radiances at the levels under a source of unit irradiance, none entering from above.

    Parameters
    ----------
    depth : (N-1, P) array
        Optical depth of the layers, from the ground up.
    scattering : (N-1, P, MOMENTS) array
        Optical depth of scattering times the Legendre moments of the phase function, the first of which is 1.
    beam : (N, P, U) array
        Optical depth from the source to each level.
    sine : (U,) array
        Of the source's elevation.
    albedo : float or (P,) array
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
    reflected = np.reshape(albedo, (-1, 1, 1))  # (P, 1, 1), or (1, 1, 1) for one number
    below[0, :, 0] = 2 * reflected * np.outer(_UNIT, _UNIT)
    source[0] = 0.0
    source[0, :, 0] = reflected / np.pi * _UNIT[:, None] * (np.maximum(sine, 0.0) * np.exp(-beam[0]))[:, None]
    identity = np.eye(NODES)
    for k in range(count):
        closed = np.swapaxes(identity - below[k] @ reflection[k], -1, -2)
        bounce = np.swapaxes(np.linalg.solve(closed, np.swapaxes(transmission[k], -1, -2)), -1, -2)
        below[k + 1] = reflection[k] + bounce @ below[k] @ transmission[k]
        source[k + 1] = upward[k] + bounce @ (source[k] + below[k] @ downward[k])
    falling = np.zeros(shape)
    for k in range(count - 1, -1, -1):
        arriving = transmission[k] @ falling[k + 1] + downward[k] + reflection[k] @ source[k]
        falling[k] = np.linalg.solve(identity - reflection[k] @ below[k], arriving)
    return (source + below @ falling) / _UNIT[:, None], falling / _UNIT[:, None]


@dataclass(frozen=True, eq=False)
class _Eigenmodes:
    """Solutions of the homogeneous equations of N-1 layers at P points, M azimuthal moments and n nodes.

    Attributes
    ----------
    k : (N-1, P, M, 1, n) array
        Eigenvalues: the modes fall with exp(-k tau).
    k_tau : (N-1, P, M, 1, n) array
        k times the optical depth of the layer.
    lower, upper : (N-1, P, M, n, n) arrays
        Cholesky factor of the operator of the difference, and its transpose.
    mode : (N-1, P, M, n, n) array
        Eigenvectors of the symmetric product of both operators.
    total, net : (N-1, P, M, n, n) arrays
        Sum and difference of the rising and falling radiances of each mode.
    """

    k: Floats
    k_tau: Floats
    lower: Reals
    upper: Reals
    mode: Floats
    total: Floats
    net: Floats

    @classmethod
    def of(cls, depth: Floats, weighted: Floats) -> _Eigenmodes:
        """The modes of layers of optical depths (N-1, P), with the single-scattering albedo times 2 l + 1 times the
        moments of the phase function (N-1, P, 1, L).
        """
        even, odd = (_half_operator(weighted, parity) for parity in (_EVEN, ~_EVEN))
        lower = np.linalg.cholesky(odd)
        upper = np.swapaxes(lower, -1, -2)
        square, mode = np.linalg.eigh(upper @ even @ lower)
        k = np.sqrt(np.maximum(square, _SMALLEST_SQUARE))[..., None, :]
        net: Floats = np.linalg.solve(upper, mode)
        return cls(k, k * depth[..., None, None, None], lower, upper, mode, lower @ mode, net)

    def reflection_and_transmission(self) -> tuple[Floats, Floats]:
        """Operators (N-1, P, M, n, n) of the layers, from the solutions that are even and odd about their middle."""
        transmitted = np.exp(-self.k_tau)
        absorbed = -np.expm1(-self.k_tau)
        a, b = self.total * (1 + transmitted), self.net * (self.k * absorbed)
        even = (a - b) @ np.linalg.inv(a + b)
        a, b = self.total * (absorbed / self.k), self.net * (1 + transmitted)
        odd = (a - b) @ np.linalg.inv(a + b)
        return 0.5 * (even + odd), 0.5 * (even - odd)


def _layers(depth: Floats, scattering: Floats, beam: Floats, sine: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Reflection and transmission (N-1, P, M, n, n) of the layers, and the scattered light of the beam that each
    sends up and down (N-1, P, M, n, U).
    """
    opaque = depth > 0
    albedo = scattering / np.where(opaque, depth, 1.0)[..., None]
    albedo = albedo * np.minimum(_LARGEST_ALBEDO / np.maximum(albedo[..., :1], _LARGEST_ALBEDO), 1.0)
    weighted = albedo[..., None, :] * _FACTOR  # (N-1, P, 1, L)
    modes = _Eigenmodes.of(depth, weighted)
    reflection, transmission = modes.reflection_and_transmission()
    (rise_top, rise_bottom), (fall_top, fall_bottom) = _scattered_beam(modes, depth, weighted, beam, sine)
    upward = rise_top - reflection @ fall_top - transmission @ rise_bottom
    downward = fall_bottom - reflection @ rise_bottom - transmission @ fall_top
    return reflection, transmission, upward, downward


def _scattered_beam(
    modes: _Eigenmodes, depth: Floats, weighted: Floats, beam: Floats, sine: Floats
) -> tuple[list[Floats], list[Floats]]:
    """A particular solution under the beam: rising and falling radiances (N-1, P, M, n, U) at top and bottom of each
    layer.
    """
    from_source = legendre(-sine)  # (M, L, U)
    twice = np.where(np.arange(AZIMUTHAL) == 0, 1.0, 2.0)[:, None, None] / (4 * np.pi)
    scale = -2 * np.sqrt(_WEIGHT / _NODE)[:, None] * twice  # (M, n, 1)
    odd, even = (scale * _phase(weighted, np.where(parity, _AT_NODES, 0.0), from_source) for parity in (~_EVEN, _EVEN))
    to_modes = np.swapaxes(modes.mode, -1, -2)
    first = to_modes @ np.linalg.solve(modes.lower, odd)
    second = to_modes @ (modes.upper @ even)
    k, k_tau = (np.swapaxes(part, -1, -2) for part in (modes.k, modes.k_tau))
    fall = np.maximum(beam[:-1] - beam[1:], 0.0)[:, :, None, None]
    entering = np.exp(-beam[1:])[:, :, None, None] * depth[..., None, None, None]
    joint_depth = k_tau + fall
    at_top = -(k * first + second) * mean_attenuation(np.zeros_like(joint_depth), joint_depth) * entering
    at_bottom = (
        (k * first - second)
        * mean_attenuation(np.broadcast_to(k_tau, joint_depth.shape), np.broadcast_to(fall, joint_depth.shape))
        * entering
    )
    sums = modes.total @ (at_top / k), modes.total @ (at_bottom / k)
    differences = modes.net @ at_top, -(modes.net @ at_bottom)
    rising, falling = (
        [0.25 * (total + sign * net) for total, net in zip(sums, differences, strict=True)] for sign in (1, -1)
    )
    return rising, falling


def _half_operator(weighted: Floats, parity: Booleans) -> Floats:
    """Extinction less scattering from node to node (N-1, P, M, n, n), for the sum or the difference of rising and
    falling radiances: alpha +- beta in Stamnes et al. 1988, in symmetric form.
    """
    part = np.where(parity, _AT_NODES, 0.0) * np.sqrt(_WEIGHT / _NODE)  # (M, L, n)
    operator: Floats = np.diag(1 / _NODE) - np.swapaxes(part, -1, -2) @ (weighted[..., None] * part)
    return operator


def _phase(weighted: Floats, outgoing: Floats, incoming: Floats) -> Floats:
    """Phase function (N-1, P, M, n, U) times the single-scattering albedo, from the Legendre functions (M, L, n) of the
    outgoing and (M, L, U) of the incoming directions.
    """
    phase: Floats = np.swapaxes(outgoing, -1, -2) @ (weighted[..., None] * incoming)
    return phase


def scattered_into(scattering: Floats, rising: Floats, falling: Floats, cosine: Floats) -> Floats:
    """Diffuse radiation scattered into directions, in the unit of `scattering` times that of the radiances.

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
    moments: Floats = weights @ (rising + falling) * _EVEN + weights @ (rising - falling) * ~_EVEN  # (N, P, M, L, U)
    moments *= 0.5 * (scattering * _FACTOR)[:, :, None, :, None]
    scattered: Floats = np.swapaxes(legendre(cosine), -1, -2) @ moments
    return scattered


def along_directions(lower: Floats, upper: Floats, source: Floats, ground: Floats, cosine: Floats) -> Floats:
    """Radiances at the levels in any direction, from the source function.

    Parameters
    ----------
    lower, upper : (N-1, P) arrays
        The parts of the layers' optical depth, from the ground up, that follow from the properties of each layer's
        lower and upper level.
    source : (N, P, AZIMUTHAL, X, U) array
        Source function at the levels.
    ground : (P, U) array
        Radiance of the ground, the same in all directions.
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
    near, far = (part[:, :, None, :, None] for part in source_weights(depth[..., None] / np.abs(cosine)))
    transmittance = np.exp(-depth[..., None] / np.abs(cosine))[:, :, None, :, None]
    # The source's mean counts each level by its extinction; its slope is limited so that no weight is negative.
    above = np.clip(
        (near + far) * share[..., None, None] + 0.5 * (far - near) * np.where(up, -1.0, 1.0)[:, None], 0.0, near + far
    )
    below = near + far - above
    for k in range(len(depth)):
        emitted = below[k][:, :, up] * source[k][:, :, up] + above[k][:, :, up] * source[k + 1][:, :, up]
        result[k + 1][:, :, up] = result[k][:, :, up] * transmittance[k][:, :, up] + emitted
    for k in range(len(depth) - 1, -1, -1):
        emitted = below[k][:, :, down] * source[k][:, :, down] + above[k][:, :, down] * source[k + 1][:, :, down]
        result[k][:, :, down] = result[k + 1][:, :, down] * transmittance[k][:, :, down] + emitted
    return result


def flux(radiance: Floats) -> Floats:
    """Flux (..., U) through a level, of the radiances (..., AZIMUTHAL, NODES, U) of one hemisphere."""
    flux_: Floats = 2 * np.pi * np.einsum("i,...iu->...u", _WEIGHT * _NODE, radiance[..., 0, :, :])
    return flux_
