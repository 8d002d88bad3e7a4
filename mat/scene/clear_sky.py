"""The clear sky of a state, broadband, for the surface heat balance: kept, for materials change more often than air."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import lru_cache

import numpy as np

from skyshine import atmospheres
from skyshine.mat.atmosphere.band.cache import content_key
from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
from skyshine.mat.atmosphere.spectra.fluxes import BroadbandFluxes, packaged_points, sky_emission, sunlight_shares
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.atmosphere.transfer.source_nodes import elevation_weights, elevations_from
from skyshine.mat.quantities.aureole import strongest, sunlit_sky
from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.surface.forcing import Sky
from skyshine.schemas.arrays import Floats
from skyshine.schemas.digest import digest_of
from skyshine.schemas.kept_arrays import keep_arrays, kept_arrays, kept_folder

FOLDER = "skies"  # folder of the kept files
HEAD = b"skyshine broadband sky 3\n"
SKY_STEP = 250.0  # m between the altitudes at which the sky is described
# degree: elevations of the Sun at which it is; close where the beam grows through the lowest, longest paths. Below, no
# light arrives that would warm anything.
SUN_ELEVATIONS = np.concatenate(
    [np.arange(-8, -1, 1), np.arange(-1, 6, 0.5), np.arange(6, 20, 1), np.arange(20, 91, 2.5)]
)
# degree: at which the share of light from around the Sun is computed; between them it is linear to 0.01.
AUREOLE_ELEVATIONS = np.array([0.5, 2.0, 5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0])
# Points with most sunlight, and the highest elevation [degree], at which layers are solved as spherical.
_CURVED, _CURVED_TO = 12, 3.5
_DARK = 1e-9  # W m^-2, of diffuse light, below which plane and spherical layers count as alike


@dataclass(frozen=True, eq=False)
class ClearLight:
    """Light of the clear sky at 1 au.

    Attributes
    ----------
    aureole : (AUREOLE_ELEVATIONS,) array
        `SunlitSky.aureole`.
    """

    fluxes: BroadbandFluxes
    aureole: Floats

    @classmethod
    def of(cls, air: AtmosphericState, levels: Floats, ground_albedo: float, water_continuum: str) -> ClearLight:
        """Compute it for a state with a water vapour continuum, the fluxes at levels [m]."""
        points = packaged_points(water_continuum)
        lit = SpectralAir.of(replace(air, surface_albedo=ground_albedo), points.shortwave)
        emission = sky_emission(air, points.longwave, levels) @ points.longwave.weight
        sunlight = _sunlight(lit, points.shortwave.weight, levels, ground_albedo)
        fluxes = BroadbandFluxes(levels, SUN_ELEVATIONS, emission, *sunlight)
        return cls(fluxes, sunlit_sky(lit, points.shortwave.weight, AUREOLE_ELEVATIONS).aureole)


def _sunlight(air: SpectralAir, weight: Floats, levels: Floats, ground_albedo: float) -> tuple[Floats, Floats]:
    """Direct and diffuse sunlight of points of weights (P,), as of `BroadbandFluxes`, at `SUN_ELEVATIONS`.

    Diffuse light is computed in plane layers under fewer elevations, and times what spherical layers make of it at the
    points with most sunlight. Beside `broadband_fluxes` it errs by at most 0.4 W m^-2 in clear air, by 2 under cloud.
    """
    direct = direct_transmittance(air.source_paths, levels, np.radians(SUN_ELEVATIONS)) @ weight
    nodes = np.array(elevations_from(SUN_ELEVATIONS[0]))
    _, plane = sunlight_shares(air, levels, nodes, ground_albedo, spherical=False)
    few, low = strongest(weight, _CURVED), nodes <= _CURVED_TO
    _, curved = sunlight_shares(air.part(few), levels, nodes[low], ground_albedo)
    of_both = (np.maximum(light @ weight[few], _DARK) for light in (curved, plane[:, low][..., few]))
    diffuse = plane @ weight
    diffuse[:, low] *= np.divide(*of_both)
    between = elevation_weights(np.sin(np.radians(nodes)), np.sin(np.radians(SUN_ELEVATIONS)))
    return direct, np.maximum(diffuse @ between.T, 0.0)


def band_model_sky(
    air: AtmosphericState, highest: float, ground_albedo: float, sun_distance: float, water_continuum: str
) -> Sky:
    """The clear sky of a state from its ground to an altitude [m], from the broadband points of the band model.

    Parameters
    ----------
    highest : float, m
    ground_albedo : float
        Albedo of the ground for sunlight.
    sun_distance : float, au
    water_continuum : str
        Name, as in a job.
    """
    ground = air.surface_altitude
    levels = np.arange(ground, max(highest, ground + SKY_STEP) + SKY_STEP, SKY_STEP)
    # The air's own levels contain the edges of cloud and fog, across which light is not linear.
    levels = np.union1d(levels, air.altitude[(air.altitude > ground) & (air.altitude < levels[-1])])
    light = _kept_light(air, levels, ground_albedo, water_continuum)
    fluxes = _at_distance(light.fluxes, sun_distance)
    black = STEFAN_BOLTZMANN * np.interp(levels, air.altitude, air.temperature) ** 4
    return Sky(
        altitude=levels,
        pressure=air.pressure_at(levels),
        solar_elevation=fluxes.source_elevation,
        direct=fluxes.direct_normal,
        diffuse=fluxes.diffuse,
        aureole=np.interp(fluxes.source_elevation, AUREOLE_ELEVATIONS, light.aureole),
        emissivity=fluxes.longwave_down / black,
        ground_albedo=ground_albedo,
    )


def _at_distance(fluxes: BroadbandFluxes, sun_distance: float) -> BroadbandFluxes:
    """Fluxes at 1 au, with the Sun at another distance, au."""
    weaker = sun_distance**-2
    return replace(fluxes, direct_normal=weaker * fluxes.direct_normal, diffuse=weaker * fluxes.diffuse)


def _kept_light(air: AtmosphericState, levels: Floats, ground_albedo: float, water_continuum: str) -> ClearLight:
    """Light at 1 au: that which was kept, or computed anew."""
    folder = kept_folder(FOLDER)
    if folder is None:
        return ClearLight.of(air, levels, ground_albedo, water_continuum)
    key = content_key(_data(water_continuum), air, levels, SUN_ELEVATIONS, AUREOLE_ELEVATIONS, float(ground_albedo))
    path = folder / f"{key}.npz"
    arrays = kept_arrays(path, HEAD, key)
    if arrays is None:
        light = ClearLight.of(air, levels, ground_albedo, water_continuum)
        values = {field.name: getattr(light.fluxes, field.name) for field in fields(light.fluxes)}
        # In the order of memory that a reader gets: sums over another one differ in their last bits.
        arrays = {name: np.array(part, order="C") for name, part in (values | {"aureole": light.aureole}).items()}
        keep_arrays(path, HEAD, key, arrays)
    aureole = arrays.pop("aureole")
    return ClearLight(BroadbandFluxes(**arrays), aureole)


@lru_cache(maxsize=2)
def _data(water_continuum: str) -> str:
    """Digest of the tables that the fluxes are computed from."""
    table = AbsorptionTable.open(water_continuum=water_continuum)
    return digest_of(atmospheres.path("broadband.h5").read_bytes(), table.content)
