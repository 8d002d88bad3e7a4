"""A runtime's reader of the databases with h5py and numpy alone: the radiance of the pixels of a scene.

Usage: python runtime.py SCENE.json

The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193.
"""

from __future__ import annotations

import itertools
import json
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FACE = ("material", "altitude", "azimuth", "slope", "time")
PATH = ("range", "altitude", "elevation", "source_elevation", "source_azimuth")
MATERIAL = ("material",)
RESPONSE = ("material", "response_altitude", "response_slope", "response_hour")
OVERHEAD = ("altitude", "forcing_time")
FORMATS = {"htt": "1.", "band": "1.", "atmq": "2."}
# What a file must hold: axes, least and largest value of each array.
ARRAYS: dict[str, dict[str, tuple[Sequence[str], float, float]]] = {
    "htt": {"temperature": (FACE, 1.0, 1e4)},
    "band": {
        "blackbody_radiance": (("temperature",), 0.0, math.inf),
        "reflectance": (MATERIAL, 0.0, 1.0),
        "specular_fraction": (MATERIAL, 0.0, 1.0),
        "shininess": (MATERIAL, 0.0, math.inf),
        "normalisation": (MATERIAL, 0.0, math.inf),
    },
    "atmq": {
        "beta_star": (PATH[:3], 1e-12, math.inf),
        "path_radiance_ratio": (PATH, 0.0, math.inf),
        "ambient_radiance": (PATH[:4], 0.0, math.inf),
        "direct_radiance": (PATH[:4], 0.0, math.inf),
    },
}
# What an .htt that holds the first of them must hold, to shade surfaces.
SHADE: dict[str, tuple[Sequence[str], float, float]] = {
    "response_kernel": ((*RESPONSE, "lag"), -math.inf, math.inf),
    "response_temperature": (RESPONSE, 0.0, 1e4),
    "heat_loss_slope": (RESPONSE, 1e-6, math.inf),
    "heat_loss_excess": ((*RESPONSE, "temperature_offset"), -math.inf, math.inf),
    "solar_absorptance": (MATERIAL, 0.0, 1.0),
    "thermal_emissivity": (MATERIAL, 0.0, 1.0),
    "melting_heat": (RESPONSE, 0.0, math.inf),
    "highest_temperature": (MATERIAL, 1.0, 1e4),
    "direct_normal_irradiance": (OVERHEAD, 0.0, math.inf),
    "diffuse_irradiance": (OVERHEAD, 0.0, math.inf),
    "sky_irradiance": (OVERHEAD, 0.0, math.inf),
    "air_temperature": (OVERHEAD, 1.0, 1e4),
    "solar_elevation": (("forcing_time",), -90.0, 90.0),
    "solar_azimuth": (("forcing_time",), -360.0, 360.0),
    "extraterrestrial_irradiance": (("forcing_time",), 1e-6, math.inf),
}
# Of an .atmq file that has them: coefficients of the light around faces of any direction.
LIGHT, GLOW = "ambient_radiance_harmonics", "ground_radiance_harmonics"
HARMONICS: dict[str, tuple[Sequence[str], float, float]] = {
    LIGHT: ((*PATH[:4], "harmonic"), -math.inf, math.inf),
    GLOW: ((*PATH[:3], "ground_temperature", "zonal_harmonic"), -math.inf, math.inf),
}
# Codes 10 l + m of the harmonics, and of those without azimuth; a file has as many as suit its l.
CODES = {"harmonic": (0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44), "zonal_harmonic": (0, 10, 20, 40)}
COUNTS = {"harmonic": (6, 11), "zonal_harmonic": (3, 4)}
GROUND = ("ground_emissivity", "ground_temperature", "ground_radiance")
# How the format reads an axis: rules and period; others are linear and do not repeat.
RULES = {
    "material": (("exact",), 0.0),
    "harmonic": (("exact",), 0.0),
    "zonal_harmonic": (("exact",), 0.0),
    "azimuth": (("linear_periodic",), 360.0),
    "source_azimuth": (("linear_folded",), 360.0),
    "time": (("linear_periodic", "linear"), 24.0),
    "response_hour": (("linear_periodic",), 24.0),
    "forcing_time": (("linear_periodic",), 24.0),
}
LAST_CODE = 65535
# Deflate packs at most 1032 bytes into one: a file that claims more does not hold it.
PACKING, SMALL = 1100, 1 << 20


