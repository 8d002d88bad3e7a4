"""The ``.atmq`` and ``.lunar_atmq`` databases of one state and one band."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.band.compile import EVERYWHERE, CompiledBand, air_at_all_points
from skyshine.mat.atmosphere.state.ground_albedo import SpectralAlbedo
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.bounds import Scattering
from skyshine.mat.atmosphere.transfer.scene_lines import REGIONS
from skyshine.mat.job.atmosphere import State
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.measure.channel_nodes import quantities_of
from skyshine.mat.measure.faces import FaceProbes
from skyshine.mat.measure.probes import DRAWN, Probes, measured
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.scale import REFLECTANCE, Scale
from skyshine.mat.products.channel_tables import ChannelTables, SharedNodes
from skyshine.mat.products.product import Context, TableIdentity, TaskReport
from skyshine.mat.products.shared_nodes import shared_nodes
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.nodes import ChannelNodes
from skyshine.mat.quantities.channels.wavelength_shares import PartedLight
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.scene.air_cells import shared_cell
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import StateBand
from skyshine.mat.scene.grids import path_grid, path_scope, table_grid
from skyshine.mat.scene.ground import band_albedo, ground_albedo
from skyshine.mat.scene.omission import Omission
from skyshine.mat.scene.sources import irradiance_of_sources, source_irradiance
from skyshine.mat.scene.summary import state_attributes
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, grid_group, tables_on_axes
from skyshine.mat.tables.files import ATMQ, LUNAR_ATMQ
from skyshine.mat.tables.stated_error import (
    ErrorMeasure,
    accuracy_group,
    measure,
    of_worst_region,
    with_independent,
)
from skyshine.schemas.digest import digest_of
from skyshine.schemas.hdf5 import Axis, Group, Variable

FILE_TYPES = {"sun": ATMQ, "moon": LUNAR_ATMQ}
LINES, SKY = 200, 48  # lines on which errors are measured, others than those on which nodes were placed
SHARED_LINES, SHARED_SKY = 80, 24  # the same for each of many states that share nodes: they err alike
# What the compiled band is tested on, for each quantity of the tables.
_SPECTRAL_KINDS = {
    "beta_star": ("transmittance",),
    "path_radiance_ratio": ("path_thermal", "path_radiance"),
    "direct_radiance": ("direct_irradiance",),
    "ambient_radiance": ("sky_irradiance",),
    AMBIENT_HARMONICS: ("sky_irradiance",),
}

METHOD = (
    f"interpolation against direct computation above the ground, {DRAWN}; kelvin: change of a black body at 300 K seen"
    f" through the path; a surface that reflects {REFLECTANCE:g} faces sky and source; percent: of that black body's"
    " radiance, in bands that end before 2.5 um of the light that such a surface reflects of the source outside the"
    f" atmosphere; {AMBIENT_HARMONICS}: ambient radiance of faces in all directions, half of them beside walls; kelvin"
    " and percent contain what the chosen spectral points err by against all points, on random paths of their own"
    " (squares add, largest errors add); 99 %, 95 % and rms are those of the region (ground, air, sky, limb) in which"
    " each is largest"
)


class AtmosphereProduct:
    """Atmospheric quantities of a state and a band, a file for each source of the job."""

    def identity(self, context: Context) -> tuple[TableIdentity, ...]:
        """A file for each source."""
        task, loaded, job = context.task, context.loaded, context.loaded.trimmed
        scope = _scope(loaded)
        state, response = job.states[task.index - 1], response_of(job.bands[task.band - 1])
        if state.ground_material is not None:
            scope["ground_reflectance"] = band_albedo(state, response, context.library)
            if isinstance(albedo := ground_albedo(state, response, context.library), SpectralAlbedo):
                scope["ground_spectrum_sha256"] = digest_of(albedo)
        if cell := shared_cell(loaded.requested, state):
            scope["points_chosen_for"] = cell.stated
        return tuple(
            TableIdentity(
                file,
                FILE_TYPES[source],
                f"absorption {absorption_table().version}",
                {
                    "site": job.site.model_dump(mode="json"),
                    "state": state.model_dump(mode="json", exclude={"date", "series"}),
                    "band": {**job.bands[task.band - 1].model_dump(mode="json"), "name": job.band_name(task.band)},
                    "source": source,
                    "water_continuum": job.water_continuum,
                    "atmosphere_grid": {
                        **job.atmosphere_grid.model_dump(mode="json"),
                        "altitude_km": job.observer_altitudes_km,
                    },
                    **({"grid": True} if job.atmosphere_grid.writes_tables else {}),
                    "accuracy": job.accuracy.model_dump(
                        mode="json", include={"spectral_tolerance", "negligible_k", "seed"}
                    ),
                    "ambient_harmonics": job.ambient_harmonics,
                    **scope,
                },
            )
            for source, file in zip(job.sources, task.files, strict=True)
        )

    def compute(self, context: Context, report: TaskReport) -> Iterator[Group]:
        """The tables of each source, of one compiled band."""
        task, loaded, job = context.task, context.loaded, context.loaded.trimmed
        with report.stage("compile"):
            of_band = StateBand.of(loaded, task.index, task.band)
        everything, compiled = of_band.everything, of_band.compiled
        judged = "not measured: no reference spectra over the whole band"
        if everything.line_by_line is not None:
            judged = everything.line_by_line.text
        report.notes.append(f"{compiled.index.size} of {compiled.total_points} spectral points")
        report.notes.append(f"all points against line by line: {judged}")
        report.notes.append(of_band.origin.value)
        if shortfall := _missed(compiled, job.accuracy.spectral_tolerance):
            report.notes.append(f"spectral_tolerance {job.accuracy.spectral_tolerance:g} is missed: {shortfall}")
        scope = path_scope(loaded)
        tolerance = tolerance_parts(job.atmosphere_grid.tolerance)
        air = BandAtmosphere.of(of_band.air, compiled.band, scope=scope).tabulated(*tolerance)
        light = Scattering.of(air.air).radiance(
            irradiance_of_sources(job, compiled.band), compiled.band.radiance_weight
        )
        left_out = Omission.of(job, job.sources, of_band.air, of_band.response, light)
        reference: tuple[ChannelTables, ChannelNodes] | None = None
        for source in job.sources:
            source_air = replace(air, air=replace(air.air, scatters=False)) if source in left_out.scattered else air
            text, kelvin = left_out.text(source), left_out.bound(source)
            notes = {
                "left_out": text or "none",
                "left_out_bound_kelvin": kelvin,
                "left_out_bound": kelvin * left_out.radiance,
                "spectral_tolerance": job.accuracy.spectral_tolerance,
                "spectral_tolerance_missed": shortfall or "none",
                "line_by_line_error": judged,
            }
            if text:
                report.notes.append(f"{source}: omitted {text}")
            names = {"band": job.band_name(task.band), "date": job.site.date.isoformat()}
            tables = _SourceTables(loaded, job.states[task.index - 1], source, source_air, of_band, reference)
            group, nodes = tables.group(names, notes, report)
            reference = reference or (tables.channels, nodes)
            yield group


def _scope(loaded: LoadedJob) -> dict[str, Any]:
    """What of the job, beside its axes, a table depends on where query limits trim it."""
    scope, job = path_scope(loaded), loaded.trimmed
    if job.query_limits is None:
        return {}
    return {"compiled_for": {"sources": job.sources, "path_share": scope.share}}


def _missed(compiled: CompiledBand, tolerance: float) -> str:
    """Quantities of a compiled band whose error is beyond the tolerance, with their error; empty where none is."""
    errors = {kind: error["rms"] for kind, error in compiled.errors.items() if error["rms"] > tolerance}
    return ", ".join(f"{kind} ({error:.1e} rms)" for kind, error in errors.items())


@dataclass(frozen=True, eq=False)
class _SourceTables:
    """The tables of a state and a band with one source; those of the source before it, if any, share its pass."""

    loaded: LoadedJob
    state: State
    source: str
    air: BandAtmosphere
    of_band: StateBand
    reference: tuple[ChannelTables, ChannelNodes] | None

    @cached_property
    def irradiance(self) -> npt.NDArray[np.float64]:
        """Irradiance of the source outside the atmosphere, (P,) W m^-2 (cm^-1)^-1."""
        band = self.of_band.compiled.band
        return source_irradiance(self.loaded.trimmed, self.source, band.wavenumber, band.width)

    @cached_property
    def channels(self) -> ChannelTables:
        """The tables in channels."""
        job = self.loaded.trimmed
        scale, tolerance = self._scale(job.atmosphere_grid.tolerance, self.irradiance)
        if self.reference is not None:
            return self.reference[0].under(self.air, self.irradiance, scale, self._at_all_points())
        return ChannelTables(
            self.air,
            path_grid(job),
            self.irradiance,
            scale,
            tolerance,
            job.ambient_harmonics,
            job.accuracy.seed,
            self._at_all_points(),
            band_wavelengths(self.of_band.response),
        )

    def group(self, names: dict[str, str], notes: dict[str, Any], report: TaskReport) -> tuple[Group, ChannelNodes]:
        """The channels on nodes that meet the job's tolerance, and the tables on its axes, arranged for writing; and
        the nodes.
        """
        job, seed = self.loaded.trimmed, self.loaded.trimmed.accuracy.seed
        base, axes = path_grid(job), job.atmosphere_grid
        irradiance, channels = self.irradiance, self.channels
        with report.stage("similar airs"):
            common = shared_nodes(self.loaded, self.state, self.of_band.response, self.source, self.of_band.everything)
        sampled, count, whose = None, (SHARED_LINES, SHARED_SKY), "similar airs"
        if common is None and self.reference is not None:
            with report.stage("channels"):
                common = SharedNodes(self.reference[1], channels.sources(self.reference[1]))
            count, whose = (LINES, SKY), "the source before"
        if common is not None:
            with report.stage("accuracy"):
                probes = self._probes(base, irradiance, *count)
            with report.stage("channels"):
                sampled = channels.on_shared(common, probes)
            report.notes.append(f"{self.source}: nodes of {whose}{'' if sampled else ' exceed the tolerance'}")
        if sampled is None:
            with report.stage("channels"):
                sampled = channels.placed(axes.most_nodes, insist=self.loaded.insists("atmosphere_grid"))
            with report.stage("accuracy"):
                probes = self._probes(base, irradiance, LINES, SKY)
        with report.stage("accuracy"):
            pixels = Probes.of_pixels(self.channels.direct, base, irradiance, random_stream(seed, Stream.PIXELS))
            groups_of_probes = [probes] if pixels is None else [probes, pixels]
            measures = measured(groups_of_probes, quantities_of(sampled.table), *self._scales(irradiance))
            if job.ambient_harmonics:
                faces = FaceProbes.drawn(self.air, base, irradiance, random_stream(seed, Stream.TILTED_FACES))
                read = faces.read(sampled.table)
                own_error, kelvin, percent = (faces.errors(read, scale) for scale in (None, *self._scales(irradiance)))
                measures.append(measure(AMBIENT_HARMONICS, own_error, kelvin, percent, regions=faces.regions()))
            measures = self._with_spectral(measures)
        report.notes.append(f"{self.source}: {channels.words(sampled)}")
        notes = notes | {"tolerance": axes.tolerance} | channels.notes(sampled)
        groups = {"accuracy": _accuracy(measures, self.of_band.compiled, seed, notes)}
        if axes.writes_tables:
            with report.stage("grid"):
                tables = tables_on_axes(sampled.table, table_grid(job))
                errors = self._with_spectral(measured(groups_of_probes, tables, *self._scales(irradiance)))
                groups["grid"] = grid_group(tables, accuracy_group(errors, {}, {}, {"seed": seed, "method": METHOD}))
        root = sampled.table.root
        return replace(root, groups=groups, attributes=self._attributes(names) | root.attributes), sampled.nodes

    def _with_spectral(self, measures: list[ErrorMeasure]) -> list[ErrorMeasure]:
        """Errors of interpolation with those of the chosen spectral points, on random paths against all points, in the
        worst region.
        """
        absolute, sources = self.of_band.compiled.absolute, list[str](self.loaded.trimmed.sources)
        number = sources.index(self.source)

        def spectral(quantity: str, scale: Scale) -> dict[str, dict[str, float]]:
            """Statistics by region of the quantity's worst kind of in-band light, in the scale's unit."""
            parts = [absolute[kind][number] for kind in _SPECTRAL_KINDS[quantity] if kind in absolute]
            factor = {"beta_star": scale.background, "path_radiance_ratio": 1.0}.get(
                quantity, scale.reflectance / np.pi
            )
            regions = dict.fromkeys(region for part in parts for region in part)
            return {
                region: {
                    name: factor * scale.factor * max(part.get(region, part[EVERYWHERE])[name] for part in parts)
                    for name in ("max", "p99", "p95", "rms")
                }
                for region in regions
            }

        kelvin, percent = self._scales(self.irradiance)
        return [
            of_worst_region(
                with_independent(
                    error_measure,
                    spectral(error_measure.quantity, kelvin),
                    spectral(error_measure.quantity, percent),
                    EVERYWHERE,
                ),
                REGIONS,
            )
            for error_measure in measures
        ]

    def _probes(self, base: PathGrid, irradiance: npt.NDArray[np.float64], lines: int, sky: int) -> Probes:
        """Random lines of sight on which tables in channels are measured."""
        generator, scope = random_stream(self.loaded.trimmed.accuracy.seed, Stream.ATMOSPHERE_ERROR), self.air.scope
        return Probes.drawn(
            self.channels.direct, base, irradiance, generator, sky=scope.lines(sky), count=scope.lines(lines)
        )

    def _at_all_points(self) -> tuple[SpectralAir, PartedLight]:
        """The air of the tables at all points of the band, and the light there."""
        all_points = self.of_band.everything
        if self.reference is not None:
            air = self.reference[0].all_points[0]
        else:
            air = air_at_all_points(self.air.air.state, all_points)
        irradiance = source_irradiance(self.loaded.trimmed, self.source, all_points.wavenumber, all_points.width)
        return air, PartedLight.of(all_points.wavenumber, all_points.radiance_weight, irradiance)

    def _attributes(self, names: dict[str, str]) -> dict[str, Any]:
        """Root attributes: source, state, band, and the ground where faces may be tilted."""
        edges = [self.of_band.response.lower, self.of_band.response.upper]
        attributes = {"source": self.source, **state_attributes(self.state), **names, "wavelength_um": edges}
        if isinstance(self.air.air.state.surface_albedo, SpectralAlbedo):
            attributes["ground_below_paths"] = (
                f"reflectance of {self.state.ground_material} by wavelength, the same everywhere; adjacency of other"
                " ground is not modelled"
            )
        return attributes | (self._ground() if self.loaded.trimmed.ambient_harmonics else {})

    def _scale(self, text: str, irradiance: npt.NDArray[np.float64]) -> tuple[Scale, float]:
        """In what a tolerance counts, and its number."""
        tolerance, unit = tolerance_parts(text)
        in_band = float(self.of_band.compiled.band.radiance_weight @ irradiance)
        return Scale.of_unit(unit, self.of_band.response, in_band), tolerance

    def _scales(self, irradiance: npt.NDArray[np.float64]) -> tuple[Scale, Scale]:
        """In what errors are stated beside the quantities' own units: kelvin and percent."""
        in_band = float(self.of_band.compiled.band.radiance_weight @ irradiance)
        return Scale.kelvin(self.of_band.response), Scale.of_unit("%", self.of_band.response, in_band)

    def _ground(self) -> dict[str, Any]:
        """Root attributes of the ground around tilted faces: that of the air."""
        kelvin, emissivity = self.air.air.state.surface_temperature, 1 - self.air.air.state.mean_albedo
        glow = float(planck_wavenumber(self.air.band.wavenumber, kelvin) @ self.air.band.radiance_weight)
        stated = {
            "ground_emissivity": emissivity,
            "ground_temperature": kelvin,
            "ground_radiance": emissivity * glow,
        }
        material = self.state.ground_material
        return stated if material is None else stated | {"ground_material": material}


def _accuracy(measures: list[ErrorMeasure], compiled: CompiledBand, seed: int, left_out: dict[str, Any]) -> Group:
    kinds = list(compiled.errors)
    words = {"max": "largest", "p95": "95th percentile of the", "rms": "root mean square"}
    spectral = {
        f"spectral_{name}": Variable(
            ("spectral_quantity",),
            np.array([compiled.errors[kind][name] for kind in kinds]),
            "1",
            f"{text} relative error of the compiled band against all spectral points",
        )
        for name, text in words.items()
    }
    notes = {
        "seed": seed,
        "method": METHOD,
        "spectral_points": int(compiled.index.size),
        "spectral_points_in_band": int(compiled.total_points),
        **left_out,
    }
    axes = {"spectral_quantity": Axis(np.array(kinds, object), "1", "in-band quantity whose spectral error is stated")}
    return accuracy_group(measures, spectral, axes, notes)
