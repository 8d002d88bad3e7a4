"""From the aerosol layers of a job's state to those of the air."""

from __future__ import annotations

from skyshine.mat.atmosphere.particles.aerosol import AerosolModel
from skyshine.mat.atmosphere.particles.aerosol_column import boundary_model
from skyshine.mat.atmosphere.particles.aerosol_layer import AerosolLayer
from skyshine.mat.atmosphere.particles.aerosol_table import (
    COVERED,
    parse_aerosol,
    parse_aerosol_optics,
    parse_extinction_profile,
    parse_refractive_index,
)
from skyshine.mat.atmosphere.particles.particles import SpectralModel
from skyshine.mat.atmosphere.particles.size_distribution import LogNormalMode, RefractiveIndex, sphere_mixture
from skyshine.mat.job import aerosols
from skyshine.mat.job.atmosphere import State
from skyshine.mat.scene.weather import mean_wind


def aerosol_layers(state: State) -> list[AerosolLayer]:
    """The aerosol layers of a state in SI units.

    Raises
    ------
    InputError
        With file:line:column of what does not fit in a table.
    """
    layers: list[AerosolLayer] = []
    for layer in state.aerosol_layers:
        if layer.optics is not None:
            layers += parse_aerosol_optics(layer.optics.text, layer.optics.path)
        else:
            layers.append(_layer(state, layer))
    return layers


def _layer(state: State, layer: aerosols.AerosolLayer) -> AerosolLayer:
    model = _particles(state, layer)
    depth = layer.optical_depth
    if layer.profile is not None:
        height, extinction = parse_extinction_profile(layer.profile.text, layer.profile.path)
        return AerosolLayer.measured(model, height, extinction, depth)
    assert depth is not None  # the job's model asks for one without a profile
    if layer.height_km is not None:
        bottom, top = layer.height_km
        return AerosolLayer.even(model, 1e3 * bottom, 1e3 * top, depth)
    assert layer.scale_height_km is not None  # the job's model asks for one of the three
    return AerosolLayer.exponential(model, 1e3 * layer.scale_height_km, depth)


def _particles(state: State, layer: aerosols.AerosolLayer) -> AerosolModel | SpectralModel:
    if layer.table is not None:
        return parse_aerosol(layer.table.text, layer.table.path)
    if layer.size_distribution is not None:
        return sphere_mixture("spheres", tuple(_mode(mode) for mode in layer.size_distribution))
    assert layer.model is not None  # the job's model asks for one of the three
    return boundary_model(layer.model, mean_wind(state.weather), state.air_mass)


def _mode(mode: aerosols.Mode) -> LogNormalMode:
    index = mode.refractive_index
    if isinstance(index, tuple):
        refractive_index = RefractiveIndex(COVERED, (index[0],) * 2, (index[1],) * 2)
    else:
        refractive_index = parse_refractive_index(index.text, index.path)
    return LogNormalMode(mode.median_radius_um, mode.geometric_sd, mode.number, refractive_index)
