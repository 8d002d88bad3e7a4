"""An atmosphere in channels (format 3): its quantities, computed from tables that have no axis of range.

Light on surfaces is one number for the whole band, or one for each of its wavelengths.
The formulas are those of ../../../../schemas/formats/atmq-3.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .axis import Axis, SceneError
from .layouts import CHANNEL_BENDING, CHANNEL_SHARES, CIVIL_TWILIGHT, GLOW, LIGHT

Floats = NDArray[np.float64]
Place = Mapping[str, float]
STORED = {LIGHT: "scattered_harmonics", GLOW: "ground_harmonics"}  # have the codes of the harmonics
SHORTEST_KM, FARTHEST_BETA_KM = 1e-12, 1e12
EARTH_RADIUS_KM = 6371.0088
THERMAL, SOURCE = CHANNEL_SHARES  # parts what the air and the ground emit, and the light of the source


class Reader(Protocol):
    """One value of an array for each of its parts, interpolated in the other axes."""

    def __call__(self, quantity: str, where: Place, parts: int = 1) -> Floats: ...


@dataclass(frozen=True)
class Path:
    """A path: its place in the tables, the height of its end, and the optical depth and extinction of the channels."""

    place: dict[str, float]
    end_height: float
    depth: Floats
    extinction: Floats


def limited(value: float) -> float:
    """In 0 to 1."""
    return min(max(value, 0.0), 1.0)


def height_at(reach: float, earth: float, height: float, angle: float) -> float:
    """Height of the end of a straight line over an Earth of a radius, km."""
    radius = earth + height
    step = reach * reach + 2 * radius * math.sin(angle) * reach
    return (step + height * (2 * earth + height)) / (earth + math.sqrt(max(radius * radius + step, 0.0)))


class Channels:
    """The arrays of a file in channels, and what it states."""

    def __init__(
        self,
        arrays: Mapping[str, tuple[list[Axis], NDArray[np.float32]]],
        read: Reader,
        stated: Mapping[str, tuple[float, ...]],
        clamped: Sequence[str],
    ) -> None:
        self.read, self.clamped = read, clamped
        self.temperatures = arrays["ground_emission"][0][0] if "ground_emission" in arrays else None
        self.source_elevation = arrays["source_factor"][0][1]
        self.bends = CHANNEL_BENDING.keys() <= arrays.keys()
        spectra = ("channel_weight", "thermal_reference", "source_reference", "ground_emission", *CHANNEL_SHARES)
        names = [name for name in arrays if name.endswith("_factor") or name in spectra]
        self.spectra = {name: arrays[name][1].astype(float) for name in names}
        self.undivided = np.ones((self.spectra["channel_weight"].size, 1))
        self.ground_km, self.scale_km = stated["ground_altitude_km"][0], stated["scale_height_km"][0]
        self.ends = {"range": stated["range_km"], "altitude": stated["altitude_km"], "elevation": (-90.0, 90.0)}

    def stored(self, harmonics: str) -> str:
        """The array that has the codes of `LIGHT` or `GLOW`."""
        return STORED[harmonics]

    def value(self, quantity: str, where: Place) -> float:
        """A quantity of format 2 at a place."""
        path = self._path(where)
        if quantity == "beta_star":
            return self._beta_star(path, where["range"])
        if quantity == "path_radiance_ratio":
            return self._path_radiance_ratio(path, where)
        return float(self._on_surface(quantity, path, where, parted=False)[0])

    def light(self, quantity: str, where: Place) -> Floats:
        """A quantity of light on surfaces at each wavelength."""
        return self._on_surface(quantity, self._path(where), where, parted=True)

    def transmittance(self, where: Place, reach: float) -> Floats:
        """Transmittance of emitted light at each wavelength over another range than that of the place, as (8) and (9)
        have it from beta*.
        """
        path, weight = self._path(where), self.spectra["channel_weight"]
        shares = self.spectra["thermal_reference"][:, None] * self.spectra[THERMAL]
        emitted = shares.sum(axis=0)
        shares = np.where(emitted > 0, shares / np.where(emitted > 0, emitted, 1.0), weight[:, None])
        absorbed, through = -np.expm1(-path.depth) @ shares, np.exp(-path.depth) @ shares
        thin = absorbed < 0.5
        least = np.finfo(float).tiny
        logarithm = np.where(thin, np.log1p(-np.minimum(absorbed, 0.5)), np.log(np.maximum(through, least)))
        parts: Floats = np.exp(logarithm * (reach / max(self._within("range", where["range"]), SHORTEST_KM)))
        return parts

    def _on_surface(self, quantity: str, path: Path, where: Place, *, parted: bool) -> Floats:
        thermal, source = (self.spectra[name] if parted else self.undivided for name in (THERMAL, SOURCE))
        if quantity == "direct_radiance":
            return self._direct(path, where["source_elevation"], source)
        if quantity == "ambient_radiance":
            return np.maximum(self._sky("sky", path, where, {}, (thermal, source)), 0.0)
        if quantity == LIGHT:
            return self._sky("harmonics", path, where, {"harmonic": where["harmonic"]}, (thermal, source))
        place = {"zonal_harmonic": where["zonal_harmonic"]}
        return self._light("ground_harmonics", path, place, thermal, self._emission(where["ground_temperature"]))

    def _within(self, name: str, value: float) -> float:
        first, last = self.ends[name]
        if not math.isfinite(value) or (name not in self.clamped and not first <= value <= last):
            raise SceneError(f"{name}: found {value:g}; allowed: {first:g} to {last:g}")
        return min(max(value, first), last)

    def _path(self, where: Place) -> Path:
        """Place and optical depths of a path; lengths in km."""
        reach, altitude, elevation = (self._within(name, where[name]) for name in self.ends)
        height = max(altitude - self.ground_km, 0.0)
        root, angle = float(np.cbrt(height)), math.radians(elevation)
        rho = float(self.read("effective_radius", {"height_root": root}, 0))
        radius, fall = rho + height, height * (2 * rho + height)
        rise = radius * math.sin(angle)
        if angle < 0 and rise * rise >= fall:
            distance = fall / (math.sqrt(rise * rise - fall) - rise)
            across = 2 * rho * height
            direction = limited((distance**2 - height**2) / across) if across > 0 else 0.0
            share = min(reach / distance, 1.0) if distance > 0 else 1.0
            length, walked, ended = reach, min(reach, distance), reach >= distance
        else:
            above = self.scale_km * (2 * radius + self.scale_km)
            level, way = math.sqrt(above), above / (rise + math.sqrt(rise * rise + above))
            share = -math.expm1(-reach / way)
            direction = 3 + limited((level - way) / (level - self.scale_km))
            if angle < 0:
                direction = 3 - math.sqrt(limited(2 * radius * math.sin(angle / 2) ** 2 / height))
            length, walked, ended = way * share, reach, False
        place = {"share": share, "height_root": root, "direction": direction}
        if self.bends:
            end = height_at(walked, EARTH_RADIUS_KM + self.ground_km, height, angle)
            end += walked * float(self.read("end_rise", place, 0))
        else:
            end = height_at(walked, rho, height, angle)
        mean = np.exp(self.read("log_mean_extinction", place))
        extinction = np.maximum(self.spectra["absorber_factor"] @ mean, 0.0)
        depth = extinction * max(length, SHORTEST_KM)
        return Path(place, 0.0 if ended else max(end, 0.0), depth, extinction)

    def _beta_star(self, path: Path, reach: float) -> float:
        weight = self.spectra["channel_weight"]
        if self._within("range", reach) == 0:
            local = float(path.extinction @ weight)
            return min(5.5 / local, FARTHEST_BETA_KM) if local > 0 else FARTHEST_BETA_KM
        absorptance, least = float(-np.expm1(-path.depth) @ weight), float(path.depth.min())
        if absorptance < 0.5:
            logarithm = math.log1p(-absorptance)
        else:
            logarithm = math.log(float(np.exp(least - path.depth) @ weight)) - least
        return min(5.5 * self._within("range", reach) / -logarithm, FARTHEST_BETA_KM) if logarithm else FARTHEST_BETA_KM

    def _path_radiance_ratio(self, path: Path, where: Place) -> float:
        absorbed, height = -np.expm1(-path.depth), where["source_elevation"]
        thermal = float(self.read("thermal_ratio", path.place, 0) * (absorbed @ self.spectra["thermal_reference"]))
        source = {"source_elevation": self._lit(height), "scattering_angle": where["scattering_angle"]}
        ratio = float(self.read("source_factor", source) @ self.read("scattered_ratio", path.place))
        scattered = self._night(height) * max(ratio, 0.0) * float(absorbed @ self.spectra["source_reference"])
        absorptance = float(absorbed @ self.spectra["channel_weight"])
        return (thermal + scattered) / absorptance if absorptance > 0 else 0.0

    def _direct(self, path: Path, height: float, shares: Floats) -> Floats:
        self._lit(height)
        above = height - float(self.read("source_rise", {"target_height": path.end_height}, 0))
        if above < 0:
            return np.zeros(shares.shape[1])
        place = {"target_height": path.end_height, "elevation_above_rise": above}
        return np.maximum(self._light("direct_light", path, place, shares), 0.0)

    def _sky(self, kind: str, path: Path, where: Place, harmonic: Place, shares: tuple[Floats, Floats]) -> Floats:
        """What the air emits, and what it scatters."""
        height = where["source_elevation"]
        lit = {"sky_source_elevation": self._lit(height), **harmonic}
        emitted = self._light(f"thermal_{kind}", path, harmonic, shares[0])
        return emitted + self._night(height) * self._light(f"scattered_{kind}", path, lit, shares[1])

    def _light(self, name: str, path: Path, where: Place, shares: Floats, spectrum: Floats | None = None) -> Floats:
        """Light on the surface at the end of a path as the path weighs it, over its transmittance, parted by shares of
        each channel.
        """
        value = self.read(name, {"surface_height": path.end_height, **where})
        through = np.exp(path.depth.min() - path.depth)
        lit = through if spectrum is None else through * spectrum
        light = lit * (self.spectra[f"{name}_factor"] @ value)
        parts: Floats = (light @ shares) / (through @ self.spectra["channel_weight"])
        return parts

    def _emission(self, kelvin: float) -> Floats:
        """What the ground emits in the channels."""
        if self.temperatures is None:
            raise SceneError("the atmosphere file holds no harmonics")
        lower, upper, weight = self.temperatures.locate(kelvin)
        rows = self.spectra["ground_emission"]
        emission: Floats = (1 - weight) * rows[lower] + weight * rows[upper]
        return emission

    def _lit(self, height: float) -> float:
        """The elevation of the source, or the first node where it is below."""
        lit = max(height, float(self.source_elevation.nodes[0])) if math.isfinite(height) else height
        self.source_elevation.locate(lit)  # refuses what the file is not for
        return lit

    def _night(self, height: float) -> float:
        """Share of the light of the first node that the source gives below it; 1 above."""
        lowest, dark = float(self.source_elevation.nodes[0]), self.source_elevation.dark_below
        if not height < lowest:
            return 1.0
        if height <= dark:
            return 0.0
        if lowest > CIVIL_TWILIGHT:
            self.source_elevation.locate(height)  # refuses it, or clamps
            return 1.0
        return (height - dark) / (lowest - dark)
