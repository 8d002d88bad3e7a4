"""What no table of a job has, each as the change of radiance that it makes: the sky behind an obstacle, shaded ground
before a wall, reflection at grazing angles, and a runtime's own depth buffer and pixels.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.spectra.fluxes import packaged_points
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.circumstances import Circumstances
from skyshine.mat.budget.measurement import Measurement
from skyshine.mat.budget.runtime_terms import AtmosphereReadings, Finish, incidence
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.budget.views import NEAR_KM, Views
from skyshine.mat.quantities.aureole import SunlitSky, sunlit_sky
from skyshine.mat.radiometry.lobe import specular_lobe
from skyshine.mat.scene.clear_sky import AUREOLE_ELEVATIONS
from skyshine.mat.tables.response import DAY_H, FORCING_STEPS, forcing_hours
from skyshine.mat.tables.shade import AUREOLE, DIFFUSE, SUN_ELEVATION
from skyshine.schemas.arrays import Booleans, Floats, Integers

DEPTH_BITS = 24  # bits of the depth buffers of today's graphics hardware; section 3.2 of the note has 23
PIXEL_RAD = 0.5e-3  # angle of a pixel: 640 across 18 degrees
OBSTACLES_DEG = (30.0, 52.0)  # half widths of the buildings before the Sun, seen from a shaded face


def depth_buffer_range(distance: Floats, nearest: float, farthest: float, bits: int = DEPTH_BITS) -> Floats:
    """Ranges as a hyperbolic depth buffer returns them.

    Parameters
    ----------
    distance : (n,) array
    nearest, farthest : float
        Clipping planes, in the unit of the distances.

    References
    ----------
    DSTO-TN-0193, section 3.2: depth is linear in the inverse of range, 0 at the near plane and 1 at the far one.
    """
    span = 1 / nearest - 1 / farthest
    depth = np.clip((1 / nearest - 1 / distance) / span, 0.0, 1.0)
    steps = 2.0**bits - 1
    result: Floats = 1 / (1 / nearest - np.round(depth * steps) / steps * span)
    return result


def share_beyond_edge(face_m: Floats, pixel_m: Floats, centre: Floats) -> Floats:
    """Share of pixels (n,) that lies beyond the nearest edges of the faces in their middle.

    Parameters
    ----------
    face_m, pixel_m : (n,) arrays
        Lengths of faces and of pixels on them.
    centre : (n,) array
        Position of the pixel's middle on the face, 0 to 1.
    """
    half = 0.5 * pixel_m
    inside = np.minimum(half, centre * face_m) + np.minimum(half, (1 - centre) * face_m)
    return 1 - inside / pixel_m


def microfacet_reflection(views: Views, normal: Floats, finish: Finish) -> Floats:
    """As `runtime_terms.reflection`, with microfacets in place of the lobe: facets spread as the lobe is, Fresnel
    reflectance that grows from the lobe's at normal incidence to 1 at grazing, and their shadows.

    References
    ----------
    Cook and Torrance 1982, ACM Trans. Graph. 1, 7-24; Blinn's distribution, (s + 2) / (2 pi) times cos^s; Fresnel:
    Schlick 1994, Comput. Graph. Forum 13, 233-246.
    """
    cosine = incidence(views, normal)
    observer = np.sum(normal * views.to_observer, axis=1)[:, None]
    between = views.to_source + views.to_observer
    half = between / np.maximum(np.linalg.norm(between, axis=1, keepdims=True), 1e-12)
    on_facet, upward = (np.sum(half * vector, axis=1)[:, None] for vector in (views.to_observer, normal))
    spread = specular_lobe(finish.shininess, views.to_source[:, None], views.to_observer[:, None], normal[:, None])
    spread = spread * (finish.shininess + 2) / (2 * np.pi)
    shadow = np.minimum(1.0, 2 * upward * np.minimum(cosine, observer) / np.maximum(on_facet, 1e-12))
    normal_reflectance = finish.reflectance * finish.specular_fraction
    fresnel = normal_reflectance + (1 - normal_reflectance) * np.clip(1 - on_facet, 0.0, 1.0) ** 5
    reflecting = (cosine > 0) & (observer > 0) & (normal_reflectance > 0)
    specular = np.pi * spread * shadow * fresnel / (4 * np.maximum(observer, 1e-3))
    of_reflectance = np.divide(specular, finish.reflectance, out=np.zeros_like(specular), where=reflecting)
    result: Floats = cosine * (1 - finish.specular_fraction) + of_reflectance
    return result


@dataclass(frozen=True, eq=False)
class ShadedDay:
    """Light on shaded faces through the day, and what a change of it does to their temperature."""

    tables: Tables
    views: Views
    circumstances: Circumstances

    @property
    def shaded(self) -> Floats:
        """Share of each step of the day in the shade, (n, steps)."""
        return np.array([a.shaded(forcing_hours(), DAY_H / FORCING_STEPS) for a in self.circumstances.surroundings])

    @property
    def sky_view_factor(self) -> Floats:
        """Sky view factor of the faces on open ground, (n, 1)."""
        view: Floats = 0.5 * (1 + self.views.normal[:, 2:])
        return view

    def light(self, name: str) -> Floats:
        """A quantity on `forcing_time`, at the faces' altitudes where it has any, (n, steps)."""
        root = self.tables.surface.root
        values = np.asarray(root.variables[name].data, float)
        if values.ndim == 1:
            return np.broadcast_to(values, (len(self.views), values.size))
        nodes = np.asarray(root.axes["altitude"].values, float)
        return np.array([[np.interp(z, nodes, step) for step in values.T] for z in self.views.surface_altitude])

    def warmer_by(self, absorbed: Floats) -> Floats:
        """Change (n, M) of temperature [K] by an absorbed heat (n, M, steps) that comes to that of the shade."""
        surroundings = self.circumstances.surroundings
        shadowed = self.tables.absorbed_change(self.views, surroundings)
        return self.tables.temperature(self.views, shadowed + absorbed) - self.tables.temperature(self.views, shadowed)

    def of_material(self, name: str) -> Floats:
        """A number of each material, (M, 1)."""
        return np.asarray(self.tables.surface.root.variables[name].data, float)[:, None]