STEPS, CORRECTIONS, DAY = 288, 8, 24.0
STEFAN_BOLTZMANN = 5.670374419e-8
WALL_EMISSIVITY = 0.95
MELTING_RANGE = 0.01  # K below its melting point in which a surface counts as melting
HOURS: Floats = np.arange(float(STEPS)) * (DAY / STEPS)


class SceneError(Exception):
    """The scene or a file does not fit; the text says what is allowed."""


@dataclass(frozen=True)
class Axis:
    """One axis: its nodes and the rule by which a runtime reads between and outside them."""

    name: str
    nodes: Floats
    rule: str
    period: float
    clamps: bool

    def fault(self) -> str:
        """What in the rule or the nodes is not as the format has it; empty where nothing is."""
        rules, period = RULES.get(self.name, (("linear",), 0.0))
        first, last = self.nodes[0], self.nodes[-1]
        if self.rule not in rules:
            return f"interpolation '{self.rule:.40}'; allowed: {' or '.join(rules)}"
        if self.period != period:
            return f"period {self.period:g}; allowed: {period:g}"
        if not np.all(np.isfinite(self.nodes)) or np.any(np.diff(self.nodes) <= 0):
            return "nodes that are not ascending numbers"
        if (self.rule == "linear_folded" and (first < 0 or last > period / 2)) or (
            period and (last > first + period or (self.rule == "linear_periodic" and last == first + period))
        ):
            return "nodes beyond its period"
        if self.name in CODES:
            known = self.nodes.size in COUNTS[self.name] and tuple(self.nodes) == CODES[self.name][: self.nodes.size]
            return "" if known else "codes that are not those of the format"
        if self.rule == "exact" and (first < 1 or last > LAST_CODE):
            return f"codes beyond 1 to {LAST_CODE}"
        return ""

    def locate(self, value: float) -> tuple[int, int, float]:
        """Index of the lower and the upper node, and the weight of the upper one."""
        if not math.isfinite(value):
            raise SceneError(f"{self.name}: found {value}; allowed: finite numbers")
        nodes, count = self.nodes, self.nodes.size
        if self.rule == "exact":
            at = np.flatnonzero(nodes == value)
            if at.size == 0:
                raise SceneError(f"{self.name}: found {value:g}; allowed: a code of the file")
            return int(at[0]), int(at[0]), 0.0
        if self.rule == "linear_periodic":
            nodes = np.append(nodes, nodes[0] + self.period)
            value = nodes[0] + (value - nodes[0]) % self.period
        elif self.rule == "linear" and self.period > 0:
            value -= self.period * math.floor((value - nodes[0]) / self.period)
        elif self.rule == "linear_folded":
            value = abs((value + self.period / 2) % self.period - self.period / 2)
        if not self.clamps and not nodes[0] <= value <= nodes[-1]:
            raise SceneError(f"{self.name}: found {value:g}; allowed: {nodes[0]:g} to {nodes[-1]:g}")
        value = min(max(value, nodes[0]), nodes[-1])
        lower = min(max(int(np.searchsorted(nodes, value, side="right")) - 1, 0), max(nodes.size - 2, 0))
        upper = min(lower + 1, nodes.size - 1)
        weight = float((value - nodes[lower]) / (nodes[upper] - nodes[lower])) if upper > lower else 0.0
        return lower, upper % count, weight


