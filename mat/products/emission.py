"""The ``.thermal_atmq`` database of a state and a band: where a job asks for weighted transmittance."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints, band_points
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.measure.probes import lines_in_cells
from skyshine.mat.measure.sampling import random_places
from skyshine.mat.measure.scale import Scale
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import Product, TaskReport
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
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.tables.axes import EXACT, AxisRule
from skyshine.mat.tables.band import PLANCK_TEMPERATURES
from skyshine.mat.tables.files import THERMAL_ATMQ
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.mat.tables.thermal import QUANTITY, thermal_group
from skyshine.materials.library import load_library

GROUPING_LINES = 200  # lines of sight by which materials are grouped
TEST_LINES = 400  # others, on which the table is measured
MATERIALS = "transmittance_of_materials"


def run(
    task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool, report: TaskReport
) -> None:
    """Build the weighted transmittance of a state and a band; arguments as `products.run_task`."""
    job, library = loaded.job, load_library()
    product = Product(
        folder / task.files[0],
        THERMAL_ATMQ,
        f"absorption {absorption_table().version}, materials {library.version}",
        _resolved(task, loaded, library, materials),
    )
    if not fresh and product.is_there():
        report.kept = True
        return
    state, response = atmospheric_state(job.site, job.states[task.index - 1]), response_of(job.bands[task.band - 1])
    chosen, grid, seed = [library[name] for name in materials], path_grid(job), job.accuracy.seed
    with report.stage("classes"):
        # All spectral points: those of a compiled band stand for absorption, not for the wavelengths at which surfaces
        # emit.
        band = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
        air = SpectralAir.of(state, band.points, band.gases, band.weight)
        micron = 1e4 / band.wavenumber
        emission = _Emission(air, band, np.array([np.interp(micron, m.wavelength, m.reflectance) for m in chosen]))
        # Grouped on the paths of the whole job, so that no answer depends on what is left out.
        classes = emission.classes(path_grid(loaded.whole), job.accuracy.class_tolerance, seed)
    with report.stage("tables"):
        beta, valid = emission.table(grid, classes)
    with report.stage("accuracy"):
        measures = emission.errors(beta, grid, classes, Scale.kelvin(response), seed)
    with report.stage("write"):
        notes = {
            "seed": seed,
            "method": (
                "linear interpolation against direct computation on random lines of sight, as many in every cell,"
                f" above the ground, at random temperatures; {QUANTITY}: of the classes; {MATERIALS}: each material's"
                " own transmittance against that read of its class; kelvin: change of a black body at 300 K seen"
                " through the path"
            ),
            "class_tolerance": job.accuracy.class_tolerance,
            "spectral_points": int(band.weight.size),
        }
        attributes = {"state": state.name, "wavelength_um": [response.lower, response.upper]}
        product.write(
            thermal_group(beta, valid, grid, chosen, classes, accuracy_group(measures, {}, {}, notes), attributes)
        )
    report.notes.append(
        f"{len(chosen)} materials in {classes.count} classes, within {classes.difference.max():.1e} of transmittance"
    )


def _resolved(task: Task, loaded: LoadedJob, library, materials: tuple[str, ...]) -> dict:
    job = loaded.job
    return {
        "site": job.site.model_dump(mode="json", exclude={"date"}),
        "state": job.states[task.index - 1].model_dump(mode="json", exclude={"date", "series"}),
        "band": job.bands[task.band - 1].model_dump(mode="json", exclude={"name"}),
        "water_continuum": job.water_continuum,
        "atmosphere_grid": {axis: nodes.tolist() for axis, nodes in _path_axes(path_grid(job)).items()},
        "grouped_on": {axis: nodes.tolist() for axis, nodes in _path_axes(path_grid(loaded.whole)).items()},
        "accuracy": job.accuracy.model_dump(mode="json", include={"class_tolerance", "seed"}),
        "materials": list(materials),
        "materials_sha256": materials_digest(library, materials),
    }


def _path_axes(grid: PathGrid) -> dict[str, np.ndarray]:
    return {"range": grid.range_km, "altitude": grid.altitude_km, "elevation": grid.elevation_deg}


class _Emission:
    """What M materials emit, through the air of a state, at all points of a band."""

    def __init__(self, air: SpectralAir, band: BandPoints, reflectance: np.ndarray):
        self.air, self.band, self.reflectance = air, band, reflectance

    def classes(self, whole: PathGrid, tolerance: float, seed: int) -> EmissionClasses:
        """Group the materials by what random lines of sight let through of them, at all temperatures."""
        altitude, elevation, ranges = lines_in_cells(whole, GROUPING_LINES, np.random.default_rng([seed, 4]))
        weights = np.concatenate(
            [emission_weights(self.band, self.reflectance, kelvin) for kelvin in PLANCK_TEMPERATURES]
        )
        through = [
            np.exp(mean_transmittance(path.depth[path.valid], weights)[0])
            for path in lines_of_sight(self.air, ranges, altitude, elevation)
            if path.valid.any()
        ]
        count = len(self.reflectance)
        found = np.concatenate(through) if through else np.zeros((0, len(weights)))
        return EmissionClasses.of(found.reshape(-1, count), tolerance)

    def table(self, grid: PathGrid, classes: EmissionClasses) -> tuple[np.ndarray, np.ndarray]:
        """beta* (C, T, R, A, E) and validity (R, A, E)."""
        by_temperature = [
            classes.means(emission_weights(self.band, self.reflectance, kelvin)) for kelvin in PLANCK_TEMPERATURES
        ]
        weights = np.stack(by_temperature, axis=1)
        beta, valid = beta_star_table(self.air, grid, weights.reshape(-1, weights.shape[-1]))
        return beta.reshape(*weights.shape[:2], *valid.shape), valid

    def errors(
        self, beta: np.ndarray, grid: PathGrid, classes: EmissionClasses, scale: Scale, seed: int
    ) -> list[ErrorMeasure]:
        """The table read off its nodes against direct computation: for the classes, and for each material by itself."""
        generator = np.random.default_rng([seed, 5])
        altitude, elevation, ranges = lines_in_cells(grid, TEST_LINES, generator)
        kelvin = random_places(PLANCK_TEMPERATURES, TEST_LINES, generator)
        axes = {"planck_temperature": PLANCK_TEMPERATURES} | _path_axes(grid)
        rules = [
            AxisRule("class", np.arange(classes.count), EXACT),
            *(AxisRule(name, nodes) for name, nodes in axes.items()),
        ]
        own, warm, materials = [], [], []
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
            own.append((read - exact).ravel())
            warm.append((seen - np.exp(-BETA_FACTOR * place["range"] / exact)).ravel())
            materials.append(
                (seen[:, classes.number - 1] - np.exp(mean_transmittance(path.depth[path.valid], weights)[0])).ravel()
            )
        own, warm, materials = (np.concatenate(errors) for errors in (own, warm, materials))
        glow = scale.background * scale.factor
        return [measure(QUANTITY, own, warm * glow), measure(MATERIALS, materials, materials * glow)]
