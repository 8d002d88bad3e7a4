"""Reading the textures of an atmosphere as a shader does, for the errors that an export states."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from skyshine.mat.gpu.container import GpuFile
from skyshine.mat.quantities.channels.coordinates import RayCoordinates
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.lobe import specular_lobe
from skyshine.mat.radiometry.scattering_angle import scattering_angle
from skyshine.mat.radiometry.spherical_harmonics import face_normal, harmonics_at, irradiance_factors, level_share
from skyshine.mat.runtime.pixel import Faces, View
from skyshine.mat.tables.band import BandTable
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

_SLACK = 1e-4  # degree, of numbers that a header has in single precision


@dataclass(frozen=True, eq=False)
class GpuAir:
    """An exported atmosphere, of one source elevation once `frame` has been asked for one.

    Attributes
    ----------
    terms : dict of str to array
        Coefficients (..., K): ``emission`` (M, T), ``thermal_path``, ``path`` (A), ``sky`` (M, Q), ``direct`` (M);
        the last three by source elevation in front before `frame`.
    """

    content: GpuFile
    terms: dict[str, Floats]

    @classmethod
    def of(cls, content: GpuFile) -> GpuAir:
        """Evaluation of an export, read or just made."""
        numbers = content.numbers
        count, materials = int(numbers["components"]), len(numbers["material"])
        heights = numbers["source_elevation"]
        shapes: dict[str, tuple[int, ...]] = {
            "emission": (materials, len(numbers["emission_temperature"])),
            "thermal_path": (),
            "path": (len(heights["path"]), len(numbers["angle"])),
            "sky": (len(heights["sky"]), materials, 1 + len(numbers["harmonic"])),
            "direct": (len(heights["direct"]), materials),
        }
        if "ground_node" in numbers:
            shapes["ground"] = (len(numbers["ground_node"]), materials, len(numbers["zonal_harmonic"]))
        return cls(
            content,
            {
                name: content.textures[name].texels.astype(float).reshape(*shape, count)
                for name, shape in shapes.items()
            },
        )

    @cached_property
    def rays(self) -> RayCoordinates:
        """Coordinates of lines of sight in the textures."""
        numbers = self.content.numbers
        return RayCoordinates(
            numbers["ground_altitude_km"],
            np.array(numbers["height_root"]),
            np.array(numbers["effective_radius"]),
            numbers["scale_height_km"],
        )

    def frame(self, source_elevation: float, hour: float | None = None) -> GpuAir:
        """The same for one elevation of the source [degree] and, where the file has the ground by the hour, at one hour
        of the local clock.

        Raises
        ------
        InputError
            The textures are not for that elevation.
        """
        numbers = self.content.numbers
        lowest, highest = numbers["lowest_source_elevation"], numbers["highest_source_elevation"]
        dark = numbers["dark_below"]
        below = source_elevation < lowest
        if below and not numbers["fades"] and source_elevation > dark:
            raise InputError(f"source_elevation: found {source_elevation:g}; allowed: {lowest:g} and above")
        if source_elevation > highest + _SLACK:
            raise InputError(f"source_elevation: found {source_elevation:g}; allowed: up to {highest:g}")
        terms = dict(self.terms)
        for name, nodes in numbers["source_elevation"].items():
            axis = np.array(nodes)
            if axis.size == 1 and abs(axis[0] - source_elevation) > _SLACK:
                raise InputError(f"source_elevation: found {source_elevation:g}; allowed: {axis[0]:g}, the frame's own")
            lower, weight = _cell(axis, np.array(source_elevation))
            upper = np.minimum(lower + 1, axis.size - 1)
            terms[name] = terms[name][lower] * (1 - weight) + terms[name][upper] * weight
        if "ground" in terms:
            kelvin, radiance = self.ground_at(0.0 if hour is None else hour)
            lower, weight = _cell(np.array(numbers["ground_node"]), np.array(kelvin))
            ground = terms.pop("ground")
            of_ground = ground[lower] * (1 - weight) + ground[lower + 1] * weight
            columns = 1 + np.searchsorted(numbers["harmonic"], numbers["zonal_harmonic"])
            terms["sky"][:, columns] += radiance * of_ground
        return replace(self, terms=terms)

    def ground_at(self, hour: float) -> tuple[float, float]:
        """Temperature [K] of the ground around faces at an hour of the local clock, and what it emits in the band."""
        numbers = self.content.numbers
        if "ground_time" not in numbers:
            return float(numbers.get("ground_temperature", np.nan)), np.nan
        time = np.array(numbers["ground_time"])
        at = time[0] + np.mod(hour - time[0], 24.0)
        temperature, radiance = (np.interp(at, time, numbers[f"ground_{name}"]) for name in ("temperature", "radiance"))
        return float(temperature), float(radiance)

    @cached_property
    def _layers(self) -> Floats:
        """The textures (n3, n2, n1, K)."""
        count = int(self.content.numbers["components"]) // 4
        parts = [self.content.textures[f"air{group}"].texels.astype(float) for group in range(count)]
        return np.concatenate(parts, axis=-1)

    def components(self, lines: LinesOfSight) -> Floats:
        """Interpolated components (n, K) at lines of sight (n,)."""
        ray_coordinates = self.rays.locate(lines.range, lines.altitude, lines.elevation)
        axes = [np.array(nodes) for nodes in self.content.numbers["axes"]]
        located = (ray_coordinates.share, ray_coordinates.direction, ray_coordinates.height_root)
        cells = [_cell(nodes, coordinate) for nodes, coordinate in zip(axes, located, strict=True)]
        total = np.zeros((*lines.range.shape, self._layers.shape[-1]))
        for corner in range(8):
            weight, index = np.ones(lines.range.shape), []
            for axis, (lower, part) in enumerate(cells):
                upper = corner >> axis & 1
                index.append(np.minimum(lower + upper, axes[axis].size - 1))
                weight = weight * (part if upper else 1 - part)
            total += weight[..., None] * self._layers[index[2], index[1], index[0]]
        return total

    def radiance(self, band: BandTable, faces: Faces, view: View) -> Floats:
        """Radiance (n,) of pixels with stated temperatures, as `runtime.pixel_radiance`; after `frame` only.

        Every pixel is read at its own range and elevation.
        """
        assert faces.temperature is not None
        numbers = self.content.numbers
        air = self.components(view.lines)
        row = np.searchsorted(numbers["material"], faces.codes)
        nodes = np.array(numbers["emission_temperature"])
        lower, part = _cell(nodes, faces.temperature)
        upper = np.minimum(lower + 1, nodes.size - 1)
        emission = self.terms["emission"]
        share = emission[row, lower] * (1 - part)[..., None] + emission[row, upper] * part[..., None]
        emitted = band.blackbody_radiance(faces.temperature) * np.einsum("nmk,nk->nm", share, air)
        turn = np.zeros(len(air)) if view.source_heading is None else faces.azimuth - view.source_heading
        weights = face_weights(faces.slope, turn, np.array(numbers["harmonic"], int))
        sky = np.maximum(np.einsum("nmqk,nq,nk->nm", self.terms["sky"][row], weights, air), 0.0)
        normal, source, observer = (
            vector / np.linalg.norm(vector, axis=-1, keepdims=True)
            for vector in (view.normal, view.to_source, view.to_observer)
        )
        incidence = np.maximum(np.sum(normal * source, axis=-1), 0.0)[:, None]
        direct = np.maximum(np.einsum("nmk,nk->nm", self.terms["direct"][row], air), 0.0) * (incidence > 0)
        fraction, shininess, normalisation = (
            band.value(name, material=faces.codes) for name in ("specular_fraction", "shininess", "normalisation")
        )
        lobe = specular_lobe(shininess, source[:, None], observer[:, None], normal[:, None])
        beam = direct * (incidence * (1 - fraction) + lobe * fraction * normalisation)
        surfaces = np.sum(faces.shares * (emitted + sky + beam), axis=-1)
        return np.asarray(surfaces + self.path(air, view))

    def path(self, air: Floats, view: View) -> Floats:
        """Path radiance (n,)."""
        numbers = self.content.numbers
        angle = scattering_angle(*view.lines.place[2:])
        axis = np.array(numbers["angle"])
        lower, part = _cell(axis, angle)
        upper = np.minimum(lower + 1, axis.size - 1)
        rows = self.terms["path"][lower] * (1 - part)[:, None] + self.terms["path"][upper] * part[:, None]
        scattered = np.maximum(np.sum(rows * air, axis=-1), 0.0)
        return np.asarray(np.maximum(air @ self.terms["thermal_path"], 0.0) + scattered)


def face_weights(slope: Floats, azimuth: Floats, harmonics: np.ndarray) -> Floats:
    """Weights (n, 1 + H) of the level value and of the harmonics in the ambient light of faces.

    `spherical_harmonics.ambient_of_faces` is linear in both: S(normal) + (level - S(up)) P(cosine of slope).
    """
    if not harmonics.size:
        return np.ones((len(slope), 1))
    normal = face_normal(slope, azimuth)
    factors = irradiance_factors(harmonics)
    share = level_share(normal[:, 2], harmonics.size)[:, None]
    upright = harmonics_at(np.array([0.0, 0.0, 1.0]), harmonics)
    return np.concatenate([share, factors * (harmonics_at(normal, harmonics) - share * upright)], axis=-1)


def _cell(nodes: Floats, values: Floats) -> tuple[np.ndarray, Floats]:
    """Lower node of values clamped to an axis, and the weight of the node above it."""
    values = np.clip(values, nodes[0], nodes[-1])
    if nodes.size == 1:
        return np.zeros(values.shape, int), np.zeros(values.shape)
    lower = np.searchsorted(nodes[1:-1], values, side="right")
    return lower, (values - nodes[lower]) / (nodes[lower + 1] - nodes[lower])
