"""Temperatures under a change of absorbed heat, in numpy: by which the tests judge the library in C (`shade.c`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.film import covered_shares
from skyshine.mat.surface.forcing import plane_irradiance
from skyshine.mat.surface.surroundings import Exposure, Surroundings
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.film_response import BEFORE, FILM, LOSS
from skyshine.mat.tables.htt import _PLACE, TemperatureTable
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.response import (
    ALTITUDE,
    DAY_H,
    FORCING_STEPS,
    HIGHEST,
    KERNEL,
    LAG,
    LOSS_EXCESS,
    LOSS_SLOPE,
    MELT,
    OFFSET,
    REFERENCE,
    SLOPE,
    forcing_hours,
    need_parts,
    need_response,
)
from skyshine.mat.tables.shade import (
    ABSORPTANCE,
    AIR,
    AUREOLE,
    DIFFUSE,
    DIRECT,
    EMISSIVITY,
    FORCING_TIME,
    LONGWAVE,
    SUN_AZIMUTH,
    SUN_ELEVATION,
)
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group

CORRECTIONS = 8  # times that the excess of the heat loss is applied
MELTING_RANGE = 0.01  # K below its melting point in which a surface counts as melting
_BLOCK = 512  # columns computed together


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
        On the face [kg m^-2 s^-1].
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
            Of a wholly wet surface [kg m^-2 s^-1]; dew is negative.
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


@dataclass(frozen=True, eq=False)
class ColumnResponse:
    """Response of some columns; P is their number, H hours, L cells of lag, O offsets.

    Attributes
    ----------
    lag : (L,) ndarray
        Where the cells of lag begin [h].
    offset : (O,) ndarray
        Of `excess` from `reference` [K].
    kernel : (P, H, L) ndarray
        [K m^2 W^-1]
    reference : (P, H) ndarray
        [K]
    slope : (P, H) ndarray
        [W m^-2 K^-1]
    excess : (P, H, O) ndarray
        [W m^-2]
    melt : (P, H) ndarray
        [W m^-2]
    film : ColumnFilm or None
        None: surfaces are dry.
    """

    lag: Floats
    offset: Floats
    kernel: Floats
    reference: Floats
    slope: Floats
    excess: Floats
    melt: Floats
    film: ColumnFilm | None = None

    def change(self, absorbed: Floats, temperature: Floats, highest: Floats) -> Floats:
        """Change of temperature through the day.

        Parameters
        ----------
        absorbed : (P, FORCING_STEPS) ndarray
            Change of the absorbed heat, means over the steps [W m^-2].
        temperature : (P, FORCING_STEPS) ndarray
            Of the table [K]; not a number where the table has no such time.
        highest : (P,) ndarray
            That the surfaces cannot exceed because they melt [K].

        Returns
        -------
        (P, FORCING_STEPS) ndarray
            [K]
        """
        if self.film is not None and not np.all(self.film.holds_water):
            change = np.empty(absorbed.shape)
            for film, rows in ((self.film, self.film.holds_water), (None, ~self.film.holds_water)):
                part = self._part(rows, film)
                change[rows] = part.change(absorbed[rows], temperature[rows], highest[rows])
            return change
        kernel, reference, slope, excess, melt = (
            _through_the_day(values) for values in (self.kernel, self.reference, self.slope, self.excess, self.melt)
        )
        melting = temperature >= highest[:, None] - MELTING_RANGE
        absorbed = np.where(melting, np.minimum(absorbed + melt, 0.0), absorbed)
        start = np.where(np.isfinite(temperature), temperature - reference, 0.0)
        loss = slope[..., None] * self.offset + excess
        if self.film is not None:
            return self._wet_change(self.film.by_step(_through_the_day), kernel, slope, loss, start, absorbed)
        base = _read(self.offset, loss, start)
        lowest, highest = self._bounds(loss, base, start, absorbed)
        change = np.clip(self._linear(kernel, absorbed), lowest, highest)
        for _ in range(CORRECTIONS):
            beyond = _read(self.offset, loss, start + change) - base - slope * change
            target = self._linear(kernel, absorbed - beyond)
            # Where the loss grows faster than its tangent the step is shortened, lest it overshoots.
            steeper = np.divide(beyond, slope * change, out=np.zeros_like(beyond), where=change != 0)
            change = np.clip(change + (target - change) / (1.0 + np.maximum(steeper, 0.0)), lowest, highest)
        return change

    def _part(self, rows: Booleans, film: ColumnFilm | None) -> ColumnResponse:
        """Some columns, under their part of a film."""
        names = ("kernel", "reference", "slope", "excess", "melt")
        part = replace(self, **{name: getattr(self, name)[rows] for name in names})
        return replace(part, film=None if film is None else film.columns(rows))

    def _wet_change(
        self, film: ColumnFilm, kernel: Floats, slope: Floats, loss: Floats, start: Floats, absorbed: Floats
    ) -> Floats:
        """`change` of surfaces with a film, all at the steps of the day: `loss` is that of the dry surface."""
        covered, water, end = film.sunlit_shares(_read(self.offset, film.evaporation, start))
        dry = _read(self.offset, loss, start)
        base = dry + covered * (_read(self.offset, film.heat_loss, start) - film.sunlight)
        light, before, change = film.light(absorbed), water, np.zeros(start.shape)
        for number in range(CORRECTIONS + 1):
            whole = loss + covered[..., None] * film.heat_loss
            heat = absorbed + covered * light
            surplus = heat - (_read(self.offset, whole, start) - base)
            lowest, highest = self._bounds(whole, base, start, heat, surplus)
            if number == 0:
                change = np.clip(self._linear(kernel, absorbed), lowest, highest)
            else:
                at = _read(self.offset, whole, start + change)
                target = self._linear(kernel, heat - (at - base - slope * change))
                steeper = np.maximum(_rise(self.offset, whole, start + change) / slope, 1.0)
                change = np.clip(change + (target - change) / steeper, lowest, highest)
            covered, after = film.shares(_read(self.offset, film.evaporation, start + change), before)
            if film.before is None:
                before = np.clip(water + (after - end), 0.0, 1.0)
        return change

    def _linear(self, kernel: Floats, absorbed: Floats) -> Floats:
        """The kernel applied to a history of heat: sum over the cells of lag."""
        edges = np.append(self.lag, self.lag[0] + DAY_H)
        ends = forcing_hours()[:, None] - edges
        integral = _integral(absorbed, ends)
        means = (integral[..., :-1] - integral[..., 1:]) / np.diff(edges)
        total: Floats = np.einsum("ptl,ptl->pt", kernel, means)
        return total

    def _bounds(
        self, loss: Floats, base: Floats, start: Floats, absorbed: Floats, surplus: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Least and largest change [K], each (P, 1): the extremes of the changes in balance at each time, and 0.

        Conduction only spreads a change over time: at its coldest time a surface gives heat to none of its layers, so
        it cannot be colder than its instantaneous balance. `surplus` is what is gained at no change, by default all.
        """
        gained = absorbed if surplus is None else surplus
        balanced = _inverse(self.offset, loss, base + absorbed) - start
        return (
            np.where(gained < 0, balanced, 0.0).min(axis=1, keepdims=True),
            np.where(gained > 0, balanced, 0.0).max(axis=1, keepdims=True),
        )


