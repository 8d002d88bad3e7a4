"""The ``.atmq`` and ``.lunar_atmq`` databases of one state and one band."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from skyshine.mat.accuracy.atmospheric import REFLECTANCE, Scale
from skyshine.mat.accuracy.grids import Placed, placed_grids
from skyshine.mat.accuracy.interpolation import ErrorMeasure, accuracy_group, measure
from skyshine.mat.accuracy.probes import Probes
from skyshine.mat.accuracy.radiance import SHORTEST
from skyshine.mat.atmosphere.compile import BandPoints, CompiledBand, band_points, negligible_gases
from skyshine.mat.atmosphere.state import AtmosphericState
from skyshine.mat.band_cache import cached_compile_band
from skyshine.mat.job import Job, LoadedJob
from skyshine.mat.jobs.fields import tolerance_parts
from skyshine.mat.plan import LeftOut, Task
from skyshine.mat.products import Product, TaskReport
from skyshine.mat.quantities import BandAtmosphere, PathGrid
from skyshine.mat.scene import absorption_table, atmospheric_state, response_of, source_irradiance, usual_irradiance
from skyshine.mat.tables.atmq import atmq_group
from skyshine.mat.tables.files import ATMQ, LUNAR_ATMQ, state_label
from skyshine.mat.tables.gridded import QUANTITIES, Gridded
from skyshine.schemas.hdf5 import Axis, Group, Variable

MAX_POINTS = 64


def run(task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool, report: TaskReport) -> None:
    """Build the tables of a state and a band with each source of the job; arguments as `products.run_task`."""
    products = _products(task, loaded, folder)
    if not fresh and all(product.is_there() for product in products.values()):
        report.kept = True
        return
    job = loaded.job
    state, response = atmospheric_state(job.site, job.states[task.index - 1]), response_of(job.bands[task.band - 1])
    grid = path_grid(loaded.job)
    with report.stage("compile"):
        everything = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
        compiled, found = compiled_band(loaded, state, everything)
    report.notes.append(f"{compiled.index.size} of {compiled.total_points} spectral points")
    if found:
        report.notes.append("compiled band from the cache")
    if compiled.dropped:
        report.notes.append(f"gases left out: {_left_out(compiled)}")
    air = BandAtmosphere.of(state, compiled.band)
    for source, product in products.items():
        _build_one(product, source, loaded, air, compiled, grid, response, report)


def compiled_band(loaded: LoadedJob, state: AtmosphericState, everything: BandPoints) -> tuple[CompiledBand, bool]:
    """All points of a band reduced as a job asks for one of its states, on that state's day; and whether they came from the cache."""
    job, whole = loaded.job, loaded.whole
    own, usual = (
        np.stack([light(whole, source, everything.wavenumber, everything.width) for source in whole.sources])
        for light in (source_irradiance, usual_irradiance)
    )
    return cached_compile_band(
        absorption_table(job.water_continuum), state, everything, path_grid(whole), own, usual,
        tolerance=job.accuracy.spectral_tolerance, max_points=MAX_POINTS, seed=job.accuracy.seed,
    )  # fmt: skip


def gases_left_out(loaded: LoadedJob) -> list[LeftOut]:
    """Gases that no band of a state needs, with what each changes at most; of states of one air, the first stands for all."""
    job, grid, found, seen = loaded.job, path_grid(loaded.whole), [], set()
    for (number, state), (band_number, band) in itertools.product(enumerate(job.states, 1), enumerate(job.bands, 1)):
        key = band_number, state.model_dump_json(exclude={"date", "weather", "series"})
        if key in seen:
            continue
        seen.add(key)
        air, response = atmospheric_state(job.site, state), response_of(band)
        everything = band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
        gases = negligible_gases(
            air, everything, grid, tolerance=job.accuracy.spectral_tolerance, seed=job.accuracy.seed
        )
        if gases:
            place = f"{state_label(number, len(job.states))}b{band_number:02d}"
            largest = max(gases.values())
            found.append(
                LeftOut(
                    f"{', '.join(gases)} in {place}", "they absorb less than the tolerance in this band",
                    f"at most {largest:.1e} in transmittance", "a smaller accuracy.spectral_tolerance",
                )
            )  # fmt: skip
    return found


def path_grid(job: Job) -> PathGrid:
    """Axes of the atmospheric tables of a job."""
    axes = job.atmosphere_grid
    return PathGrid(
        axes.range_km, job.observer_altitudes_km, axes.elevation_deg, axes.source_elevation_deg, axes.source_azimuth_deg
    )


def _products(task: Task, loaded: LoadedJob, folder: Path) -> dict[str, Product]:
    job = loaded.job
    # The band is compiled on the paths of the whole job, so that no answer depends on what is left out.
    scope = {} if job.needs is None else {"compiled_for": _scope(loaded.whole)}
    kinds = {"sun": ATMQ, "moon": LUNAR_ATMQ}
    return {
        source: Product(
            folder / name,
            kinds[source],
            f"absorption {absorption_table().version}",
            {
                "site": job.site.model_dump(mode="json"),
                "state": job.states[task.index - 1].model_dump(mode="json", exclude={"date", "series"}),
                "band": job.bands[task.band - 1].model_dump(mode="json"),
                "source": source,
                "water_continuum": job.water_continuum,
                "atmosphere_grid": {
                    **job.atmosphere_grid.model_dump(mode="json"), "altitude_km": job.observer_altitudes_km
                },
                "accuracy": job.accuracy.model_dump(mode="json", include={"spectral_tolerance", "seed"}),
                **scope,
            },
        )
        for source, name in zip(job.sources, task.files)
    }  # fmt: skip


