"""Parts of the kernel's light alone: scattered once, scattered more often, of a thermal field, of a short path."""

from dataclasses import replace

import numpy as np

from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.ordinate_light import OrdinateLight
from skyshine.mat.atmosphere.transfer.ordinates import ordinates
from skyshine.mat.atmosphere.transfer.scattered_light import ScatteredLight
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.thermal_light import ThermalLight


def scattered_once(air, optics=None, paths=None, scaled=None, peak=None):
    """Light scattered once in air, by its optics, source paths and delta-scaled extinction (N, P) or by others."""
    optics, paths = optics or air.optics, paths or air.scaled_source_paths
    scaled = air.scaled_extinction if scaled is None else scaled
    levels, points = scaled.shape
    functions, sine = ordinates(2, 1), np.array([-1.0, 1.0])
    dark = np.zeros((levels, sine.size, functions.pairs[0].size, points), np.float32)
    parts, falling = LayerParts.whole(levels - 1), np.zeros((levels, sine.size, points))
    field = OrdinateLight(
        air.state.altitude, sine, scaled, scaled, functions, parts, dark, None, np.array(DIRECTIONS), falling
    )
    return ScatteredLight(optics, paths, peak, field)


def scattered_again(air, field=None):
    """Light scattered more than once in air, of its field or of another."""
    none = replace(
        air.optics,
        rayleigh=np.zeros_like(air.optics.rayleigh),
        aerosol_scattering=np.zeros_like(air.optics.aerosol_scattering),
    )
    return ScatteredLight(none, air.scaled_source_paths, None, field or air.diffuse_light)


def without_peak(air):
    """Light scattered in air, without scattering again and again in the forward peak."""
    return ScatteredLight(air.optics, air.scaled_source_paths, None, air.diffuse_light)


def thermal_of(source, field, segments, depths, real=float):
    """Thermal radiance (K, P) of segments through a source with another field."""
    return ThermalLight(replace(source, field=field), real).of_segments(segments, depths)


def thermal_source(air, layer, share, upward_cosine):
    """Thermal source function (P,) inside a layer at a share of its height, by which a short path shines."""
    altitude = air.state.altitude[layer] * (1 - share) + air.state.altitude[layer + 1] * share
    amount = 1e-9 / air.optics.extinction[layer : layer + 2].max()
    still, direction = np.zeros(2), np.full(2, np.arccos(-upward_cosine))
    lower, upper = (np.array([amount * part]) for part in (1 - share, share))
    segments = Segments(
        np.zeros(1, int), np.array([layer]), lower, upper, np.full(2, altitude), still, direction, still
    )
    depths = Depths(segments.column(air.optics.extinction))
    return air.thermal_radiance(segments, depths)[0] / depths.per_segment[0]