class Database:
    """One file, read and checked whole: files come from anywhere, and nothing in one is believed before."""

    def __init__(self, path: Path, filetypes: Sequence[str], clamped: Sequence[str]) -> None:
        self.path, self.clamped = path, clamped
        self.arrays: dict[str, tuple[list[Axis], NDArray[np.float32]]] = {}
        self.codes: dict[str, int] = {}
        self.ground: dict[str, float] = {}
        try:
            if not path.is_file():
                raise OSError
            self.bytes = PACKING * path.stat().st_size + SMALL
            file = h5py.File(path, "r")
        except OSError:
            raise SceneError(f"{path}: is not a readable HDF5 file") from None
        with file:
            try:
                self._read(file, filetypes)
            except (OSError, KeyError, RuntimeError, ValueError, TypeError, AttributeError) as error:
                words = " ".join(str(error).split())
                raise SceneError(f"{path}: is damaged ({words:.100})") from None

    def _read(self, file: h5py.File, filetypes: Sequence[str]) -> None:
        filetype, version = (text(file, name) for name in ("filetype", "format_version"))
        major = FORMATS[filetypes[0]]
        if filetype not in filetypes or not version.startswith(major):
            allowed = f"{' or '.join(filetypes)} {major}x"
            raise SceneError(f"{self.path}: holds {filetype[:40]!r} {version[:20]}; allowed: {allowed}")
        shaded = SHADE if filetype == "htt" and "response_kernel" in file else {}
        for name, (axes, least, most) in (ARRAYS[filetypes[0]] | shaded).items():
            self.arrays[name] = self._array(file, name, axes, least, most)
        if FORMATS[filetypes[0]] == FORMATS["atmq"] and LIGHT in file:
            for name, (axes, least, most) in HARMONICS.items():
                self.arrays[name] = self._array(file, name, axes, least, most)
            if (self.arrays[LIGHT][0][-1].nodes.size == 6) != (self.arrays[GLOW][0][-1].nodes.size == 3):
                raise SceneError(f"{self.path}: '{LIGHT}' and '{GLOW}' are of different harmonics")
            self.ground = {name: number(file, name) for name in GROUND}
            if not all(math.isfinite(value) and value >= 0 for value in self.ground.values()):
                raise SceneError(f"{self.path}: does not state the ground: {', '.join(GROUND)}")
        if filetype == "band":
            self.codes = self._names(file, self.arrays["reflectance"][0][0])

    def _dataset(self, file: h5py.File, name: str, dtype: str, rank: int) -> h5py.Dataset:
        """An array of this very file, of a type (in any byte order) and so many axes."""
        if name not in file and not isinstance(file.get(name, getlink=True), h5py.SoftLink):
            raise SceneError(f"{self.path}: lacks '{name}'")
        if not isinstance(file.get(name, getlink=True), h5py.HardLink):
            raise SceneError(f"{self.path}: '{name}' is a link to somewhere else")
        dataset = file[name]
        if not isinstance(dataset, h5py.Dataset):
            raise SceneError(f"{self.path}: '{name}' is not an array")
        if dataset.is_virtual or dataset.external is not None:
            raise SceneError(f"{self.path}: '{name}' is kept in another file")
        if dataset.dtype.newbyteorder("=") != np.dtype(dtype):
            raise SceneError(f"{self.path}: '{name}' has values of another type")
        if dataset.shape is None or len(dataset.shape) != rank or dataset.size == 0:
            raise SceneError(f"{self.path}: '{name}' has the shape {dataset.shape}; allowed: {rank} axes, none empty")
        if dataset.size * dataset.dtype.itemsize > self.bytes:
            raise SceneError(f"{self.path}: '{name}' claims more bytes than the file can hold")
        return dataset

    def _axis(self, file: h5py.File, quantity: str, name: str) -> tuple[Axis, h5py.Dataset]:
        """The quantity's own axis where the file has one, else the one that quantities share."""
        own = f"{quantity}_{name}" if f"{quantity}_{name}" in file else name
        dataset = self._dataset(file, own, "i4" if RULES.get(name, ((), 0.0))[0] == ("exact",) else "f8", 1)
        policy = text(dataset, "out_of_range") if "out_of_range" in dataset.attrs else "error"
        if policy not in ("error", "clamp"):
            raise SceneError(f"{self.path}: the axis '{own}' has out_of_range {policy[:40]!r}; allowed: error, clamp")
        axis = Axis(
            name,
            dataset[()].astype(float),
            text(dataset, "interpolation"),
            number(dataset, "period") if "period" in dataset.attrs else 0.0,
            policy == "clamp" or name in self.clamped,
        )
        if fault := axis.fault():
            raise SceneError(f"{self.path}: the axis '{own}' has {fault}")
        return axis, dataset

    def _array(
        self, file: h5py.File, quantity: str, names: Sequence[str], least: float, most: float
    ) -> tuple[list[Axis], NDArray[np.float32]]:
        dataset, axes = self._dataset(file, quantity, "f4", len(names)), []
        scales = scales_of(dataset)
        for k, name in enumerate(names):
            by_angle = name == "source_azimuth" and "scattering_angle" in file
            axis, nodes = self._axis(file, quantity, "scattering_angle" if by_angle else name)
            if dataset.shape[k] != axis.nodes.size:
                found = f"{dataset.shape[k]} values along '{axis.name}', which has {axis.nodes.size} nodes"
                raise SceneError(f"{self.path}: '{quantity}' has {found}")
            if len(scales) != len(names) or scales[k] != nodes:
                raise SceneError(f"{self.path}: '{quantity}' has other dimension scales than its axes")
            axes.append(axis)
        values = dataset[()]
        if not np.all((values >= least) & (values <= most) & np.isfinite(values)):
            raise SceneError(f"{self.path}: '{quantity}' holds values beyond {least:g} to {most:g}")
        return axes, values

    def _names(self, file: h5py.File, axis: Axis) -> dict[str, int]:
        """Codes of the materials by name."""
        dataset = self._dataset(file, "material_name", "O", 1)
        names = dataset.asstr()[()].tolist()
        if len(set(names)) != axis.nodes.size or len(names) != axis.nodes.size or not all(names):
            raise SceneError(f"{self.path}: 'material_name' does not hold a name for each code")
        return dict(zip(names, map(int, axis.nodes), strict=True))

    def value(self, quantity: str, where: Mapping[str, float]) -> float:
        """Linear interpolation in every axis: the weighted sum over the corners of one cell."""
        axes, values = self.arrays[quantity]
        located = [axis.locate(where[axis.name]) for axis in axes]
        total = 0.0
        for corner in itertools.product((0, 1), repeat=len(axes)):
            share = math.prod(
                weight if up else 1.0 - weight for up, (_, _, weight) in zip(corner, located, strict=True)
            )
            if share:
                at = tuple((lower, upper)[up] for up, (lower, upper, _) in zip(corner, located, strict=True))
                total += share * float(values[at])
        return total

    def material(self, given: str | float) -> float:
        """Code of a material given by code or by name."""
        if not isinstance(given, str):
            return given
        if given not in self.codes:
            raise SceneError(f"material: found '{given:.60}'; allowed: {', '.join(self.codes):.200}")
        return self.codes[given]