@dataclass(frozen=True, eq=False)
class StoredResponse:
    """The response in a ``.htt`` database.

    Attributes
    ----------
    altitude, slope : AxisRule
        Of the columns whose response is stored.
    lag, offset : ndarray
        As in `ColumnResponse`.
    kernel, reference, loss_slope, excess, melt : ndarray, shape (M, A, S, H, ...)
    film : StoredFilm or None
        None: surfaces are dry.
    """

    altitude: AxisRule
    slope: AxisRule
    lag: Floats
    offset: Floats
    kernel: npt.NDArray[Any]
    reference: npt.NDArray[Any]
    loss_slope: npt.NDArray[Any]
    excess: npt.NDArray[Any]
    melt: npt.NDArray[Any]
    film: StoredFilm | None = None

    @classmethod
    def of(cls, root: Group) -> StoredResponse:
        """The response that a database holds.

        Raises
        ------
        InputError
            It holds none, or a part of one.
        """
        need_response(root)
        return cls(
            AxisRule.of(ALTITUDE, root.axes[ALTITUDE]),
            AxisRule.of(SLOPE, root.axes[SLOPE]),
            np.asarray(root.axes[LAG].values, float),
            np.asarray(root.axes[OFFSET].values, float),
            root.variables[KERNEL].data,
            root.variables[REFERENCE].data,
            root.variables[LOSS_SLOPE].data,
            root.variables[LOSS_EXCESS].data,
            root.variables[MELT].data,
            StoredFilm.of(root),
        )

    def columns(self, material: Integers, altitude: Floats, slope: Floats) -> ColumnResponse:
        """The response of columns, by index of the material, altitude [km] and slope [degree], each (P,)."""
        corners: list[tuple[Integers, Integers, Floats]] = []
        below, above, high = self.altitude.locate(np.clip(altitude, *self.altitude.nodes[[0, -1]]))
        flat, steep, share = self.slope.locate(np.clip(slope, *self.slope.nodes[[0, -1]]))
        for level, level_weight in ((below, 1.0 - high), (above, high)):
            for tilt, tilt_weight in ((flat, 1.0 - share), (steep, share)):
                corners.append((level, tilt, level_weight * tilt_weight))

        def mixed(values: npt.NDArray[Any]) -> Floats:
            total: Floats = np.zeros((material.size, *values.shape[3:]))
            for level, tilt, weight in corners:
                part = values[material, level, tilt].astype(float)
                total += weight.reshape(-1, *[1] * (part.ndim - 1)) * part
            return total

        return ColumnResponse(
            self.lag,
            self.offset,
            mixed(self.kernel),
            mixed(self.reference),
            mixed(self.loss_slope),
            mixed(self.excess),
            mixed(self.melt),
            None if self.film is None else self.film.columns(material, slope, mixed),
        )


