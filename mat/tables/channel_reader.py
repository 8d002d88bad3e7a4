"""Reading a database in channels: transmittance, path radiance and light on surfaces from its arrays.

With D_j the optical depth of channel j along a path, from the absorbers' mean extinction and the path's length,

    tau = sum_j w_j exp(-D_j)
    L_path = thermal_ratio sum_j e_j (1 - exp(-D_j)) + (sum_k f_k scattered_ratio_k) sum_j s_j (1 - exp(-D_j))
    L_surface = sum_j exp(-D_j) sum_q g_jq X_q / tau

for light X on surfaces, which (20) and (36) weigh by the path's transmittance. By wavelength, the light of channel j is
parted with its shares S_jb; transmittance by wavelength is that of emitted light, sum_j e_j S_jb exp(-D_j) over the sum
without air.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.quantities.channels.coordinates import RayCoordinates, RayPlaces
from skyshine.mat.quantities.formulas import beta_star, mean_transmittance
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
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.night import Night
from skyshine.mat.tables.out_of_range import AS_STATED, OutOfRange
from skyshine.schemas.arrays import Floats
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

    def _night(self) -> Night:
        return Night(self._rule(SOURCE_ELEVATION))

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
