"""The pixel of the runtime that reads all tables there, against one whole truth for the tables of many builds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.circumstances import Circumstances, random_circumstances
from skyshine.mat.budget.runtime_terms import (
    AtmosphereReadings,
    ReflectedLight,
    emitted_transmittance,
    runtime_radiance,
)
from skyshine.mat.budget.truth import FacetRadiance, FacetTruth, Prepared
from skyshine.mat.budget.views import Views, random_views
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.lines_of_sight import slope_and_azimuth
from skyshine.mat.runtime.pixel import Faces, View
from skyshine.mat.runtime.pixel import pixel_radiance as runtime_pixel
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Floats


def temperature_among(tables: Tables, views: Views, circumstances: Circumstances) -> Floats:
    """Temperatures (n, M) [K] as a runtime reads them, under shadows and beside walls where the tables know them."""
    if not tables.shades:
        return tables.temperature(views)
    return tables.temperature(views, absorbed_change=tables.absorbed_change(views, circumstances.surroundings))


def pixel_radiance(
    tables: Tables, truth: FacetTruth, views: Views, circumstances: Circumstances, temperature: Floats
) -> Floats:
    """Radiance (n, M) of the runtime that reads all tables at the pixel, of one material each, W m^-2 sr^-1.

    Parameters
    ----------
    truth : FacetTruth
        Exact radiances for the source.
    circumstances : Circumstances
        Circumstances of the faces.
    temperature : (n, M) array
        Temperatures from `temperature_among`, K.
    """
    count, materials = temperature.shape
    row = np.repeat(np.arange(count), materials)
    codes = np.tile(list(tables.band.materials.values()), count)[:, None]
    slope, azimuth = slope_and_azimuth(views.normal)
    faces = Faces(
        codes,
        np.ones(codes.shape),
        views.surface_altitude[row],
        azimuth[row],
        slope[row],
        views.time[row],
        temperature.reshape(-1, 1),
        ground_temperature=tables.air.ground_temperature(tables.surface, time=views.time)[row],
        lit_share=truth.lit_share(circumstances)[row],
        sky_view=circumstances.sky_view[row],
        wall_temperature=tables.wall_temperature(views, circumstances)[row],
    )
    vectors = views.normal[row], views.to_source[row], views.to_observer[row]
    view = View(views.lines.take(row), views.range[row], *vectors, views.source_azimuth[row])
    pixels = runtime_pixel(tables.surface, tables.band.clamped(), tables.air.clamped(), faces, view)
    return pixels.radiance.reshape(count, materials)


def integrated_readings(truth: FacetTruth, facets: FacetRadiance) -> AtmosphereReadings:
    """Quantities of the air as in exact tables."""
    band = truth.air.band
    through = emitted_transmittance(band, truth.reflectance, facets.lines, facets.kelvin)
    return replace(AtmosphereReadings.integrated(facets.lines, band), emitted=through)


def integrated_light(tables: Tables, truth: FacetTruth, facets: FacetRadiance) -> ReflectedLight:
    """Reflected light as exact tables would give it."""
    return ReflectedLight.integrated(facets.lines, truth.air.band, truth.reflectance, tables.finish.reflectance)


@dataclass(frozen=True, eq=False)
class Scenes:
    """Random views of faces under a source, with the surroundings of the faces."""

    truth: FacetTruth
    views: Views
    circumstances: Circumstances

    @classmethod
    def drawn(
        cls,
        prepared: Prepared,
        library: MaterialLibrary,
        materials: Sequence[str],
        grid: PathGrid,
        surface_axes: Mapping[str, Floats],
        *,
        shades: bool,
        source: str,
        scenes: int,
        seed: int,
    ) -> Scenes | None:
        """Draw views whose every coordinate lies on axes.

        Parameters
        ----------
        materials : sequence of str
            Materials of the faces.
        grid, surface_axes : PathGrid, dict of str to array
            Axes of the tables, as for `random_views`.
        shades : bool
            Whether faces are in shadows and beside walls.
        source : {'sun', 'moon'}
        scenes, seed : int
            Number of views, and what they are drawn with.

        Returns
        -------
        Scenes or None
            None where the axes leave no room for a view, with the Moon above the horizon.
        """
        shells = prepared.exact.air.shells
        views = random_views(prepared.loaded.trimmed, source, grid, surface_axes, shells, scenes, seed)
        if not len(views):
            return None
        truth, circumstances = FacetTruth(prepared, library, materials, source), Circumstances.none(len(views))
        if shades:  # otherwise the job says that no scene will ask for shade
            draw = random_stream(seed, Stream.CIRCUMSTANCES)
            circumstances = random_circumstances(views.time, truth.mean_air_temperature, draw)
            if source != "sun":
                circumstances = replace(circumstances, wall_beam=np.zeros(len(views)))
        return cls(truth, views, circumstances)


@dataclass(frozen=True, eq=False)
class PixelTruth:
    """The whole truth of scenes, for the pixels of any tables of the same state, band, source and materials.

    Attributes
    ----------
    radiance : (n, M) array
        W m^-2 sr^-1.
    averages : (n, M) array
        Error of the runtime's equations with exact quantities and temperatures, W m^-2 sr^-1: what no table removes.
    open_air : (n, M) array
        Temperatures of the faces in the open, K.
    """

    scenes: Scenes
    radiance: Floats
    averages: Floats
    open_air: Floats

    @classmethod
    def of(cls, scenes: Scenes, tables: Tables) -> PixelTruth:
        """Compute the radiance of all scenes.

        Parameters
        ----------
        tables : Tables
            Tables of any accuracy, for their materials and the quantities that they have.
        """
        facets = scenes.truth.of(scenes.views, scenes.circumstances, tables.finish)
        readings = integrated_readings(scenes.truth, facets)
        light = integrated_light(tables, scenes.truth, facets)
        runtime = runtime_radiance(readings, tables.emission(facets.kelvin), facets.bounce, tables.finish, light)
        return cls(scenes, facets.radiance, runtime - facets.radiance, facets.open_air)

    def error(self, tables: Tables, steps: int | None = None) -> Floats:
        """Error (n, M) of a runtime that reads all tables at the pixel, W m^-2 sr^-1.

        Parameters
        ----------
        steps : int, optional
            Steps of the heat balance, by whose error the temperatures are changed.
        """
        views, circumstances, truth = self.scenes.views, self.scenes.circumstances, self.scenes.truth
        kelvin = temperature_among(tables, views, circumstances)
        if steps is not None:
            coarser = truth.temperature(views.normal, views.surface_altitude, views.time, steps=steps)
            kelvin = kelvin + coarser - self.open_air
        return pixel_radiance(tables, truth, views, circumstances, kelvin) - self.radiance

    def radiance_in(self, tables: Tables, kelvin: Floats, air: BandAtmosphere) -> Floats:
        """Radiance (n, M) of the runtime's equations with the quantities of some air computed directly, W m^-2 sr^-1.

        Parameters
        ----------
        tables : Tables
        kelvin : (n, M) array
            Temperatures of the faces.
        air : BandAtmosphere
        """
        views, circumstances, truth = self.scenes.views, self.scenes.circumstances, self.scenes.truth.in_air(air)
        lines, finish, band = truth.lines(views, circumstances), tables.finish, truth.air.band
        emitted = emitted_transmittance(band, truth.reflectance, lines, kelvin)
        readings = replace(AtmosphereReadings.integrated(lines, band), emitted=emitted)
        light = ReflectedLight.integrated(lines, band, truth.reflectance, finish.reflectance)
        bounce = truth.bounce(views, views.normal, finish, circumstances)
        return runtime_radiance(readings, tables.emission(kelvin), bounce, finish, light)
