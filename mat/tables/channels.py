"""Layout of atmospheric databases in channels: monochromatic points whose light follows Beer's law."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.quantities.ambient_harmonics import GROUND_TEMPERATURES
from skyshine.mat.radiometry.spherical_harmonics import HARMONICS, zonal
from skyshine.mat.tables.atmq import RADIANCE
from skyshine.mat.tables.axes import DARK_BELOW, EXACT, table_axis
from skyshine.mat.tables.band import WAVELENGTH
from skyshine.schemas.hdf5 import Axis, Group, Variable

if TYPE_CHECKING:
    from skyshine.mat.quantities.channels.coordinates import RayCoordinates
    from skyshine.mat.quantities.channels.nodes import ChannelNodes
    from skyshine.mat.quantities.channels.parts import Parts
    from skyshine.mat.quantities.channels.path_fields import BandLight, PathFields
    from skyshine.mat.quantities.channels.source_parts import SourceParts
    from skyshine.mat.quantities.channels.surface_light import LightParts, SurfaceLight
    from skyshine.mat.quantities.channels.wavelength_shares import WavelengthShares
    from skyshine.schemas.arrays import Floats

NODES = ("share", "height_root", "direction")
END_RISE = "end_rise"
THERMAL_SHARE, SOURCE_SHARE = "thermal_wavelength_share", "source_wavelength_share"
_LOG_STEP = 2.0**-11  # of the logarithm of mean extinction: a quarter of a thousandth of optical depth
_KEPT_BITS = 13


@dataclass(frozen=True, eq=False)
class ChannelContent:
    """What a database in channels holds.

    Attributes
    ----------
    rays : RayCoordinates
    nodes : ChannelNodes
    wavenumber, weight : (P,) arrays
        Of the channels, cm^-1, and in the band, of any sum.
    absorbers : Parts
    light : BandLight
    fields : PathFields
    sources : SourceParts
    surface : SurfaceLight
    shares : WavelengthShares
        Of the light of the channels.
    bends_paths : bool
        Whether the file says how refraction lowers the ends of paths.
    range_km, altitude_km : pairs of float
        Least and most that the file is for.
    dark_below : float
        Elevation at and below which there is no light of the source, degree.
    """

    rays: RayCoordinates
    nodes: ChannelNodes
    wavenumber: Floats
    weight: Floats
    absorbers: Parts
    light: BandLight
    fields: PathFields
    sources: SourceParts
    surface: SurfaceLight
    shares: WavelengthShares
    bends_paths: bool
    range_km: tuple[float, float]
    altitude_km: tuple[float, float]
    dark_below: float


def channel_group(content: ChannelContent, accuracy: Group, attributes: Mapping[str, Any]) -> Group:
    """Arrange the channels of a state, band and source for writing.

    Parameters
    ----------
    content : ChannelContent
    accuracy : Group
        The measured errors.
    attributes : mapping
        Band edges, state and source, for the root.
    """
    part = Group({}, {})
    for added in (_paths(content), _sources(content), _surfaces(content), _wavelengths(content.shares)):
        part.axes.update(added.axes)
        part.variables.update(added.variables)
    own = {
        "ground_altitude_km": content.rays.ground_km,
        "scale_height_km": content.rays.scale_height_km,
        "range_km": list(content.range_km),
        "altitude_km": list(content.altitude_km),
    }
    return Group(part.axes, part.variables, {"accuracy": accuracy}, dict(attributes) | own)


def _paths(content: ChannelContent) -> Group:
    """Transmittance and thermal light of paths."""
    nodes, fields = content.nodes, content.fields
    axes = {
        "share": table_axis(nodes.share, "1", "share of the way"),
        "height_root": table_axis(nodes.height_root, "1", "cube root of the observer's height above the ground in km"),
        "direction": table_axis(nodes.direction, "1", "direction of the line of sight: 0 to 1 ground, 2 to 4 space"),
        "channel": _numbers(content.weight.size, "monochromatic channel"),
        "absorber": _numbers(content.absorbers.count, "absorber"),
    }
    mean = np.log(fields.extinction)
    variables = {
        "effective_radius": Variable(
            ("height_root",),
            content.rays.effective_radius,
            "km",
            "radius of an Earth without refraction that has the same horizon at that height",
        ),
        "log_mean_extinction": Variable(
            ("absorber", *NODES),
            np.round(mean / _LOG_STEP) * _LOG_STEP,
            "1",
            "logarithm of the mean extinction of an absorber along the path, in km^-1",
        ),
        "absorber_factor": Variable(
            ("channel", "absorber"), content.absorbers.factor, "1", "optical depth of a channel per absorber's"
        ),
        "channel_wavenumber": Variable(("channel",), content.wavenumber, "cm^-1", "wavenumber of the channel"),
        "channel_weight": Variable(
            ("channel",), content.weight / content.weight.sum(), "1", "weight in the band's transmittance"
        ),
        "thermal_reference": Variable(
            ("channel",), content.light.thermal, RADIANCE, "black body at 288 K in the channel, with its weight"
        ),
        "thermal_ratio": Variable(
            NODES, _rounded(fields.thermal), "1", "thermal path radiance over that of air at 288 K"
        ),
    }
    if content.bends_paths:
        variables[END_RISE] = Variable(
            NODES,
            _rounded(fields.end_rise),
            "1",
            "height of the end of the path above that of a straight line, over the range",
        )
    return Group(axes, variables)


def _wavelengths(shares: WavelengthShares) -> Group:
    """Where in the band the light of the channels lies."""
    comment = {
        "comment": "linear between the wavelengths, as reflectance_spectrum of the .band file; each row sums to 1"
    }
    axes = {WAVELENGTH: table_axis(shares.wavelength, "um", "wavelength in the band")}
    variables = {
        THERMAL_SHARE: Variable(
            ("channel", WAVELENGTH),
            shares.thermal,
            "1",
            "share of a wavelength in the emitted light of a channel",
            comment,
        ),
        SOURCE_SHARE: Variable(
            ("channel", WAVELENGTH),
            shares.source,
            "1",
            "share of a wavelength in the source's light in a channel",
            comment,
        ),
    }
    return Group(axes, variables)


def _sources(content: ChannelContent) -> Group:
    """Scattered light of paths."""
    sources = content.sources
    axes = {
        "source_part": _numbers(max(sources.chosen_angle.size, 1), "direction of the source that the tables hold"),
        "source_elevation": _source_elevation(sources.elevation, content.dark_below),
        "scattering_angle": table_axis(
            sources.angle, "degree", "angle between the line of sight and the source, at the observer"
        ),
    }
    shape = content.nodes.shape
    scattered = content.fields.scattered if sources.chosen_angle.size else np.zeros((1, *shape))
    factor = sources.factor if sources.chosen_angle.size else np.zeros((1, *sources.factor.shape[1:]))
    variables = {
        "source_reference": Variable(
            ("channel",), content.light.source, "1", "the source's light in the channel, with its weight"
        ),
        "scattered_ratio": Variable(
            ("source_part", *NODES),
            _rounded(scattered),
            RADIANCE,
            "scattered path radiance over sum of source_reference (1 - exp(-optical depth))",
        ),
        "source_factor": Variable(
            ("source_part", "source_elevation", "scattering_angle"), factor, "1", "share of each part by direction"
        ),
    }
    return Group(axes, variables)


def _surfaces(content: ChannelContent) -> Group:
    """Light on the surfaces at the ends of paths."""
    surface = content.surface
    axes: dict[str, Axis] = {
        "surface_height": table_axis(surface.height_km, "km", "height of the surface point above the ground"),
        "target_height": table_axis(
            surface.target_height_km, "km", "height above the ground of the target of the beam"
        ),
        "sky_source_elevation": _source_elevation(surface.sky_elevation, content.dark_below),
        "elevation_above_rise": table_axis(
            surface.above_rise, "degree", "elevation of the source above the one at which it rises there"
        ),
    }
    variables = {
        "source_rise": Variable(
            ("target_height",), surface.rise, "degree", "geometric elevation at which the source rises"
        )
    }

    def add(name: str, light: LightParts | None, dims: tuple[str, ...], words: str) -> None:
        if light is None:
            return
        axes[f"{name}_part"] = _numbers(len(light.value), f"spectrum of {name}")
        variables[name] = Variable((f"{name}_part", *dims), light.value, RADIANCE, words)
        variables[f"{name}_factor"] = Variable(
            ("channel", f"{name}_part"), light.factor, "1", f"of {name} in each channel"
        )

    height, source = "surface_height", "sky_source_elevation"
    add(
        "direct_light",
        surface.direct,
        ("target_height", "elevation_above_rise"),
        "direct irradiance over pi, normal to the beam",
    )
    add("thermal_sky", surface.thermal_sky, (height,), "what the air emits on a level surface, over pi")
    add("scattered_sky", surface.scattered_sky, (height, source), "scattered light on a level surface, over pi")
    if surface.thermal_harmonics is not None:
        count = surface.thermal_harmonics.value.shape[-1]
        axes["harmonic"] = table_axis(
            np.array(HARMONICS[:count], np.int32),
            "1",
            "spherical harmonic, 10 l + m, in cos(m azimuth from the source)",
            interpolation=EXACT,
        )
        axes["zonal_harmonic"] = table_axis(
            np.array(zonal(count), np.int32), "1", "spherical harmonic without azimuth, 10 l", interpolation=EXACT
        )
        axes["ground_temperature"] = table_axis(np.array(GROUND_TEMPERATURES), "K", "temperature of the ground")
        add("thermal_harmonics", surface.thermal_harmonics, (height, "harmonic"), "harmonics of what the air emits")
        add(
            "scattered_harmonics",
            surface.scattered_harmonics,
            (height, source, "harmonic"),
            "harmonics of scattered light around the surface",
        )
        add(
            "ground_harmonics",
            surface.ground_harmonics,
            (height, "zonal_harmonic"),
            "harmonics of the transmittance to the ground",
        )
        variables["ground_emission"] = Variable(
            ("ground_temperature", "channel"), surface.ground_emission, "cm", "emission of the ground, per unit in band"
        )
    return Group(axes, variables)


def _source_elevation(nodes: Floats, dark_below: float) -> Axis:
    axis = table_axis(nodes, "degree", "geometric elevation of the source")
    axis.attributes[DARK_BELOW] = dark_below
    return axis


def _numbers(count: int, words: str) -> Axis:
    return table_axis(np.arange(1, count + 1, dtype=np.int32), "1", words, interpolation=EXACT)


def _rounded(values: Floats) -> Floats:
    """Values with as many bits as their errors leave: the rest does not compress."""
    mantissa, exponent = np.frexp(values)
    rounded: Floats = np.ldexp(np.round(np.ldexp(mantissa, _KEPT_BITS)), exponent - _KEPT_BITS)
    return rounded