def _scope(whole: Job) -> dict:
    return {"sources": whole.sources, **whole.atmosphere_grid.model_dump(mode="json"), "altitude_km": whole.observer_altitudes_km}


def _build_one(product, source, loaded, air, compiled: CompiledBand, base: PathGrid, response, report) -> None:
    irradiance = source_irradiance(loaded.job, source, compiled.band.wavenumber, compiled.band.width)
    with report.stage("grid"):
        placed = _placed(loaded, air, base, irradiance, response)
    with report.stage("tables"):
        tables = {name: found.table for name, found in placed.items()}
        rest = tuple(key for name, (key, _) in QUANTITIES.items() if name not in tables)
        if rest:
            tables |= Gridded.all_of(air.table(base, irradiance, wanted=rest), base)
    with report.stage("accuracy"):
        measures = _interpolation_errors(air, tables, base, irradiance, response, loaded.job.accuracy.seed)
    with report.stage("write"):
        low, high = response.lower, response.upper
        attributes = {"source": source, "state": air.air.state.name, "wavelength_um": [low, high]}
        if placed:
            nodes = ", ".join(f"{name} {found.table.values.size:,}" for name, found in placed.items())
            report.notes.append(f"{source}: nodes that hold the tolerance: {nodes}")
        accuracy = _accuracy(measures, compiled, loaded.job.accuracy.seed, _notes(loaded.job.atmosphere_grid, placed))
        product.write(atmq_group(tables, accuracy, attributes))


def _left_out(compiled: CompiledBand) -> str:
    """Gases left out of a compiled band, with the largest change each makes in a transmittance."""
    return ", ".join(f"{gas} ({change:.1e})" for gas, change in compiled.dropped.items()) or "none"


def _placed(loaded, air: BandAtmosphere, base: PathGrid, irradiance, response) -> dict[str, Placed]:
    """The quantities whose tolerance the job names, on axes that hold it."""
    axes = loaded.job.atmosphere_grid
    scales = {}
    for name, text in axes.tolerances.items():
        tolerance, unit = tolerance_parts(text)
        if unit == "K" and response.upper < SHORTEST:
            raise loaded.document.error(
                ("atmosphere_grid", "tolerance"),
                f"found '{text}' for {response.lower:g} to {response.upper:g} um; allowed: W m^-2 sr^-1 for bands that end before "
                f"{SHORTEST:g} um, where a scene at 300 K does not glow; write 0.01 W m^-2 sr^-1, say",
            )
        scales[name] = (Scale.kelvin(response) if unit == "K" else Scale.radiance(response)), tolerance
    if not scales:
        return {}
    return placed_grids(
        lambda grid, key: air.table(grid, irradiance, wanted=(key,)),
        lambda generator, sky: Probes.drawn(air, base, irradiance, generator, sky),
        base, scales, seed=loaded.job.accuracy.seed, most=axes.most_nodes,
    )  # fmt: skip


def _notes(axes, placed: dict[str, Placed]) -> dict:
    """What the file says of the axes that a tolerance has placed."""
    notes = {}
    for name, found in placed.items():
        notes[f"{name}_tolerance"] = axes.tolerances[name]
        notes[f"{name}_uniform_over_placed_nodes"] = found.ratio
    if "direct_radiance" in placed:
        notes["reads_on_the_horizon"] = placed["direct_radiance"].horizon_share
        notes["largest_error_on_the_horizon"] = placed["direct_radiance"].horizon_maximum
    if placed:
        notes["uniform_nodes"] = "an estimate: equally spaced nodes that are as good on each axis by itself, multiplied, over those placed"
    return notes


def _interpolation_errors(air: BandAtmosphere, tables: dict[str, Gridded], base: PathGrid, irradiance, response, seed: int) -> list[ErrorMeasure]:
    """Tables against direct computation on random lines of the job's own axes, above the ground."""
    probes = Probes.drawn(air, base, irradiance, np.random.default_rng(seed))
    own, warm = (probes.errors(tables, scale) for scale in (None, Scale.kelvin(response)))
    return [measure(name, own[name], warm[name]) for name in QUANTITIES]


def _accuracy(measures: list[ErrorMeasure], compiled: CompiledBand, seed: int, placed: dict) -> Group:
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
        "method": "linear interpolation against direct computation on random lines of sight, as many in every cell, above the ground; "
        f"kelvin: change of a black body at 300 K seen through the path; a surface that reflects {REFLECTANCE:g} faces sky and source",
        "spectral_points": int(compiled.index.size),
        "spectral_points_in_band": int(compiled.total_points),
        "gases_left_out": _left_out(compiled),
        **placed,
    }
    axes = {"spectral_quantity": Axis(np.array(kinds, object), "1", "in-band quantity whose spectral error is stated")}
    return accuracy_group(measures, spectral, axes, notes)
