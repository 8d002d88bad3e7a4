"""Quantities of lines of sight from the channels of an atmosphere, in numpy: by which the tests judge `quantity.c`.

With D_j the optical depth of channel j along a path, from the absorbers' mean extinction and the path's length,

    tau = sum_j w_j exp(-D_j)
    L_path = thermal_ratio sum_j e_j (1 - exp(-D_j)) + (sum_k f_k scattered_ratio_k) sum_j s_j (1 - exp(-D_j))
    L_surface = sum_j exp(-D_j) sum_q g_jq X_q / tau

for light X on surfaces, which (20) and (36) weigh by the path's transmittance. By wavelength, the light of channel j is
parted with its shares S_jb; transmittance by wavelength is that of emitted light, sum_j e_j S_jb exp(-D_j) over the sum
without air.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.channels.coordinates import Entry, RayCoordinates, RayPlaces
from skyshine.mat.quantities.formulas import beta_star, mean_transmittance
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.radiometry.spherical_harmonics import ambient_of_faces, face_normal
from skyshine.mat.tables.ambient import stated_ground
from skyshine.mat.tables.atmosphere_table import _PATH, DEPTH, AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, GROUND_HARMONICS, VALID
from skyshine.mat.tables.axes import CLAMP, AxisRule
from skyshine.mat.tables.channel_fields import (
    ABOVE_RISE,
    END_RISE,
    GROUND_EMISSION,
    NODES,
    SKY_ELEVATION,
    SOURCE_ELEVATION,
    SOURCE_SHARE,
    SURFACE,
    TARGET,
    THERMAL_SHARE,
)
from skyshine.mat.tables.gridded import ANGLE, AXES
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.night import CIVIL_TWILIGHT, Night
from skyshine.mat.tables.out_of_range import AS_STATED, OutOfRange
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError, nearest
from skyshine.schemas.hdf5 import Group

# Coordinates of the channels: what lies outside them was refused by range, altitude or elevation before.
_INNER = {*NODES, SURFACE, TARGET, ABOVE_RISE}
SHORTEST_KM = 1e-12  # of air used in place of a range of 0, where the path radiance ratio has its limit


@dataclass(frozen=True, eq=False)
class ChannelPaths:
    """Paths of any shape.

    Attributes
    ----------
    coordinates : RayPlaces
    depth : (..., P) array
        Optical depth in the channels.
    extinction : (..., P) array
        Mean extinction of a path of no length, km^-1, otherwise of the path.
    """

    coordinates: RayPlaces
    depth: Floats
    extinction: Floats


@dataclass(frozen=True, eq=False)
class ChannelReader:
    """The arrays of one database in channels.

    Attributes
    ----------
    root : Group
    ground_km, scale_height_km : float
        Root attributes of the file.
    out_of_range : OutOfRange
        Policies of the axes on which a user specifies values.
    """

    root: Group
    ground_km: float
    scale_height_km: float
    out_of_range: OutOfRange

    @classmethod
    def of(cls, root: Group, attributes: Mapping[str, Any], out_of_range: OutOfRange = AS_STATED) -> ChannelReader:
        """Of a file's root and its attributes."""
        ground, scale = float(attributes["ground_altitude_km"]), float(attributes["scale_height_km"])
        return cls(root, ground, scale, out_of_range)

    @cached_property
    def rays(self) -> RayCoordinates:
        nodes = np.asarray(self.root.axes["height_root"].values, float)
        return RayCoordinates(self.ground_km, nodes, self._array("effective_radius"), self.scale_height_km)

    def paths(self, range_km: npt.ArrayLike, altitude_km: npt.ArrayLike, elevation_deg: npt.ArrayLike) -> ChannelPaths:
        """Optical depths of paths; arguments are broadcast against each other."""
        coordinates = self.rays.locate(range_km, altitude_km, elevation_deg)
        if END_RISE in self.root.variables:
            reach = np.minimum(np.asarray(range_km, float), coordinates.ground_distance)
            straight = self.rays.straight_height(reach, coordinates.height_root, elevation_deg)
            end = straight + reach * self._fields(END_RISE, coordinates)
            at_ground = coordinates.to_ground & (coordinates.share >= 1)
            coordinates = replace(coordinates, end_height=np.where(at_ground, 0.0, np.maximum(end, 0.0)))
        mean = np.exp(self._fields("log_mean_extinction", coordinates))
        factor = self._array("absorber_factor")
        extinction = np.maximum(np.moveaxis(mean, 0, -1) @ factor.T, 0.0)
        return ChannelPaths(
            coordinates, extinction * np.maximum(coordinates.length, SHORTEST_KM)[..., None], extinction
        )

    def transmittance(self, paths: ChannelPaths) -> Floats:
        """In-band transmittance (...)."""
        return np.asarray(np.exp(self._mean(paths)[0]))

    def beta_star(self, paths: ChannelPaths, range_km: npt.ArrayLike) -> Floats:
        """beta* [km], equation (8)."""
        weight = self._array("channel_weight")
        local = paths.extinction @ weight / 1e3
        return beta_star(np.asarray(range_km, float) * 1e3 + np.zeros(local.shape), self._mean(paths)[0], local)

    def path_radiance_ratio(self, paths: ChannelPaths, source_elevation: npt.ArrayLike, angle: npt.ArrayLike) -> Floats:
        """Path radiance over absorptance, for a scattering angle [degree]."""
        absorbed = -np.expm1(-paths.depth)
        thermal = self._fields("thermal_ratio", paths.coordinates)
        radiance = thermal * (absorbed @ self._array("thermal_reference"))
        height = np.asarray(source_elevation, float)
        night = self._night()
        factor = self._read(
            "source_factor",
            source_part=self._numbers("source_part", np.broadcast_shapes(height.shape, np.shape(angle))),
            source_elevation=night.within(height),
            scattering_angle=angle,
        )
        parts = self._fields("scattered_ratio", paths.coordinates)
        scattered = np.maximum(np.sum(factor * parts, axis=0), 0.0) * night.share(height)
        radiance = radiance + scattered * (absorbed @ self._array("source_reference"))
        absorptance = self._mean(paths)[1]
        return np.asarray(radiance / np.where(absorptance > 0, absorptance, np.inf))

    def depth_by_wavelength(self, paths: ChannelPaths) -> Floats:
        """-ln of the transmittance of emitted light at the wavelengths of the band, (..., B); above 0 at a range of 0,
        as of `SHORTEST_KM` of air.
        """
        shares = self._array("thermal_reference")[:, None] * self._array(THERMAL_SHARE)
        emitted = shares.sum(axis=0)
        share = shares / np.where(emitted > 0, emitted, 1.0)
        through, absorbed = np.exp(-paths.depth) @ share, -np.expm1(-paths.depth) @ share
        opaque = np.log(np.maximum(through, np.finfo(float).tiny))
        depth = -np.where(absorbed < 0.5, np.log1p(-np.minimum(absorbed, 0.5)), opaque)
        return np.asarray(np.where(emitted > 0, depth, -self._mean(paths)[0][..., None]))

    def direct_radiance(
        self, paths: ChannelPaths, source_elevation: npt.ArrayLike, *, by_wavelength: bool = False
    ) -> Floats:
        """Direct irradiance over pi, (36); its part at each wavelength, (..., B), on request."""
        height = self._surface_height(paths)
        above = np.asarray(source_elevation, float) - self._read("source_rise", target_height=height)
        surface = {"target_height": height, "elevation_above_rise": above}
        light = self._light("direct_light", paths, shares=self._shares(SOURCE_SHARE, by_wavelength), **surface)
        up = above[..., None] >= 0 if by_wavelength else above >= 0
        return np.where(up, np.maximum(light, 0.0), 0.0)

    def ambient_radiance(
        self, paths: ChannelPaths, source_elevation: npt.ArrayLike, *, by_wavelength: bool = False
    ) -> Floats:
        """Sky irradiance over pi, (20); its part at each wavelength, (..., B), on request."""
        names = "thermal_sky", "scattered_sky"
        return np.maximum(self._sky(*names, paths, source_elevation, {}, by_wavelength), 0.0)

    def harmonics(
        self,
        paths: ChannelPaths,
        source_elevation: npt.ArrayLike,
        harmonic: npt.ArrayLike,
        *,
        by_wavelength: bool = False,
    ) -> Floats:
        """Coefficients of the light around the ends of paths; their parts at each wavelength, (..., B), on request."""
        return self._sky(
            "thermal_harmonics",
            "scattered_harmonics",
            paths,
            source_elevation,
            {"harmonic": np.asarray(harmonic)},
            by_wavelength,
        )

    def ground_harmonics(
        self, paths: ChannelPaths, kelvin: npt.ArrayLike, harmonic: npt.ArrayLike, *, by_wavelength: bool = False
    ) -> Floats:
        """Coefficients of the ground's emission, per unit of what it emits; by wavelength, (..., B), on request."""
        height = self._surface_height(paths)
        channels = np.asarray(self.root.axes["channel"].values)
        emission = self._read(
            GROUND_EMISSION, ground_temperature=np.asarray(kelvin, float)[..., None], channel=channels
        )
        surface = {"surface_height": height, "zonal_harmonic": np.asarray(harmonic)}
        shares = self._shares(THERMAL_SHARE, by_wavelength)
        return self._light("ground_harmonics", paths, emission, shares=shares, **surface)

    def _sky(
        self,
        thermal: str,
        scattered: str,
        paths: ChannelPaths,
        source_elevation: npt.ArrayLike,
        axes: dict[str, Any],
        by_wavelength: bool,
    ) -> Floats:
        height, night = self._surface_height(paths), self._night()
        elevation = np.asarray(source_elevation, float)
        emitted = self._light(
            thermal, paths, shares=self._shares(THERMAL_SHARE, by_wavelength), surface_height=height, **axes
        )
        at = {"surface_height": height, SKY_ELEVATION: night.within(elevation)} | axes
        sunlit = self._light(scattered, paths, shares=self._shares(SOURCE_SHARE, by_wavelength), **at)
        share = night.share(elevation)
        return emitted + sunlit * (share[..., None] if by_wavelength else share)

    def _light(
        self,
        name: str,
        paths: ChannelPaths,
        spectrum: Floats | None = None,
        *,
        shares: Floats | None = None,
        **coordinates: npt.ArrayLike,
    ) -> Floats:
        """Light at the ends of paths as they weigh it, over their transmittance; `spectrum` (..., P) multiplies it, and
        `shares` (P, B) part it along a last axis.
        """
        shape = np.broadcast_shapes(paths.depth.shape[:-1], *(np.shape(values) for values in coordinates.values()))
        part = self._numbers(f"{name}_part", shape)
        value = self._read(name, **{f"{name}_part": part}, **coordinates)
        relative = np.exp(paths.depth.min(axis=-1, keepdims=True) - paths.depth)
        through = relative if spectrum is None else relative * spectrum
        factor = self._array(f"{name}_factor")
        mean = relative @ self._array("channel_weight")
        if shares is None:
            return np.asarray(np.sum(np.moveaxis(through @ factor, -1, 0) * value, axis=0) / mean)
        light = np.zeros((*shape, shares.shape[1]))
        for column, of_part in zip(factor.T, value, strict=True):  # all parts at once would take their number of times
            light += of_part[..., None] * (through @ (column[:, None] * shares))
        return np.asarray(light / mean[..., None])

    def _shares(self, name: str, by_wavelength: bool) -> Floats | None:
        return self._array(name) if by_wavelength else None

    def _surface_height(self, paths: ChannelPaths) -> Floats:
        return paths.coordinates.end_height

    def _mean(self, paths: ChannelPaths) -> tuple[Floats, Floats]:
        """Logarithm of transmittance and absorptance, (...)."""
        depth = paths.depth.reshape(-1, paths.depth.shape[-1])
        logarithm, absorptance = mean_transmittance(depth, self._array("channel_weight"))
        shape = paths.depth.shape[:-1]
        return logarithm.reshape(shape), absorptance.reshape(shape)

    def _night(self) -> NightShare:
        return NightShare(self._rule(SOURCE_ELEVATION))

    def _fields(self, name: str, ray: RayPlaces) -> Floats:
        """A field at places, one for each part in front where it has parts."""
        coordinates = {"share": ray.share, "height_root": ray.height_root, "direction": ray.direction}
        part_axis = self.root.variables[name].dims[0]
        if part_axis not in NODES:
            coordinates[part_axis] = self._numbers(part_axis, np.shape(ray.share))
        return self._read(name, **coordinates)

    def _numbers(self, axis: str, shape: tuple[int, ...]) -> npt.NDArray[Any]:
        """Numbers of the parts of an axis, in front of a shape."""
        numbers = np.asarray(self.root.axes[axis].values)
        return numbers.reshape(-1, *[1] * len(shape))

    def _read(self, name: str, **coordinates: npt.ArrayLike) -> Floats:
        variable = self.root.variables[name]
        arrays = {axis: np.asarray(values) for axis, values in coordinates.items()}
        return interpolate(np.asarray(variable.data), [self._rule(dim) for dim in variable.dims], arrays)

    def _rule(self, axis: str) -> AxisRule:
        rule = AxisRule.of(axis, self.root.axes[axis])
        if axis in _INNER:
            return replace(rule, out_of_range=CLAMP)
        return self.out_of_range.applied(rule, SOURCE_ELEVATION if axis == SKY_ELEVATION else None)

    def _array(self, name: str) -> Floats:
        return np.asarray(self.root.variables[name].data, float)