def buildings(sky: SunlitSky) -> tuple[Floats, Floats]:
    """Shares of the sky's light that buildings of `OBSTACLES_DEG` hide, and of an even sky, (2, S) each."""

    def hidden(width: float) -> tuple[Floats, Floats]:
        return sky.within(lambda v, _: np.abs(np.arctan2(v[..., 1], v[..., 0])) < np.radians(width))

    light, even = zip(*(hidden(width) for width in OBSTACLES_DEG), strict=True)
    return np.array(light), np.array(even)


def aureole_heat(prepared: Prepared, day: ShadedDay, building: Integers) -> Floats:
    """Sunlight (n, M, steps) [W m^-2] that the one share of the aureole leaves on faces behind a building too much.

    Parameters
    ----------
    prepared : Prepared
        Prepared state, for its air.
    building : (n,) int array
        Number of the building in `OBSTACLES_DEG`.
    """
    state = replace(prepared.exact.air.state, surface_albedo=prepared.inputs[2].ground_albedo)
    points = packaged_points(prepared.loaded.trimmed.water_continuum).shortwave
    light, even = buildings(sunlit_sky(SpectralAir.of(state, points), points.weight, AUREOLE_ELEVATIONS))
    elevation = day.light(SUN_ELEVATION)

    def at_sun(table: Floats) -> Floats:
        rows = [np.interp(e, AUREOLE_ELEVATIONS, table[b]) for e, b in zip(elevation, building, strict=True)]
        return np.array(rows)

    share = day.light(AUREOLE)
    too_much = (1 - share) * (1 - at_sun(even)) - (1 - at_sun(light))
    # Where the share is 0 clouds hide the Sun, whose surroundings are no brighter.
    of_level = np.where(share > 0, too_much, 0.0) * day.light(DIFFUSE) * day.shaded
    absorptance = day.of_material("solar_absorptance")
    return (day.sky_view_factor * of_level)[:, None] * absorptance


def aureole_light(prepared: Prepared, views: Views, irradiance: Floats, in_shade: Booleans) -> Floats:
    """Band light (n, 1) [W m^-2 sr^-1] from around the Sun that shaded faces keep, as the ambient light has it."""
    result = np.zeros((len(views), 1))
    dark = in_shade & (views.source_elevation > 0)
    if dark.any() and prepared.reduced.air.scatters:
        band = prepared.reduced.band
        sky = SunlitSky.of(prepared.reduced.air, irradiance * band.radiance_weight / np.pi, AUREOLE_ELEVATIONS)
        level = np.interp(views.source_elevation, AUREOLE_ELEVATIONS, sky.aureole * sky.irradiance)
        result[dark, 0] = (level * 0.5 * (1 + views.normal[:, 2]))[dark]
    return result


