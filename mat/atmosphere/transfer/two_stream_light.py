"""Light of Sun or Moon that air, particles and ground scatter more than once.

The diffuse field is that of the delta-scaled two-stream equations with the coefficients of the practical improved flux
method, under a beam attenuated along its true path through spherical layers, to twilight and beyond; how much of the
beam's scattering goes up follows the true phase function, and the ground reflects beam and diffuse light. What this
field scatters into a line of sight follows the first two moments of the phase function.

Light scattered once into the line of sight is not part of it: `single_scattering` adds that with the true phase
function. Both use the delta-scaled beam, to which light scattered straight forward by particles belongs, on the way to
the last scattering, so that nothing is counted twice. Between there and the observer all extinction applies. Light
scattered straight forward then reaches a horizontal surface with exactly the energy that the beam lost to it.

Two streams have no dependence on azimuth and are inaccurate close to the horizon. They are used where points are many,
as in the choice of a band's points; `ordinate_light` is used for the chosen ones.

References
----------
Zdunkowski, Welch and Korb 1980, Beitr. Phys. Atmos. 53, 147 (coefficients).
Joseph, Wiscombe and Weinman 1976, J. Atmos. Sci. 33, 2452 (delta scaling).
Dahlback and Stamnes 1991, Planet. Space Sci. 39, 671 (beam through spherical layers over a plane diffuse field).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES, SpectralOptics
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments, mean_attenuation
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS, layer_weights, source_nodes
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.two_stream_layers import TwoStreamLayers, add_layers
from skyshine.schemas.arrays import Floats, Integers, Singles

# Without absorption lambda is 0, by which the closed form of a layer divides. This much absorption removes 1e-4 of the
# light from a layer of optical depth 1e4.
_LARGEST_ALBEDO = 1 - 1e-12
# Points solved together: bounds memory to about 100 MB.
_CHUNK = 512


@dataclass(frozen=True, eq=False)
class TwoStreamLight:
    """Source function of light scattered more than once, per unit of the source's irradiance outside the atmosphere
    [sr^-1].

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    sine : (U,) array
        Of the source's geometric elevation at the place of scattering, increasing.
    extinction : (N, P) array
        m^2 per molecule; single or double precision.
    mean, tilt : (N, U, P) arrays
        The source is mean + tilt for light straight up, mean - tilt straight down, mean + `tilt_weight` * tilt
        between; single precision.
    """

    levels: Floats
    sine: Floats
    extinction: Floats
    mean: Singles
    tilt: Singles

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        shells: Shells,
        optics: SpectralOptics,
        scaled: Floats,
        source_paths: SourcePaths,
        elevations: Sequence[float] = ELEVATIONS,
    ) -> TwoStreamLight:
        """Solve the field of a state.

        Parameters
        ----------
        state : AtmosphericState
        shells : Shells
        optics : SpectralOptics
        scaled : (N, P) array
            Extinction, m^2 per molecule, without the fraction asymmetry^2 of scattering by particles, which delta
            scaling leaves in the beam.
        source_paths : source_paths.SourcePaths
            Through that extinction.
        elevations : sequence of float
            Of the source, at which the field is solved, degree, increasing.
        """
        sine = np.sin(np.radians(elevations))
        shape = (state.altitude.size, sine.size, optics.wavenumber.size)
        mean, tilt = np.empty(shape, np.float32), np.empty(shape, np.float32)
        scattering = optics.rayleigh + optics.aerosol_scattering
        first_moment = optics.aerosol_scattering * optics.asymmetry
        divisor = 2 * np.pi * np.where(optics.extinction > 0, optics.extinction, 1.0)
        fluxes = level_fluxes(state.altitude, shells, optics, scaled, source_paths, sine, state.surface_albedo)
        for part, rising, falling in fluxes:
            mean[:, :, part[1]] = (scattering / divisor)[part][:, None] * (rising + falling)
            tilt[:, :, part[1]] = (first_moment / divisor)[part][:, None] * (rising - falling)
        return cls(state.altitude, sine, optics.extinction, mean, tilt)

    def spectral(
        self, segments: Segments, depths: Depths, cosine: Floats, _deflection: Floats | None = None
    ) -> Singles:
        """Radiance along a ray at each point.

        Parameters
        ----------
        segments : Segments
        depths : Depths
        cosine : (K+1, S) array
            Of the source's zenith angle at the segment ends.

        Returns
        -------
        (S, P) array
            sr^-1.
        """
        nodes, share = source_nodes(self.sine, cosine)
        light = self._at_nodes(segments, depths, nodes)
        count = cosine.shape[1]
        radiance: Singles = share.transpose(1, 0, 2).reshape(count, -1) @ light.reshape(share.shape[0] * nodes.size, -1)
        return radiance

    def by_segment(self, segments: Segments, depths: Depths, cosine: Floats) -> Singles:
        """Radiance of each segment of a ray at the observer, (K, S, P) sr^-1; arguments as `spectral`."""
        nodes, share = source_nodes(self.sine, cosine)
        radiance: Singles = share @ self._at_nodes(segments, depths, nodes)
        return radiance

    def _at_nodes(self, segments: Segments, depths: Depths, nodes: Integers) -> Singles:
        """Radiance of each segment at the observer, (K, V, P), at elevations (V,) of the source."""
        below, above = layer_weights(segments, self.levels, self.extinction, depths)
        light: Singles = below[:, None] * self._toward_observer(segments, segments.layer, nodes)
        light += above[:, None] * self._toward_observer(segments, segments.layer + 1, nodes)
        return light

    def band(self, segments: Segments, depths: Depths, cosine: Floats, _deflection: Floats, weight: Floats) -> Floats:
        """Radiance of a band from all segments up to each end, (K+1, S); `weight` (P,) as in
        `single_scattering.scattered_band`.
        """
        nodes, share = source_nodes(self.sine, cosine)
        scale = max(float(np.max(np.abs(weight))), np.finfo(float).tiny)  # keeps moonlight inside single precision
        unit = (weight / scale).astype(np.float32)
        below, above = layer_weights(segments, self.levels, self.extinction, depths)
        light = np.matmul(self._toward_observer(segments, segments.layer, nodes), (below * unit)[..., None])
        light = light + np.matmul(
            self._toward_observer(segments, segments.layer + 1, nodes), (above * unit)[..., None]
        )  # (K, V, 1)
        radiance = np.zeros((cosine.shape[0], cosine.shape[1]))
        np.cumsum(np.matmul(share, light)[..., 0].astype(float) * scale, axis=0, out=radiance[1:])
        return radiance

    def at(
        self, layer: int, share: float, upward_cosine: float, cosine: Floats, _deflection: Floats | None = None
    ) -> Floats:
        """Source function at one place, (S, P).

        Parameters
        ----------
        layer : int
        share : float
            Weight of its upper level.
        upward_cosine : float
            Of the angle from the vertical at which the light leaves.
        cosine : (S,) array
            Of the source's zenith angle.
        """
        nodes, weight = source_nodes(self.sine, np.stack([cosine, cosine]))
        below, above = (
            self.mean[k, nodes] + tilt_weight(upward_cosine) * self.tilt[k, nodes] for k in (layer, layer + 1)
        )
        source: Floats = weight[0] @ (below * (1 - share) + above * share)
        return source

    def _toward_observer(self, segments: Segments, layer: Integers, nodes: Integers) -> Singles:
        """Source function (K, V, P) at a level (K,) of each segment, for light towards the observer, at elevations (V,)
        of the source.
        """
        rows = layer[:, None], nodes
        source: Singles = (
            self.mean[rows] + tilt_weight(segments.upward_cosine)[:, None, None].astype(np.float32) * self.tilt[rows]
        )
        return source


def tilt_weight(cosine: npt.ArrayLike) -> Floats:
    """Weight of the tilt, -1 to 1, for radiation that travels at a cosine of the angle from the vertical.

    3/2 of the cosine is the first moment of Eddington's field; beyond 1 it would make the source negative.
    """
    weight: Floats = np.clip(1.5 * np.asarray(cosine), -1.0, 1.0)
    return weight


def level_fluxes(
    altitude: Floats,
    shells: Shells,
    optics: SpectralOptics,
    scaled: Floats,
    source_paths: SourcePaths,
    sine: Floats,
    albedo: float,
) -> Iterator[tuple[tuple[slice, slice], Floats, Floats]]:
    """Diffuse fluxes at the levels under a source of unit irradiance, a few points at a time.

    Parameters
    ----------
    altitude : (N,) array
        Of the levels, m.
    shells, optics, scaled, source_paths
        As `TwoStreamLight.of`.
    sine : (U,) array
        Of the source's elevation, the same at every level.
    albedo : float
        Of the ground.

    Yields
    ------
    part : tuple of slice
        All levels, and the points.
    rising, falling : (N, U, p) arrays
        Of delta-scaled light: light scattered straight forward counts as beam.
    """
    in_beam = optics.aerosol_scattering * optics.asymmetry**2
    scattering = optics.rayleigh + optics.aerosol_scattering - in_beam
    first_moment = optics.aerosol_scattering * optics.asymmetry - in_beam
    particles_up = upward_share(optics.phase, sine)
    count = altitude.size
    for start in range(0, optics.wavenumber.size, _CHUNK):
        part = slice(None), slice(start, start + _CHUNK)
        paths = replace(source_paths, log_depth=source_paths.log_depth[..., part[1]])
        beam = paths.optical_depth(altitude, np.broadcast_to(sine, (count, sine.size))).astype(float)
        depth, scattered, moment = (
            vertical_column(shells, values[part]) for values in (scaled, scattering, first_moment)
        )
        up = optics.aerosol_scattering[part][:, None] * (particles_up @ optics.phase_share[:, part[1]])
        up = (up + 0.5 * optics.rayleigh[part][:, None]).reshape(count, -1)
        upward = vertical_column(shells, up).reshape(count - 1, sine.size, -1)
        yield part, *diffuse_fluxes(depth, scattered, moment, upward, beam, sine, albedo)


def upward_share(phase: Floats, sine: Floats) -> Floats:
    """Fraction of a beam's scattering that goes up.

    Parameters
    ----------
    phase : (A, N, C) array
        Phase function at `optics.PHASE_ANGLES`.
    sine : (U,) array
        Of the source's elevation.

    Returns
    -------
    (N, U, C) array
    """
    # `part` is the fraction above the horizon of the circle of directions at one angle from the beam.
    beam = np.sqrt(np.maximum(1 - sine**2, 1e-12))[:, None] * np.sin(PHASE_ANGLES)
    rim = sine[:, None] * np.cos(PHASE_ANGLES) / np.maximum(beam, 1e-12)
    part = np.arccos(np.clip(rim, -1.0, 1.0)) / np.pi
    edges = np.concatenate([[0.0], 0.5 * (PHASE_ANGLES[1:] + PHASE_ANGLES[:-1]), [np.pi]])
    weight = -np.diff(np.cos(edges))
    total = np.einsum("a,anc->nc", weight, phase)
    share: Floats = np.einsum("ua,anc->nuc", part * weight, phase) / total[:, None]
    return share


def diffuse_fluxes(
    depth: Floats,
    scattering: Floats,
    first_moment: Floats,
    upward: Floats,
    beam: Floats,
    sine: Floats,
    albedo: float,
) -> tuple[Floats, Floats]:
    """Diffuse fluxes under a beam of unit irradiance.

    Parameters
    ----------
    depth, scattering, first_moment : (N-1, P) arrays
        Of the layers from the ground up, delta scaled: optical depth, that of scattering, and that times the asymmetry.
    upward : (N-1, U, P) array
        Optical depth of that scattering of the beam which goes up.
    beam : (N, U, P) array
        Optical depth from the source to each level, delta scaled.
    sine : (U,) array
        Of the source's elevation.
    albedo : float
        Of the ground.

    Returns
    -------
    rising, falling : (N, U, P) arrays

    References
    ----------
    Zdunkowski, Welch and Korb 1980: gamma1 = 2 - omega (1.25 + 0.75 g), gamma2 = 0.75 omega (1 - g).
    """
    tau, scattering = depth[:, None], scattering[:, None]
    opaque, scatters = tau > 0, scattering > 0
    omega = np.minimum(np.where(opaque, scattering / np.where(opaque, tau, 1.0), 0.0), _LARGEST_ALBEDO)
    g = np.where(scatters, first_moment[:, None] / np.where(scatters, scattering, 1.0), 0.0)
    layers = TwoStreamLayers.of(2 - omega * (1.25 + 0.75 * g), 0.75 * omega * (1 - g), tau)
    # The upward part of the delta-scaled scattering cannot exceed the whole.
    up = np.clip(np.where(scatters, upward / np.where(scatters, scattering, 1.0), 0.5), 0.0, 1.0)
    rises, falls = _scattered_beam(layers, omega, up, beam)
    ground = albedo * np.maximum(sine, 0.0)[:, None] * np.exp(-beam[0])
    return add_layers(layers.reflection, layers.transmission, rises, falls, albedo, ground)


def _scattered_beam(layers: TwoStreamLayers, omega: Floats, up: Floats, beam: Floats) -> tuple[Floats, Floats]:
    """Flux that layers send out at the top and at the bottom of the light they scatter out of a beam, (N-1, U, P) each.

    Parameters
    ----------
    layers : TwoStreamLayers
        Of (N-1, 1, P) arrays.
    omega : (N-1, 1, P) array
        Single-scattering albedo.
    up : (N-1, U, P) array
        Fraction of the beam's scattering that goes up.
    beam : (N, U, P) array
        Optical depth from the source to each level.
    """
    # The beam falls exponentially inside a layer; `to_top` and `to_bottom` are the mean of its scattering over the
    # layer, weighted with exp(-lambda t) for the optical depth t to the top and to the bottom.
    fall = np.maximum(beam[:-1] - beam[1:], 0.0)
    lambda_tau = layers.lambda_ * layers.tau
    scattered = omega * layers.tau * np.exp(-beam[1:])
    to_top = mean_attenuation(np.zeros_like(fall), lambda_tau + fall) * scattered
    to_bottom = mean_attenuation(np.broadcast_to(lambda_tau, fall.shape), fall) * scattered
    Gamma, exp_lambda_tau = layers.Gamma, layers.exp_lambda_tau
    closed = 1 - (Gamma * exp_lambda_tau) ** 2
    rises = (
        up * (to_top - Gamma**2 * exp_lambda_tau * to_bottom) + (1 - up) * Gamma * (to_top - exp_lambda_tau * to_bottom)
    ) / closed
    falls = (
        (1 - up) * (to_bottom - Gamma**2 * exp_lambda_tau * to_top) + up * Gamma * (to_bottom - exp_lambda_tau * to_top)
    ) / closed
    return rises, falls