def step_means(values: Floats) -> Floats:
    """Means over the steps of a day, (P, FORCING_STEPS), of values (P, n) that are means over n equal ones.

    Steps are centred on their times, the first on midnight.
    """
    if values.shape[1] == FORCING_STEPS:
        return values
    edges = (np.arange(FORCING_STEPS + 1.0) - 0.5) * (DAY_H / FORCING_STEPS)
    means: Floats = np.diff(_integral(values, edges[None, :]))[:, 0] * (FORCING_STEPS / DAY_H)
    return means


def at_times(values: Floats, hours: Floats) -> Floats:
    """Values (P, FORCING_STEPS) of each column at one clock hour of each (P,), linear and periodic."""
    place = np.mod(hours, DAY_H) * (FORCING_STEPS / DAY_H)
    before = np.floor(place).astype(int) % FORCING_STEPS
    weight = place - np.floor(place)
    rows = np.arange(len(values))
    between: Floats = values[rows, before] * (1 - weight) + values[rows, (before + 1) % FORCING_STEPS] * weight
    return between


def _through_the_day(values: Floats) -> Floats:
    """Values (P, H, ...) at equal hours of a day as ones at its steps, (P, FORCING_STEPS, ...), linear between."""
    hours = values.shape[1]
    place = np.arange(FORCING_STEPS) * hours / FORCING_STEPS
    before = np.floor(place).astype(int)
    weight = (place - before).reshape(-1, *[1] * (values.ndim - 2))
    between: Floats = values[:, before] * (1 - weight) + values[:, (before + 1) % hours] * weight
    return between


def _integral(values: Floats, hours: Floats) -> Floats:
    """Integral of step means (P, n) from the beginning of the first step to hours (T, E): (P, T, E)."""
    columns, steps = values.shape
    sums = np.concatenate([np.zeros((columns, 1)), np.cumsum(values, axis=1)], axis=1)
    place = hours * (steps / DAY_H) + 0.5
    day = np.floor(place / steps)
    place = place - day * steps
    before = np.minimum(np.floor(place).astype(int), steps - 1)
    total: Floats = (sums[:, before] + (place - before) * values[:, before] + day * sums[:, -1:, None]) * (
        DAY_H / steps
    )
    return total


def _read(nodes: Floats, values: Floats, at: Floats) -> Floats:
    """Values (P, T, O) at points (P, T) between their nodes (O,), linear, beyond the ends too."""
    lower = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    left, right = (np.take_along_axis(values, (lower + side)[..., None], axis=2)[..., 0] for side in (0, 1))
    result: Floats = left + (at - nodes[lower]) * (right - left) / (nodes[lower + 1] - nodes[lower])
    return result


