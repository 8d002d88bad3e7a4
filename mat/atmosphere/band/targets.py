"""In-band quantities on a sample of a job's paths: the targets a band is fitted to, and the responses that test it.

The test is valid for all states of one air: radiation is linear in the emission of the ground and in the light of the
sources, so that both parts are stored by interval, in which both are constant.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.band.sample import NOWHERE, Sample, SampledLine
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.segments import Depths
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers

KINDS = ("transmittance", "path_thermal", "path_radiance", "sky_irradiance", "direct_irradiance")
DIRECT = KINDS[-1]
# Directions of the thermal sky.
_ZENITHS = 3
# K; of the ground whose radiance is the unit of `Responses.ground`.
GROUND = 300.0
# Points whose targets are computed together: the arrays of a path then fit into a processor's cache.
_CHUNK = 1024
# Light of the source, and products with the light on surfaces, up to so many of a line's ranges, which cost little more
# than one.
_LIT_RANGES = 4


Parts = dict[str, list[Floats]]  # arrays by quantity, to be concatenated


@dataclass(frozen=True, eq=False)
class Targets:
    """Targets of a sample to which a band is fitted, by quantity (`KINDS`).

    Attributes
    ----------
    mean : dict of (M,) arrays
        Means in band; without quantities that are 0 everywhere.
    at_points : (all M, C) array
        Values at the candidates, one quantity after another, in the measure of `BandPoints.weight` (per um).
    """

    mean: dict[str, Floats]
    at_points: Floats


@dataclass(frozen=True, eq=False)
class Responses:
    """In-band targets of a sample for every temperature of the ground and every light of the sources: both add in
    proportion.

    Attributes
    ----------
    wavenumber : (I,) array
        Wavenumber of each interval with points, cm^-1: ground emission and source irradiance are the same at all its
        points.
    interval_start : (I,) int array
        The first point of each interval.
    surface_temperature : float
        K, of the ground in `unlit`.
    unlit : dict of (M,) arrays
        Responses by quantity (`KINDS`), without light of a source.
    ground : dict of (M, I) arrays
        Difference that a ground at `GROUND` makes to one at 0 K.
    light : dict of (M, I) arrays
        Per unit of the source's irradiance.
    source : dict of (M,) int arrays
        Number of the source.
    region : dict of (M,) int arrays
        Regions, as in `SampledLine.region`.
    """

    wavenumber: Floats
    interval_start: Integers
    surface_temperature: float
    unlit: dict[str, Floats]
    ground: dict[str, Floats]
    light: dict[str, Floats]
    source: dict[str, Integers]
    region: dict[str, Integers]

    def mean(self, surface_temperature: float, irradiance: Floats, brightness: Floats) -> dict[str, Floats]:
        """In-band values (M,) by quantity, without quantities that are 0 everywhere.

        Parameters
        ----------
        surface_temperature : float
            K, of the ground.
        irradiance : (B, P) array
            Irradiance of the sources at the points, W m^-2 (cm^-1)^-1.
        brightness : (B,) array
            Direct light counts relative to it.

        Raises
        ------
        ValueError
            An irradiance is not the same at all points of an interval.
        """
        sources = irradiance[:, self.interval_start]
        if not np.allclose(
            np.repeat(sources, np.diff(self.interval_start, append=irradiance.shape[1]), axis=1),
            irradiance,
            rtol=1e-9,
            atol=0.0,
        ):
            raise ValueError("irradiance must be the same at all points of an interval")
        emission, reference, unit = (
            planck_wavenumber(self.wavenumber, t) for t in (surface_temperature, self.surface_temperature, GROUND)
        )
        means = {}
        for kind in KINDS:
            light = sources / brightness[:, None] if kind == DIRECT else sources
            sunlight = np.sum(self.light[kind] * light[self.source[kind]], axis=1)
            means[kind] = self.unlit[kind] + self.ground[kind] @ ((emission - reference) / unit) + sunlight
        return _without_dark(means)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Some targets (m, P) of a quantity, as the fields of `Responses`; ground or light is None where it is 0, region
    where it is `NOWHERE`.
    """

    kind: str
    unlit: Floats
    ground: Floats | None = None
    light: Floats | None = None
    source: Integers | None = None
    region: Integers | None = None

    def through(self, transmittance: Floats, indices: Integers, region: Integers) -> _Rows:
        """The rows at places (n,), counted cyclically, each times the transmittance (n, P) of a path to a region."""
        rows = indices % len(self.unlit)
        ground, light = (None if part is None else part[rows] * transmittance for part in (self.ground, self.light))
        source = None if self.source is None else self.source[rows]
        return _Rows(self.kind, self.unlit[rows] * transmittance, ground, light, source, region)


