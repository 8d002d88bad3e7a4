"""Temperatures in the shade, beside a wall or under other heat: the formulas of schemas/formats/htt-1.md."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from .axis import Axis, Floats, SceneError
from .database import Database
from .film import Film

STEPS, CORRECTIONS, DAY = 288, 8, 24.0
STEFAN_BOLTZMANN = 5.670374419e-8
WALL_EMISSIVITY = 0.95
MELTING_RANGE = 0.01  # K below its melting point in which a surface counts as melting
HOURS: Floats = np.arange(float(STEPS)) * (DAY / STEPS)


def integral(values: Floats, hours: Floats) -> Floats:
    """Integral of step means, from the beginning of the first step to hours of any day."""
    steps = values.size
    sums = np.append(0.0, np.cumsum(values))
    place = hours * (steps / DAY) + 0.5
    day = np.floor(place / steps)
    place = place - day * steps
    before = np.minimum(np.floor(place).astype(int), steps - 1)
    total: Floats = (sums[before] + (place - before) * values[before] + day * sums[-1]) * (DAY / steps)
    return total


def step_means(values: Floats) -> Floats:
    """Means over the steps of the day of values that are means over other equal steps."""
    if values.size == STEPS:
        return values
    edges = (np.arange(STEPS + 1.0) - 0.5) * (DAY / STEPS)
    means: Floats = np.diff(integral(values, edges)) * (STEPS / DAY)
    return means


def read(nodes: Floats, values: Floats, at: Floats) -> Floats:
    """Values (STEPS, nodes) at one point of each step, linear between the nodes and beyond their ends."""
    rows = np.arange(STEPS)
    lower = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    left, right = values[rows, lower], values[rows, lower + 1]
    result: Floats = left + (at - nodes[lower]) * (right - left) / (nodes[lower + 1] - nodes[lower])
    return result


def rise(nodes: Floats, values: Floats, at: Floats) -> Floats:
    """Slope of what `read` reads."""
    rows = np.arange(STEPS)
    lower = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, nodes.size - 2)
    result: Floats = (values[rows, lower + 1] - values[rows, lower]) / (nodes[lower + 1] - nodes[lower])
    return result


def inverse(nodes: Floats, values: Floats, wanted: Floats) -> Floats:
    """Points at which ascending values (STEPS, nodes) are the wanted ones."""
    rows = np.arange(STEPS)
    lower = np.clip((values <= wanted[:, None]).sum(axis=1) - 1, 0, nodes.size - 2)
    left, right = values[rows, lower], values[rows, lower + 1]
    share = np.divide(wanted - left, right - left, out=np.zeros(STEPS), where=right > left)
    result: Floats = nodes[lower] + share * (nodes[lower + 1] - nodes[lower])
    return result


def within(axis: Axis, value: float) -> float:
    """The value, or the end of the axis that it is beyond."""
    return float(min(max(value, axis.nodes[0]), axis.nodes[-1]))


def through_the_day(surface: Database, name: str, place: Mapping[str, float]) -> Floats:
    """An array of the response at each step of the day, (STEPS, ...): linear in altitude, slope and hour."""
    axes, values = surface.arrays[name]
    part: Floats = values.astype(float)
    for axis in axes[:3]:
        lower, upper, weight = axis.locate(place[axis.name])
        part = part[lower] * (1 - weight) + part[upper] * weight
    steps = [axes[3].locate(hour) for hour in HOURS]
    lowers, uppers, weights = (np.array(column) for column in zip(*steps, strict=True))
    weights = weights.reshape(-1, *[1] * (part.ndim - 1))
    result: Floats = part[lowers.astype(int)] * (1 - weights) + part[uppers.astype(int)] * weights
    return result


def history(surface: Database, face: Mapping[str, float]) -> Floats:
    """Temperature of the table at each step of the day; not a number at times that it does not hold."""
    time = surface.arrays["temperature"][0][4]
    held = (HOURS - time.nodes[0]) % DAY <= time.nodes[-1] - time.nodes[0]
    if time.rule == "linear_periodic":
        held[:] = True
    return np.array(
        [
            surface.value("temperature", {**face, "time": float(hour)}) if inside else math.nan
            for hour, inside in zip(HOURS, held, strict=True)
        ]
    )


def change(surface: Database, face: Mapping[str, float], absorbed: Floats) -> Floats:
    """Change of temperature at each step of the day by a change of absorbed heat at each step."""
    axes = surface.arrays["response_kernel"][0]
    offsets, lags = surface.arrays["heat_loss_excess"][0][4].nodes, axes[4].nodes
    place = {
        "material": face["material"],
        "response_altitude": within(axes[1], face["altitude"]),
        "response_slope": within(axes[2], face["slope"]),
    }
    kernel, reference, slope, excess, melt = (
        through_the_day(surface, name, place)
        for name in ("response_kernel", "response_temperature", "heat_loss_slope", "heat_loss_excess", "melting_heat")
    )
    sunlit = history(surface, face)
    melting = sunlit >= surface.value("highest_temperature", face) - MELTING_RANGE
    absorbed = np.where(melting, np.minimum(absorbed + melt, 0.0), absorbed)
    start = sunlit - reference
    start[np.isnan(start)] = 0.0
    loss = slope[:, None] * offsets + excess
    edges = np.append(lags, lags[0] + DAY)

    def linear(heat: Floats) -> Floats:
        ends = integral(heat, HOURS[:, None] - edges)
        total: Floats = np.sum(kernel * (ends[:, :-1] - ends[:, 1:]) / np.diff(edges), axis=1)
        return total

    film = film_of(surface, face, place)
    if film is not None:
        return wet_change(film, linear, offsets, slope, loss, start, absorbed)
    base = read(offsets, loss, start)
    balanced = inverse(offsets, loss, base + absorbed) - start
    lowest, highest = np.where(absorbed < 0, balanced, 0).min(), np.where(absorbed > 0, balanced, 0).max()
    moved = np.clip(linear(absorbed), lowest, highest)
    for _ in range(CORRECTIONS):
        beyond = read(offsets, loss, start + moved) - base - slope * moved
        target = linear(absorbed - beyond)
        steeper = np.divide(beyond, slope * moved, out=np.zeros(STEPS), where=moved != 0)
        moved = np.clip(moved + (target - moved) / (1 + np.maximum(steeper, 0)), lowest, highest)
    return moved


def film_of(surface: Database, face: Mapping[str, float], place: Mapping[str, float]) -> Film | None:
    """The film on a face at its place in the response; None where no water stays."""
    if "film_heat_loss" not in surface.arrays or surface.value("film_capacity", face) <= 0:
        return None
    names = ("film_heat_loss", "film_evaporation", "film_sunlight", "absorbed_sunlight")
    upward = max(math.cos(math.radians(face["slope"])), 0.0)
    rain = np.array([surface.value("rain", {"forcing_time": hour}) for hour in HOURS]) * upward
    before = surface.value("film_before", place) if "film_before" in surface.arrays else None
    tables = (through_the_day(surface, name, place) for name in names)
    return Film(*tables, rain, surface.value("film_capacity", face), before)


def wet_change(
    film: Film,
    linear: Callable[[Floats], Floats],
    offsets: Floats,
    slope: Floats,
    loss: Floats,
    start: Floats,
    absorbed: Floats,
) -> Floats:
    """`change` of a face with a film; `loss` is that of the dry face."""
    covered, water, end = film.in_the_open(read(offsets, film.evaporation, start))
    base = read(offsets, loss, start) + covered * (read(offsets, film.loss, start) - film.sunlight)
    light, before, moved = film.light(absorbed), water, np.zeros(STEPS)
    for number in range(CORRECTIONS + 1):
        whole, heat = loss + covered[:, None] * film.loss, absorbed + covered * light
        surplus = heat - (read(offsets, whole, start) - base)
        balanced = inverse(offsets, whole, base + heat) - start
        lowest, highest = np.where(surplus < 0, balanced, 0).min(), np.where(surplus > 0, balanced, 0).max()
        if number == 0:
            moved = np.clip(linear(absorbed), lowest, highest)
        else:
            beyond = read(offsets, whole, start + moved) - base - slope * moved
            steeper = np.maximum(rise(offsets, whole, start + moved) / slope, 1)
            moved = np.clip(moved + (linear(heat - beyond) - moved) / steeper, lowest, highest)
        covered, after = film.shares(read(offsets, film.evaporation, start + moved), before)
        if film.returns:
            before = min(max(water + (after - end), 0.0), 1.0)
    return moved


def temperature_under(surface: Database, face: Mapping[str, float], absorbed: Sequence[float] | Floats) -> float:
    """Temperature of a face that absorbs other heat than the table's: means over equal steps of the day, W m^-2."""
    need_response(surface)
    heat = np.asarray(absorbed, float)
    if heat.ndim != 1 or heat.size == 0 or not np.all(np.isfinite(heat)):
        raise SceneError("absorbed_change must be a list of finite numbers")
    moved = change(surface, face, step_means(heat))
    place = face["time"] % DAY * (STEPS / DAY)
    before, weight = math.floor(place) % STEPS, place - math.floor(place)
    sunlit, limit = surface.value("temperature", face), surface.value("highest_temperature", face)
    return float(min(sunlit + moved[before] * (1 - weight) + moved[(before + 1) % STEPS] * weight, max(limit, sunlit)))


