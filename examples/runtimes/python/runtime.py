"""A runtime's reader of the databases with h5py and numpy alone: the radiance of the pixels of a scene.

Usage: python runtime.py SCENE.json

The scene and the result are described in ../README.md. Equation numbers are those of DSTO-TN-0193.
"""

import itertools
import json
import math
import sys
from pathlib import Path

import h5py
import numpy as np

VIEW = ("range", "altitude", "elevation")
SOURCE = (*VIEW, "source_elevation")
FORMATS = {"htt": "1", "band": "1", "atmq": "2"}
FACE = ("material", "altitude", "azimuth", "slope", "time")


class SceneError(Exception):
    """The scene or a file does not fit; the text says what is allowed."""


class Axis:
    """One axis: its nodes and the rule by which a runtime reads between and outside them."""

    def __init__(self, name, dataset, clamped):
        self.name, self.nodes = name, dataset[()].astype(float)
        self.interpolation = dataset.attrs.get("interpolation", "linear")
        self.period = float(dataset.attrs.get("period", 0.0))
        self.clamps = clamped or dataset.attrs.get("out_of_range", "error") == "clamp"

    def locate(self, value):
        """Index of the lower and the upper node, and the weight of the upper one."""
        if not math.isfinite(value):
            raise SceneError(f"{self.name}: found {value}; allowed: finite numbers")
        nodes, count = self.nodes, self.nodes.size
        if self.interpolation == "exact":
            at = np.flatnonzero(nodes == value)
            if at.size == 0:
                raise SceneError(f"{self.name}: found {value:g}; allowed: a code of the file")
            return at[0], at[0], 0.0
        if self.interpolation == "linear_periodic":
            nodes = np.append(nodes, nodes[0] + self.period)
            value = nodes[0] + (value - nodes[0]) % self.period
        elif self.interpolation == "linear" and self.period > 0:
            value -= self.period * math.floor((value - nodes[0]) / self.period)
        elif self.interpolation == "linear_folded":
            value = abs((value + self.period / 2) % self.period - self.period / 2)
        if not self.clamps and not nodes[0] <= value <= nodes[-1]:
            raise SceneError(f"{self.name}: found {value:g}; allowed: {nodes[0]:g} to {nodes[-1]:g}")
        value = min(max(value, nodes[0]), nodes[-1])
        lower = min(max(int(np.searchsorted(nodes, value, side="right")) - 1, 0), max(nodes.size - 2, 0))
        upper = min(lower + 1, nodes.size - 1)
        weight = (value - nodes[lower]) / (nodes[upper] - nodes[lower]) if upper > lower else 0.0
        return lower, upper % count, weight


class Database:
    """One file: arrays are read when they are first asked for."""

    def __init__(self, path, filetypes, clamped):
        try:
            self.file = h5py.File(path, "r")
        except OSError:
            raise SceneError(f"{path}: is not a readable HDF5 file") from None
        filetype, version = (str(self.file.attrs.get(name, "")) for name in ("filetype", "format_version"))
        major = FORMATS[filetypes[0]]
        if filetype not in filetypes or version.split(".")[0] != major:
            raise SceneError(f"{path}: holds '{filetype}' {version}; allowed: {' or '.join(filetypes)} {major}.x")
        self.clamped, self.axes, self.arrays = clamped, {}, {}

    def axis(self, quantity, name):
        """The quantity's own axis where the file has one, else the one that quantities share."""
        own = f"{quantity}_{name}" if f"{quantity}_{name}" in self.file else name
        if own not in self.axes:
            self.axes[own] = Axis(name, self.file[own], name in self.clamped)
        return self.axes[own]

    def value(self, quantity, axes, where):
        """Linear interpolation in every axis: the weighted sum over the corners of one cell."""
        if quantity not in self.arrays:
            self.arrays[quantity] = self.file[quantity][()]
        located = [self.axis(quantity, name).locate(where[name]) for name in axes]
        total = 0.0
        for corner in itertools.product((0, 1), repeat=len(axes)):
            share = math.prod(
                weight if up else 1.0 - weight for up, (_, _, weight) in zip(corner, located, strict=True)
            )
            if share:
                total += share * float(
                    self.arrays[quantity][tuple(place[up] for up, place in zip(corner, located, strict=True))]
                )
        return total

    def material(self, given):
        """Code of a material given by code or by name."""
        if not isinstance(given, str):
            return given
        names = self.file["material_name"].asstr()[()].tolist()
        if given not in names:
            raise SceneError(f"material: found '{given}'; allowed: {', '.join(names)}")
        return int(self.file["material"][names.index(given)])