class NumpyAir(AtmosphereTable):
    """An open atmosphere that reads its quantities in numpy."""

    @classmethod
    def of(cls, air: AtmosphereTable) -> NumpyAir:
        return cls(air.path, air.filetype, air.root, air.attributes, air.out_of_range)

    def ambient_radiance(
        self, *, slope, azimuth=0.0, ground_temperature=None, band=None, by_wavelength=False, **where
    ) -> npt.NDArray[np.float64]:
        glow = None if band is None else band.blackbody_radiance
        read = self.value_by_wavelength if by_wavelength else self.value
        return ambient_radiance(
            self, read, slope, azimuth, ground_temperature, glow, where, by_wavelength=by_wavelength
        )

    def _read(self, quantity: str, where: dict[str, Any], *, by_wavelength: bool) -> npt.NDArray[np.float64]:
        rules = {rule.name: rule for rule in self.rules(quantity)}
        angle = where.pop(ANGLE, None) if AXES[-1] in rules else None
        wanted = set(rules) - ({AXES[-1]} if angle is not None else set())
        for name in where:
            if name not in wanted:
                raise InputError(f"found the axis '{name}'; {nearest(name, sorted(wanted))}", file=self.path)
        if missing := sorted(wanted - set(where)):
            raise InputError(f"the axis '{missing[0]}' is missing; give a value for it", file=self.path)
        place = _aligned(
            {name: where[name] for name in rules if name in where} | ({} if angle is None else {ANGLE: angle})
        )
        for name in _PATH:
            place[name] = _within(rules[name], place[name])
        entry = Entry.of(*(place[name] for name in _PATH))
        line = entry.range_km, entry.altitude_km, entry.elevation_deg
        reader = ChannelReader.of(self.root, self.attributes, self.out_of_range)
        if quantity == VALID:
            return np.asarray(entry.range_km <= reader.rays.locate(*line).ground_distance, float)
        paths = reader.paths(*line)
        if np.any(np.isfinite(entry.end_altitude_km)):  # in space the beam alone knows how high
            high = np.where(np.isfinite(entry.end_altitude_km), entry.end_altitude_km - reader.ground_km, 0.0)
            end = np.where(np.isfinite(entry.end_altitude_km), high, paths.coordinates.end_height)
            paths = replace(paths, coordinates=replace(paths.coordinates, end_height=end))
        if quantity == "beta_star":
            return reader.beta_star(paths, place["range"])
        if quantity == DEPTH:
            return reader.depth_by_wavelength(paths)
        parted = {"by_wavelength": by_wavelength}
        if quantity == GROUND_HARMONICS:
            return reader.ground_harmonics(paths, place["ground_temperature"], place["zonal_harmonic"], **parted)
        source = place["source_elevation"]
        if quantity == "ambient_radiance":
            return reader.ambient_radiance(paths, source, **parted)
        if quantity == "direct_radiance":
            _within(rules["source_elevation"], np.maximum(source, rules["source_elevation"].nodes[0]))
            return reader.direct_radiance(paths, source, **parted)
        if quantity == AMBIENT_HARMONICS:
            return reader.harmonics(paths, source, place["harmonic"], **parted)
        turned = place[ANGLE] if angle is not None else scattering_angle(place["elevation"], source, place[AXES[-1]])
        if angle is None:
            source = entry.source_elevation(source, place[AXES[-1]])
        return reader.path_radiance_ratio(paths, source, turned)