def fitted_and_tested(
    air: SpectralAir,
    weight: Floats,
    irradiance: Floats,
    brightness: Floats,
    fit: Sample,
    candidates: Integers,
    test: Sample,
) -> tuple[Targets, Responses]:
    """Targets of one sample and responses of another.

    Parameters
    ----------
    air : SpectralAir
        Air at all P points.
    weight : (P,) array
        `BandPoints.weight`.
    irradiance : (B, P) array
        Irradiance of the sources, W m^-2 (cm^-1)^-1.
    brightness : (B,) array
        Direct light counts relative to it.
    candidates : (C,) int array, increasing
        Points whose targets of `fit` are returned.

    Returns
    -------
    Targets, Responses
    """
    share = weight / weight.sum()
    columns = _columns(candidates)

    def part(start: int, end: int) -> tuple[tuple[Parts, Parts], Responses]:
        part_air = air.part(slice(start, end))
        light = irradiance[:, start:end]
        return (
            _fitted(part_air, share[start:end], light, brightness, fit, columns(start, end)),
            responses(part_air, share[start:end], test, len(irradiance)),
        )

    edges = _edges(air.optics.wavenumber)
    fitted, tested = zip(*parallel_map(part, edges[:-1], edges[1:]), strict=True)
    return _targets(fitted), _joined(tested, edges)


def fitted_targets(
    air: SpectralAir, weight: Floats, irradiance: Floats, brightness: Floats, fit: Sample, candidates: Integers
) -> Targets:
    """Targets of a sample; arguments as `fitted_and_tested`."""
    share = weight / weight.sum()
    columns = _columns(candidates)

    def part(start: int, end: int) -> tuple[Parts, Parts]:
        light = irradiance[:, start:end]
        return _fitted(air.part(slice(start, end)), share[start:end], light, brightness, fit, columns(start, end))

    edges = _edges(air.optics.wavenumber)
    return _targets(parallel_map(part, edges[:-1], edges[1:]))


def tested_responses(air: SpectralAir, weight: Floats, test: Sample, sources: int) -> Responses:
    """Responses of a sample at all points of a band of `weight` (P,)."""
    share = weight / weight.sum()

    def part(start: int, end: int) -> Responses:
        return responses(air.part(slice(start, end)), share[start:end], test, sources)

    edges = _edges(air.optics.wavenumber)
    return _joined(parallel_map(part, edges[:-1], edges[1:]), edges)


def _columns(candidates: Integers) -> Callable[[int, int], Integers]:
    """The candidates between two points, counted from the first of them."""
    return lambda start, end: candidates[(candidates >= start) & (candidates < end)] - start


def _targets(fitted: Sequence[tuple[Parts, Parts]]) -> Targets:
    """Targets from the means and the values at points of all groups of points."""
    mean = _without_dark({kind: _sum(np.concatenate(means[kind]) for means, _ in fitted) for kind in KINDS})
    columns = [values[KINDS[0]][0].shape[1] for _, values in fitted]
    at_points = np.empty((sum(rows.size for rows in mean.values()), sum(columns)))
    for end, count, (_, values) in zip(np.cumsum(columns), columns, fitted, strict=True):
        np.concatenate([rows for kind in mean for rows in values[kind]], out=at_points[:, end - count : end])
    return Targets(mean, at_points)