def shaded_share(intervals: Sequence[Sequence[float]]) -> Floats:
    """Share of each step of the day in the shade, of intervals that do not overlap."""
    first, last = HOURS - DAY / STEPS / 2, HOURS + DAY / STEPS / 2
    covered = np.zeros(STEPS)
    for begin, end in intervals:
        for turn in (-DAY, 0.0, DAY):
            length = np.minimum(last, (end + DAY if end < begin else end) + turn) - np.maximum(first, begin + turn)
            covered += np.maximum(length, 0.0)
    return np.minimum(covered * (STEPS / DAY), 1.0)


def absorbed_change(surface: Database, face: Mapping[str, float], surroundings: Mapping[str, Any]) -> Floats:
    """Change of the heat that a face absorbs at each step of the day, by shade and a wall."""
    need_response(surface)
    shade, open_share = surroundings.get("shade", []), surroundings.get("sky_view", 1.0)
    facing, emissivity = surroundings.get("facing"), surroundings.get("facing_emissivity", WALL_EMISSIVITY)
    altitude = within(surface.arrays["air_temperature"][0][0], face["altitude"])
    normal, level, sky, air_temperature, extraterrestrial, elevation, azimuth = (
        np.array([surface.value(name, {"altitude": altitude, "forcing_time": hour}) for hour in HOURS])
        for name in (
            *("direct_normal_irradiance", "diffuse_irradiance", "sky_irradiance", "air_temperature"),
            *("extraterrestrial_irradiance", "solar_elevation", "solar_azimuth"),
        )
    )
    up, turn = np.radians(elevation), np.radians(azimuth - face["azimuth"])
    cosine, sine = math.cos(math.radians(face["slope"])), math.sin(math.radians(face["slope"]))
    view = 0.5 * (1 + cosine)
    incidence = np.maximum(cosine * np.sin(up) + sine * np.cos(up) * np.cos(turn), 0.0)
    index, ratio = normal / extraterrestrial, incidence / np.maximum(np.sin(up), math.sin(math.radians(1)))
    diffuse = level * ((1 - index) * view + index * ratio)
    spread = np.minimum(diffuse, view * level)
    beam = normal * incidence + diffuse - spread
    air = STEFAN_BOLTZMANN * air_temperature**4
    emitted = air if facing is None else STEFAN_BOLTZMANN * facing**4
    wall = emissivity * emitted + (1 - emissivity) * (sky + air) / 2
    absorbs, emits = (surface.value(name, face) for name in ("solar_absorptance", "thermal_emissivity"))
    blocked = shaded_share(shade) * beam + (1 - open_share) * spread
    result: Floats = emits * (1 - open_share) * view * (wall - sky) - absorbs * blocked
    return result


def air_temperature(surface: Database, altitude: float, time: float) -> float:
    """Temperature of the air over surfaces."""
    need_response(surface)
    place = {"altitude": within(surface.arrays["air_temperature"][0][0], altitude), "forcing_time": time}
    return surface.value("air_temperature", place)


def need_response(surface: Database) -> None:
    """Refuse a file without the response."""
    if "response_kernel" not in surface.arrays:
        raise SceneError("the surface file holds no response to shade")
