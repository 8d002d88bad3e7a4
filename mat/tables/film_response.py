"""The film of water on surfaces under a change of absorbed heat: the march of ``schemas/formats/htt-1.md``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.surface.film import covered_shares
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.hdf5 import Group

LOSS, EVAPORATION = "film_heat_loss", "film_evaporation"
SUNLIGHT, DRY_SUNLIGHT = "film_sunlight", "absorbed_sunlight"
BEFORE, CAPACITY, RAIN = "film_before", "film_capacity", "rain"
FILM = (LOSS, EVAPORATION, SUNLIGHT, DRY_SUNLIGHT, CAPACITY, RAIN)  # all or none in a file

RETURNS = 1e-9  # of the capacity, by which a film that returns after a day may differ
DAYS = 30  # marched through at most until it returns
_STEP_S = 86400.0 / 288


@dataclass(frozen=True, eq=False)
class ColumnFilm:
    """A whole film on P columns: at H hours and O offsets, or at the steps of the day.

    Attributes
    ----------
    heat_loss : (P, H, O) ndarray
        Above that of the dry surface, without sunlight [W m^-2].
    evaporation : (P, H, O) ndarray
        [kg m^-2 s^-1]
    sunlight, dry_sunlight : (P, H) ndarray
        Absorbed above that of the dry surface, and by that [W m^-2].
    capacity : (P,) ndarray
        [kg m^-2]; 0 where no water stays.
    rain : (P, FORCING_STEPS) ndarray
        Rain on the face [kg m^-2 s^-1].
    before : (P,) ndarray or None
        Water at midnight before the day [kg m^-2]; None: the film returns after the day.
    """

    heat_loss: Floats
    evaporation: Floats
    sunlight: Floats
    dry_sunlight: Floats
    capacity: Floats
    rain: Floats
    before: Floats | None

    @property
    def holds_water(self) -> Booleans:
        """Which columns may be wet, (P,)."""
        wet: Booleans = self.capacity > 0
        return wet

    def columns(self, rows: Booleans) -> ColumnFilm:
        """Those of some columns."""
        before = None if self.before is None else self.before[rows]
        parts = {field.name: getattr(self, field.name)[rows] for field in fields(self) if field.name != "before"}
        return ColumnFilm(**parts, before=before)

    def by_step(self, through_the_day: Callable[[Floats], Floats]) -> ColumnFilm:
        """The same at the steps of the day."""
        names = ("heat_loss", "evaporation", "sunlight", "dry_sunlight")
        return replace(self, **{name: through_the_day(getattr(self, name)) for name in names})

    def light(self, absorbed: Floats) -> Floats:
        """Sunlight that a whole film absorbs more under a change of heat (P, N) of a dry surface [W m^-2]: what is
        taken from it counts as sunlight.
        """
        left = np.divide(absorbed, self.dry_sunlight, out=np.zeros(absorbed.shape), where=self.dry_sunlight > 0)
        return self.sunlight * np.clip(1.0 + left, 0.0, 1.0)

    def shares(self, evaporation: Floats, start: Floats) -> tuple[Floats, Floats]:
        """Share that the film covers through a day (P, N), and the water at its end (P,).

        Parameters
        ----------
        evaporation : (P, N) ndarray
            Evaporation rate of a wholly wet surface [kg m^-2 s^-1]; dew is negative.
        start : (P,) ndarray
            Water before the day, over the capacity.
        """
        return self._march(evaporation, start, np.arange(start.size))

    def sunlit_shares(self, evaporation: Floats) -> tuple[Floats, Floats, Floats]:
        """Share through the day that the file holds (P, N), and water before it and at its end (P,)."""
        if self.before is not None:
            start = np.minimum(self._over_capacity(self.before), 1.0)
            share, end = self.shares(evaporation, start)
            return share, start, end
        count = len(evaporation)
        share, start, end = np.zeros(evaporation.shape), np.zeros(count), np.zeros(count)
        active = np.arange(count)
        for _ in range(DAYS):
            start[active] = end[active]
            share[active], end[active] = self._march(evaporation[active], start[active], active)
            active = active[end[active] - start[active] > RETURNS]
            if not active.size:
                break
        return share, start, end

    def _march(self, evaporation: Floats, start: Floats, columns: Integers) -> tuple[Floats, Floats]:
        gain = np.maximum(-evaporation, 0.0) + self.rain[columns]
        supply, demand = (self._over_capacity(v * _STEP_S, columns) for v in (gain, np.maximum(evaporation, 0.0)))
        share = covered_shares(supply, demand, start)
        return share, share[:, -1] ** 1.5

    def _over_capacity(self, water: Floats, columns: Integers | slice = slice(None)) -> Floats:
        capacity = self.capacity[columns].reshape(-1, *[1] * (water.ndim - 1))
        part: Floats = np.divide(water, capacity, out=np.zeros(water.shape), where=capacity > 0)
        return part


@dataclass(frozen=True, eq=False)
class StoredFilm:
    """The film in a ``.htt`` database: arrays (M, A, S, H, ...) as in `ColumnFilm`, `capacity` (M,), `rain` (N,) on
    level ground, `before` (M, A, S) or None.
    """

    heat_loss: npt.NDArray[Any]
    evaporation: npt.NDArray[Any]
    sunlight: npt.NDArray[Any]
    dry_sunlight: npt.NDArray[Any]
    capacity: npt.NDArray[Any]
    rain: npt.NDArray[Any]
    before: npt.NDArray[Any] | None

    @classmethod
    def of(cls, root: Group) -> StoredFilm | None:
        """That of a database, None where surfaces know no film."""
        if LOSS not in root.variables:
            return None
        loss, evaporation, sunlight, dry_sunlight, capacity, rain = (root.variables[name].data for name in FILM)
        before = root.variables[BEFORE].data if BEFORE in root.variables else None
        return cls(loss, evaporation, sunlight, dry_sunlight, capacity, rain, before)

    def columns(
        self, material: Integers, slope: Floats, mixed: Callable[[npt.NDArray[Any]], Floats]
    ) -> ColumnFilm | None:
        """Of columns, by index of the material and slope [degree], each (P,); `mixed` reads tables at their altitudes
        and slopes. None where no water stays on any.
        """
        capacity = np.asarray(self.capacity, float)[material]
        if not np.any(capacity > 0):
            return None
        upward = np.maximum(np.cos(np.radians(slope)), 0.0)
        return ColumnFilm(
            mixed(self.heat_loss),
            mixed(self.evaporation),
            mixed(self.sunlight),
            mixed(self.dry_sunlight),
            capacity,
            upward[:, None] * np.asarray(self.rain, float),
            None if self.before is None else mixed(self.before),
        )