def responses(air: SpectralAir, share: Floats, sample: Sample, sources: int) -> Responses:
    """Responses of a sample.

    Parameters
    ----------
    air : SpectralAir
        Air at P points.
    share : (P,) array
        Weights of the points; those of the whole band sum to 1.
    sources : int
        Number of sources.
    """
    interval_start = _first_of_intervals(air.optics.wavenumber)
    unlit, ground, light = (_empty_parts() for _ in range(3))
    source, region = ({kind: list[Integers]() for kind in KINDS} for _ in range(2))
    for rows in _rows(air, sample, sources, with_ground=True):
        count = len(rows.unlit)
        unlit[rows.kind].append(rows.unlit @ share)
        for part, values in ((ground, rows.ground), (light, rows.light)):
            by_interval = (
                np.zeros((count, interval_start.size))
                if values is None
                else np.add.reduceat(values * share, interval_start, axis=1)
            )
            part[rows.kind].append(by_interval)
        source[rows.kind].append(np.zeros(count, int) if rows.source is None else rows.source)
        region[rows.kind].append(np.full(count, NOWHERE) if rows.region is None else rows.region)
    return Responses(
        air.optics.wavenumber[interval_start],
        interval_start,
        air.state.surface_temperature,
        {kind: np.concatenate(unlit[kind]) for kind in KINDS},
        {kind: np.concatenate(ground[kind]) for kind in KINDS},
        {kind: np.concatenate(light[kind]) for kind in KINDS},
        {kind: np.concatenate(source[kind]) for kind in KINDS},
        {kind: np.concatenate(region[kind]) for kind in KINDS},
    )


def _empty_parts() -> Parts:
    return {kind: [] for kind in KINDS}


def _sum(arrays: Iterable[Floats]) -> Floats:
    """Sum of arrays of one shape."""
    total: Floats = sum(arrays, start=np.zeros(()))
    return total


def _first_of_intervals(wavenumber: Floats) -> Integers:
    """First point (I,) of each interval, from the middle of each point's interval."""
    return np.flatnonzero(np.diff(wavenumber, prepend=np.nan) != 0)