@dataclass(frozen=True, eq=False)
class NightShare(Night):
    """`Night` with the light that it leaves."""

    def share(self, elevation: npt.ArrayLike) -> Floats:
        """Share of the light of the lowest node at elevations [degree]; 1 at and above that node.

        Raises
        ------
        InputError
            The lowest node is before the end of civil twilight, and an elevation is between it and the dark.
        """
        height = np.asarray(elevation, float)
        fading = self.lacks(height)
        if np.any(fading):
            if self.rule.out_of_range == CLAMP:
                return np.where(height > self.dark_below, 1.0, 0.0)
            raise InputError(
                f"{SOURCE_ELEVATION}: found {np.ravel(height[fading])[0]:g}; allowed: {self.lowest:g} and above, or"
                f" {self.dark_below:g} and below, where it is dark; for twilight, build the file with a node at"
                f" {CIVIL_TWILIGHT:g} or below"
            )
        width = self.lowest - self.dark_below
        faded = np.clip((height - self.dark_below) / width, 0.0, 1.0) if width > 0 else np.zeros_like(height)
        return np.where(height < self.lowest, faded, 1.0)

    def within(self, elevation: npt.ArrayLike) -> Floats:
        """Elevations [degree], those below the lowest node moved to it."""
        height = np.asarray(elevation, float)
        return np.where(np.isfinite(height), np.maximum(height, self.lowest), height)


