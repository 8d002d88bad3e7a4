"""Temperatures under a change of absorbed heat: what a runtime computes from the response in a ``.htt`` database.

``schemas/formats/htt-1.md`` gives the formulas.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.film_response import FILM, ColumnFilm, StoredFilm
from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError
from skyshine.schemas.hdf5 import Group

KERNEL, REFERENCE = "response_kernel", "response_temperature"
LOSS_SLOPE, LOSS_EXCESS = "heat_loss_slope", "heat_loss_excess"
HIGHEST, MELT = "highest_temperature", "melting_heat"
ALTITUDE, SLOPE, HOUR, LAG, OFFSET = (
    "response_altitude",
    "response_slope",
    "response_hour",
    "lag",
    "temperature_offset",
)

FORCING_STEPS = 288  # of a day, at which changes of heat and temperature are computed
CORRECTIONS = 8  # times that the excess of the heat loss is applied
DAY_H = 24.0
MELTING_RANGE = 0.01  # K below its melting point in which a surface counts as melting
_BLOCK = 512  # columns computed together


def forcing_hours() -> Floats:
    """Clock hours of the steps of a day, (FORCING_STEPS,)."""
    return np.arange(float(FORCING_STEPS)) * (DAY_H / FORCING_STEPS)


def need_parts(root: Group, names: Sequence[str]) -> None:
    """Refuse a database that holds some arrays for shade and lacks others, or one of their axes.

    Raises
    ------
    InputError
    """
    for name in names:
        if name not in root.variables or not set(root.variables[name].dims) <= set(root.axes):
            raise InputError(f"lacks '{name}' of the response to shade, or an axis of it; build it again")


@dataclass(frozen=True, eq=False)
class ColumnResponse:
    """Response of some columns; P is their number, H hours, L cells of lag, O offsets.

    Attributes
    ----------
    lag : (L,) ndarray
        Lower edges of the cells of lag [h].
    offset : (O,) ndarray
        Nodes of the offset of `excess` from `reference` [K].
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
            Temperature in the table [K]; NaN where the table has no such time.
        highest : (P,) ndarray
            Upper limit of the surface temperature, at which the material melts [K].

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
        Axes of the columns whose response is stored.
    lag, offset : ndarray
        Nodes of lag and offset, as in `ColumnResponse`.
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
        if KERNEL not in root.variables:
            raise InputError("holds no response to shade; build it again, without needs.shade: false")
        film = FILM if FILM[0] in root.variables else ()
        need_parts(root, (KERNEL, REFERENCE, LOSS_SLOPE, LOSS_EXCESS, MELT, HIGHEST, *film))
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
        Root group of the database.
    history : callable
        Reads its temperatures [K] at values of the axes, by name.
    column : mapping
        Material code, altitude [km], azimuth and slope [degree], to be broadcast.
    hours : array_like
        Clock hours at which the change is wanted, to be broadcast with them.
    absorbed : (..., n) ndarray
        Absorbed power, as in `TemperatureTable.temperature`.

    Returns
    -------
    ndarray
        Of the broadcast shape [K].

    Raises
    ------
    InputError
        The database holds no response, or a change is not finite.
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
