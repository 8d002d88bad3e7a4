"""Error of the pixel of a job's databases at many settings, all against the truth of the same scenes."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property, partial
from itertools import product
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from skyshine.mat.bench.rungs import Rung, job_digest
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.pixel import PixelTruth, Scenes
from skyshine.mat.budget.sizes import kelvin_of, measures
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.builder.executors import open_executor
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.grids import path_grid
from skyshine.mat.threads import VARIABLE, core_count
from skyshine.materials.library import MaterialLibrary, load_library
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import CheckFailed
from skyshine.schemas.kept_arrays import CACHE_VARIABLE
from skyshine.schemas.quantity import quantity
from skyshine.schemas.whole_files import write_whole

_SURFACE = ("altitude", "azimuth", "slope")
MEASURES = ("rms", "p99", "maximum")


@dataclass(eq=False)
class Truths:
    """The whole truth of random scenes of a job, computed once for all settings.

    Attributes
    ----------
    loaded : LoadedJob
        Job as written, with the states that are built.
    jobs : sequence of Job
        Jobs at all settings: scenes lie inside the axes of each.
    scenes, seed : int
        Views of each state, band and source, and what they are drawn with.
    folder : Path
        Keeps the radiances, for the next run.
    say : callable
        Called with a line of text that says what is computed.
    prepared : dict of (int, int) to Prepared
        Prepared atmospheres by state and band, as far as they were needed.
    """

    loaded: LoadedJob
    jobs: Sequence[Job]
    library: MaterialLibrary
    scenes: int
    seed: int
    folder: Path
    say: Callable[[str], object]
    prepared: dict[tuple[int, int], Prepared] = field(default_factory=dict)
    _cache: dict[tuple[int, int, str], PixelTruth | None] = field(default_factory=dict)

    @cached_property
    def grid(self) -> PathGrid:
        """Nodes of the job as it is written, between the ends that all settings have."""
        grids = [path_grid(job) for job in [self.loaded.trimmed, *self.jobs]]
        return PathGrid(*(_common([getattr(grid, axis.name) for grid in grids]) for axis in fields(PathGrid)))

    @cached_property
    def surface_axes(self) -> dict[str, Floats]:
        """The same of the temperature table; times are the hours that scenes ask for, where the job limits them."""
        axes = [_surface_axes(job) for job in [self.loaded.trimmed, *self.jobs]]
        ends = {name: _common([job_axes[name] for job_axes in axes]) for name in ("altitude", "slope")}
        return axes[0] | ends

    @cached_property
    def key(self) -> str:
        """Key of the job and the scenes: errors on equal keys may be compared."""
        nodes = [getattr(self.grid, axis.name).tolist() for axis in fields(PathGrid)]
        nodes += [self.surface_axes[name].tolist() for name in (*_SURFACE, "time")]
        return job_digest(self.loaded, "exact tables", [self.scenes, self.seed, nodes])

    def of(self, state: int, band: int, source: str, tables: Tables) -> PixelTruth | None:
        """The truth of one set of scenes; None where the axes leave no room for a view.

        Parameters
        ----------
        tables : Tables
            Tables of any setting: materials, and their lobes.
        """
        key = state, band, source
        if key not in self._cache:
            if key[:2] not in self.prepared:
                self.prepared[key[:2]] = Prepared.of(self.loaded, state, band)
            scenes = Scenes.drawn(
                self.prepared[key[:2]],
                self.library,
                tables.materials,
                self.grid,
                self.surface_axes,
                shades=tables.shades,
                source=source,
                scenes=self.scenes,
                seed=self.seed,
            )
            self._cache[key] = None if scenes is None else self._computed(scenes, tables, f"s{state}b{band}{source}")
        return self._cache[key]

    def _computed(self, scenes: Scenes, tables: Tables, name: str) -> PixelTruth:
        """The truth of scenes: that of an earlier run where it was of the same job and scenes."""
        file, materials = self.folder / f"{name}.json", list(tables.materials)
        try:
            stored = json.loads(file.read_text(encoding="utf-8"))
            if stored["key"] == self.key and stored["materials"] == materials:
                return PixelTruth(scenes, np.array(stored["radiance"], float), np.array(stored["averages"], float))
        except (OSError, ValueError, KeyError, TypeError):
            pass  # none, or damaged: computed again
        self.say(f"computing the truth of {name}")
        truth = PixelTruth.of(scenes, tables)
        self.folder.mkdir(parents=True, exist_ok=True)
        values = {"radiance": truth.radiance.tolist(), "averages": truth.averages.tolist()}
        stored = {"key": self.key, "materials": materials, **values}
        write_whole(file, json.dumps(stored) + "\n")
        return truth


def _surface_axes(job: Job) -> dict[str, Floats]:
    limits, grid = job.query_limits, job.surface_grid
    times = grid.times
    if limits is not None and limits.hours is not None:
        start, stop = limits.hours
        times = [start, stop + (24.0 if stop < start else 0.0)] if len(times) > 1 else times
    nodes = job.surface_altitudes_km, grid.azimuth_deg, grid.slope_deg, times
    return {name: np.asarray(values, float) for name, values in zip((*_SURFACE, "time"), nodes, strict=True)}


def _common(axes: Sequence[Floats]) -> Floats:
    """Nodes of the first of some axes between the ends that all of them have.

    Raises
    ------
    CheckFailed
        They have no place in common.
    """
    low, high = max(axis[0] for axis in axes), min(axis[-1] for axis in axes)
    if low > high:
        raise CheckFailed(f"axes that end at {high:g} and begin at {low:g} have no scene in common")
    nodes = axes[0]
    return np.unique([low, high, *nodes[(nodes > low) & (nodes < high)]])


TablesOf: TypeAlias = Callable[[int, int, str], Tables]  # tables of a state, a band and a source
AirOf: TypeAlias = Callable[[Prepared], BandAtmosphere]


def measure(rung: Rung, truths: Truths) -> None:
    """Measure the pixel of a rung's databases, unless it is known on these scenes already.

    Raises
    ------
    InputError
        A database is missing or does not belong to the job.
    """
    if rung.errors.get("key") != truths.key:
        rung.errors = {"key": truths.key, **errors_of(truths, rung.tables)}
        rung.keep()


def errors_of(truths: Truths, tables: TablesOf, steps: int | None = None, air: AirOf | None = None) -> dict[str, Any]:
    """Errors of the pixel of some tables: of all sets of scenes together, by band, and of each set.

    Parameters
    ----------
    steps : int, optional
        Steps of the heat balance, by whose error the temperatures in the tables are changed.
    air : callable, optional
        Coarser air, by whose light that of the tables is changed.
    """
    job = truths.loaded.trimmed
    sets: list[dict[str, Any]] = []
    errors: list[_SetErrors] = []
    for state, band, source in sets_of(job):
        of_source = tables(state, band, source)
        truth = truths.of(state, band, source, of_source)
        if truth is None:
            continue
        prepared = truths.prepared[state, band]
        airs = None if air is None else (prepared.reduced, air(prepared))
        of_set = _SetErrors(band, prepared.response, truth, truth.error(of_source, steps, airs))
        errors.append(of_set)
        sets.append({"state": state, "source": source, "views": len(truth.scenes.views), **_described([of_set])})
    bands = [[scene_error for scene_error in errors if scene_error.band == band] for band in job.needed_bands]
    return {
        "all": _described(errors),
        "bands": [_described(of_band) for of_band in bands if of_band],
        "sets": sets,
    }


def sets_of(job: Job) -> Iterator[tuple[int, int, str]]:
    """State, band and source of each set of scenes."""
    return product(range(1, len(job.states) + 1), job.needed_bands, job.sources)


def compute_truths(truths: Truths, rung: Rung) -> None:
    """Compute the truth of all sets of scenes and keep it, each band of a state in a process of its own.

    Parameters
    ----------
    rung : Rung
        Any that is built, with its cache.
    """
    job = truths.loaded.trimmed
    numbers = list(product(range(1, len(job.states) + 1), job.needed_bands))
    variables = {CACHE_VARIABLE: str(rung.cache), VARIABLE: "1"}
    settings = truths.loaded, truths.jobs, truths.scenes, truths.seed, truths.folder
    with open_executor(None, min(len(numbers), core_count()), truths.folder, variables) as pool:
        list(pool.map(partial(_compute, settings, rung), numbers))


def _compute(settings: tuple[LoadedJob, Sequence[Job], int, int, Path], rung: Rung, number: tuple[int, int]) -> None:
    loaded, jobs, scenes, seed, folder = settings
    truths = Truths(loaded, jobs, load_library(), scenes, seed, folder, lambda _: None)
    for source in loaded.trimmed.sources:
        truths.of(*number, source, rung.tables(*number, source))


@dataclass(frozen=True, eq=False)
class _SetErrors:
    """Errors of the pixels of a band under one state and source, W m^-2 sr^-1."""

    band: int
    response: SpectralResponse
    truth: PixelTruth
    error: Floats

    def kelvin(self, error: Floats) -> Floats:
        """As differences of equivalent temperature; not numbers below 2.5 um."""
        return kelvin_of(self.response, self.truth.radiance, error)

    def share(self, error: Floats) -> Floats:
        """Share of the mean radiance of the set."""
        share: Floats = error / self.truth.radiance.mean()
        return share


def _described(errors: Sequence[_SetErrors]) -> dict[str, Any]:
    """Errors of some sets together: of their pixels, and with exact tables, in kelvin and in shares of radiance."""
    thermal = [scene_error for scene_error in errors if np.isfinite(scene_error.kelvin(scene_error.error)).all()]
    bands = {scene_error.band: scene_error.response for scene_error in errors}
    return {
        "bands": list(bands),
        "wavelengths": [quantity([response.lower, response.upper], "um") for response in bands.values()],
        "pixels": sum(scene_error.error.size for scene_error in errors),
        "temperature": _measures([scene_error.kelvin(scene_error.error) for scene_error in thermal], "K"),
        "share_of_radiance": _measures([scene_error.share(scene_error.error) for scene_error in errors], "1"),
        "exact_tables": {
            "temperature": _measures([scene_error.kelvin(scene_error.truth.averages) for scene_error in thermal], "K"),
            "share_of_radiance": _measures(
                [scene_error.share(scene_error.truth.averages) for scene_error in errors], "1"
            ),
        },
    }


def _measures(values: Sequence[Floats], units: str) -> dict[str, Any] | None:
    """Rms, 99th percentile and maximum of errors; None where there are none."""
    if not values:
        return None
    by_name = measures(np.concatenate([array.ravel() for array in values]))
    return {name: quantity(by_name[name], units) for name in MEASURES}