def _aligned(where: Mapping[str, Any]) -> dict[str, npt.NDArray[Any]]:
    """Values with as many axes each, in front those of length 1."""
    arrays = {name: np.asarray(values) for name, values in where.items()}
    dims = max((values.ndim for values in arrays.values()), default=0)
    return {name: values.reshape((1,) * (dims - values.ndim) + values.shape) for name, values in arrays.items()}


def _within(rule: AxisRule, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values inside an axis, or an error."""
    rule.locate(values)
    return np.asarray(np.clip(values.astype(float), rule.nodes[0], rule.nodes[-1]))


def ambient_radiance(
    table: AtmosphereTable,
    read: Callable[..., npt.NDArray[np.float64]],
    slope: npt.ArrayLike,
    azimuth: npt.ArrayLike,
    ground_temperature: npt.ArrayLike | None,
    blackbody: Callable[[npt.ArrayLike], npt.NDArray[np.float64]] | None,
    where: Mapping[str, Any],
    *,
    by_wavelength: bool,
) -> npt.NDArray[np.float64]:
    """As `loader.AtmosphereTable.ambient_radiance`, whose values `read` gives, parted by wavelength along a last axis
    or not; `blackbody` gives the band radiance (7) of temperatures in K.
    """
    level = read("ambient_radiance", **where)
    parts = level.shape[-1:] if by_wavelength else ()
    if AMBIENT_HARMONICS not in table.quantities:
        if np.any(np.asarray(slope) != 0):
            raise InputError(
                f"has no {AMBIENT_HARMONICS}; allowed: slope 0; build the file from a job whose surface_grid.slope_deg"
                " has tilted faces",
                file=table.path,
            )
        places = level.shape[:-1] if by_wavelength else level.shape
        shape = np.broadcast_shapes(places, np.shape(slope), np.shape(azimuth))
        level = level.reshape((1,) * (len(shape) - len(places)) + level.shape)
        return np.array(np.broadcast_to(level, shape + parts))
    stated = stated_ground(table.attributes)
    kelvin, emitted = np.asarray(stated.temperature), np.asarray(stated.radiance)
    if ground_temperature is not None and blackbody is not None:
        kelvin = np.asarray(ground_temperature, float)
        emitted = stated.emissivity * blackbody(kelvin)
    light = _coefficients(table, read, AMBIENT_HARMONICS, "harmonic", where)
    of_ground = {**where, "ground_temperature": kelvin}
    ground = _coefficients(table, read, GROUND_HARMONICS, "zonal_harmonic", of_ground)
    normal = face_normal(slope, azimuth)
    if by_wavelength:
        light, ground = np.swapaxes(light, -1, -2), np.swapaxes(ground, -1, -2)
        emitted, normal = emitted[..., None], normal[..., None, :]
    return ambient_of_faces(level, light, ground, emitted, normal)


def _coefficients(
    table: AtmosphereTable,
    read: Callable[..., npt.NDArray[np.float64]],
    quantity: str,
    harmonic: str,
    where: Mapping[str, Any],
) -> npt.NDArray[np.float64]:
    """Values of a quantity at places, for all harmonics along the axis behind that of the places."""
    rules = {rule.name: rule for rule in table.rules(quantity)}
    place = {name: np.asarray(values)[..., None] for name, values in where.items() if name in rules}
    return read(quantity, **place, **{harmonic: rules[harmonic].nodes})