def text(item: h5py.HLObject, name: str) -> str:
    """A text attribute; empty where there is none, or it is not one text."""
    value = item.attrs.get(name)
    if isinstance(value, bytes):
        return value.decode(errors="replace")
    return value if isinstance(value, str) else ""


def number(item: h5py.HLObject, name: str) -> float:
    """A number attribute; NaN where there is none, or it is not one number."""
    value = item.attrs.get(name)
    if value is None or isinstance(value, str | bytes) or np.size(value) != 1:
        return math.nan
    return float(np.reshape(value, ()))


def scales_of(dataset: h5py.Dataset) -> list[h5py.Dataset]:
    """The first dimension scale of each axis, by the references of DIMENSION_LIST; h5py's `dims` believes its type."""
    if "DIMENSION_LIST" not in dataset.attrs:
        return []
    dtype = dataset.attrs.get_id("DIMENSION_LIST").dtype
    if (base := h5py.check_vlen_dtype(dtype)) is None or h5py.check_ref_dtype(base) is not h5py.Reference:
        return []
    return [dataset.file[references[0]] for references in dataset.attrs["DIMENSION_LIST"] if len(references)]


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
    base = read(offsets, loss, start)
    edges = np.append(lags, lags[0] + DAY)

    def linear(heat: Floats) -> Floats:
        ends = integral(heat, HOURS[:, None] - edges)
        total: Floats = np.sum(kernel * (ends[:, :-1] - ends[:, 1:]) / np.diff(edges), axis=1)
        return total

    balanced = inverse(offsets, loss, base + absorbed) - start
    lowest, highest = np.where(absorbed < 0, balanced, 0).min(), np.where(absorbed > 0, balanced, 0).max()
    moved = np.clip(linear(absorbed), lowest, highest)
    for _ in range(CORRECTIONS):
        beyond = read(offsets, loss, start + moved) - base - slope * moved
        target = linear(absorbed - beyond)
        steeper = np.divide(beyond, slope * moved, out=np.zeros(STEPS), where=moved != 0)
        moved = np.clip(moved + (target - moved) / (1 + np.maximum(steeper, 0)), lowest, highest)
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