def _rise(nodes: Floats, values: Floats, at: Floats) -> Floats:
    """Slope of what `_read` reads (P, T)."""
    lower = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    left, right = (np.take_along_axis(values, (lower + side)[..., None], axis=2)[..., 0] for side in (0, 1))
    rise: Floats = (right - left) / (nodes[lower + 1] - nodes[lower])
    return rise


def _inverse(nodes: Floats, values: Floats, wanted: Floats) -> Floats:
    """Points (P, T) at which ascending values (P, T, O) over nodes (O,) are the wanted ones (P, T), linear."""
    lower = np.clip((values <= wanted[..., None]).sum(axis=2) - 1, 0, nodes.size - 2)
    left, right = (np.take_along_axis(values, (lower + side)[..., None], axis=2)[..., 0] for side in (0, 1))
    weight = np.divide(wanted - left, right - left, out=np.zeros_like(wanted), where=right > left)
    result: Floats = nodes[lower] + weight * (nodes[lower + 1] - nodes[lower])
    return result


def temperature_change(
    root: Group,
    history: Callable[..., Floats],
    column: Mapping[str, npt.ArrayLike],
    hours: npt.ArrayLike,
    absorbed: Floats,
) -> Floats:
    """Change of the temperatures of a ``.htt`` database by other heat.

    Parameters
    ----------
    root : Group
        Of the database.
    history : callable
        Reads its temperatures [K] at values of the axes, by name.
    column : mapping
        Material code, altitude [km], azimuth and slope [degree], to be broadcast.
    hours : array_like
        Clock hours at which the change is wanted, to be broadcast with them.
    absorbed : (..., n) ndarray
        As in `TemperatureTable.temperature`.

    Returns
    -------
    ndarray
        Of the broadcast shape [K].

    Raises
    ------
    InputError
        The database has no response, or a change is not finite.
    """
    stored = StoredResponse.of(root)
    if absorbed.ndim == 0 or absorbed.shape[-1] == 0 or not np.all(np.isfinite(absorbed)):
        raise InputError(
            "absorbed_change: found no steps or a value that is not finite; allowed: finite W m^-2 by time"
        )
    changes = absorbed.reshape(-1, absorbed.shape[-1])
    numbers = np.arange(len(changes)).reshape(absorbed.shape[:-1])
    fields = [np.asarray(values, float) for values in (*column.values(), numbers, hours)]
    flat = [values.ravel() for values in np.broadcast_arrays(*fields)]
    places, inverse = np.unique(np.stack(flat[:-1], axis=1), axis=0, return_inverse=True)
    codes = np.asarray(root.axes["material"].values)
    times = held_times(AxisRule.of("time", root.axes["time"]))
    result = np.empty(flat[-1].size)
    for start in range(0, len(places), _BLOCK):
        code, altitude, azimuth, slope, number = places[start : start + _BLOCK].T
        temperature = np.full((code.size, FORCING_STEPS), np.nan)
        temperature[:, times] = history(
            material=code[:, None].astype(int),
            altitude=altitude[:, None],
            azimuth=azimuth[:, None],
            slope=slope[:, None],
            time=forcing_hours()[times],
        )
        index = np.searchsorted(codes, code)
        highest = np.asarray(root.variables[HIGHEST].data, float)[index]
        columns = stored.columns(index, altitude, slope)
        change = columns.change(step_means(changes[number.astype(int)]), temperature, highest)
        rows = np.flatnonzero((inverse.ravel() >= start) & (inverse.ravel() < start + _BLOCK))
        result[rows] = at_times(change[inverse.ravel()[rows] - start], flat[-1][rows])
    return result.reshape(np.broadcast_shapes(*(values.shape for values in fields)))


def held_times(rule: AxisRule) -> Booleans:
    """Which steps of the day a time axis holds, (FORCING_STEPS,)."""
    if rule.interpolation == PERIODIC:
        return np.ones(FORCING_STEPS, bool)
    first, last = rule.nodes[[0, -1]]
    held: Booleans = np.mod(forcing_hours() - first, DAY_H) <= last - first
    return held


