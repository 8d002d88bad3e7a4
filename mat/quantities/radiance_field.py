"""Radiance around a point in the air by direction: sky above, air and ground below, from the solver of path radiance.

The ground reflects the sky and the source evenly to all sides, with the albedo of the state; what it emits is left to
the transmittance towards it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.optics import PHASE_ANGLES
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.quantities.joined_paths import in_groups
from skyshine.schemas.arrays import Floats

# Directions within a cell, each way, over which the phase function is averaged; azimuths for the cosine to a face.
_SAMPLES = 8
_POINTS = 16  # spectral points that count as one source where lines are joined


@dataclass(frozen=True, eq=False)
class Directions:
    """Cells of the sphere: D zenith angles, of which the first half point down, by A azimuths from the source.

    The other half of the azimuths mirrors them. Zenith angles are Gauss nodes in the square root of the cosine, which
    gather at the horizon, where radiance varies most; azimuths are equally spaced, exact for cos(m phi), m < 2 A.

    Attributes
    ----------
    cosine, weight : (D,) arrays
        Cosine of the zenith angle, and its weight; the weights of a hemisphere sum to 1.
    edges : (D, 2) array
        Bounds of the cells in that cosine.
    """

    cosine: Floats
    weight: Floats
    edges: Floats
    azimuths: int

    @classmethod
    def of(cls, zeniths: int, azimuths: int) -> Directions:
        """So many zenith angles in each hemisphere and azimuths in half a turn."""
        node, weight = np.polynomial.legendre.leggauss(zeniths)
        root, weight = 0.5 * (node + 1), 0.5 * weight
        bounds = np.append(0.0, np.cumsum(weight)) ** 2
        bounds[-1] = 1.0
        cosine, weight = root**2, 2 * root * weight
        edges = np.stack([bounds[:-1], bounds[1:]], axis=1)
        return cls(
            np.concatenate([-cosine[::-1], cosine]),
            np.concatenate([weight[::-1], weight]),
            np.concatenate([-edges[::-1, ::-1], edges]),
            azimuths,
        )

    @property
    def azimuth(self) -> Floats:
        """(A,) rad."""
        return np.pi * (np.arange(self.azimuths) + 0.5) / self.azimuths

    @property
    def solid_angle(self) -> Floats:
        """(D, 1) [sr], of each cell and its mirror image."""
        return (2 * np.pi / self.azimuths * self.weight)[:, None]

    @property
    def vectors(self) -> Floats:
        """Unit vectors (D, A, 3); z points up, x towards the source's azimuth."""
        return _vectors(self.cosine[:, None], self.azimuth)

    @cached_property
    def samples(self) -> Floats:
        """Unit vectors (D, A, N, 3) evenly over each cell."""
        part = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
        cosine = self.edges[:, :1] + np.diff(self.edges) * part
        azimuth = self.azimuth[:, None] + np.pi / self.azimuths * (part - 0.5)
        vectors = _vectors(cosine[:, None, :, None], azimuth[None, :, None, :])
        return vectors.reshape(self.cosine.size, self.azimuths, -1, 3)

    def irradiance_weights(self, normal: Floats) -> Floats:
        """Weights (D, A) [sr] with which radiance sums to the irradiance of a face with a normal (3,).

        The cosine is averaged over the azimuths of a cell alone: a ring of the sphere depends so smoothly on its zenith
        angle that the Gauss nodes keep their accuracy.
        """
        part = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
        azimuth = self.azimuth[:, None] + np.pi / self.azimuths * part
        ring = _vectors(self.cosine[:, None, None], azimuth)
        mirrored = normal * np.array([1.0, -1.0, 1.0])
        cosine = np.stack([np.maximum(ring @ side, 0.0).mean(axis=-1) for side in (normal, mirrored)]).sum(axis=0)
        weights: Floats = 0.5 * self.solid_angle * cosine
        return weights


def _vectors(cosine: Floats, azimuth: Floats) -> Floats:
    sine = np.sqrt(1 - cosine**2)
    return np.stack(np.broadcast_arrays(sine * np.cos(azimuth), sine * np.sin(azimuth), cosine), axis=-1)


@dataclass(frozen=True, eq=False)
class GroundReflection:
    """Radiance that the ground reflects, W m^-2 sr^-1 (cm^-1)^-1.

    Attributes
    ----------
    thermal : (P,) array
        Reflection of the air's emission.
    scattered : (S, P) array
        Reflection of a source's light at each of S elevations, per unit of its irradiance outside the atmosphere.
    """

    thermal: Floats
    scattered: Floats

    @classmethod
    def of(cls, air: SpectralAir, source_elevation: Floats) -> GroundReflection:
        """Reflection of the state's ground under a source at elevations (S,) [rad]."""
        altitude = np.array([air.state.surface_altitude])
        share = air.state.albedo_at(air.optics.wavenumber) / np.pi
        sky = sky_irradiance(air, altitude, source_elevation)
        direct = direct_transmittance(air.source_paths, altitude, source_elevation)[0]
        beam = np.maximum(np.sin(source_elevation), 0.0)[:, None] * direct
        return cls(share * sky.thermal[0], share * (sky.scattered[0] + beam))


