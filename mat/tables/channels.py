"""Layout of atmospheric databases in channels: monochromatic points whose light follows Beer's law."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from skyshine.mat.quantities.ambient_harmonics import GROUND_TEMPERATURES
from skyshine.mat.radiometry.spherical_harmonics import HARMONICS, zonal
from skyshine.mat.tables.axes import DARK_BELOW, EXACT, table_axis
from skyshine.mat.tables.band import WAVELENGTH
from skyshine.mat.tables.channel_fields import (
    ABOVE_RISE,
    END_RISE,
    GROUND_EMISSION,
    HARMONIC_LIGHT,
    LIGHT,
    SKY_ELEVATION,
    SOURCE_ELEVATION,
    SOURCE_SHARE,
    SURFACE,
    TARGET,
    THERMAL_SHARE,
    fields_of,
)
from skyshine.schemas.digits import rounded_bits, rounded_to
from skyshine.schemas.hdf5 import Axis, Group

if TYPE_CHECKING:
    from skyshine.mat.quantities.channels.coordinates import RayCoordinates
    from skyshine.mat.quantities.channels.nodes import ChannelNodes
    from skyshine.mat.quantities.channels.parts import Parts
    from skyshine.mat.quantities.channels.path_fields import BandLight, PathFields
    from skyshine.mat.quantities.channels.source_parts import SourceParts
    from skyshine.mat.quantities.channels.surface_light import LightParts, SurfaceLight
    from skyshine.mat.quantities.channels.wavelength_shares import WavelengthShares
    from skyshine.schemas.arrays import Floats, Reals

_MOST_BY_DEPTH = math.exp(-1)  # largest change of a transmittance by the logarithm of its optical depth
_KEPT_BITS = 13  # kept bits of the heights of the ends of paths
_FACTOR_BITS = 12  # kept bits of optical depths per absorber's: they change a transmittance by 5e-5 or less
_SHARE_STEP = 2.0**-14  # step of the shares of a channel's light at a wavelength
_DIRECT_LIGHT = "direct_light"
_BEAM_BITS = 16  # beam bits of direct light, whose parts cancel each other


@dataclass(frozen=True, eq=False)
class ChannelContent:
    """Content of a database in channels.

    Attributes
    ----------
    wavenumber, weight : (P,) arrays
        Wavenumbers of the channels, cm^-1, and their weights in the band, of any sum.
    shares : WavelengthShares
        Wavelength shares of the light of the channels.
    bends_paths : bool
        Whether the file says how refraction lowers the ends of paths.
    range_km, altitude_km : pairs of float
        Least and most that the file is for.
    dark_below : float
        Elevation at and below which there is no light of the source, degree.
    transmittance_step, radiance_step : float
        Changes of transmittance and of path radiance [W m^-2 sr^-1] that do not matter: finer digits are not stored.
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
    transmittance_step: float
    radiance_step: float


def channel_group(content: ChannelContent, accuracy: Group, attributes: Mapping[str, Any]) -> Group:
    """Arrange the channels of a state, band and source for writing.

    Parameters
    ----------
    accuracy : Group
        The measured errors.
    attributes : mapping
        Band edges, state and source, for the root.
    """
    fields = fields_of(harmonics=content.surface.thermal_harmonics is not None, bent=content.bends_paths)
    arrays = _paths(content) | _sources(content) | _surfaces(content)
    arrays |= {THERMAL_SHARE: _rounded_shares(content.shares.thermal)}
    arrays |= {SOURCE_SHARE: _rounded_shares(content.shares.source)}
    root_attributes = {
        "ground_altitude_km": content.rays.ground_km,
        "scale_height_km": content.rays.scale_height_km,
        "range_km": list(content.range_km),
        "altitude_km": list(content.altitude_km),
    }
    variables = {name: fields[name].variable(values) for name, values in arrays.items()}
    return Group(_axes(content), variables, {"accuracy": accuracy}, dict(attributes) | root_attributes)


