"""A state made ready for transfer at a set of spectral points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics, spectral_optics
from skyshine.mat.atmosphere.transfer.ordinate_light import StreamLight, straight_share
from skyshine.mat.atmosphere.transfer.segments import (
    Depths,
    emitted,
    scattered_band,
    scattered_spectral,
    segment_attenuation,
)
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths, SourceRays
from skyshine.mat.atmosphere.transfer.thermal_source import ThermalSource, thermal_source
from skyshine.mat.atmosphere.transfer.two_stream_light import DiffuseLight


@dataclass(frozen=True, eq=False)
class SpectralAir:
    """Layers, optical properties and paths to a distant source of a state, at P spectral points.

    Attributes
    ----------
    state : AtmosphericState
    shells : Shells
        Refracting as at the mean wavenumber of the points.
    optics : SpectralOptics
    source_rays : SourceRays
    streams : bool
        Light scattered more than once is that of `streams.StreamLight`, not of the two streams of
        `multiple.DiffuseLight`.
    scatters : bool
        Light of the source is scattered; False leaves it out of paths and sky, and lets it fall on surfaces directly.
    """

    state: AtmosphericState
    shells: Shells
    optics: SpectralOptics
    source_rays: SourceRays
    streams: bool = False
    scatters: bool = True

    @classmethod
    def of(cls, state, points, gases=None, weight=None, *, streams=False):
        """Prepare a state.

        Parameters
        ----------
        state : AtmosphericState
        points : SpectralPoints
        gases : sequence of str, optional
            Those that absorb; by default all.
        weight : (P,) array, optional
            For the mean wavenumber; by default that of the points.
        streams : bool
            For some hundred points at most: a field takes 1 MB a point.
        """
        optics = spectral_optics(state, points, gases)
        mean = float(np.average(optics.wavenumber, weights=points.weight if weight is None else weight))
        shells = Shells.of(state.altitude, state.number_density, mean)
        return cls(state, shells, optics, SourceRays.of(shells), streams)

    def part(self, points):
        """The same air at a slice of the points."""
        return replace(self, optics=self.optics.at(points))

    def prepare(self):
        """Compute what is kept, before several threads ask for it."""
        for kept in (
            "source_paths",
            "thermal",
            *(("scaled_extinction", "scaled_source_paths", "diffuse_light") if self.scatters else ()),
        ):
            getattr(self, kept)

    @cached_property
    def source_paths(self) -> SourcePaths:
        """Paths of a distant source's light."""
        return SourcePaths.of(self.source_rays, self.optics.extinction)

    @cached_property
    def thermal(self) -> ThermalSource:
        """The source function of thermal radiation."""
        return thermal_source(self.state, self.shells, self.optics)

    def thermal_radiance(self, segments, depths):
        """Thermal radiance of each segment of a ray at the observer, (K, P) W m^-2 sr^-1 (cm^-1)^-1, in the depths'
        precision.

        Parameters
        ----------
        segments : transfer.Segments
        depths : transfer.Depths
        """
        thermal = self._single_thermal if depths.each.dtype == np.float32 else self.thermal
        near, far = segments.source(thermal.mean, thermal.tilt, self.shells.altitude)
        return emitted(depths, near, far)

    @cached_property
    def _single_thermal(self):
        return ThermalSource(self.thermal.mean.astype(np.float32), self.thermal.tilt.astype(np.float32))

    @cached_property
    def scaled_extinction(self):
        """Of the beam that is scattered, (N, P) m^2 per molecule: without what particles throw straight on."""
        return self.optics.extinction - self.optics.aerosol_scattering * self.straight_share

    @cached_property
    def straight_share(self):
        """Share (N, P) of the scattering by particles that goes straight on."""
        return straight_share(self.optics) if self.streams else self.optics.asymmetry**2

    @cached_property
    def scaled_source_paths(self):
        """`source_paths` through the scaled extinction."""
        if not np.any(self.optics.aerosol_scattering):
            return self.source_paths
        return SourcePaths.of(self.source_rays, self.scaled_extinction)

    @cached_property
    def diffuse_light(self):
        """`streams.StreamLight` or `multiple.DiffuseLight` of the source."""
        paths = self.scaled_source_paths
        if self.streams:
            return StreamLight.of(self.state, self.shells, self.optics, self.straight_share, paths)
        return DiffuseLight.of(self.state, self.shells, self.optics, self.scaled_extinction, paths)

    def scattered_radiance(self, segments, depths, to_source, deflection, phase=None):
        """Scattered light of the source along a ray.

        Parameters
        ----------
        segments : transfer.Segments
        depths : transfer.Depths
        to_source, deflection : (K+1, S) arrays
            Cosines of the source's zenith angle and of the scattering angle at the segment ends.
        phase : (N, S, C) array, optional
            As in `transfer.scattered_spectral`.

        Returns
        -------
        (S, P) array
            Per unit of the source's irradiance, sr^-1.
        """
        seen = self._seen_through(segments, depths)
        attenuation = segment_attenuation(segments, seen, self.scaled_source_paths, to_source)
        once = scattered_spectral(segments, self.optics, attenuation, deflection, phase)
        return once + self.diffuse_light.spectral(segments, depths, to_source, deflection)

    def scattered_in_band(self, segments, depths, to_source, deflection, weight):
        """Scattered light in a band up to each end of a ray's segments, (K+1, S); `weight` as in
        `transfer.scattered_band`.
        """
        paths, seen = self.scaled_source_paths, self._seen_through(segments, depths)
        once = scattered_band(segments, self.optics, seen, paths, to_source, deflection, weight)
        return once + self.diffuse_light.band(segments, depths, to_source, deflection, weight)

    def _seen_through(self, segments, depths):
        """`transfer.Depths` for light scattered once: what then goes straight on is not lost."""
        return Depths(segments.column(self.scaled_extinction)) if self.streams else depths