@dataclass(frozen=True, eq=False)
class OpenAir:
    """Light, longwave and air over surfaces without surroundings, by altitude and time of day.

    Attributes
    ----------
    altitude : AxisRule
        [km]
    direct, diffuse, longwave : (A, FORCING_STEPS) ndarray
        Direct normal, diffuse horizontal, of the whole sky on a level surface [W m^-2].
    air : (A, FORCING_STEPS) ndarray
        [K]
    elevation, azimuth : (FORCING_STEPS,) ndarray
        Of the Sun [degree].
    aureole : (FORCING_STEPS,) ndarray
        Share of the diffuse light that comes from around the Sun.
    """

    altitude: AxisRule
    direct: Floats
    diffuse: Floats
    longwave: Floats
    air: Floats
    elevation: Floats
    azimuth: Floats
    aureole: Floats

    @classmethod
    def of(cls, root: Group) -> OpenAir:
        """The light that a database holds; `StoredResponse.of` refuses one without it."""
        names = (DIRECT, DIFFUSE, LONGWAVE, AIR, SUN_ELEVATION, SUN_AZIMUTH, AUREOLE)
        need_parts(root, names)
        return cls(
            AxisRule.of("altitude", root.axes["altitude"]),
            *(np.asarray(root.variables[name].data, float) for name in names),
        )

    def absorbed_change(
        self,
        exposure: Exposure,
        altitude: Floats,
        azimuth: Floats,
        slope: Floats,
        absorptance: Floats,
        emissivity: Floats,
    ) -> Floats:
        """Change of the absorbed heat of P surfaces by their surroundings.

        Parameters
        ----------
        exposure : Exposure
            Of the P surfaces, at the steps of the day.
        altitude, azimuth, slope : (P,) ndarray
            [km], [degree]
        absorptance, emissivity : (P,) ndarray
            For sunlight, and for longwave.

        Returns
        -------
        (P, FORCING_STEPS) ndarray
            [W m^-2]
        """
        steps = AxisRule(FORCING_TIME, forcing_hours(), PERIODIC, DAY_H)
        place = {
            "altitude": np.clip(altitude, *self.altitude.nodes[[0, -1]])[:, None],
            FORCING_TIME: forcing_hours()[None, :],
        }
        direct_normal, diffuse_level, longwave, air = (
            interpolate(values, [self.altitude, steps], place)
            for values in (self.direct, self.diffuse, self.longwave, self.air)
        )
        direct, diffuse, _ = plane_irradiance(
            slope[:, None],
            azimuth[:, None],
            self.elevation,
            self.azimuth,
            direct_normal,
            diffuse_level,
            0.0,
            self.aureole,
        )
        view = 0.5 * (1 + np.cos(np.radians(slope)))[:, None]
        beam, spread = exposure.sunlight(view, direct, diffuse, view * (1 - self.aureole) * diffuse_level)
        sky, others = exposure.longwave(view, longwave, air)
        open_sky, ground = Surroundings().longwave(view, longwave, air)
        change: Floats = absorptance[:, None] * (beam + spread - direct - diffuse)
        change += emissivity[:, None] * (sky + others - open_sky - ground)
        return change


def absorbed_change(
    root: Group,
    around: Surroundings | Exposure,
    material: npt.NDArray[Any],
    altitude: Floats,
    azimuth: Floats,
    slope: Floats,
    *,
    ground: Ground | None = None,
) -> Floats:
    """Change of absorbed heat at places of a ``.htt`` database.

    Parameters
    ----------
    root : Group
        Of the database.
    around : Surroundings or Exposure
        Of all places, or of each in the order of the broadcast shape.
    material, altitude, azimuth, slope : ndarray
        Codes, [km], [degree], to be broadcast.
    ground : Ground, optional
        Which has the same shade; by default it stays as it is in the open.

    Returns
    -------
    (..., FORCING_STEPS) ndarray
        [W m^-2]

    Raises
    ------
    InputError
        The database has no response, or no such material.
    """
    StoredResponse.of(root)
    need_parts(root, (ABSORPTANCE, EMISSIVITY))
    rule = AxisRule.of("material", root.axes["material"])
    at, up, over, tilt = np.broadcast_arrays(rule.locate(material)[0], altitude, azimuth, slope)
    absorptance, emissivity = (root.variables[name].data[at.ravel()] for name in (ABSORPTANCE, EMISSIVITY))
    if isinstance(around, Surroundings):
        around = Exposure.of(around, forcing_hours(), DAY_H / FORCING_STEPS)
    change = OpenAir.of(root).absorbed_change(
        around, up.ravel(), over.ravel(), tilt.ravel(), absorptance.astype(float), emissivity.astype(float)
    )
    if ground is not None and np.any(tilt > 0):
        change += _from_ground(root, around, ground, up.ravel(), tilt.ravel(), absorptance, emissivity)
    return change.reshape(*at.shape, FORCING_STEPS)


