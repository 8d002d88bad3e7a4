"""The ``.atmq`` and ``.lunar_atmq`` databases of one state and one band."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from skyshine.mat.atmosphere.band.compile import CompiledBand
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.transfer.bounds import Bounds
from skyshine.mat.job.fields import tolerance_parts
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.measure.atmosphere_nodes import Placed, placed_grids
from skyshine.mat.measure.probes import Probes
from skyshine.mat.measure.scale import REFLECTANCE, Scale
from skyshine.mat.plan.plan import Task
from skyshine.mat.products.product import Product, TaskReport
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.equivalent_temperature import SHORTEST
from skyshine.mat.scene.atmosphere import atmospheric_state
from skyshine.mat.scene.bands import absorption_table, response_of
from skyshine.mat.scene.compiled import compiled_band
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.scene.omission import Omission
from skyshine.mat.scene.sources import irradiance_of_sources, source_irradiance
from skyshine.mat.tables.atmq import atmq_group
from skyshine.mat.tables.files import ATMQ, LUNAR_ATMQ
from skyshine.mat.tables.gridded import QUANTITIES, Gridded
from skyshine.mat.tables.stated_error import ErrorMeasure, accuracy_group, measure
from skyshine.schemas.hdf5 import Axis, Group, Variable


def run(
    task: Task, loaded: LoadedJob, folder: Path, materials: tuple[str, ...], fresh: bool, report: TaskReport
) -> None:
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
        compiled, origin = compiled_band(loaded, state, everything)
    report.notes.append(f"{compiled.index.size} of {compiled.total_points} spectral points")
    report.notes.append(origin.value)
    if compiled.dropped:
        report.notes.append(f"gases left out: {_left_out(compiled)}")
    air, whole = BandAtmosphere.of(state, compiled.band), loaded.whole
    most = Bounds.of(
        air.air, path_grid(whole), irradiance_of_sources(whole, compiled.band), compiled.band.radiance_weight
    )
    left_out = Omission.of(job, whole.sources, state, response, most)
    if left_out.particles:
        air = BandAtmosphere.of(left_out.without(state), compiled.band)
    for source, product in products.items():
        own = replace(air, air=replace(air.air, scatters=False)) if source in left_out.scattered else air
        text, kelvin = left_out.text(source, state), left_out.bound(source)
        notes = {
            "left_out": text or "none",
            "left_out_bound_kelvin": kelvin,
            "left_out_bound": kelvin * left_out.radiance,
        }
        if text:
            report.notes.append(f"{source}: left out {text}")
        _build_one(product, source, loaded, own, compiled, grid, response, report, notes)


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
                "band": job.bands[task.band - 1].model_dump(mode="json", exclude={"name"}),
                "source": source,
                "water_continuum": job.water_continuum,
                "atmosphere_grid": {
                    **job.atmosphere_grid.model_dump(mode="json"),
                    "altitude_km": job.observer_altitudes_km,
                },
                "accuracy": job.accuracy.model_dump(
                    mode="json", include={"spectral_tolerance", "negligible_k", "seed"}
                ),
                **scope,
            },
        )
        for source, name in zip(job.sources, task.files, strict=True)
    }


def _scope(whole: Job) -> dict:
    return {
        "sources": whole.sources,
        **whole.atmosphere_grid.model_dump(mode="json"),
        "altitude_km": whole.observer_altitudes_km,
    }


def _build_one(
    product, source, loaded, air, compiled: CompiledBand, base: PathGrid, response, report, left_out: dict
) -> None:
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
        accuracy = _accuracy(
            measures, compiled, loaded.job.accuracy.seed, left_out | _notes(loaded.job.atmosphere_grid, placed)
        )
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
                f"found '{text}' for {response.lower:g} to {response.upper:g} um; allowed: W m^-2 sr^-1 for bands that"
                f" end before {SHORTEST:g} um, where a scene at 300 K does not glow; write 0.01 W m^-2 sr^-1, say",
            )
        scales[name] = (Scale.kelvin(response) if unit == "K" else Scale.radiance(response)), tolerance
    if not scales:
        return {}
    return placed_grids(
        lambda grid, key: air.table(grid, irradiance, wanted=(key,)),
        lambda generator, key, count: Probes.drawn(
            air, base, irradiance, generator, sky=count if key == "ambient" else 0, count=count, wanted=(key,)
        ),
        base,
        scales,
        seed=loaded.job.accuracy.seed,
        max_nodes=axes.most_nodes,
    )


def _notes(axes, placed: dict[str, Placed]) -> dict:
    """What the file says of the axes that a tolerance has placed."""
    notes = {}
    for name, found in placed.items():
        notes[f"{name}_tolerance"] = axes.tolerances[name]
        notes[f"{name}_uniform_nodes"] = ", ".join(str(n) for n in found.uniform)
        notes[f"{name}_uniform_over_placed_nodes"] = found.ratio
    if "direct_radiance" in placed:
        notes["reads_on_the_horizon"] = placed["direct_radiance"].horizon_share
        notes["largest_error_on_the_horizon"] = placed["direct_radiance"].horizon_maximum
    if placed:
        notes["uniform_method"] = (
            "an estimate: equally spaced nodes (ranges in their logarithm) that are as good on each axis by itself"
        )
    return notes


def _interpolation_errors(
    air: BandAtmosphere, tables: dict[str, Gridded], base: PathGrid, irradiance, response, seed: int
) -> list[ErrorMeasure]:
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
        "method": (
            "linear interpolation against direct computation on random lines of sight, as many in every cell, above"
            " the ground; kelvin: change of a black body at 300 K seen through the path; a surface that reflects"
            f" {REFLECTANCE:g} faces sky and source"
        ),
        "spectral_points": int(compiled.index.size),
        "spectral_points_in_band": int(compiled.total_points),
        "gases_left_out": _left_out(compiled),
        **placed,
    }
    axes = {"spectral_quantity": Axis(np.array(kinds, object), "1", "in-band quantity whose spectral error is stated")}
    return accuracy_group(measures, spectral, axes, notes)
