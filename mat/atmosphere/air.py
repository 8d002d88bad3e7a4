"""A state made ready for transfer at a set of spectral points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.diffuse import ThermalSource, thermal_source
from skyshine.mat.atmosphere.geometry import Shells
from skyshine.mat.atmosphere.optics import SpectralOptics, spectral_optics
from skyshine.mat.atmosphere.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import SourcePaths, emitted


@dataclass(frozen=True, eq=False)
class SpectralAir:
    """Layers, optical properties and paths to a distant source of a state, at P spectral points.

    Attributes
    ----------
    state : AtmosphericState
    shells : Shells
        Refracting as at the mean wavenumber of the points.
    optics : SpectralOptics
    source_paths : SourcePaths
    thermal : ThermalSource
    """

    state: AtmosphericState
    shells: Shells
    optics: SpectralOptics
    source_paths: SourcePaths
    thermal: ThermalSource

    @classmethod
    def of(cls, state, points, gases=None, weight=None):
        """Prepare a state.

        Parameters
        ----------
        state : AtmosphericState
        points : SpectralPoints
        gases : sequence of str, optional
            Those that absorb; by default all.
        weight : (P,) array, optional
            For the mean wavenumber; by default that of the points.
        """
        optics = spectral_optics(state, points, gases)
        mean = float(np.average(optics.wavenumber, weights=points.weight if weight is None else weight))
        shells = Shells.of(state.altitude, state.number_density, mean)
        paths = SourcePaths.of(shells, optics.extinction)
        return cls(state, shells, optics, paths, thermal_source(state, shells, optics))

    def thermal_radiance(self, segments, optical_depth):
        """Thermal path radiance up to each end of a ray's segments, (K+1, P) W m^-2 sr^-1 (cm^-1)^-1.

        Parameters
        ----------
        segments : transfer.Segments
        optical_depth : (K, P) array
            Of each segment.
        """
        near, far = segments.source(self.thermal.mean, self.thermal.tilt, self.shells.altitude)
        return emitted(optical_depth, near, far)
