"""The ``.atmq`` and ``.lunar_atmq`` databases of one state and one band."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.band.compile import CompiledBand
from skyshine.mat.atmosphere.band.points import BandPoints, band_points
from skyshine.mat.atmosphere.state.ground_albedo import SpectralAlbedo
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.bounds import Bounds
from skyshine.mat.job.atmosphere import AtmosphereGrid, State
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.measure.atmosphere_nodes import Placed, placed_grids
from skyshine.mat.measure.channel_nodes import quantities_of
from skyshine.mat.measure.faces import FaceProbes
from skyshine.mat.measure.probes import AMBIENT, DRAWN, LINES, Probes
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.scale import REFLECTANCE, Scale
from skyshine.mat.products.channel_tables import ChannelTables
from skyshine.mat.products.product import Context, TableIdentity, TaskReport
from skyshine.mat.products.shared_nodes import shared_nodes
from skyshine.mat.quantities.ambient_harmonics import AmbientHarmonics, ambient_harmonics
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.channels.wavelength_shares import PartedLight
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.band_wavelengths import band_wavelengths
from skyshine.mat.radiometry.blackbody import SpectralResponse, planck_wavenumber
from skyshine.mat.scene.air_cells import shared_cell
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid, path_scope
from skyshine.mat.scene.ground import band_albedo, ground_albedo, over_ground
from skyshine.mat.scene.omission import Omission
from skyshine.mat.scene.sources import irradiance_of_sources, source_irradiance
from skyshine.mat.scene.summary import state_attributes
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS, ThermalLight, atmq_group
from skyshine.mat.tables.files import ATMQ, ATMQ_CHANNELS, LUNAR_ATMQ, LUNAR_ATMQ_CHANNELS
from skyshine.mat.tables.gridded import QUANTITIES, Gridded
from skyshine.mat.tables.night import dark_elevation
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.schemas.digest import digest_of
from skyshine.schemas.hdf5 import Axis, Group, Variable

FILE_TYPES = {"sun": ATMQ, "moon": LUNAR_ATMQ}
_LINES, _SKY = 200, 48  # on which tables in channels are measured, whose nodes were placed on others
_SHARED_LINES, _SHARED_SKY = 80, 24  # the same for each of many states that share nodes: they err alike
CHANNEL_TYPES = {"sun": ATMQ_CHANNELS, "moon": LUNAR_ATMQ_CHANNELS}


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
                (CHANNEL_TYPES if job.atmosphere_grid.in_channels else FILE_TYPES)[source],
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
                    **_own_axes(job),
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
        written, response = job.states[task.index - 1], response_of(job.bands[task.band - 1])
        state = over_ground(atmospheric_state(job.site, written), written, response, context.library)
        with report.stage("compile"):
            all_points = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
            compiled, origin = compiled_band(loaded, written, response, state, all_points)
        report.notes.append(f"{compiled.index.size} of {compiled.total_points} spectral points")
        report.notes.append(origin.value)
        if missed := _missed(compiled, job.accuracy.spectral_tolerance):
            report.notes.append(f"spectral_tolerance {job.accuracy.spectral_tolerance:g} is missed: {missed}")
        if compiled.dropped:
            report.notes.append(f"gases left out: {_gases_left_out(compiled)}")
        scope = path_scope(loaded)
        air = BandAtmosphere.of(state, compiled.band, scope=scope)
        bounds = Bounds.of(
            air.air,
            path_grid(job),
            irradiance_of_sources(job, compiled.band),
            compiled.band.radiance_weight,
        )
        left_out = Omission.of(job, job.sources, state, response, bounds)
        if left_out.particles:
            air = BandAtmosphere.of(left_out.without(state), compiled.band, scope=scope)
        for source in job.sources:
            lit = replace(air, air=replace(air.air, scatters=False)) if source in left_out.scattered else air
            text, kelvin = left_out.text(source, state), left_out.bound(source)
            notes = {
                "left_out": text or "none",
                "left_out_bound_kelvin": kelvin,
                "left_out_bound": kelvin * left_out.radiance,
                "spectral_tolerance": job.accuracy.spectral_tolerance,
                "spectral_tolerance_missed": missed or "none",
            }
            if text:
                report.notes.append(f"{source}: left out {text}")
            names = {"band": job.band_name(task.band), "date": job.site.date.isoformat()}
            tables = _SourceTables(loaded, written, source, lit, compiled, response, all_points)
            yield (tables.in_channels if job.atmosphere_grid.in_channels else tables.group)(names, notes, report)


def _scope(loaded: LoadedJob) -> dict[str, Any]:
    """What of the job, beside its axes, a table depends on where query limits trim it."""
    scope, job = path_scope(loaded), loaded.trimmed
    if job.query_limits is None:
        return {}
    return {"compiled_for": {"sources": job.sources, "path_share": scope.share}}


def _own_axes(job: Job) -> dict[str, Any]:
    """Nodes of single quantities, by axis, where they differ from those of the job's axes."""
    shared, own = job.atmosphere_axes(), {}
    for name in () if job.atmosphere_grid.in_channels else QUANTITIES:
        axes = job.atmosphere_axes(name)
        if axes != shared:
            own[name] = {axis: nodes for axis, nodes in axes.items() if nodes != shared[axis]}
    return {"own_axes": own} if own else {}


