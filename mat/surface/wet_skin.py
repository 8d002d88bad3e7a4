"""How a surface absorbs, emits and evaporates at each time: as its material does, or as water on and in it has it.

References
----------
Snow: albedo falls to that of old snow by 0.01 an hour exponentially, 0.70 dry and 0.50 melting (Verseghy 1991, Int. J.
Climatol. 11, 111-133). Film: its share of the surface is (film / capacity)^(2/3) (Deardorff 1978, J. Geophys. Res. 83,
1889-1903, for leaves; Noilhan and Planton 1989), capacities those of Grimmond and Oke (1991), Water Resour. Res. 27,
1739-1755.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.convection import TREE_ROUGHNESS
from skyshine.materials.records import Soil, SurfaceProperties
from skyshine.schemas.arrays import Floats

_OLD_DRY, _OLD_MELTING = 0.70, 0.50
_AGEING = 0.01 * 24.0  # d^-1
# K of the air about freezing over which old snow goes from dry to melting: chosen, so that nothing jumps.
_THAW = 1.0
# Water that stays on a surface, kg m^-2: pavement, buildings, coniferous and deciduous trees, grass, bare soil.
_PAVED, _BUILT, _TREES, _GRASS, _BARE = 0.48, 0.25, 1.3, 1.9, 0.8
_SHARE_POWER = 2.0 / 3.0


@dataclass(frozen=True)
class FilmSkin:
    """A surface wholly under its film of water.

    Attributes
    ----------
    capacity : float
        Amount of water [kg m^-2, mm].
    """

    solar_absorptance: float
    thermal_emissivity: float
    capacity: float

    def share(self, film: Floats) -> Floats:
        """Share of the surface that a film [kg m^-2] covers, 0 to 1."""
        share: Floats = (film / self.capacity) ** _SHARE_POWER
        return share


@dataclass(frozen=True)
class MoistSkin:
    """A soil's surface by volume fraction of water; tuples are (n,).

    Attributes
    ----------
    texture : str
        Texture of the soil grains.
    moisture : tuple of float
        Moisture from 0 to the porosity.
    """

    texture: str
    moisture: tuple[float, ...]
    solar_absorptance: tuple[float, ...]
    thermal_emissivity: tuple[float, ...]


def film_capacity(surface: SurfaceProperties, soil: Soil | None) -> float:
    """Water that stays on a surface [kg m^-2]; 0 where a film of it changes nothing: snow and open water."""
    if surface.snow or (surface.wetness == 1 and surface.surface_resistance == 0):
        return 0.0
    if surface.roughness_length > TREE_ROUGHNESS:
        return _TREES
    if surface.canopy:
        return _GRASS
    if soil is not None:
        return _BARE
    return _PAVED if surface.exposure == "field" else _BUILT


def aged_albedo(fresh: float, age: Floats, air_temperature: Floats) -> Floats:
    """Albedo of snow at an age [d] whose fresh albedo is known; `air_temperature` (rows, N) [K], of which the mean
    tells whether old snow melts.
    """
    excess = np.mean(np.atleast_2d(air_temperature), axis=1, keepdims=True) - ZERO_CELSIUS
    melting = np.clip(0.5 + 0.5 * excess / _THAW, 0.0, 1.0)
    old = np.minimum(_OLD_DRY + melting * (_OLD_MELTING - _OLD_DRY), fresh)
    albedo: Floats = old + (fresh - old) * np.exp(-_AGEING * age)
    return albedo