def need_response(surface: Database) -> None:
    """Refuse a file without the response."""
    if "response_kernel" not in surface.arrays:
        raise SceneError("the surface file holds no response to shade")


def unit(vector: Sequence[float]) -> Floats:
    """A direction of length 1."""
    parts: Floats = np.asarray(vector, float)
    length = float(np.linalg.norm(parts))
    if parts.shape != (3,) or not math.isfinite(length) or length == 0:
        raise SceneError("a direction must be three finite numbers that are not all 0")
    direction: Floats = parts / length
    return direction


def scattering_angle(elevation: float, source_elevation: float, azimuth: float) -> float:
    """Angle between line of sight and source, all in degree."""
    line, source = math.radians(elevation), math.radians(source_elevation)
    half = (
        math.sin((line - source) / 2) ** 2
        + math.cos(line) * math.cos(source) * math.sin(math.radians(azimuth) / 2) ** 2
    )
    return 2 * math.degrees(math.asin(math.sqrt(min(max(half, 0.0), 1.0))))


def lobe(normal: Floats, to_source: Floats, to_observer: Floats, shininess: float) -> float:
    """Equations (37) and (38): chi of the half vector to the power of the shininess."""
    between = to_source + to_observer
    length = float(np.linalg.norm(between))
    chi = max(float(between @ normal) / length, 0.0) if length > 0 else 0.0
    return float(min(chi, 1.0) ** shininess)


def temperature_of(surface: Database, face: dict[str, float], given: dict[str, Any]) -> float:
    """Temperature of the table, or with the heat or the surroundings that the pixel has."""
    if given.get("surroundings"):
        return temperature_under(surface, face, absorbed_change(surface, face, given["surroundings"]))
    if given.get("absorbed_change"):
        return temperature_under(surface, face, given["absorbed_change"])
    return surface.value("temperature", face)


def irradiance_harmonics(x: float, y: float, z: float) -> tuple[float, ...]:
    """A_l / pi times Y_lm of a unit normal, in the order of the codes."""
    even = x * x - y * y
    return (
        0.28209479177387814,
        0.32573500793527993 * z,
        0.32573500793527993 * x,
        0.15769578262626002 * (3 * z * z - 1) / 2,
        0.2731371076480198 * x * z,
        0.1365685538240099 * even,
        -0.03526184897173477 * (35 * z**4 - 30 * z * z + 3) / 8,
        -0.0557538786297741 * x * z * (7 * z * z - 3) / 2,
        -0.039423945656565 * even * (7 * z * z - 1) / 2,
        -0.14751089748166088 * x * z * (x * x - 3 * y * y) / 2,
        -0.026076488977049006 * (even * even - 4 * x * x * y * y),
    )


def ambient(air: Database, where: Mapping[str, float], face: Mapping[str, float], ground: tuple[float, float]) -> float:
    """L_ambient of a face: slope, and azimuth from that of the source, in degree; temperature of the ground and the
    radiance that it emits.
    """
    level = air.value("ambient_radiance", where)
    slope, turn = math.radians(face["slope"]), math.radians(face["azimuth"])
    normal = math.sin(slope) * math.cos(turn), math.sin(slope) * math.sin(turn), math.cos(slope)
    facing, upright, square = irradiance_harmonics(*normal), irradiance_harmonics(0.0, 0.0, 1.0), normal[2] ** 2
    codes = air.arrays[LIGHT][0][-1].nodes
    total = [air.value(LIGHT, {**where, "harmonic": code}) for code in codes]
    for code in air.arrays[GLOW][0][-1].nodes:
        place = {**where, "ground_temperature": ground[0], "zonal_harmonic": code}
        total[CODES["harmonic"].index(int(code))] += ground[1] * air.value(GLOW, place)
    missing = level - sum(part * up for part, up in zip(total, upright, strict=False))
    if codes.size == 6:
        share = (35 * square**2 - 30 * square + 3) / 8
    else:
        share = (231 * square**3 - 315 * square**2 + 105 * square - 5) / 16
    return max(sum(part * at for part, at in zip(total, facing, strict=False)) + missing * share, 0.0)


