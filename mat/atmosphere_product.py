"""The ``.atmq`` and ``.lunar_atmq`` databases of one state and one band."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np

from skyshine.mat.accuracy.atmospheric import REFLECTANCE, Scale
from skyshine.mat.accuracy.grids import RefinedGrid, refined_grid
from skyshine.mat.accuracy.interpolation import ErrorMeasure, accuracy_group, measure
from skyshine.mat.accuracy.probes import Probes
from skyshine.mat.accuracy.radiance import SHORTEST
from skyshine.mat.atmosphere.compile import BandPoints, CompiledBand, band_points, negligible
from skyshine.mat.band_cache import cached_compile_band
from skyshine.mat.job import Job, LoadedJob
from skyshine.mat.jobs.fields import tolerance_parts
from skyshine.mat.negligible import Negligible
from skyshine.mat.plan import LeftOut, Task
from skyshine.mat.products import Product, TaskReport
from skyshine.mat.quantities import AtmosphericQuantities, BandAtmosphere, PathGrid
from skyshine.mat.scene import absorption_table, atmospheric_state, response_of, source_irradiance
from skyshine.mat.tables.atmq import atmq_group
from skyshine.mat.tables.files import ATMQ, LUNAR_ATMQ, state_label
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
    grid, whole = path_grid(loaded.job), loaded.whole
    table = absorption_table(job.water_continuum)
    with report.stage("compile"):
        everything = band_points(table.points(*response.wavenumber_range), response)
        compiled, found = cached_compile_band(
            table,
            state,
            everything,
            path_grid(whole),
            _irradiance(whole, everything),
            tolerance=job.accuracy.spectral_tolerance,
            max_points=MAX_POINTS,
            seed=job.accuracy.seed,
        )
    report.notes.append(f"{compiled.index.size} of {compiled.total_points} spectral points")
    if found:
        report.notes.append("compiled band from the cache")
    if compiled.dropped:
        report.notes.append(f"gases left out: {_left_out(compiled)}")
    left_out = Negligible.of(job, whole.sources, state, response, compiled.bounds)
    air = BandAtmosphere.of(left_out.without(state), compiled.band)
    for source, product in products.items():
        own = replace(air, air=replace(air.air, scatters=False)) if source in left_out.scattered else air
        text, kelvin = left_out.text(source, state), left_out.bound(source)
        notes = {"left_out": text or "none", "left_out_bound_kelvin": kelvin, "left_out_bound": kelvin * left_out.radiance}
        if text:
            report.notes.append(f"{source}: left out {text}")
        _build_one(product, source, loaded, own, compiled, grid, response, report, notes)


def physics_left_out(loaded: LoadedJob) -> list[LeftOut]:
    """Points, gases, particles and scattered light that bands of states do not need, with what each changes at most.

    Of states of one air, the first stands for all but their light.
    """
    job, whole, grid = loaded.job, loaded.whole, path_grid(loaded.whole)
    bands, found, faint, known = {}, [], {}, {}
    for number in job.needed_bands:
        response = response_of(job.bands[number - 1])
        bands[number] = response, band_points(absorption_table(job.water_continuum).points(*response.wavenumber_range), response)
        found += _points(job, bands[number][1].weight.size, number)
    for (number, state), band in itertools.product(enumerate(job.states, 1), bands):
        key = band, state.model_dump_json(exclude={"date", "weather", "series"})
        place = f"{state_label(number, len(job.states))}b{band:02d}"
        air, (response, everything) = atmospheric_state(job.site, state), bands[band]
        irradiance = _irradiance(whole.of_state(number), everything)
        if key not in known:
            gases, bounds, scattering = negligible(
                air, everything, grid, irradiance, tolerance=job.accuracy.spectral_tolerance, seed=job.accuracy.seed
            )
            if gases:
                found.append(_gases(gases, place))
            known[key] = bounds, scattering
        bounds, scattering = known[key]
        bounds = replace(bounds, scattered=scattering.radiance(irradiance, everything.radiance_weight))
        left_out = Negligible.of(job, whole.sources, air, response, bounds)
        changes = {f"scattered light of the {source}": left_out.scattered[source] for source in job.sources if source in left_out.scattered}
        for what, change in (changes | {f"particles ({name})": change for name, change in left_out.names(air).items()}).items():
            faint.setdefault(what, []).append((change, change * left_out.radiance, place))
    return found + [_faint(what, cases) for what, cases in faint.items()]


_RESTORE_SPECTRUM = "a smaller accuracy.spectral_tolerance"


def _points(job: Job, count: int, band: int) -> list[LeftOut]:
    """Spectral points of a band, which has so many."""
    bound = f"about {job.accuracy.spectral_tolerance:g} of a value, rms; the file holds what is measured"
    what = f"all but {MAX_POINTS} or fewer of {count:,} spectral points in b{band:02d}"
    return [LeftOut(what, "a few stand for all", bound, _RESTORE_SPECTRUM)] if count > MAX_POINTS else []


def _gases(gases: dict[str, float], place: str) -> LeftOut:
    bound = f"at most {max(gases.values()):.1e} in transmittance"
    return LeftOut(f"{', '.join(gases)} in {place}", "they absorb less than the tolerance in this band", bound, _RESTORE_SPECTRUM)


def _faint(what: str, cases: list[tuple[float, float, str]]) -> LeftOut:
    """Particles or light that can be left out at some places."""
    kelvin, radiance, _ = max(cases)
    places = [place for *_, place in cases]
    more = f" and {len(places) - 3} more" if len(places) > 3 else ""
    return LeftOut(
        f"{what} in {', '.join(places[:3])}{more}", "too faint to be seen",
        f"at most {kelvin:.1e} K or {radiance:.1e} W m^-2 sr^-1 of what is seen", "a smaller accuracy.negligible_k; 0 leaves nothing out",
    )  # fmt: skip


def _irradiance(job: Job, band: BandPoints) -> np.ndarray:
    """Irradiance (B, P) of the job's sources outside the atmosphere at the points of a band."""
    return np.stack([source_irradiance(job, source, band.wavenumber, band.width) for source in job.sources])


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
                "band": job.bands[task.band - 1].model_dump(mode="json", exclude={"name"}),
                "source": source,
                "water_continuum": job.water_continuum,
                "atmosphere_grid": {
                    **job.atmosphere_grid.model_dump(mode="json"), "altitude_km": job.observer_altitudes_km
                },
                "accuracy": job.accuracy.model_dump(mode="json", include={"spectral_tolerance", "negligible_k", "seed"}),
                **scope,
            },
        )
        for source, name in zip(job.sources, task.files)
    }  # fmt: skip


