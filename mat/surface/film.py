"""A film of water on surfaces: filled by rain and dew, emptied by evaporation and by what runs off.

Film and temperature depend on each other: columns are solved with a film, whose evaporation at those temperatures gives
the next film, until the heat balance no longer notices. Each step is implicit in the film, so that the share that
evaporates in a step is the share with which the balance was solved: latent heat is that of the water lost.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from skyshine.mat.surface.balance import Balance
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.solution import Solution
from skyshine.mat.surface.vapour import surface_vapour
from skyshine.mat.surface.wet_skin import FilmSkin
from skyshine.schemas.arrays import Floats, Integers

# Heat of vaporisation of which the psychrometer constant of the balance is made: FAO Paper 56, equation 8 [J kg^-1].
LATENT_HEAT = 2.45e6
# Change of the heat balance [W m^-2] by which the last film may differ from that of its temperatures: below 0.05 K.
TOLERANCE = 0.2
ROUNDS = 40  # at most; what is left then is in the residual
_CAREFUL = 4  # rounds after which the next film is taken by part
_LEAST_PART = 0.05  # chosen: the least part of the way to the next film
_TINY = 1e-100
_PERIODIC = 22  # halvings of the capacity: to below _RETURNS
_RETURNS = 1e-7  # kg m^-2


def film_of(
    skin: FilmSkin, gain: Floats, potential: Floats, step: float, before: Floats | None
) -> tuple[Floats, Floats]:
    """Film and share that it covers at each time.

    Parameters
    ----------
    gain : (columns, N) ndarray
        Rain and dew in the step that ends at each time [kg m^-2 s^-1].
    potential : (columns, N) ndarray
        Evaporation of a surface that is wholly wet at that time, not negative [kg m^-2 s^-1].
    step : float
        [s]
    before : (columns,) ndarray or None
        Film at the end of the day before [kg m^-2]; None: the film returns after the period.

    Returns
    -------
    film, share : (columns, N) ndarray
        [kg m^-2], 0 to the capacity; 0 to 1.
    """

    supply, demand = gain * step, potential * step
    if before is None:
        before = _returning(skin, supply, demand)
    share = covered_shares(supply / skin.capacity, demand / skin.capacity, before / skin.capacity)
    return skin.capacity * share**1.5, share


def covered_shares(supply: Floats, demand: Floats, water: Floats) -> Floats:
    """Share that a film covers at each time of a day.

    Parameters
    ----------
    supply, demand : (columns, N) ndarray
        What a step brings, and what a wholly wet surface loses in it, over the capacity; not negative.
    water : (columns,) ndarray
        Film before the day over the capacity, 0 to 1.

    Returns
    -------
    (columns, N) ndarray
        0 to 1. With water w = s^(3/2) a step is w + demand s = w before + supply; where the root lies beyond 1 the rest
        runs off.

    Examples
    --------
    Half a film on a surface that loses nothing, on which another half of the capacity falls in each step:

    >>> covered_shares(np.full((1, 3), 0.5), np.zeros((1, 3)), np.array([0.0])).round(3)
    array([[0.63, 1.  , 1.  ]])
    """
    supply, demand = supply.T, demand.T
    shares = np.empty(supply.shape)
    for time, loss in enumerate(demand):
        water = water + supply[time]
        root = np.minimum(_root(loss, water), 1.0)
        np.multiply(root, root, out=shares[time])
        water = shares[time] * root
    return shares.T


def _root(loss: Floats, water: Floats) -> Floats:
    """The root u >= 0 of u^3 + loss u^2 = water, each (columns,) and not negative.

    Cardano's and Vieta's forms about u = -loss / 3; u = sqrt(water / (u + loss)) then mends what they lose where u is
    much smaller than the loss.
    """
    third = loss / 3.0
    cube = third * third * third
    half = 0.5 * water - cube
    square = 0.25 * water * (water - 4.0 * cube)
    large = np.cbrt(half + np.sqrt(np.maximum(square, 0.0)))
    single = large + third * third / np.maximum(large, _TINY)
    three = 2.0 * third * np.cos(np.arccos(np.clip(half / np.maximum(cube, _TINY), -1.0, 1.0)) / 3.0)
    root: Floats = np.maximum(np.where(square >= 0, single, three) - third, 0.0)
    for _ in range(2):
        root = np.sqrt(water / np.maximum(root + loss, _TINY))
    return root


def _returning(skin: FilmSkin, gain: Floats, potential: Floats) -> Floats:
    """The least film (columns,) [kg m^-2] that is the same after the period, of gain and potential of its steps
    [kg m^-2].

    The film after a period grows with that before it, from 0 up and from the capacity down. Where the surface dries
    within the period it does not depend on it: the second trial is the first.
    """

    supply, demand = gain / skin.capacity, potential / skin.capacity

    def after(film: Floats, chosen: Integers) -> Floats:
        share = covered_shares(supply[chosen], demand[chosen], film / skin.capacity)[:, -1]
        mass: Floats = skin.capacity * share**1.5
        return mass

    rows = np.arange(len(gain))
    before = after(np.zeros(len(gain)), rows)
    wet = np.flatnonzero(before > _RETURNS)
    low = before[wet]
    for _ in range(2):
        rise = after(low, wet)
        before[wet] = rise
        unfinished = rise - low > _RETURNS
        wet, low = wet[unfinished], rise[unfinished]
    high = np.full(wet.size, skin.capacity)
    for _ in range(_PERIODIC if wet.size else 0):
        middle = 0.5 * (low + high)
        grows = after(middle, wet) > middle
        low, high = np.where(grows, middle, low), np.where(grows, high, middle)
    before[wet] = 0.5 * (low + high)
    return before


@dataclass(frozen=True, eq=False)
class WetSkin:
    """How water lies on a material and what follows from temperatures; `canopy_days` has leaves over soil."""

    material: SurfaceMaterial
    sources: ClassVar[int] = 1  # rows of times that a column has

    def filmed(self, forcing: Forcing, share: Floats) -> Forcing:
        """A forcing with films that cover shares (columns, sources N)."""
        return replace(forcing, film=share)

    def loss(self, forcing: Forcing, temperature: Floats) -> Floats:
        """Heat loss under a forcing with films (columns, sources N) [W m^-2]."""
        return np.asarray(Balance(forcing, self.material).loss(temperature), float)

    def temperature(self, solution: Solution) -> Floats:
        """Those of the sources (columns, sources N) [K]."""
        return solution.temperature

    def next_film(
        self, forcing: Forcing, temperature: Floats, step: float, before: Floats | None
    ) -> tuple[Floats, Floats]:
        """Film and share that follow from temperatures (columns, sources N) [K]."""
        return _next_film(self.material, forcing, temperature, step, before)


def solve_with_film(
    skin: WetSkin,
    forcing: Forcing,
    step: float,
    solve: Callable[[Forcing, Integers], Solution],
    before: Floats | None,
) -> Solution:
    """Temperatures and films of all columns.

    Parameters
    ----------
    skin : WetSkin
        Skin of a material with a film.
    forcing : Forcing
        Forcing with rain.
    step : float
        [s]
    solve : callable
        Solves some columns under a forcing with a film.
    before : (columns,) or (columns, sources) ndarray or None
        Water before the period, as in `film_of`.

    Returns
    -------
    Solution
        Its `residual` contains what the last film would still change.
    """
    columns = forcing.shape[0]
    active = np.arange(columns)
    still = np.tile(np.atleast_2d(forcing.air_temperature) + np.zeros(forcing.shape), skin.sources)
    share = skin.next_film(forcing, still, step, before)[1]
    film, complete = np.zeros(share.shape), None
    part_way, away = np.full((columns, 1), 0.5), np.zeros(share.shape)
    for number in range(ROUNDS):
        dry = forcing.columns(active)
        part = skin.filmed(dry, share[active])
        solution = solve(part, active)
        start, temperature = None if before is None else before[active], skin.temperature(solution)
        film[active], following = skin.next_film(part, temperature, step, start)
        changed = skin.loss(skin.filmed(dry, following), temperature) - skin.loss(part, temperature)
        change = np.abs(changed).max(axis=1)
        solution = replace(solution, residual=np.maximum(solution.residual, change), film=film[active])
        complete = solution if complete is None else complete.with_columns(active, solution)
        keep = change > TOLERANCE
        if not keep.any():
            break
        active, update = active[keep], following[keep] - share[active[keep]]
        if number > _CAREFUL:
            part_way[active] = aitken(part_way[active], away[active], update)
        away[active] = update
        share[active] += update * (part_way[active] if number >= _CAREFUL else 1.0)
    assert isinstance(complete, Solution)
    return complete


def aitken(part: Floats, before: Floats, now: Floats) -> Floats:
    """Part (columns, 1) of the way to the next iterate, by the ways (columns, N) of the last two rounds: Aitken's
    secant for vectors (Irons and Tuck 1969, Int. J. Numer. Methods Eng. 1, 275-277), `_LEAST_PART` to 1.

    Examples
    --------
    A way that turns round to -1 of itself when it is gone by half, would be 0 when gone by a quarter:

    >>> aitken(np.array([[0.5]]), np.array([[0.4, 0.2]]), np.array([[-0.4, -0.2]]))
    array([[0.25]])
    """
    change = now - before
    square = np.maximum((change**2).sum(axis=1, keepdims=True), 1e-300)
    secant: Floats = -part * (before * change).sum(axis=1, keepdims=True) / square
    return np.clip(secant, _LEAST_PART, 1.0)


def _next_film(
    material: SurfaceMaterial, forcing: Forcing, temperature: Floats, step: float, before: Floats | None
) -> tuple[Floats, Floats]:
    """Film and share that follow from temperatures (columns, N) [K]."""
    assert material.film is not None and forcing.rain is not None
    flux = evaporated(material, forcing, temperature)
    rain = forcing.rain * np.maximum(forcing.cos_slope, 0.0)
    gain = np.maximum(-flux, 0.0) + rain
    return film_of(material.film, gain, np.maximum(flux, 0.0), step, before)


def evaporated(material: SurfaceMaterial, forcing: Forcing, temperature: Floats) -> Floats:
    """Water that a wholly wet surface loses (columns, N) [kg m^-2 s^-1]; negative where dew falls."""
    latent = Balance(replace(forcing, film=np.ones((1, 1))), material).latent_of_film(temperature)
    _, ratio = surface_vapour(temperature)
    flux: Floats = latent / (LATENT_HEAT * ratio)
    return flux
