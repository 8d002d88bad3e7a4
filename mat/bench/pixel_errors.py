"""Error of the pixel of a job's databases at many settings, all against the truth of the same scenes."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, TypeAlias

import numpy as np

from skyshine.mat.bench.rungs import Rung
from skyshine.mat.bench.thinned import value_counts
from skyshine.mat.budget.built_tables import Tables
from skyshine.mat.budget.pixel import PixelTruth, Scenes, temperature_among
from skyshine.mat.budget.sizes import kelvin_of, measures
from skyshine.mat.budget.truth import Prepared
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.job.own_materials import job_materials
from skyshine.mat.quantities.band_atmosphere import BandAtmosphere
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.grids import path_grid
from skyshine.schemas.arrays import Floats
from skyshine.schemas.quantity import quantity

MEASURES = ("rms", "p99", "maximum")
AirOf: TypeAlias = Callable[[Prepared], BandAtmosphere]


def unchanged(tables: Tables) -> Tables:
    """Tables as they were built."""
    return tables


@dataclass(frozen=True)
class Variant:
    """Tables whose pixel is measured.

    Attributes
    ----------
    name : str
    rung : Rung
        Built setting whose tables they are.
    tables : callable
        What is changed of them.
    steps : int or None
        Steps of the heat balance, by whose error the temperatures are changed.
    air : callable or None
        Coarser air, by whose light that of the tables is changed.
    """

    name: str
    rung: Rung
    tables: Callable[[Tables], Tables] = unchanged
    steps: int | None = None
    air: AirOf | None = None


@dataclass(frozen=True, eq=False)
class SetErrors:
    """Errors of the pixels of a state, a band and a source, (n, M) of n views and M materials, W m^-2 sr^-1.

    Attributes
    ----------
    state, band : int
        Counted from 1.
    source : str
    response : SpectralResponse
    radiance : (n, M) array
    averages : (n, M) array
        Error with exact tables.
    assigned : (M, M) array or None
        Share of the texels of each material that the textures assign to each material, where there are textures.
    errors : dict of str to (n, M) array
        By name of the variant.
    values : dict of str to (int, int)
        Numbers of values of atmosphere and temperatures in the tables of a variant.
    points : dict of str to (int, int)
        Spectral points of the air of the tables, and of the coarser air, of variants with such.
    seconds : dict of str to (float, float)
        Processor seconds of the fields of light of both.
    """

    state: int
    band: int
    source: str
    response: SpectralResponse
    radiance: Floats
    averages: Floats
    assigned: Floats | None
    errors: dict[str, Floats] = field(default_factory=dict)
    values: dict[str, tuple[int, int]] = field(default_factory=dict)
    points: dict[str, tuple[int, int]] = field(default_factory=dict)
    seconds: dict[str, tuple[float, float]] = field(default_factory=dict)

    def kelvin(self, error: Floats) -> Floats:
        """Errors as differences of equivalent temperature; not numbers below 2.5 um."""
        return kelvin_of(self.response, self.radiance, error)

    def share(self, error: Floats) -> Floats:
        """Errors over the mean radiance of the set."""
        share: Floats = error / self.radiance.mean()
        return share


def errors_of_band(
    loaded: LoadedJob, variants: Sequence[Variant], scenes: int, seed: int, number: tuple[int, int]
) -> list[SetErrors]:
    """Errors of the pixel of all variants in a state and a band, under each source that is above the horizon.

    Parameters
    ----------
    loaded : LoadedJob
        Job as written, with the states that are built: scenes lie inside its axes, which all settings have.
    variants : sequence of Variant
        Variants to measure; the first is that of the job as written.
    scenes, seed : int
        Views of each set, and what they are drawn with.
    number : (int, int)
        State and band.
    """
    prepared = Prepared.of(loaded, *number)
    airs: dict[AirOf, tuple[BandAtmosphere, float]] = {}

    def with_fields(air: AirOf) -> tuple[BandAtmosphere, float]:
        """Air with its fields of light, and the processor seconds that they took."""
        if air not in airs:
            atmosphere, begin = air(prepared), time.process_time()
            atmosphere.air.prepare()
            airs[air] = atmosphere, time.process_time() - begin
        return airs[air]

    found = []
    for source in loaded.trimmed.sources:
        rungs = dict.fromkeys(variant.rung for variant in variants)
        built = {rung: rung.tables(*number, source) for rung in rungs}
        tables = built[variants[0].rung]
        truth = _truth(prepared, tables, source, scenes, seed)
        if truth is None:
            continue
        of_set = SetErrors(*number, source, prepared.response, truth.radiance, truth.averages, tables.assigned_share)
        kelvin = temperature_among(tables, truth.scenes.views, truth.scenes.circumstances)
        light = cache(partial(truth.radiance_in, tables, kelvin))
        for variant in variants:
            changed = variant.tables(built[variant.rung])
            error = truth.error(changed, variant.steps)
            if variant.air is not None:
                pair = with_fields(_of_tables), with_fields(variant.air)
                error = error + light(pair[1][0]) - light(pair[0][0])
                usual, coarser = (air.band.weight.size for air, _ in pair)
                of_set.points[variant.name] = usual, coarser
                of_set.seconds[variant.name] = pair[0][1], pair[1][1]
            of_set.errors[variant.name], of_set.values[variant.name] = error, value_counts(changed)
        found.append(of_set)
    return found


def _of_tables(prepared: Prepared) -> BandAtmosphere:
    return prepared.reduced


def _truth(prepared: Prepared, tables: Tables, source: str, scenes: int, seed: int) -> PixelTruth | None:
    """The truth of one set of scenes; None where the axes leave no room for a view."""
    job = prepared.loaded.trimmed
    drawn = Scenes.drawn(
        prepared,
        job_materials(job.own_materials),
        tables.materials,
        path_grid(job),
        surface_axes(job),
        shades=tables.shades,
        source=source,
        scenes=scenes,
        seed=seed,
    )
    return None if drawn is None else PixelTruth.of(drawn, tables)


def surface_axes(job: Job) -> dict[str, Floats]:
    """Axes of the faces of scenes; times are the hours that scenes ask for, where the job limits them."""
    limits, grid = job.query_limits, job.surface_grid
    times = grid.times
    if limits is not None and limits.hours is not None:
        start, stop = limits.hours
        times = [start, stop + (24.0 if stop < start else 0.0)] if len(times) > 1 else times
    nodes = {"altitude": job.surface_altitudes_km, "azimuth": grid.azimuth_deg, "slope": grid.slope_deg, "time": times}
    return {name: np.asarray(values, float) for name, values in nodes.items()}


def described(sets: Sequence[SetErrors], name: str) -> dict[str, Any]:
    """Errors of a variant: of all sets of scenes together, by band, and of each set."""
    bands = dict.fromkeys(of_set.band for of_set in sets)
    return {
        "all": _together(sets, name),
        "bands": [_together([of_set for of_set in sets if of_set.band == band], name) for band in bands],
        "sets": [
            {"state": of_set.state, "source": of_set.source, "views": len(of_set.radiance)} | _together([of_set], name)
            for of_set in sets
        ],
    }


def _together(sets: Sequence[SetErrors], name: str) -> dict[str, Any]:
    """Errors of some sets together: of their pixels, and with exact tables, in kelvin and in shares of radiance."""
    bands = {of_set.band: of_set.response for of_set in sets}
    return {
        "bands": list(bands),
        "wavelengths": [quantity([response.lower, response.upper], "um") for response in bands.values()],
        "pixels": sum(of_set.radiance.size for of_set in sets),
        **_in_both_units(sets, [of_set.errors[name] for of_set in sets]),
        "exact_tables": _in_both_units(sets, [of_set.averages for of_set in sets]),
    }


def _in_both_units(sets: Sequence[SetErrors], errors: Sequence[Floats]) -> dict[str, Any]:
    """Measures in kelvin, of the sets that have thermal light, and in shares of radiance."""
    pairs = list(zip(sets, errors, strict=True))
    kelvin = [of_set.kelvin(error) for of_set, error in pairs]
    return {
        "temperature": _measures([values for values in kelvin if np.isfinite(values).all()], "K"),
        "share_of_radiance": _measures([of_set.share(error) for of_set, error in pairs], "1"),
    }


def _measures(values: Sequence[Floats], units: str) -> dict[str, Any] | None:
    """Rms, 99th percentile and maximum of errors; None where there are none."""
    if not values:
        return None
    by_name = measures(np.concatenate([array.ravel() for array in values]))
    return {name: quantity(by_name[name], units) for name in MEASURES}