def _scope(whole: Job) -> dict:
    return {"sources": whole.sources, **whole.atmosphere_grid.model_dump(mode="json"), "altitude_km": whole.observer_altitudes_km}


def _build_one(product, source, loaded, air, compiled: CompiledBand, base: PathGrid, response, report, left_out: dict) -> None:
    irradiance = source_irradiance(loaded.job, source, compiled.band.wavenumber, compiled.band.width)
    with report.stage("grid"):
        refined = _grid(loaded, air, base, irradiance, response)
        grid = refined.grid if refined else base
    with report.stage("tables"):
        quantities = air.table(grid, irradiance)
    with report.stage("accuracy"):
        measures = _interpolation_errors(air, quantities, grid, base, irradiance, response, loaded.job.accuracy.seed)
    with report.stage("write"):
        low, high = response.lower, response.upper
        attributes = {"source": source, "state": air.air.state.name, "wavelength_um": [low, high]}
        placed = dict(left_out)
        if refined:
            report.notes.append(f"{source}: {refined.cells:,} nodes hold {loaded.job.atmosphere_grid.tolerance}")
            placed |= {
                "tolerance": loaded.job.atmosphere_grid.tolerance,
                "uniform_nodes": ", ".join(str(n) for n in refined.uniform),
                "uniform_over_placed_nodes": refined.ratio,
                "reads_on_the_horizon": refined.horizon_share,
                "largest_error_on_the_horizon": refined.horizon_maximum,
            }
        accuracy = _accuracy(measures, compiled, loaded.job.accuracy.seed, placed)
        product.write(atmq_group(quantities, grid, accuracy, attributes))


def _left_out(compiled: CompiledBand) -> str:
    """Gases left out of a compiled band, with the largest change each makes in a transmittance."""
    return ", ".join(f"{gas} ({change:.1e})" for gas, change in compiled.dropped.items()) or "none"


def _grid(loaded, air: BandAtmosphere, base: PathGrid, irradiance, response) -> RefinedGrid | None:
    """The grid that holds the job's tolerance, where it names one."""
    axes, seed = loaded.job.atmosphere_grid, loaded.job.accuracy.seed
    if axes.tolerance is None:
        return None
    tolerance, unit = tolerance_parts(axes.tolerance)
    if unit == "K" and response.upper < SHORTEST:
        raise loaded.document.error(
            ("atmosphere_grid", "tolerance"),
            f"found '{axes.tolerance}' for {response.lower:g} to {response.upper:g} um; allowed: W m^-2 sr^-1 for bands that end before "
            f"{SHORTEST:g} um, where a scene at 300 K does not glow; write 0.01 W m^-2 sr^-1, say",
        )
    scale = Scale.kelvin(response) if unit == "K" else Scale.radiance(response)
    return refined_grid(
        lambda grid: air.table(grid, irradiance), lambda generator, sky: Probes.drawn(air, base, irradiance, generator, sky),
        base, scale, tolerance, seed=seed, most=axes.most_nodes,
    )  # fmt: skip


def _interpolation_errors(
    air: BandAtmosphere, table: AtmosphericQuantities, grid: PathGrid, base: PathGrid, irradiance, response, seed: int
) -> list[ErrorMeasure]:
    """Table against direct computation on random lines of the job's own axes, above the ground."""
    probes = Probes.drawn(air, base, irradiance, np.random.default_rng(seed))
    own, warm = (probes.errors(table, grid, scale) for scale in (None, Scale.kelvin(response)))
    return [measure(name, own[name], warm[name]) for name in own]


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
