"""A state made ready for transfer at a set of spectral points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES, delta_fraction, solved_moments
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS
from skyshine.mat.atmosphere.transfer.forward_peak import ForwardPeak
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.layer_columns import vertical_column, vertical_parts
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics, spectral_optics
from skyshine.mat.atmosphere.transfer.ordinate_light import OrdinateLight
from skyshine.mat.atmosphere.transfer.ordinates import AZIMUTHAL
from skyshine.mat.atmosphere.transfer.scattered_light import ScatteredLight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths, SourceRays
from skyshine.mat.atmosphere.transfer.stream_count import azimuthal_count, node_count
from skyshine.mat.atmosphere.transfer.thermal_light import ThermalLight
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalSource
from skyshine.schemas.arrays import Floats, Integers, Reals


@dataclass(frozen=True, eq=False)
class SpectralAir:
    """Layers, optical properties and paths to a distant source of a state, at P spectral points.

    Attributes
    ----------
    shells : Shells
        Refracting as at the mean wavenumber of the points.
    scatters : bool
        Light of the source is scattered; with False, path and sky radiance are thermal only and surfaces receive direct
        light.
    elevations : tuple of float
        Elevations of the source at which the field of multiply scattered light is solved, degree, increasing.
    azimuthal : int
        Azimuthal moments of that field.
    nodes : int
        Number of discrete ordinates of scattered light in each hemisphere.
    spherical : bool
        Geometry of that field under a low source: spherical, or with False plane under beams through spherical layers.
    every : int
        The field of light scattered more than once is solved at one of so many points.
    angles : tuple of float
        Angles from the vertical of the directions at which source functions of scattered light are tabulated, rad,
        increasing.
    """

    state: AtmosphericState
    shells: Shells
    optics: SpectralOptics
    source_rays: SourceRays
    scatters: bool = True
    elevations: tuple[float, ...] = ELEVATIONS
    azimuthal: int = AZIMUTHAL
    nodes: int = NODES
    spherical: bool = True
    every: int = 1
    angles: tuple[float, ...] = DIRECTIONS

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        points: SpectralPoints,
        gases: Sequence[str] | None = None,
        weight: Floats | None = None,
    ) -> SpectralAir:
        """Prepare a state.

        Parameters
        ----------
        gases : sequence of str, optional
            Those that absorb; by default all.
        weight : (P,) array, optional
            Weights of the mean wavenumber; by default those of the points.
        """
        optics = spectral_optics(state, points, gases)
        mean = float(np.average(optics.wavenumber, weights=points.weight if weight is None else weight))
        shells = Shells.of(state.altitude, state.number_density, mean)
        nodes = node_count(state)
        return cls(state, shells, optics, SourceRays.of(shells), nodes=nodes, azimuthal=azimuthal_count(nodes))

    def part(self, points: slice | Integers) -> SpectralAir:
        """The same air at some of the points, with the fields of light that are solved already."""
        part = replace(self, optics=self.optics.at(points))
        if "thermal" in vars(self):
            vars(part)["thermal"] = self.thermal.part(points)
        if "diffuse_light" in vars(self):
            vars(part)["diffuse_light"] = self.diffuse_light.part(points)
        return part

    def prepare(self) -> None:
        """Compute the cached properties once, before several threads use them."""
        names = ["source_paths", "thermal"]
        if self.scatters:
            names += ["scaled_extinction", "scaled_source_paths", "diffuse_light", "scattered_light"]
        for name in names:
            getattr(self, name)

    @cached_property
    def source_paths(self) -> SourcePaths:
        """Paths of a distant source's light."""
        return SourcePaths.of(self.source_rays, self.optics.extinction)

    @cached_property
    def thermal(self) -> ThermalSource:
        """The source function of thermal radiation."""
        return ThermalSource.of(self.state, self.shells, self.optics, self.nodes, self.angles)

    def thermal_radiance(self, segments: Segments, depths: Depths) -> Reals:
        """Thermal radiance of each segment of a ray at the observer, (K, P) W m^-2 sr^-1 (cm^-1)^-1, in the depths'
        precision.
        """
        real = depths.per_segment.dtype
        if real not in self._thermal_light:
            self._thermal_light[real] = ThermalLight(self.thermal, real)
        return self._thermal_light[real].of_segments(segments, depths)

    @cached_property
    def _thermal_light(self) -> dict[np.dtype[Any], ThermalLight]:
        """By precision of the depths."""
        return {}

    @cached_property
    def thermal_skies(self) -> dict[tuple[float, int], Floats]:
        """Thermal irradiance (P,) of level surfaces by altitude [m] and number of directions, as `sky` computes it."""
        return {}

    @cached_property
    def scaled_extinction(self) -> Floats:
        """Delta-scaled extinction (N, P) [m^2 per molecule]: without the scattering straight forward by particles."""
        return self.optics.extinction - self.optics.aerosol_scattering * self.delta_fraction

    @cached_property
    def delta_fraction(self) -> Floats:
        """Fraction (N, P) of the scattering by particles that counts as straight forward."""
        return delta_fraction(self.optics, self.nodes)

    @cached_property
    def scaled_source_paths(self) -> SourcePaths:
        """`source_paths` through the scaled extinction."""
        if not np.any(self.optics.aerosol_scattering):
            return self.source_paths
        return SourcePaths.of(self.source_rays, self.scaled_extinction)

    @cached_property
    def forward_peak(self) -> ForwardPeak:
        """What scattering again and again in the forward peak changes of light scattered once."""
        moments, column = self.optics.moments, np.zeros(self.state.altitude.size)
        for level, air in ((slice(None, -1), 0), (slice(1, None), 1)):
            column[level] += vertical_parts(self.shells, np.ones((column.size, 1)))[air][:, 0]
        return ForwardPeak(
            self.optics,
            self.delta_fraction,
            solved_moments(self.optics, self.nodes),
            np.clip(moments[2 * self.nodes], 0.0, None),
            column,
            self.source_rays,
        )

    @cached_property
    def diffuse_light(self) -> OrdinateLight:
        """Light of the source scattered more than once; with all elevations and moments it takes 1 MB a point."""
        if self.every > 1:
            return self._field_between()
        return OrdinateLight.of(
            self.state,
            self.shells,
            self.optics,
            self.delta_fraction,
            self.scaled_source_paths,
            self.elevations,
            self.azimuthal,
            self.nodes,
            self.angles,
            spherical=self.spherical,
        )

    def _field_between(self) -> OrdinateLight:
        """The field solved at one of `every` points, in the order of their vertical optical depth d, and linear in
        d / (1 + d) between them.
        """
        depth = vertical_column(self.shells, self.optics.extinction).sum(axis=0)
        depth /= 1 + depth
        order = np.argsort(depth, kind="stable")
        number = np.unique(np.linspace(0, order.size - 1, -(-order.size // self.every) + 1).round().astype(int))
        solved = order[number]
        lower = np.clip(np.searchsorted(depth[solved], depth, side="right") - 1, 0, max(solved.size - 2, 0))
        step = depth[solved][lower + 1] - depth[solved][lower]
        share = np.clip((depth - depth[solved][lower]) / np.where(step > 0, step, 1.0), 0.0, 1.0)
        light = replace(self, every=1).part(solved).diffuse_light
        return light.between(self.shells, self.optics, self.delta_fraction, solved, lower, share)

    @cached_property
    def scattered_light(self) -> ScatteredLight:
        """Light of a source scattered into lines of sight."""
        peak = None if self.scaled_source_paths is self.source_paths else self.forward_peak
        return ScatteredLight(self.optics, self.scaled_source_paths, peak, self.diffuse_light)