def unit(vector):
    vector = np.asarray(vector, float)
    length = np.linalg.norm(vector)
    if vector.shape != (3,) or not math.isfinite(length) or length == 0:
        raise SceneError("a direction must be three finite numbers that are not all 0")
    return vector / length


def scattering_angle(elevation, source_elevation, azimuth):
    """Angle between line of sight and source, all in degree."""
    line, source = math.radians(elevation), math.radians(source_elevation)
    half = (
        math.sin((line - source) / 2) ** 2
        + math.cos(line) * math.cos(source) * math.sin(math.radians(azimuth) / 2) ** 2
    )
    return 2 * math.degrees(math.asin(math.sqrt(min(max(half, 0.0), 1.0))))


def lobe(normal, to_source, to_observer, shininess):
    """Equations (37) and (38): chi of the half vector to the power of the shininess."""
    between = to_source + to_observer
    length = np.linalg.norm(between)
    chi = max(float(between @ normal) / length, 0.0) if length > 0 else 0.0
    return min(chi, 1.0) ** shininess


def pixel(scene, surface, band, air, given):
    """Equations (1) to (44) for one pixel."""
    code = band.material(given["material"])
    face = {name: given[f"surface_{name}"] for name in FACE[1:-1]} | {"material": code, "time": given["time"]}
    temperature = surface.value("temperature", FACE, face)
    blackbody = band.value("blackbody_radiance", ("temperature",), {"temperature": temperature})  # (7)
    rho, fraction, shininess, normalisation = (
        band.value(name, ("material",), {"material": code})
        for name in ("reflectance", "specular_fraction", "shininess", "normalisation")
    )
    centre = {name: given[f"centre_{name}"] for name in ("range", "elevation")} | {
        name: given[name] for name in ("altitude", "source_elevation", "source_azimuth")
    }
    beta = air.value("beta_star", VIEW, centre)
    tau = math.exp(-5.5 * given["range"] / beta)  # (9)
    source = "source_azimuth"
    if "scattering_angle" in air.file:
        source = "scattering_angle"
        centre[source] = scattering_angle(
            *(centre[name] for name in ("elevation", "source_elevation", "source_azimuth"))
        )
    path = air.value("path_radiance_ratio", (*SOURCE, source), centre) * -math.expm1(
        -5.5 * given["range"] / beta
    )  # (11)
    skyshine = air.value("ambient_radiance", SOURCE, centre) * rho * tau  # (19)
    normal, to_source, to_observer = (unit(given[name]) for name in ("normal", "to_source", "to_observer"))
    incidence = max(float(normal @ to_source), 0.0)
    direct = air.value("direct_radiance", SOURCE, centre) * rho * tau if incidence > 0 else 0.0
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


def pixel_value(radiance, scene):
    """Equation (44)."""
    size = 2 ** scene["bits"]
    share = min(max(radiance / scene["gain"], 0.0), 1.0)
    return min(max(int(size * scene["buffer_gain"] * (share - scene["offset"]) - 0.5), 0), size - 1)


def main(path):
    folder = Path(path).parent
    scene = json.loads(Path(path).read_text(encoding="utf-8"))
    clamped = scene.get("clamp", [])
    surface = Database(folder / scene["surface"], ["htt"], clamped)
    band = Database(folder / scene["band"], ["band"], clamped)
    air = Database(folder / scene["atmosphere"], ["atmq", "lunar_atmq"], clamped)
    print(json.dumps({"pixels": [pixel(scene, surface, band, air, given) for given in scene["pixels"]]}))


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except KeyError as error:
        sys.exit(f"the scene or a file lacks {error}")
    except (SceneError, OSError, ValueError, IndexError) as error:
        sys.exit(str(error))
