"""Leaves and the soil in their gaps: the light and heat that each receives, and how they look together from above.

Two sources share the ground. Leaves cover of the hemisphere what gaps leave. The soil exchanges with sky and air
through the gaps as bare soil does; where leaves cover it, with them through the space beneath and with the air through
the resistance of calm air over soil. Fluxes are by area of ground, those of leaves by the area that they cover: so
divided, their balance is that of a closed canopy, but for the light.

References
----------
Gaps: Beer's law for leaves at random, Nilson (1971), Agric. Meteorol. 8, 25-38, whose factor clumping is. Sunlight that
leaves scatter on its way down: Goudriaan (1977), as Campbell and Norman (1998), An Introduction to Environmental
Biophysics, equation (15.6), has it. Two sources beside each other, and the resistance of the soil: Norman, Kustas
and Humes (1995), Agric. For. Meteorol. 77, 263-293.
"""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import scipy

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.convection import AIR_HEAT_CAPACITY, air_density
from skyshine.mat.surface.material import Canopy, SurfaceMaterial
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.errors import InputError

PROJECTION = 0.5  # projection of leaves that face all ways alike (a sphere's: Campbell and Norman 1998, 15.4)
# Absorptance of single leaves for sunlight: 0.8 for its visible half, 0.2 for the other (Campbell and Norman 1998,
# section 15.2).
LEAF_ABSORPTANCE = 0.5
# m s^-1: of heat from soil to the air where no wind reaches it, 1 / (a' + b' u) with u = 0 (Norman et al. 1995).
CALM_SOIL = 0.004
_GRAZING = 1e-6  # cosine below which no light passes leaves
# Smallest share of the hemisphere that leaves cover: with fewer their light is negligible.
_LEAST_COVER = 1e-9


def gap_towards(leaf_area: float, cosine: npt.ArrayLike) -> Floats:
    """Share of gaps in a direction.

    Parameters
    ----------
    leaf_area : float
        Leaf area index times clumping [m^2 m^-2].
    cosine : array_like
        Cosine of the angle between the direction and the normal of the ground, 0 to 1.

    Examples
    --------
    Leaves of one square metre over a square metre, seen from above and from 60 degrees:

    >>> gap_towards(1.0, [1.0, 0.5]).round(3)
    array([0.607, 0.368])
    """
    cosine = np.asarray(cosine, float)
    path = PROJECTION * leaf_area / np.maximum(cosine, _GRAZING)
    gap: Floats = np.where((cosine > 0) | (leaf_area == 0), np.exp(-path if leaf_area else 0 * path), 0.0)
    return gap


def gap_to_sky(leaf_area: float) -> float:
    """Share of gaps for radiation that comes evenly from the hemisphere: 2 E_3(G leaf area)."""
    return float(2.0 * scipy.special.expn(3, PROJECTION * leaf_area))


def sunlit(leaf_area: float) -> float:
    """Leaf area whose gaps pass as much sunlight as all leaves do, scattering included."""
    return float(np.sqrt(LEAF_ABSORPTANCE)) * leaf_area


def mixed_absorptance(canopy: Canopy) -> float:
    """Solar absorptance of leaves and soil together under even light."""
    through = gap_to_sky(sunlit(canopy.leaf_area))
    return (1 - through) * canopy.leaves.solar_absorptance + through * canopy.soil.solar_absorptance


def mixed_emissivity(canopy: Canopy) -> float:
    """Thermal emissivity of leaves and soil together over the hemisphere."""
    gap = gap_to_sky(canopy.leaf_area)
    return (1 - gap) * canopy.leaves.thermal_emissivity + gap * canopy.soil.thermal_emissivity


def seen_temperature(canopy: Canopy, sources: Reals) -> Floats:
    """Temperature (columns, N) [K] of a body that radiates as leaves and soil (columns, 2 N) [K], seen along the
    normal of the ground.
    """
    leaves, soil = np.split(np.asarray(sources, float), 2, axis=1)
    gap = gap_towards(canopy.leaf_area, 1.0)
    temperature: Floats = ((1 - gap) * leaves**4 + gap * soil**4) ** 0.25
    return temperature


