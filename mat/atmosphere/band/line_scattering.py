"""Light of a source that the segments of sampled lines of sight scatter to the observer, at many points at once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.band.sample import SampledLine
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.atmosphere.transfer.single_scattering import scattering_of_segments, segment_attenuation
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.two_stream_light import TwoStreamLight
from skyshine.schemas.arrays import Singles


@dataclass(frozen=True, eq=False)
class LineScattering:
    """What light of the source along lines of sight is computed from, in single precision.

    Attributes
    ----------
    optics : SpectralOptics
    paths : SourcePaths
        Delta scaled.
    diffuse : TwoStreamLight
    """

    optics: SpectralOptics
    paths: SourcePaths
    diffuse: TwoStreamLight

    @classmethod
    def of(cls, air: SpectralAir) -> LineScattering:
        """Of air with two streams."""
        optics, diffuse = air.optics.single, air.diffuse_light
        if not isinstance(diffuse, TwoStreamLight):
            raise TypeError("points are chosen with two streams")
        return cls(optics, air.scaled_source_paths, replace(diffuse, extinction=optics.extinction))

    def radiance(self, line: SampledLine, depths: Depths) -> Singles:
        """Light of the source that each segment of a line scatters to the observer, (K, P), per unit of its
        irradiance.
        """
        attenuation = segment_attenuation(line.segments, depths, self.paths, line.to_source)
        once = attenuation * scattering_of_segments(line.segments, self.optics, line.deflection)
        once /= np.float32(4 * np.pi)
        radiance: Singles = (once + self.diffuse.by_segment(line.segments, depths, line.to_source))[:, 0]
        return radiance