@dataclass(frozen=True)
class Ground:
    """Ground of a ``.htt`` database that has the shade of the tilted surfaces before which it lies.

    Attributes
    ----------
    number : int
        Of its material in the database.
    emissivity, albedo : float
    temperature : callable
        Temperatures (Z, FORCING_STEPS) [K] of level ground at altitudes (Z,) [km], under an absorbed heat (Z,
        FORCING_STEPS) [W m^-2] or none.
    """

    number: int
    emissivity: float
    albedo: float
    temperature: Callable[[Floats, Floats | None], Floats]


def _from_ground(
    root: Group,
    around: Exposure,
    ground: Ground,
    altitude: Floats,
    slope: Floats,
    absorptance: Floats,
    emissivity: Floats,
) -> Floats:
    """Change of absorbed heat (P, FORCING_STEPS) by ground that is colder and reflects less light in the shade."""
    count = max(len(around.shaded), len(around.sky_view))
    heights, which = (altitude, np.arange(altitude.size)) if count > 1 else np.unique(altitude, return_inverse=True)
    level, one = np.zeros(heights.size), np.ones(heights.size)
    air = OpenAir.of(root)
    light = air.absorbed_change(around, heights, level, level, one, level)
    own = (np.full(heights.size, root.variables[name].data[ground.number], float) for name in (ABSORPTANCE, EMISSIVITY))
    heat = air.absorbed_change(around, heights, level, level, *own)
    colder = ground.temperature(heights, heat) ** 4 - ground.temperature(heights, None) ** 4
    view = 0.5 * (1 - np.cos(np.radians(slope)))[:, None]
    longwave, reflected = ground.emissivity * Stefan_Boltzmann * colder, ground.albedo * light
    change: Floats = view * (emissivity[:, None] * longwave[which] + absorptance[:, None] * reflected[which])
    return change


class NumpySurface(TemperatureTable):
    """An open table of temperatures whose response is applied in numpy."""

    @classmethod
    def of(cls, surface: TemperatureTable) -> NumpySurface:
        return cls(surface.path, surface.filetype, surface.root, surface.attributes, surface.out_of_range)

    def _heated(self, material: Any, place: Mapping[str, npt.ArrayLike], absorbed: Floats) -> Floats:
        sunlit = self.value("temperature", material=material, **place)
        history = partial(self.value, "temperature")
        column = {"material": self.material_codes(material)} | {name: place[name] for name in _PLACE}
        change = temperature_change(self.root, history, column, place["time"], absorbed)
        highest = self.value(HIGHEST, material=material)
        return np.asarray(np.where(change == 0, sunlit, np.minimum(sunlit + change, np.maximum(highest, sunlit))))

    def exposed_change(self, exposure: Exposure, *, material: Any, **where: Any) -> npt.NDArray[np.float64]:
        place = self._place(where.pop("slope", None), altitude=where.get("altitude"), azimuth=where.get("azimuth"))
        places = [np.asarray(place[name], float) for name in _PLACE]
        return absorbed_change(self.root, exposure, self.material_codes(material), *places, ground=self._ground)

    @property
    def _ground(self) -> Ground | None:
        """The ground around tilted surfaces, where the file names it and holds level faces of it."""
        name = self.attributes.get("ground_material")
        if name not in self.materials or np.min(np.asarray(self.root.axes["slope"].values)) > 0:
            return None
        inside, hours = self.clamped(), forcing_hours()
        clock = AxisRule.of("time", self.root.axes["time"])
        within = held_times(clock)

        def temperature(altitude: npt.NDArray[np.float64], heat: npt.NDArray[np.float64] | None) -> Any:
            place = {"altitude": altitude[:, None], "time": np.where(within, hours, clock.nodes[0])}
            change = None if heat is None else heat[:, None]
            kelvin = inside.temperature(material=str(name), **place, absorbed_change=change)
            return np.where(within, kelvin, 0.0)

        number = list(self.materials).index(str(name))
        emissivity, albedo = (float(self.attributes[f"ground_{key}"]) for key in ("emissivity", "albedo"))
        return Ground(number, emissivity, albedo, temperature)
