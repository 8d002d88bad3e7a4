"""What scattering layers reflect, transmit and send out at the nodes of discrete ordinates, from the eigenmodes of each
homogeneous layer.

Radiances are kept as sqrt(weight * cosine) times themselves, which makes the operators of a layer symmetric. Depth runs
downwards; inside a layer the beam falls exponentially, and the blackbody radiance is linear in depth.

References
----------
Stamnes, Tsay, Wiscombe and Jayaweera 1988, Appl. Opt. 27, 2502 (equations, reduction to half the order).
Nakajima and Tanaka 1986, J. Quant. Spectrosc. Radiat. Transfer 35, 13 (symmetric form, adding).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.ordinates import Ordinates
from skyshine.mat.atmosphere.transfer.segments import mean_attenuation
from skyshine.schemas.arrays import Booleans, Floats, Reals

# Without absorption an eigenvalue is 0, by which the closed form of a layer divides. This much absorption removes 1e-4
# of the light from a layer of optical depth 1e4.
LARGEST_ALBEDO = 1 - 1e-12
_SMALLEST_SQUARE = 1e-14
# Below this optical depth a layer emits as if it had its mean temperature.
_THIN = 1e-4


@dataclass(frozen=True, eq=False)
class LayerModes:
    """Solutions of the homogeneous equations of N-1 layers at P points, M azimuthal moments and n nodes.

    Attributes
    ----------
    depth : (N-1, P) array
        Optical depth of the layers, from the ground up.
    weighted : (N-1, P, 1, L) array
        Single-scattering albedo times 2 l + 1 times the moments of the phase function.
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

    ordinates: Ordinates
    depth: Floats
    weighted: Floats
    k: Floats
    k_tau: Floats
    lower: Reals
    upper: Reals
    mode: Floats
    total: Floats
    net: Floats

    @classmethod
    def of(cls, ordinates: Ordinates, depth: Floats, weighted: Floats) -> LayerModes:
        """The modes of layers of optical depths (N-1, P), with `weighted` as (N-1, L, P)."""
        weighted = np.swapaxes(weighted, 1, 2)[:, :, None]
        even, odd = (_half_operator(ordinates, weighted, parity) for parity in (ordinates.even, ~ordinates.even))
        lower = np.linalg.cholesky(odd)
        upper = np.swapaxes(lower, -1, -2)
        square, mode = np.linalg.eigh(upper @ even @ lower)
        k = np.sqrt(np.maximum(square, _SMALLEST_SQUARE))[..., None, :]
        net: Floats = np.linalg.solve(upper, mode)
        return cls(
            ordinates, depth, weighted, k, k * depth[..., None, None, None], lower, upper, mode, lower @ mode, net
        )

    def reflection_and_transmission(self) -> tuple[Floats, Floats]:
        """Operators (N-1, P, M, n, n) of the layers, from the solutions that are even and odd about their middle."""
        transmitted = np.exp(-self.k_tau)
        absorbed = -np.expm1(-self.k_tau)
        a, b = self.total * (1 + transmitted), self.net * (self.k * absorbed)
        even = (a - b) @ np.linalg.inv(a + b)
        a, b = self.total * (absorbed / self.k), self.net * (1 + transmitted)
        odd = (a - b) @ np.linalg.inv(a + b)
        return 0.5 * (even + odd), 0.5 * (even - odd)

    def scattered_beam(
        self, reflection: Floats, transmission: Floats, beam: Floats, sine: Floats
    ) -> tuple[Floats, Floats]:
        """Light of a beam that the layers scatter and send up and down, (N-1, P, M, n, U) each.

        Parameters
        ----------
        reflection, transmission : (N-1, P, M, n, n) arrays
            Reflection and transmission of the layers.
        beam : (N, P, U) array
            Optical depth from the source to each level.
        sine : (U,) array
            Sine of the source's elevation.
        """
        directions = self.ordinates
        from_source = directions.legendre(-sine)  # (M, L, U)
        scale = -2 * np.sqrt(directions.weight / directions.node)[:, None]
        scale = scale * directions.twice[:, None, None] / (4 * np.pi)  # (M, n, 1)

        def phase(parity: Booleans) -> Floats:
            outgoing = np.where(parity, directions.at_nodes, 0.0)
            part: Floats = scale * (np.swapaxes(outgoing, -1, -2) @ (self.weighted[..., None] * from_source))
            return part

        to_modes = np.swapaxes(self.mode, -1, -2)
        odd = to_modes @ np.linalg.solve(self.lower, phase(~directions.even))
        even = to_modes @ (self.upper @ phase(directions.even))
        k, k_tau = (np.swapaxes(part, -1, -2) for part in (self.k, self.k_tau))
        fall = np.maximum(beam[:-1] - beam[1:], 0.0)[:, :, None, None]
        entering = np.exp(-beam[1:])[:, :, None, None] * self.depth[..., None, None, None]
        joint_depth = k_tau + fall
        at_top = -(k * odd + even) * mean_attenuation(np.zeros_like(joint_depth), joint_depth) * entering
        at_bottom = (
            (k * odd - even)
            * mean_attenuation(np.broadcast_to(k_tau, joint_depth.shape), np.broadcast_to(fall, joint_depth.shape))
            * entering
        )
        sums = self.total @ (at_top / k), self.total @ (at_bottom / k)
        differences = self.net @ at_top, -(self.net @ at_bottom)
        (rise_top, rise_bottom), (fall_top, fall_bottom) = (
            [0.25 * (total + sign * net) for total, net in zip(sums, differences, strict=True)] for sign in (1, -1)
        )
        upward = rise_top - reflection @ fall_top - transmission @ rise_bottom
        downward = fall_bottom - reflection @ rise_bottom - transmission @ fall_top
        return upward, downward

    def emitted(self, reflection: Floats, transmission: Floats, emission: Floats) -> tuple[Floats, Floats]:
        """Thermal radiation that the layers send up and down, (N-1, P, 1, n, 1) each, of light that does not depend on
        azimuth.

        With a blackbody radiance B linear in depth, radiances B + z dB / dtau solve the equations. z is odd in the
        cosine: cosine / (1 - albedo * asymmetry), but for the quadrature. The layer alone lacks what would enter it.

        Parameters
        ----------
        reflection, transmission : (N-1, P, 1, n, n) arrays
            Reflection and transmission of the layers.
        emission : (N, P) array
            Blackbody radiance at the levels.
        """
        directions = self.ordinates
        unit = np.sqrt(directions.weight * directions.node)[:, None]
        bottom, top = (part[..., None, None, None] * unit for part in (emission[:-1], emission[1:]))
        depth = self.depth[..., None, None, None]
        thin = depth < _THIN
        gradient = (emission[:-1] - emission[1:])[..., None, None, None] / np.where(thin, 1.0, depth)
        slope = gradient * np.linalg.solve(self.upper, np.linalg.solve(self.lower, unit))
        mean = 0.5 * (bottom + top)
        isothermal = mean - (reflection + transmission) @ mean
        upward = top + slope - reflection @ (top - slope) - transmission @ (bottom + slope)
        downward = bottom - slope - reflection @ (bottom + slope) - transmission @ (top - slope)
        return np.where(thin, isothermal, upward), np.where(thin, isothermal, downward)


def _half_operator(directions: Ordinates, weighted: Floats, parity: Booleans) -> Floats:
    """Extinction less scattering from node to node (N-1, P, M, n, n), for the sum or the difference of rising and
    falling radiances: alpha +- beta in Stamnes et al. 1988, in symmetric form.
    """
    part = np.where(parity, directions.at_nodes, 0.0) * np.sqrt(directions.weight / directions.node)  # (M, L, n)
    operator: Floats = np.diag(1 / directions.node) - np.swapaxes(part, -1, -2) @ (weighted[..., None] * part)
    return operator
