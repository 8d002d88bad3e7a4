"""The ``.thermal_atmq`` database of a state and a band: where a job asks for weighted transmittance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.band.points import BandPoints, band_points
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.sampling import lines_in_cells, random_places
from skyshine.mat.measure.scale import Scale
from skyshine.mat.products.product import Context, TableIdentity, TaskReport
from skyshine.mat.quantities.emission import (
    EmissionClasses,
    beta_star_table,
    emission_beta_star,
    emission_weights,
    lines_of_sight,
)
from skyshine.mat.quantities.formulas import BETA_FACTOR, mean_transmittance
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.scene.atmosphere import atmospheric_state, materials_digest
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.grids import path_grid, path_scope
from skyshine.mat.scene.summary import state_attributes
from skyshine.mat.tables.axes import EXACT, AxisRule
from skyshine.mat.tables.band import PLANCK_TEMPERATURES
from skyshine.mat.tables.files import THERMAL_ATMQ
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.mat.tables.thermal import QUANTITY, thermal_group
from skyshine.schemas.hdf5 import Group

GROUPING_LINES = 200  # lines of sight by which materials are grouped
TEST_LINES = 400  # others, on which the table is measured
MATERIALS = "transmittance_of_materials"


class EmissionProduct:
    """Weighted transmittance of a state and a band."""

    def identity(self, context: Context) -> tuple[TableIdentity, ...]:
        """The one file of a state and a band."""
        task, job, library = context.task, context.loaded.trimmed, context.library
        scope = path_scope(context.loaded)
        resolved = {
            "site": job.site.model_dump(mode="json", exclude={"date"}),
            "state": job.states[task.index - 1].model_dump(mode="json", exclude={"date", "series"}),
            "band": {**job.bands[task.band - 1].model_dump(mode="json"), "name": job.band_name(task.band)},
            "water_continuum": job.water_continuum,
            "atmosphere_grid": _lists(path_grid(job, QUANTITY)),
            "grouped_on": _lists(path_grid(job)),
            **({"path_share": scope.share} if scope.is_part else {}),
            "accuracy": job.accuracy.model_dump(mode="json", include={"class_tolerance", "seed"}),
            "materials": list(context.materials),
            "materials_sha256": materials_digest(library, context.materials),
        }
        version = f"absorption {absorption_table().version}, materials {library.version}"
        return (TableIdentity(task.files[0], THERMAL_ATMQ, version, resolved),)

    def compute(self, context: Context, report: TaskReport) -> Iterator[Group]:
        """The classes of materials, and the table of each class."""
        task, job = context.task, context.loaded.trimmed
        state, response = atmospheric_state(job.site, job.states[task.index - 1]), response_of(job.bands[task.band - 1])
        materials, grid = [context.library[name] for name in context.materials], path_grid(job, QUANTITY)
        seed, tolerance, scope = job.accuracy.seed, job.accuracy.class_tolerance, path_scope(context.loaded)
        with report.stage("classes"):
            # All spectral points: those of a compiled band stand for absorption, not for the wavelengths at which
            # surfaces emit.
            band = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
            air = SpectralAir.of(state, band.points, band.gases, band.weight)
            micron = 1e4 / band.wavenumber
            reflectance = np.array([np.interp(micron, m.wavelength, m.reflectance) for m in materials])
            emission = _Emission(air, band, reflectance)
            classes = emission.classes(path_grid(job), tolerance, seed, scope.lines(GROUPING_LINES))
        with report.stage("tables"):
            beta, valid = emission.table(grid, classes)
        with report.stage("accuracy"):
            lines = scope.lines(TEST_LINES)
            measures = emission.errors(beta, grid, classes, Scale.kelvin(response), seed, lines)
        notes = {
            "seed": seed,
            "method": (
                "linear interpolation against direct computation on random lines of sight, as many in every cell,"
                f" above the ground, at random temperatures; {QUANTITY}: of the classes; {MATERIALS}: each material's"
                " own transmittance against that read of its class; kelvin: change of a black body at 300 K seen"
                " through the path"
            ),
            "class_tolerance": tolerance,
            "spectral_points": int(band.weight.size),
        }
        attributes = {
            **state_attributes(job.states[task.index - 1]),
            "band": job.band_name(task.band),
            "wavelength_um": [response.lower, response.upper],
        }
        report.notes.append(
            f"{len(materials)} materials in {classes.count} classes, within {classes.difference.max():.1e} of"
            " transmittance"
        )
        yield thermal_group(beta, valid, grid, materials, classes, accuracy_group(measures, {}, {}, notes), attributes)


def _lists(grid: PathGrid) -> dict[str, list[float]]:
    return {axis: nodes.tolist() for axis, nodes in _path_axes(grid).items()}


def _path_axes(grid: PathGrid) -> dict[str, np.ndarray]:
    return {"range": grid.range_km, "altitude": grid.altitude_km, "elevation": grid.elevation_deg}


@dataclass(frozen=True, eq=False)
class _Emission:
    """What M materials emit, through the air of a state, at all P points of a band: reflectance (M, P)."""

    air: SpectralAir
    band: BandPoints
    reflectance: npt.NDArray[np.float64]

    def classes(self, grid: PathGrid, tolerance: float, seed: int, lines: int) -> EmissionClasses:
        """Group the materials by what random lines of sight let through of them, at all temperatures."""
        altitude, elevation, ranges = lines_in_cells(grid, lines, random_stream(seed, Stream.EMISSION_CLASSES))
        weights = np.concatenate(
            [emission_weights(self.band, self.reflectance, kelvin) for kelvin in PLANCK_TEMPERATURES]
        )
        through = [
            np.exp(mean_transmittance(path.depth[path.valid], weights)[0])
            for path in lines_of_sight(self.air, ranges, altitude, elevation)
            if path.valid.any()
        ]
        count = len(self.reflectance)
        transmittance = np.concatenate(through) if through else np.zeros((0, len(weights)))
        return EmissionClasses.of(transmittance.reshape(-1, count), tolerance)

    def table(self, grid: PathGrid, classes: EmissionClasses) -> tuple[np.ndarray, np.ndarray]:
        """beta* (C, T, R, A, E) and validity (R, A, E)."""
        by_temperature = [
            classes.means(emission_weights(self.band, self.reflectance, kelvin)) for kelvin in PLANCK_TEMPERATURES
        ]
        weights = np.stack(by_temperature, axis=1)
        beta, valid = beta_star_table(self.air, grid, weights.reshape(-1, weights.shape[-1]))
        return beta.reshape(*weights.shape[:2], *valid.shape), valid

    def errors(
        self, beta: np.ndarray, grid: PathGrid, classes: EmissionClasses, scale: Scale, seed: int, lines: int
    ) -> list[ErrorMeasure]:
        """The table read off its nodes against direct computation: for the classes, and for each material by itself."""
        generator = random_stream(seed, Stream.EMISSION_ERROR)
        altitude, elevation, ranges = lines_in_cells(grid, lines, generator)
        kelvin = random_places(PLANCK_TEMPERATURES, lines, generator)
        axes = {"planck_temperature": PLANCK_TEMPERATURES} | _path_axes(grid)
        rules = [
            AxisRule("class", np.arange(classes.count), EXACT),
            *(AxisRule(name, nodes) for name, nodes in axes.items()),
        ]
        in_units, in_transmittance, of_materials = [], [], []
        for number, path in enumerate(lines_of_sight(self.air, ranges, altitude, elevation)):
            weights = emission_weights(self.band, self.reflectance, kelvin[number])
            place = dict(
                zip(
                    axes,
                    (kelvin[number], ranges[number, path.valid, None], altitude[number], elevation[number]),
                    strict=True,
                )
            )
            read = interpolate(beta, rules, {"class": np.arange(classes.count)} | place)
            exact = emission_beta_star(self.air, path, classes.means(weights))[path.valid]
            seen = np.exp(-BETA_FACTOR * place["range"] / read)
            in_units.append((read - exact).ravel())
            in_transmittance.append((seen - np.exp(-BETA_FACTOR * place["range"] / exact)).ravel())
            of_materials.append(
                (seen[:, classes.number - 1] - np.exp(mean_transmittance(path.depth[path.valid], weights)[0])).ravel()
            )
        kelvin_per_transmittance = scale.background * scale.factor
        of_classes, of_each = np.concatenate(in_transmittance), np.concatenate(of_materials)
        return [
            measure(QUANTITY, np.concatenate(in_units), of_classes * kelvin_per_transmittance),
            measure(MATERIALS, of_each, of_each * kelvin_per_transmittance),
        ]