def _gases_left_out(compiled: CompiledBand) -> str:
    """Gases left out of a compiled band, with the largest change each makes in a transmittance."""
    return ", ".join(f"{gas} ({change:.1e})" for gas, change in compiled.dropped.items()) or "none"


def _missed(compiled: CompiledBand, tolerance: float) -> str:
    """Quantities of a compiled band whose error is beyond the tolerance, with their error; empty where none is."""
    errors = {kind: error["rms"] for kind, error in compiled.errors.items() if error["rms"] > tolerance}
    return ", ".join(f"{kind} ({error:.1e} rms)" for kind, error in errors.items())


@dataclass(frozen=True, eq=False)
class _SourceTables:
    """The tables of a state and a band with one source."""

    loaded: LoadedJob
    state: State
    source: str
    air: BandAtmosphere
    compiled: CompiledBand
    response: SpectralResponse
    every: BandPoints

    def group(self, names: dict[str, str], notes: dict[str, Any], report: TaskReport) -> Group:
        """The tables with their measured errors, arranged for writing."""
        job = self.loaded.trimmed
        base, band = path_grid(job), self.compiled.band
        irradiance = source_irradiance(job, self.source, band.wavenumber, band.width)
        with report.stage("grid"):
            placed = self._placed(base, irradiance)
        with report.stage("tables"):
            tables = {name: placement.table for name, placement in placed.items()}
            tables |= self._unplaced([name for name in QUANTITIES if name not in tables], irradiance)
        harmonics = None
        if job.ambient_harmonics:
            with report.stage("harmonics"):
                grid = tables["ambient_radiance"].grid
                harmonics = ambient_harmonics(self.air, grid, irradiance, job.ambient_harmonics)
        with report.stage("tables"):
            thermal = self._thermal(tables, irradiance, job.ambient_harmonics)
        with report.stage("accuracy"):
            measures = self._interpolation_errors(tables, base, irradiance)
            if harmonics is not None:
                measures.append(self._harmonic_errors(tables["ambient_radiance"], harmonics, base, irradiance))
        if placed:
            nodes = ", ".join(f"{name} {placement.table.values.size:,}" for name, placement in placed.items())
            report.notes.append(f"{self.source}: nodes that hold the tolerance: {nodes}")
        notes = notes | _placement_notes(job.atmosphere_grid, placed)
        attributes = self._attributes(names)
        accuracy = _accuracy(measures, self.compiled, job.accuracy.seed, notes)
        return atmq_group(tables, accuracy, attributes, harmonics, thermal)

    def in_channels(self, names: dict[str, str], notes: dict[str, Any], report: TaskReport) -> Group:
        """The tables in channels, on nodes that hold the job's tolerance, arranged for writing."""
        job, seed = self.loaded.trimmed, self.loaded.trimmed.accuracy.seed
        base, axes = path_grid(job), job.atmosphere_grid
        irradiance = source_irradiance(job, self.source, self.compiled.band.wavenumber, self.compiled.band.width)
        (text,) = set(axes.tolerances.values())
        scale, tolerance = self._scale(text, irradiance)
        channels = ChannelTables(
            self.air,
            base,
            irradiance,
            scale,
            tolerance,
            job.ambient_harmonics,
            seed,
            self._at_all_points(),
            band_wavelengths(self.response),
        )
        with report.stage("similar airs"):
            shared = shared_nodes(self.loaded, self.state, self.response, self.source, self.every)
        placed = None
        if shared is not None:
            with report.stage("accuracy"):
                probes = self._probes(base, irradiance, _SHARED_LINES, _SHARED_SKY)
            with report.stage("channels"):
                placed = channels.on_shared(shared, probes)
            report.notes.append(f"{self.source}: nodes of similar airs{'' if placed else ' do not hold'}")
        if placed is None:
            with report.stage("channels"):
                placed = channels.placed(axes.most_nodes)
            with report.stage("accuracy"):
                probes = self._probes(base, irradiance, _LINES, _SKY)
        with report.stage("accuracy"):
            measures = probes.measured(quantities_of(placed.table), *self._scales(irradiance))
            if job.ambient_harmonics:
                faces = FaceProbes.drawn(self.air, base, irradiance, random_stream(seed, Stream.TILTED_FACES))
                own, kelvin, percent = (
                    faces.errors_in_channels(placed.table, scale) for scale in (None, *self._scales(irradiance))
                )
                measures.append(measure(AMBIENT_HARMONICS, own, kelvin, percent, regions=faces.regions()))
        report.notes.append(f"{self.source}: {channels.words(placed)}")
        notes = notes | {"tolerance": text} | channels.notes(placed)
        accuracy = _accuracy(measures, self.compiled, seed, notes)
        root = placed.table.root
        return replace(root, groups={"accuracy": accuracy}, attributes=self._attributes(names) | root.attributes)

    def _probes(self, base: PathGrid, irradiance: npt.NDArray[np.float64], lines: int, sky: int) -> Probes:
        """Random lines of sight on which tables in channels are measured."""
        generator, scope = random_stream(self.loaded.trimmed.accuracy.seed, Stream.ATMOSPHERE_ERROR), self.air.scope
        return Probes.drawn(self.air, base, irradiance, generator, sky=scope.lines(sky), count=scope.lines(lines))

    def _at_all_points(self) -> tuple[SpectralAir, PartedLight]:
        """The air of the tables at all points of the band, and the light there."""
        every = self.every
        air = SpectralAir.of(self.air.air.state, every.points, every.gases, every.weight)
        irradiance = source_irradiance(self.loaded.trimmed, self.source, every.wavenumber, every.width)
        return air, PartedLight.of(every.wavenumber, every.radiance_weight, irradiance)

    def _attributes(self, names: dict[str, str]) -> dict[str, Any]:
        """Root attributes: source, state, band, and the ground where faces may be tilted."""
        edges = [self.response.lower, self.response.upper]
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
        return Scale.of_unit(unit, self.response, float(self.compiled.band.radiance_weight @ irradiance)), tolerance

    def _scales(self, irradiance: npt.NDArray[np.float64]) -> tuple[Scale, Scale]:
        """In what errors are stated beside the quantities' own units: kelvin and percent."""
        in_band = float(self.compiled.band.radiance_weight @ irradiance)
        return Scale.kelvin(self.response), Scale.of_unit("%", self.response, in_band)

    def _thermal(self, tables: dict[str, Gridded], irradiance: npt.NDArray[np.float64], count: int) -> ThermalLight:
        """The tables without the source, on its lowest elevation alone."""
        dark = np.zeros_like(irradiance)
        path, ambient = (_one_source(tables[name].grid) for name in ("path_radiance_ratio", "ambient_radiance"))
        paths = self.air.table(path, dark, wanted=("path_radiance_ratio",)).path_radiance_ratio
        light = self.air.table(ambient, dark, wanted=("ambient",)).ambient
        assert paths is not None and light is not None  # they are wanted
        coefficients = None
        if count:
            coefficients = ambient_harmonics(self.air, ambient, dark, count).radiance[..., 0, :]
        return ThermalLight(
            tables["path_radiance_ratio"].grid,
            tables["ambient_radiance"].grid,
            paths[..., 0, 0],
            light[..., 0],
            coefficients,
            dark_elevation(float(path.altitude_km[-1])),
        )

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

    def _placed(self, base: PathGrid, irradiance: npt.NDArray[np.float64]) -> dict[str, Placed]:
        """The quantities whose tolerance the job names, on axes that hold it."""
        axes, air = self.loaded.trimmed.atmosphere_grid, self.air
        scales = {name: self._scale(text, irradiance) for name, text in axes.tolerances.items()}
        if not scales:
            return {}
        return placed_grids(
            lambda grid, key: air.table(grid, irradiance, wanted=(key,)),
            lambda generator, key, count: Probes.drawn(
                air, base, irradiance, generator, sky=count if key == "ambient" else 0, count=count, wanted=(key,)
            ),
            base,
            scales,
            seed=self.loaded.trimmed.accuracy.seed,
            max_nodes=axes.most_nodes,
        )

    def _unplaced(self, names: list[str], irradiance: npt.NDArray[np.float64]) -> dict[str, Gridded]:
        """The quantities of these names on the axes that the job has for them, those that share all axes together."""
        groups: dict[tuple[tuple[float, ...], ...], list[str]] = {}
        for name in names:
            axes = self.loaded.trimmed.atmosphere_axes(name)
            groups.setdefault(tuple(map(tuple, axes.values())), []).append(name)
        tables: dict[str, Gridded] = {}
        for together in groups.values():
            grid = path_grid(self.loaded.trimmed, together[0])
            wanted = tuple(QUANTITIES[name][0] for name in together)
            tables |= Gridded.all_of(self.air.table(grid, irradiance, wanted=wanted), grid)
        return tables

    def _interpolation_errors(
        self, tables: dict[str, Gridded], base: PathGrid, irradiance: npt.NDArray[np.float64]
    ) -> list[ErrorMeasure]:
        """Tables against direct computation on random lines of the job's own axes, above the ground."""
        generator = random_stream(self.loaded.trimmed.accuracy.seed, Stream.ATMOSPHERE_ERROR)
        scope = self.air.scope
        probes = Probes.drawn(self.air, base, irradiance, generator, sky=scope.lines(AMBIENT), count=scope.lines(LINES))
        return probes.measured({name: tables[name] for name in QUANTITIES}, *self._scales(irradiance))

    def _harmonic_errors(
        self, level: Gridded, harmonics: AmbientHarmonics, base: PathGrid, irradiance: npt.NDArray[np.float64]
    ) -> ErrorMeasure:
        """Faces read from the tables of harmonics against the integral over their hemispheres, on random lines."""
        generator = random_stream(self.loaded.trimmed.accuracy.seed, Stream.TILTED_FACES)
        faces = FaceProbes.drawn(self.air, base, irradiance, generator)
        own, kelvin, percent = (faces.errors(level, harmonics, scale) for scale in (None, *self._scales(irradiance)))
        return measure(AMBIENT_HARMONICS, own, kelvin, percent, regions=faces.regions())