def _axes(content: ChannelContent) -> dict[str, Axis]:
    nodes, sources, surface = content.nodes, content.sources, content.surface
    axes = {
        "share": table_axis(nodes.share, "1", "share of the way"),
        "height_root": table_axis(nodes.height_root, "1", "cube root of the observer's height above the ground in km"),
        "direction": table_axis(nodes.direction, "1", "direction of the line of sight: 0 to 1 ground, 2 to 4 space"),
        "channel": _numbers(content.weight.size, "monochromatic channel"),
        "absorber": _numbers(content.absorbers.count, "absorber"),
        "source_part": _numbers(max(len(sources.factor), 1), "field of scattered light"),
        SOURCE_ELEVATION: _source_elevation(sources.elevation, content.dark_below),
        "scattering_angle": table_axis(
            sources.angle, "degree", "angle between the line of sight and the source, at the observer"
        ),
        SURFACE: table_axis(surface.height_km, "km", "height of the surface point above the ground"),
        TARGET: table_axis(surface.target_height_km, "km", "height above the ground of the target of the beam"),
        SKY_ELEVATION: _source_elevation(surface.sky_elevation, content.dark_below),
        ABOVE_RISE: table_axis(
            surface.above_rise, "degree", "elevation of the source above the one at which it rises there"
        ),
    }

    def parts(names: Collection[str]) -> dict[str, Axis]:
        light = _light(surface)
        return {f"{n}_part": _numbers(len(light[n].value), f"spectrum of {n}") for n in names if n in light}

    axes |= parts(LIGHT)
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
        axes |= parts(HARMONIC_LIGHT)
    return axes | {WAVELENGTH: table_axis(content.shares.wavelength, "um", "wavelength in the band")}


def _paths(content: ChannelContent) -> dict[str, Floats]:
    """Transmittance and thermal light of paths."""
    fields = content.fields
    arrays = {
        "effective_radius": content.rays.effective_radius,
        "log_mean_extinction": rounded_to(np.log(fields.extinction), content.transmittance_step / _MOST_BY_DEPTH),
        "absorber_factor": _with_bits(content.absorbers.factor, _FACTOR_BITS),
        "channel_wavenumber": content.wavenumber,
        "channel_weight": content.weight / content.weight.sum(),
        "thermal_reference": content.light.thermal,
        "thermal_ratio": rounded_to(fields.thermal, content.radiance_step / content.light.thermal.sum()),
    }
    return arrays | ({END_RISE: _with_bits(fields.end_rise, _KEPT_BITS)} if content.bends_paths else {})


def _sources(content: ChannelContent) -> dict[str, Floats]:
    """Scattered light of paths; one direction without light where there is none."""
    scattered, factor = content.fields.scattered, content.sources.factor
    if not len(factor):
        scattered, factor = np.zeros((1, *content.nodes.shape)), np.zeros((1, *factor.shape[1:]))
    most = np.maximum(np.abs(scattered).max(axis=(1, 2, 3), keepdims=True)[..., 0], content.radiance_step)
    return {
        "source_reference": content.light.source,
        "scattered_ratio": rounded_to(scattered, content.radiance_step),
        "source_factor": rounded_to(factor, content.radiance_step / most),
    }


def _surfaces(content: ChannelContent) -> dict[str, Reals]:
    """Light on the surfaces at the ends of paths."""
    surface = content.surface
    arrays: dict[str, Reals] = {"source_rise": surface.rise}
    for name, light in _light(surface).items():
        value = _with_bits(light.value, _BEAM_BITS) if name == _DIRECT_LIGHT else light.value
        arrays |= {name: value, f"{name}_factor": light.factor}
    return arrays | ({GROUND_EMISSION: surface.ground_emission} if surface.thermal_harmonics is not None else {})


def _rounded_shares(shares: Floats) -> Floats:
    """Shares (P, W) in whole steps, of which the largest of each row has what is left to 1."""
    rounded = rounded_to(shares, _SHARE_STEP)
    rows, largest = np.arange(len(rounded)), np.argmax(rounded, axis=1)
    rounded[rows, largest] += 1.0 - rounded.sum(axis=1)
    return rounded


def _light(surface: SurfaceLight) -> dict[str, LightParts]:
    """Light in parts by its name in the file, as far as there is some."""
    light = {
        _DIRECT_LIGHT: surface.direct,
        "thermal_sky": surface.thermal_sky,
        "scattered_sky": surface.scattered_sky,
        "thermal_harmonics": surface.thermal_harmonics,
        "scattered_harmonics": surface.scattered_harmonics,
        "ground_harmonics": surface.ground_harmonics,
    }
    return {name: parts for name, parts in light.items() if parts is not None}


def _source_elevation(nodes: Floats, dark_below: float) -> Axis:
    axis = table_axis(nodes, "degree", "geometric elevation of the source")
    axis.attributes[DARK_BELOW] = dark_below
    return axis


def _numbers(count: int, words: str) -> Axis:
    return table_axis(np.arange(1, count + 1, dtype=np.int32), "1", words, interpolation=EXACT)


def _with_bits(values: Floats, bits: int) -> Floats:
    return rounded_bits(values.astype(np.float32), bits).astype(float)