@dataclass(frozen=True, eq=False)
class RadianceField:
    """Radiance from D x A directions at a point, at P spectral points.

    Attributes
    ----------
    thermal : (D, P) array
        Emitted and scattered by the air or reflected by the ground, without the ground's emission, W m^-2 sr^-1
        (cm^-1)^-1.
    scattered : (D, S, A, P) array
        Light of a source at S elevations, per unit of its irradiance outside the atmosphere.
    to_ground : (D, P) array
        Transmittance to the ground; 0 where the direction does not meet it.
    """

    thermal: Floats
    scattered: Floats
    to_ground: Floats

    @classmethod
    def at(
        cls,
        air: SpectralAir,
        altitude: float,
        source_elevation: Floats,
        reflection: GroundReflection,
        directions: Directions,
        phases: Sequence[Floats] | None,
    ) -> RadianceField:
        """The field at an altitude [m] under a source at geometric elevations (S,) [rad]; with `cell_phases` of the
        directions, or None for a source without light.
        """
        count, points = directions.cosine.size, air.optics.wavenumber.size
        rays = trace(air.shells, np.full(count, altitude), np.arcsin(directions.cosine))
        thermal, to_ground = np.zeros((count, points)), np.zeros((count, points))
        scattered = np.zeros((count, source_elevation.size, directions.azimuths, points))
        sources = np.repeat(source_elevation, directions.azimuths), np.tile(directions.azimuth, source_elevation.size)
        cosines = source_cosine(rays, *sources), scattering_cosine(rays, *sources)
        for group in in_groups(count, sources[0].size * points // _POINTS):
            lines = [Segments.of(rays, row) for row in range(group.start, group.stop)]
            segments, offset = Segments.joined(lines)
            if not segments.index.size:
                to_ground[group] = 1.0
                continue
            depths = Depths(segments.column(air.optics.extinction), offset)
            thermal[group] = depths.by_line(air.thermal_radiance(segments, depths))
            to_ground[group] = np.exp(-depths.cumulative[np.append(offset[1:], segments.altitude.size) - 1])
            if phases is not None and air.scatters and source_elevation.size:
                to_source, deflection = (
                    np.concatenate([part[group.start + row, line.ends] for row, line in enumerate(lines)])
                    for part in cosines
                )
                light = air.scattered_light.along(segments, depths, to_source, deflection, np.stack(phases[group]))
                scattered[group] = light.reshape(-1, source_elevation.size, directions.azimuths, points)
        to_ground[~rays.ground] = 0.0
        thermal += to_ground * reflection.thermal
        scattered += to_ground[:, None, None] * reflection.scattered[:, None]
        return cls(thermal, scattered, to_ground)

    def radiance(self, irradiance: Floats) -> Floats:
        """Radiance (D, S, A, P) under a source of irradiance (P,) outside the atmosphere, without the ground's
        emission.
        """
        return self.thermal[:, None, None] + self.scattered * irradiance


def cell_phases(air: SpectralAir, directions: Directions, source_elevation: Floats) -> list[Floats]:
    """Phase function of particles at the levels, mean over the cells of each zenith angle, D of (N, S * A, C).

    Particles scatter most within a few degrees of the source, which single directions would miss. The mean is scaled to
    the cell's true solid angle, so that the sum of the cells is the whole.
    """
    source = np.stack([np.cos(source_elevation), np.zeros_like(source_elevation), np.sin(source_elevation)], axis=-1)
    angle = np.arccos(np.clip(np.einsum("danx,sx->dsan", directions.samples, source, optimize=True), -1.0, 1.0))
    position = angle / PHASE_ANGLES[1]
    lower = np.minimum(position.astype(int), PHASE_ANGLES.size - 2)
    cells, samples = lower[..., 0].size, lower.shape[-1]
    index = lower.reshape(cells, samples) + PHASE_ANGLES.size * np.arange(cells)[:, None]
    upper = (position - lower).reshape(cells, samples)
    places, share = np.concatenate([index, index + 1]), np.concatenate([1 - upper, upper])
    weight = np.bincount(places.ravel(), share.ravel(), minlength=cells * PHASE_ANGLES.size)
    scale = np.diff(directions.edges)[:, 0] / directions.weight / samples
    per_cell = weight.reshape(scale.size, -1, PHASE_ANGLES.size) * scale[:, None, None]
    levels, wavelengths = air.optics.phase.shape[1:]
    mean = per_cell @ air.optics.phase.reshape(PHASE_ANGLES.size, -1)
    return list(np.moveaxis(mean.reshape(scale.size, -1, levels, wavelengths), 2, 1))