class CanopyBalance:
    """Net heat that leaves leaves and soil of some columns, as a function of their temperatures.

    It replaces a `Balance` of twice as many times: those of the leaves, by the area that they cover, then
    those of the soil, by area of ground. What they give each other is conduction (`CanopyConduction`).

    Parameters
    ----------
    forcing : Forcing
        Above the leaves.
    material : SurfaceMaterial
        Material with a canopy.

    Raises
    ------
    InputError
        There is no air, or nothing tells where the direct light comes from.
    """

    def __init__(self, forcing: Forcing, material: SurfaceMaterial) -> None:
        assert material.canopy is not None
        canopy = self.canopy = material.canopy
        self.forcing, self.material = forcing, material
        _refuse_unknown(forcing, material.name)
        columns, steps = forcing.shape
        self.shape = columns, 2 * steps
        self.air_temperature = np.tile(forcing.air_temperature + np.zeros((1, steps)), 2)
        self.gap = gap_to_sky(canopy.leaf_area)
        self.cover = max(1.0 - self.gap, _LEAST_COVER)
        beam, spread = light_shares(canopy, forcing)
        direct, even = forcing.shortwave_direct, forcing.shortwave_diffuse + forcing.shortwave_reflected
        self.leaves = Balance(
            _lit(forcing, direct * (1 - beam) / self.cover, even * (1 - spread) / self.cover), canopy.leaves
        )
        below = replace(forcing, film=forcing.film_below)
        self.soil = Balance(_lit(below, 0.0 * direct, 0.0 * even), canopy.soil)
        heat_capacity = air_density(forcing.pressure, forcing.air_temperature) * AIR_HEAT_CAPACITY
        self.calm = CALM_SOIL * heat_capacity
        self.soil_light = self.soil.skin.solar_absorptance * (direct * beam + even * spread) + np.zeros(forcing.shape)

    def columns(self, chosen: slice | Integers) -> CanopyBalance:
        """The balance of a slice or index array of columns."""
        return CanopyBalance(self.forcing.columns(chosen), self.material)

    @property
    def bends(self) -> bool:
        """As `Balance.bends`, of leaves or soil."""
        return self.leaves.bends or self.soil.bends

    def single(self) -> CanopyBalance:
        """The same in single precision."""
        balance = copy(self)
        balance.leaves, balance.soil = self.leaves.single(), self.soil.single()
        balance.calm, balance.soil_light = self.calm.astype(np.float32), self.soil_light.astype(np.float32)
        return balance

    def loss(self, temperature: Reals) -> Reals:
        """Net outward flux (columns, 2 N) [W m^-2]."""
        leaves, soil = np.split(temperature, 2, axis=1)
        below, _ = self._below(soil)
        return np.concatenate([self.leaves.loss(leaves), below], axis=1)

    def loss_and_slope(self, temperature: Reals) -> tuple[Reals, Reals]:
        """`loss` and its derivative by temperature [W m^-2 K^-1], each (columns, 2 N)."""
        leaves, soil = np.split(temperature, 2, axis=1)
        above, above_slope = self.leaves.loss_and_slope(leaves)
        below, below_slope = self._below(soil)
        return np.concatenate([above, below], axis=1), np.concatenate([above_slope, below_slope], axis=1)

    def _below(self, soil: Reals) -> tuple[Reals, Reals]:
        """Net outward flux of soil, without what leaves give it, and its slope, each (columns, N)."""
        loss, loss_slope = self.soil.loss_and_slope(soil)
        calm, calm_slope = self.soil.given_to_air(soil, self.calm)
        return (
            self.gap * loss + self.cover * calm - self.soil_light,
            self.gap * loss_slope + self.cover * calm_slope,
        )

    def by_ground(self, values: Reals) -> Reals:
        """The sum (columns, N) over leaves and soil, by area of ground, of values (columns, 2 N) as `loss` has them."""
        leaves, soil = np.split(values, 2, axis=1)
        total: Reals = self.cover * leaves + soil
        return total

    def fluxes(self, temperature: Reals) -> dict[str, Reals]:
        """Each flux of leaves and soil together by name (columns, N) [W m^-2], as `Balance.fluxes`."""
        leaves, soil = np.split(temperature, 2, axis=1)
        above, below = self.leaves.fluxes(leaves), self.soil.fluxes(soil)
        parts = {name: self.cover * above[name] + self.gap * below[name] for name in above}
        parts["shortwave_absorbed"] = parts["shortwave_absorbed"] + self.soil_light
        warmer = self.calm * (soil - self.forcing.air_temperature)
        parts["convection"] = parts["convection"] + self.cover * warmer
        parts["evaporation"] = parts["evaporation"] + self.cover * (self.soil.given_to_air(soil, self.calm)[0] - warmer)
        return parts


def light_shares(canopy: Canopy, forcing: Forcing) -> tuple[Floats, float]:
    """Share of direct light (columns, N), and of all other sunlight, that reaches the soil."""
    area = sunlit(canopy.leaf_area)
    if forcing.sun_cosine is None:
        return np.zeros((1, 1)), gap_to_sky(area)
    return gap_towards(area, forcing.sun_cosine), gap_to_sky(area)


def _lit(forcing: Forcing, direct: Floats, even: Floats) -> Forcing:
    return replace(forcing, shortwave_direct=direct, shortwave_diffuse=even, shortwave_reflected=np.zeros((1, 1)))


def _refuse_unknown(forcing: Forcing, name: str) -> None:
    if not np.any(forcing.pressure):
        raise InputError(
            f"found '{name}' with gaps between its leaves where there is no air; allowed: a closed skin; remove"
            " leaf_area_index"
        )
    if forcing.sun_cosine is None and np.any(forcing.shortwave_direct):
        raise InputError(
            f"found direct light on '{name}' with gaps between its leaves, but not from where; place the Sun"
        )
