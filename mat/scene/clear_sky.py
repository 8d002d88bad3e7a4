"""The clear sky of a state, broadband, for the surface heat balance: kept, for materials change more often than air."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache

import numpy as np
from scipy.constants import Stefan_Boltzmann

from skyshine import atmospheres
from skyshine.mat.atmosphere.band.cache import content_key
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.spectra.fluxes import BroadbandFluxes, broadband_fluxes
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.surface.forcing import Sky
from skyshine.schemas.arrays import Floats
from skyshine.schemas.digest import digest_of
from skyshine.schemas.kept_arrays import keep_arrays, kept_arrays, kept_folder

FOLDER = "skies"  # of the kept files
HEAD = b"skyshine broadband sky 1\n"
SKY_STEP = 250.0  # m between the altitudes at which the sky is described
# degree: elevations of the Sun at which it is; close where the beam grows through the lowest, longest paths. Below, no
# light arrives that would warm anything.
SUN_ELEVATIONS = np.concatenate(
    [np.arange(-8, -1, 1), np.arange(-1, 6, 0.5), np.arange(6, 20, 1), np.arange(20, 91, 2.5)]
)


def band_model_sky(air: AtmosphericState, highest: float, ground_albedo: float, sun_distance: float) -> Sky:
    """The clear sky of a state from its ground to an altitude [m], from the broadband points of the band model."""
    ground = air.surface_altitude
    levels = np.arange(ground, max(highest, ground + SKY_STEP) + SKY_STEP, SKY_STEP)
    # The air's own levels hold the edges of cloud and fog, across which light is not linear.
    levels = np.union1d(levels, air.altitude[(air.altitude > ground) & (air.altitude < levels[-1])])
    fluxes = _at_distance(_kept_fluxes(air, levels, ground_albedo), sun_distance)
    black = Stefan_Boltzmann * np.interp(levels, air.altitude, air.temperature) ** 4
    return Sky(
        altitude=levels,
        pressure=air.pressure_at(levels),
        solar_elevation=fluxes.source_elevation,
        direct=fluxes.direct_normal,
        diffuse=fluxes.diffuse,
        emissivity=fluxes.longwave_down / black,
        ground_albedo=ground_albedo,
    )


def _at_distance(fluxes: BroadbandFluxes, sun_distance: float) -> BroadbandFluxes:
    """Fluxes at 1 au, with the Sun at another distance, au."""
    weaker = sun_distance**-2
    return replace(fluxes, direct_normal=weaker * fluxes.direct_normal, diffuse=weaker * fluxes.diffuse)


def _kept_fluxes(air: AtmosphericState, levels: Floats, ground_albedo: float) -> BroadbandFluxes:
    """Fluxes at 1 au: those that were kept, or new ones."""
    folder = kept_folder(FOLDER)
    if folder is None:
        return broadband_fluxes(air, levels, SUN_ELEVATIONS, ground_albedo)
    key = content_key(_data(), air, levels, SUN_ELEVATIONS, float(ground_albedo))
    path = folder / f"{key}.npz"
    arrays = kept_arrays(path, HEAD, key)
    if arrays is not None:
        return BroadbandFluxes(**arrays)
    fluxes = broadband_fluxes(air, levels, SUN_ELEVATIONS, ground_albedo)
    keep_arrays(path, HEAD, key, {field.name: getattr(fluxes, field.name) for field in fields(fluxes)})
    return fluxes


@lru_cache(maxsize=1)
def _data() -> str:
    """Digest of the tables that the fluxes are computed from."""
    return digest_of(atmospheres.path("broadband.h5").read_bytes(), AbsorptionTable.open().content)
