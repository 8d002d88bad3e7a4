"""Light of a source that the segments of sampled lines of sight scatter to the observer, at many points at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.sample import SampledLine
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.forward_peak import ForwardPeak
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinate_light import OrdinateLight
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.atmosphere.transfer.single_scattering import scattering_of_segments, segment_attenuation
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.schemas.arrays import Singles


@dataclass(frozen=True, eq=False)
class LineScattering:
    """What light of the source along lines of sight is computed from, in single precision.

    Attributes
    ----------
    optics : SpectralOptics
    paths : SourcePaths
        Delta scaled.
    peak : ForwardPeak
    diffuse : OrdinateLight
    """

    optics: SpectralOptics
    paths: SourcePaths
    peak: ForwardPeak
    diffuse: OrdinateLight

    @classmethod
    def of(cls, air: SpectralAir) -> LineScattering:
        """What the light is computed from, of the air at its points."""
        optics = air.optics.single
        return cls(optics, air.scaled_source_paths, air.forward_peak, air.diffuse_light.single)

    def radiance(self, line: SampledLine, depths: Depths) -> Singles:
        """Light of the source that each segment of a line scatters to the observer, (K, P), per unit of its
        irradiance.
        """
        scaled = Depths(line.segments.column(self.diffuse.scaled))
        attenuation = segment_attenuation(line.segments, scaled, self.paths, line.to_source)
        once = attenuation * scattering_of_segments(line.segments, self.optics, line.deflection)
        once /= np.float32(4 * np.pi)
        if self.peak.near(line.segments, line.to_source, line.deflection).any():
            once += self.peak.by_segment(line.segments, attenuation, line.to_source, line.deflection)
        angles = line.to_source, line.deflection
        radiance: Singles = once[:, 0] + self.diffuse.by_segment(line.segments, depths, scaled, *angles)
        return radiance