def light_of_ground(day: ShadedDay, readings: AtmosphereReadings) -> Floats | None:
    """Ambient light (n, 1) [W m^-2 sr^-1] that ground in the open sends to faces at the time of the views, above that
    of ground in their shade; None where the file names no ground of which it has the response.
    """
    surface, views, tables = day.tables.surface.clamped(), day.views, day.tables
    name = surface.attributes.get("ground_material")
    if name not in surface.materials:
        return None
    coordinates: dict[str, Any] = {"material": str(name), "altitude": float(surface.root.axes["altitude"].values[0])}
    change = np.array(
        [surface.absorbed_change(**coordinates, shade=face.shade) for face in day.circumstances.surroundings]
    )
    time = views.time[:, None]
    kelvin = [surface.temperature(**coordinates, time=time, absorbed_change=heat) for heat in (None, change[:, None])]
    emissivity = float(tables.air.attributes.get("ground_emissivity", 1.0))
    open_air, shaded = (tables.blackbody(temperature) for temperature in kelvin)
    dark = (day.circumstances.in_shade & (views.source_elevation > 0))[:, None]
    sine = np.maximum(np.sin(np.radians(views.source_elevation)), 0.0)[:, None]
    beam = np.where(dark, readings.direct * sine, 0.0)
    light: Floats = (1 - day.sky_view_factor) * (emissivity * (open_air - shaded) + (1 - emissivity) * beam)
    return light


def unmodelled_errors(measured: Measurement, generator: np.random.Generator) -> dict[str, Floats]:
    """Errors (n, M) of radiance, W m^-2 sr^-1: none of them is a source of the pixel's.

    Parameters
    ----------
    generator : numpy.random.Generator
        Random numbers for the buildings before the Sun and the material beyond an edge.
    """
    errors = _of_shade(measured, generator) if measured.truth.source == "sun" and measured.tables.shades else {}
    return errors | {"lobe": _of_lobe(measured), "depth_buffer": _of_depth(measured)} | _of_edges(measured, generator)


def _of_shade(measured: Measurement, generator: np.random.Generator) -> dict[str, Floats]:
    views, circumstances = measured.views, measured.circumstances
    day = ShadedDay(measured.tables, views, circumstances)
    building = generator.integers(len(OBSTACLES_DEG), size=len(views))
    too_warm = -day.warmer_by(-aureole_heat(measured.prepared, day, building))
    light = aureole_light(measured.prepared, views, measured.reduced_light, circumstances.in_shade)
    errors = {"aureole": _warmer(measured, too_warm) + measured.of_ambient(light)}
    of_ground = light_of_ground(day, measured.full)
    if of_ground is not None:
        errors["seen_faces"] = measured.of_ambient(of_ground)
    return errors


def _warmer(measured: Measurement, kelvin: Floats) -> Floats:
    return measured.warmer(kelvin) - measured.base


def _of_lobe(measured: Measurement) -> Floats:
    views, finish = measured.views, measured.finish
    facets = microfacet_reflection(views, views.normal, finish)
    dark = measured.circumstances.in_shade & (measured.truth.source == "sun")
    return measured.base - measured.reflected_by(np.where(dark[:, None], 0.0, facets))


def _of_depth(measured: Measurement) -> Floats:
    views = measured.views
    farthest = max(float(measured.grid.range_km.max()), float(views.range.max()))
    read = depth_buffer_range(views.range, min(NEAR_KM[0], float(views.range.min())), farthest)
    return measured.at_range(read) - measured.base


def _of_edges(measured: Measurement, generator: np.random.Generator) -> dict[str, Floats]:
    views, base = measured.views, measured.base
    count = base.shape[1]
    if count == 1:
        return {}
    share = share_beyond_edge(views.face, 1e3 * views.range * PIXEL_RAD, views.share)
    neighbour = (np.arange(count) + generator.integers(1, count, size=base.shape)) % count
    return {"aliasing": share[:, None] * (base - np.take_along_axis(base, neighbour, axis=1))}
