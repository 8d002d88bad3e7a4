"""The ground below the paths in a sensor's band, where a state names its material."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skyshine.mat.atmosphere.state.ground_albedo import SpectralAlbedo
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.job.atmosphere import State
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.reflectance import band_reflectance
from skyshine.materials.library import MaterialLibrary


def band_albedo(state: State, response: SpectralResponse, library: MaterialLibrary) -> float:
    """Mean reflectance of a state's ground in a band: its `surface_albedo` where that is written, else its material's.

    A runtime makes emissivity of it.
    """
    if state.ground_material is None or "surface_albedo" in state.model_fields_set:
        return state.surface_albedo
    return float(band_reflectance(library[state.ground_material], response))


def ground_albedo(state: State, response: SpectralResponse, library: MaterialLibrary) -> float | SpectralAlbedo:
    """Reflectance of a state's ground against wavelength, as far as a band reaches: that of its material, or the one
    number that the state writes.
    """
    mean = band_albedo(state, response, library)
    if state.ground_material is None or "surface_albedo" in state.model_fields_set:
        return mean
    material = library[state.ground_material]
    low, high = (1e4 / wavenumber for wavenumber in reversed(response.wavenumber_range))
    inside = material.wavelength[(material.wavelength > low) & (material.wavelength < high)]
    wavelength = np.concatenate([[low], inside, [high]])
    reflectance = np.interp(wavelength, material.wavelength, material.reflectance)
    return mean if np.ptp(reflectance) == 0 else SpectralAlbedo(wavelength, reflectance, mean)


def over_ground(
    air: AtmosphericState, state: State, response: SpectralResponse, library: MaterialLibrary
) -> AtmosphericState:
    """The air of a state over its ground, as that is in a band."""
    albedo = ground_albedo(state, response, library)
    return air if albedo == air.surface_albedo else replace(air, surface_albedo=albedo)