def _edges(wavenumber: Floats) -> Integers:
    """Edges of the groups of points whose targets are computed together, each of whole intervals."""
    count, interval_start = wavenumber.size, _first_of_intervals(wavenumber)
    groups = 2 * -(-count // (2 * _CHUNK)) if count > _CHUNK // 2 else 1  # even in number, for threads in pairs
    equal = np.linspace(0, count, groups, endpoint=False)
    return np.append(np.unique(interval_start[np.searchsorted(interval_start, equal, side="right") - 1]), count)


def _joined(parts: Sequence[Responses], edges: Integers) -> Responses:
    """Responses at all points from those of the groups between edges."""
    unlit = {kind: _sum(part.unlit[kind] for part in parts) for kind in KINDS}
    ground, light = (
        {kind: np.concatenate([getattr(part, name)[kind] for part in parts], axis=1) for kind in KINDS}
        for name in ("ground", "light")
    )
    interval_start = np.concatenate(
        [part.interval_start + start for part, start in zip(parts, edges[:-1], strict=True)]
    )
    wavenumber = np.concatenate([part.wavenumber for part in parts])
    return replace(
        parts[0],
        wavenumber=wavenumber,
        interval_start=interval_start,
        unlit=unlit,
        ground=ground,
        light=light,
    )


def _without_dark(means: Mapping[str, Floats]) -> dict[str, Floats]:
    """The quantities that are not 0 everywhere."""
    return {kind: values for kind, values in means.items() if np.any(values > 0)}


def _fitted(
    air: SpectralAir, share: Floats, irradiance: Floats, brightness: Floats, sample: Sample, columns: Integers
) -> tuple[Parts, Parts]:
    """In-band means, and values at some of the points of `air`, each as lists by quantity."""
    means, at_points = _empty_parts(), _empty_parts()
    for rows in _rows(air, sample, len(irradiance)):
        values = rows.unlit
        if rows.light is not None:
            light = irradiance / brightness[:, None] if rows.kind == DIRECT else irradiance
            values = values + rows.light * light[rows.source]
        means[rows.kind].append(values @ share)
        at_points[rows.kind].append(values[:, columns])
    return means, at_points


def _rows(air: SpectralAir, sample: Sample, sources: int, with_ground: bool = False) -> Iterator[_Rows]:
    """Targets of a sample at the points of `air`, in several `_Rows`; with `with_ground` the response to the ground's
    emission too.
    """
    optics = air.optics
    per_micron = optics.wavenumber**2 * 1e-4
    dark = _over_emitting_ground(air) if with_ground and np.any(optics.aerosol_scattering) else None
    sky, beam = _from_above(air, dark, sample, sources, per_micron)
    yield sky
    yield beam
    extinction = optics.extinction.astype(np.float32)
    for number, line in enumerate(sample.lines):
        segments, node = line.segments, line.node
        depths = Depths(segments.column(extinction))
        transmittance = np.exp(-depths.cumulative[node].astype(float))
        yield _Rows("transmittance", transmittance, region=line.region)
        ranges = np.unique(np.linspace(node.size - 1, 0, _LIT_RANGES, endpoint=False).round().astype(int))
        region = np.tile(line.region[ranges], sources)
        if number % sample.emission_step == 0:
            within = (np.arange(segments.index.size) < node[:, None]).astype(np.float32)
            thermal = (within @ air.thermal_radiance(segments, depths)) * per_micron
            ground = None if dark is None else (within @ dark.thermal_radiance(segments, depths)) * per_micron
            yield _Rows("path_thermal", thermal, ground, region=line.region)
            if number % sample.scattering_step == 0:
                of_segments = air.scattered_light.of_segments(segments, depths, line.to_source, line.deflection)
                light = (within[ranges] @ of_segments) * per_micron
                of_ground = None if ground is None else np.tile(ground[ranges], (sources, 1))
                terms = np.tile(thermal[ranges], (sources, 1)), of_ground, np.tile(light, (sources, 1))
                yield _Rows("path_radiance", *terms, np.repeat(np.arange(sources), ranges.size), region)
        # The products of (20) and (36): sky light on the ground, and direct light at the end of the path, through it.
        yield sky.through(transmittance[ranges], number + ranges, line.region[ranges])
        direct = np.tile(_beam_at_ends(air, line, node[ranges]) * transmittance[ranges] * per_micron, (sources, 1))
        yield _Rows(DIRECT, np.zeros_like(direct), None, direct, np.repeat(np.arange(sources), ranges.size), region)


def _beam_at_ends(air: SpectralAir, line: SampledLine, node: Integers) -> Floats:
    """Transmittance (n, P) from the source to some ends of a line's segments."""
    depth = air.source_paths.optical_depth(line.segments.altitude[node], line.to_source[node])[:, 0]
    beam: Floats = np.exp(-depth.astype(float))
    return beam


def _from_above(
    air: SpectralAir, dark: SpectralAir | None, sample: Sample, sources: int, per_micron: Floats
) -> tuple[_Rows, _Rows]:
    """Rows of sky and direct irradiance at the sample's surfaces: all for the first source, then all for the next."""
    sky = sky_irradiance(air, sample.surface_altitude, sample.sky_elevation, zeniths=_ZENITHS)
    elevations = sample.sky_elevation.size
    thermal, ground = np.repeat(sky.thermal * per_micron, elevations, axis=0), None
    if dark is not None:
        by_ground = sky_irradiance(dark, sample.surface_altitude, np.zeros(0), zeniths=_ZENITHS).thermal
        ground = np.repeat(by_ground * per_micron, elevations, axis=0)
    transmittance = direct_transmittance(air.source_paths, sample.direct_altitude, sample.direct_elevation)
    scattered, direct = ((rows * per_micron).reshape(-1, per_micron.size) for rows in (sky.scattered, transmittance))

    def for_all_sources(kind: str, unlit: Floats, ground: Floats | None, light: Floats) -> _Rows:
        unlit, light = np.tile(unlit, (sources, 1)), np.tile(light, (sources, 1))
        ground = None if ground is None else np.tile(ground, (sources, 1))
        return _Rows(kind, unlit, ground, light, np.repeat(np.arange(sources), len(light) // sources))

    return (
        for_all_sources("sky_irradiance", thermal, ground, scattered),
        for_all_sources(DIRECT, np.zeros_like(direct), None, direct),
    )


def _over_emitting_ground(air: SpectralAir) -> SpectralAir:
    """The same air without emission, over a ground at `GROUND`."""
    optics = replace(air.optics, emission=np.zeros_like(air.optics.emission))
    return replace(air, state=replace(air.state, surface_temperature=GROUND), optics=optics)
