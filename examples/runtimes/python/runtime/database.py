"""A database, read and checked whole before the first pixel, with h5py and numpy alone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

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
Layouts = dict[str, tuple[Sequence[str], float, float]]
# What a file must hold: axes, least and largest value of each array.
ARRAYS: dict[str, Layouts] = {
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
SHADE: Layouts = {
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
# Of an .htt that holds the first of them: where Sun and Moon stand.
TRACKS: Layouts = {
    "sun_elevation": (("track_time",), -90.0, 90.0),
    "sun_azimuth": (("track_time",), -1080.0, 1080.0),
    "sun_distance": (("track_time",), 0.9, 1.1),
    "moon_elevation": (("track_time",), -90.0, 90.0),
    "moon_azimuth": (("track_time",), -1080.0, 1080.0),
    "moon_distance": (("track_time",), 3e5, 4.5e5),
    "moon_phase_angle": (("track_time",), 0.0, 180.0),
    "moon_illuminated_fraction": (("track_time",), 0.0, 1.0),
}
# Of an .atmq file that has them: coefficients of the light around faces of any direction.
LIGHT, GLOW = "ambient_radiance_harmonics", "ground_radiance_harmonics"
HARMONICS: Layouts = {
    LIGHT: ((*PATH[:4], "harmonic"), -math.inf, math.inf),
    GLOW: ((*PATH[:3], "ground_temperature", "zonal_harmonic"), -math.inf, math.inf),
}
# Of an .atmq that holds the first of them: its quantities without the source.
NIGHT: Layouts = {
    "thermal_path_radiance_ratio": (PATH[:3], 0.0, math.inf),
    "thermal_ambient_radiance": (PATH[:3], 0.0, math.inf),
}
NIGHT_HARMONICS: Layouts = {"thermal_radiance_harmonics": ((*PATH[:3], "harmonic"), -math.inf, math.inf)}
WITHOUT_SOURCE = {
    "path_radiance_ratio": "thermal_path_radiance_ratio",
    "ambient_radiance": "thermal_ambient_radiance",
    "direct_radiance": "",
    LIGHT: "thermal_radiance_harmonics",
}
CIVIL_TWILIGHT = -6.0  # degree: a table whose lowest source elevation is above says nothing of twilight
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
    dark_below: float  # of source elevations: no light of the source is left there; NaN where the file does not say

    def fault(self) -> str:
        """What in the rule or the nodes is not as the format has it; empty where nothing is."""
        rules, period = RULES.get(self.name, (("linear",), 0.0))
        first, last = self.nodes[0], self.nodes[-1]
        if self.rule not in rules:
            return f"interpolation '{self.rule:.40}'; allowed: {' or '.join(rules)}"
        if self.period != period:
            return f"period {self.period:g}; allowed: {period:g}"
        if self.name == "source_elevation" and not (math.isnan(self.dark_below) or -90 <= self.dark_below <= 0):
            return f"dark_below {self.dark_below:g}; allowed: -90 to 0"
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
        self.filetype = ""
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
        self.filetype = filetype
        for name, (axes, least, most) in self._layouts(file, filetype).items():
            self.arrays[name] = self._array(file, name, axes, least, most)
        if LIGHT in self.arrays:
            self._check_light(file)
        if NIGHT.keys() <= self.arrays.keys():
            self._check_night()
        if filetype == "band":
            self.codes = self._names(file, self.arrays["reflectance"][0][0])

    def _layouts(self, file: h5py.File, filetype: str) -> Layouts:
        """What the file must hold, by the first array of each part that may be absent."""
        if filetype == "band":
            return ARRAYS["band"]
        if filetype == "htt":
            parts = (SHADE, TRACKS)
            return ARRAYS["htt"] | {k: v for part in parts if next(iter(part)) in file for k, v in part.items()}
        layouts = ARRAYS["atmq"] | (HARMONICS if LIGHT in file else {})
        if next(iter(NIGHT)) in file:
            layouts = layouts | NIGHT | (NIGHT_HARMONICS if LIGHT in file else {})
        return layouts

    def _check_light(self, file: h5py.File) -> None:
        """The harmonics go together, and the file states the ground."""
        if (self.arrays[LIGHT][0][-1].nodes.size == 6) != (self.arrays[GLOW][0][-1].nodes.size == 3):
            raise SceneError(f"{self.path}: '{LIGHT}' and '{GLOW}' are of different harmonics")
        self.ground = {name: number(file, name) for name in GROUND}
        if not all(math.isfinite(value) and value >= 0 for value in self.ground.values()):
            raise SceneError(f"{self.path}: does not state the ground: {', '.join(GROUND)}")

    def _check_night(self) -> None:
        """The axes of source elevation say where it is dark."""
        for name in WITHOUT_SOURCE.keys() & self.arrays.keys():
            if math.isnan(self.arrays[name][0][3].dark_below):
                raise SceneError(f"{self.path}: the source elevations of '{name}' do not state dark_below")

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
            number(dataset, "dark_below"),
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
        """A quantity at a place; below the lowest elevation of the source, its light fades into what the air emits."""
        if quantity in WITHOUT_SOURCE and next(iter(NIGHT)) in self.arrays:
            axis, height = self.arrays[quantity][0][3], where["source_elevation"]
            lowest, dark = axis.nodes[0], axis.dark_below
            if math.isfinite(height) and height < lowest and (height <= dark or lowest <= CIVIL_TWILIGHT):
                share = (height - dark) / (lowest - dark) if height > dark else 0.0
                total = share * self._interpolated(quantity, {**where, "source_elevation": lowest})
                emitted = WITHOUT_SOURCE[quantity]
                return total + (1.0 - share) * self._interpolated(emitted, where) if emitted else total
        return self._interpolated(quantity, where)

    def _interpolated(self, quantity: str, where: Mapping[str, float]) -> float:
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
