"""Water on leaves and on the soil in their gaps: what leaves do not keep drips to the soil.

Rain falls through the gaps seen from above; the rest fills the film of the leaves, whose overflow drips. Both films
evaporate through the air of their own paths (`canopy`).

References
----------
Interception by the covered share, and drip of what exceeds the storage: Rutter et al. (1971), Agric. Meteorol. 9,
367-384, with the film's share of the leaves as evaporation has it (`wet_skin`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.surface.canopy import CanopyBalance, gap_towards
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.film import LATENT_HEAT, WetSkin, evaporated, film_of
from skyshine.mat.surface.solution import Solution
from skyshine.mat.surface.vapour import surface_vapour
from skyshine.mat.surface.wet_skin import FilmSkin
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class WetStand(WetSkin):
    """Films of leaves, then of the soil, in rows of twice as many times; the latter in kg by m^2 of ground."""

    sources = 2

    def filmed(self, forcing: Forcing, share: Floats) -> Forcing:
        leaves, soil = np.split(share, 2, axis=1)
        return replace(forcing, film=leaves, film_below=soil)

    def loss(self, forcing: Forcing, temperature: Floats) -> Floats:
        return np.asarray(CanopyBalance(forcing, self.material).loss(temperature), float)

    def temperature(self, solution: Solution) -> Floats:
        assert solution.sources is not None
        return solution.sources

    def next_film(
        self, forcing: Forcing, temperature: Floats, step: float, before: Floats | None
    ) -> tuple[Floats, Floats]:
        canopy = self.material.canopy
        assert canopy is not None and forcing.rain is not None
        leaves, soil = np.split(temperature, 2, axis=1)
        rain = forcing.rain * np.maximum(forcing.cos_slope, 0.0) + np.zeros(forcing.shape)
        through = float(gap_towards(canopy.leaf_area, 1.0))
        wet = CanopyBalance(self.filmed(forcing, np.ones((1, 2))), self.material)
        starts = (None, None) if before is None else (before[:, 0], before[:, 1])
        caught = rain * (1 - through) / wet.cover
        film, share, drip = _film(
            canopy.leaves.film, evaporated(canopy.leaves, forcing, leaves), caught, step, starts[0]
        )
        lost = wet.soil.latent_of_film(soil) * wet.gap
        vapour, ratio = surface_vapour(soil)
        if wet.soil.filmed:
            deficit = vapour - wet.soil.vapour_pressure
            lost = lost + wet.cover * deficit * ratio * wet.calm / wet.soil.psychrometer
        below, below_share, _ = _film(
            canopy.soil.film, lost / (LATENT_HEAT * ratio), rain * through + wet.cover * drip, step, starts[1]
        )
        return np.concatenate([film, below], axis=1), np.concatenate([share, below_share], axis=1)


def _film(
    skin: FilmSkin | None, flux: Floats, supply: Floats, step: float, before: Floats | None
) -> tuple[Floats, Floats, Floats]:
    """Film [kg m^-2], its share and what runs off [kg m^-2 s^-1], of evaporation and supply (columns, N)."""
    if skin is None:
        return np.zeros(supply.shape), np.zeros(supply.shape), supply
    gain, demand = np.maximum(-flux, 0.0) + supply, np.maximum(flux, 0.0)
    film, share = film_of(skin, gain, demand, step, before)
    earlier = np.roll(film, 1, axis=1)
    if before is not None:
        earlier[:, 0] = before
    return film, share, np.maximum((earlier - film) / step + gain - demand * share, 0.0)