def ambient_of_pixel(
    surface: Database, band: Database, air: Database, centre: Mapping[str, float], given: dict[str, Any]
) -> float:
    """L_ambient of a pixel's face; of a level one where the file or the pixel says no more."""
    if not air.ground or "source_heading" not in given:
        return air.value("ambient_radiance", centre)
    emissivity, temperature, radiance = (air.ground[name] for name in GROUND)
    if "ground_material" in given:
        place = {"material": band.material(given["ground_material"]), "azimuth": 0.0, "slope": 0.0}
        temperature = surface.value(
            "temperature", {**place, "altitude": given["surface_altitude"], "time": given["time"]}
        )
        radiance = emissivity * band.value("blackbody_radiance", {"temperature": temperature})
    face = {"slope": given["surface_slope"], "azimuth": given["surface_azimuth"] - given["source_heading"]}
    return ambient(air, centre, face, (temperature, radiance))


def pixel(
    scene: dict[str, Any], surface: Database, band: Database, air: Database, given: dict[str, Any]
) -> dict[str, float]:
    """Equations (1) to (44) for one pixel."""
    code = band.material(given["material"])
    face = {name: given[f"surface_{name}"] for name in FACE[1:-1]} | {"material": code, "time": given["time"]}
    temperature = temperature_of(surface, face, given)
    blackbody = band.value("blackbody_radiance", {"temperature": temperature})  # (7)
    rho, fraction, shininess, normalisation = (
        band.value(name, {"material": code})
        for name in ("reflectance", "specular_fraction", "shininess", "normalisation")
    )
    centre = {name: given[f"centre_{name}"] for name in ("range", "elevation")} | {
        name: given[name] for name in ("altitude", "source_elevation", "source_azimuth")
    }
    centre["scattering_angle"] = scattering_angle(
        *(centre[name] for name in ("elevation", "source_elevation", "source_azimuth"))
    )
    beta = air.value("beta_star", centre)
    depth = 5.5 * given["range"] / beta
    tau = math.exp(-depth)  # (9)
    path = air.value("path_radiance_ratio", centre) * -math.expm1(-depth)  # (11)
    skyshine = ambient_of_pixel(surface, band, air, centre, given) * rho * tau  # (19)
    normal, to_source, to_observer = (unit(given[name]) for name in ("normal", "to_source", "to_observer"))
    incidence = max(float(normal @ to_source), 0.0)
    direct = air.value("direct_radiance", centre) * rho * tau if incidence > 0 else 0.0
    thermal = blackbody * (1.0 - rho) * tau  # (6)
    diffuse = direct * incidence * (1.0 - fraction)  # (34)
    specular = direct * lobe(normal, to_source, to_observer, shininess) * fraction * normalisation  # (35)
    radiance = diffuse + specular + skyshine + thermal + path  # (1)
    return {
        "temperature": temperature,
        "blackbody_radiance": blackbody,
        "beta_star": beta,
        "transmittance": tau,
        "thermal": thermal,
        "path": path,
        "skyshine": skyshine,
        "diffuse": diffuse,
        "specular": specular,
        "radiance": radiance,
        "pixel_value": pixel_value(radiance, scene),
    }


def pixel_value(radiance: float, scene: dict[str, Any]) -> int:
    """Equation (44), rounded to the nearest integer: the nearest to x - 1/2, halves upwards, is the floor of x."""
    size = int(2 ** scene["bits"])
    share = min(max(radiance / scene["gain"], 0.0), 1.0)
    value: int = math.floor(size * scene["buffer_gain"] * (share - scene["offset"]))
    return min(max(value, 0), size - 1)


def compute(path: Path) -> str:
    """The result of a scene, as JSON."""
    folder, scene = path.parent, json.loads(path.read_text(encoding="utf-8"))
    clamped = scene.get("clamp", [])
    surface = Database(folder / scene["surface"], ["htt"], clamped)
    band = Database(folder / scene["band"], ["band"], clamped)
    air = Database(folder / scene["atmosphere"], ["atmq", "lunar_atmq"], clamped)
    return json.dumps({"pixels": [pixel(scene, surface, band, air, given) for given in scene["pixels"]]})


def main(path: str) -> None:
    try:
        print(compute(Path(path)))
    except KeyError as error:
        sys.exit(f"the scene lacks {error}")
    except (SceneError, OSError, ValueError, TypeError) as error:
        # Texts of a file may hold what ends a line.
        sys.exit("".join(character if character.isprintable() else "?" for character in str(error)))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: python runtime.py SCENE.json")
    main(sys.argv[1])