def _one_source(grid: PathGrid) -> PathGrid:
    """The lines of sight of a grid with the lowest of its source elevations."""
    return PathGrid(grid.range_km, grid.altitude_km, grid.elevation_deg, grid.source_elevation_deg[:1], np.zeros(1))


def _placement_notes(axes: AtmosphereGrid, placed: dict[str, Placed]) -> dict[str, Any]:
    """What the file says of the axes that a tolerance has placed."""
    notes: dict[str, Any] = {}
    for name, placement in placed.items():
        notes[f"{name}_tolerance"] = axes.tolerances[name]
        notes[f"{name}_uniform_nodes"] = ", ".join(str(n) for n in placement.uniform)
        notes[f"{name}_uniform_over_placed_nodes"] = placement.ratio
    if "direct_radiance" in placed:
        notes["reads_on_the_horizon"] = placed["direct_radiance"].horizon_share
        notes["largest_error_on_the_horizon"] = placed["direct_radiance"].horizon_maximum
    if placed:
        notes["uniform_method"] = (
            "an estimate: equally spaced nodes (ranges in their logarithm) that are as good on each axis by itself"
        )
    return notes


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
        "method": (
            f"linear interpolation against direct computation above the ground, {DRAWN}; kelvin: change of a black body"
            " at 300 K seen through the path; a surface that reflects"
            f" {REFLECTANCE:g} faces sky and source; percent: of that black body's radiance, in bands that end before"
            " 2.5 um of the light that such a surface reflects of the source outside the atmosphere;"
            f" {AMBIENT_HARMONICS}: ambient radiance of faces in all directions, half of them beside walls"
        ),
        "spectral_points": int(compiled.index.size),
        "spectral_points_in_band": int(compiled.total_points),
        "gases_left_out": _gases_left_out(compiled),
        **left_out,
    }
    axes = {"spectral_quantity": Axis(np.array(kinds, object), "1", "in-band quantity whose spectral error is stated")}
    return accuracy_group(measures, spectral, axes, notes)
