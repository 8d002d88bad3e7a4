"""The ground below the paths in a sensor's band, where a state names its material."""

from __future__ import annotations

from dataclasses import replace

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.atmosphere import State
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.reflectance import band_reflectance
from skyshine.materials.library import load_library


def band_albedo(state: State, response: SpectralResponse) -> float:
    """Reflectance of a state's ground in a band: its `surface_albedo` where that is written, else its material's.

    It is the mean over the band, of which a runtime makes emissivity too: the few points of a compiled band stand for
    absorption, not for the wavelengths at which a ground reflects.
    """
    if state.ground_material is None or "surface_albedo" in state.model_fields_set:
        return state.surface_albedo
    return float(band_reflectance(load_library()[state.ground_material], response))


def over_ground(air: AtmosphericState, state: State, response: SpectralResponse) -> AtmosphericState:
    """The air of a state over its ground, as that is in a band."""
    albedo = band_albedo(state, response)
    return air if albedo == air.surface_albedo else replace(air, surface_albedo=albedo)
