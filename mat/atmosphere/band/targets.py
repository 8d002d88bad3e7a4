"""What the points of a band give on a sample of a job's paths: the targets a band is fitted to, and what it is tested
on.

The test holds for all states of one air: radiation is linear in what the ground emits and in the light of the sources,
so that their parts are kept by interval, in which both are the same.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.transfer import segments as transfer
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map

KINDS = ("transmittance", "path_thermal", "path_radiance", "sky_irradiance", "direct_irradiance")
DIRECT = KINDS[-1]
# Directions of the sky. The cells of their quadrature take the mean of the phase function, and nothing else changes
# with azimuth but through the curvature of the Earth.
_ZENITHS, _AZIMUTHS = 4, 1
# K; of the ground whose radiance is the unit of `Responses.ground`.
GROUND = 300.0
# Points whose targets are computed together: the arrays of a path then stay in a processor's cache.
_CHUNK = 1024


@dataclass(frozen=True, eq=False)
class Targets:
    """Of a sample that a band is fitted to, by quantity (`KINDS`).

    Attributes
    ----------
    mean : dict of (M,) arrays
        In band; without quantities that are 0 everywhere.
    at_points : (all M, C) array
        At the candidates, one quantity after another, in the measure of `BandPoints.weight` (per um).
    """

    mean: dict[str, np.ndarray]
    at_points: np.ndarray


@dataclass(frozen=True, eq=False)
class Responses:
    """In-band targets of a sample for every temperature of the ground and every light of the sources: both add in
    proportion.

    Attributes
    ----------
    wavenumber : (I,) array
        Of each interval with points, cm^-1: what ground and sources send is the same at all its points.
    first : (I,) int array
        The first of these.
    surface_temperature : float
        K, of the ground in `still`.
    still : dict of (M,) arrays
        By quantity (`KINDS`), without light of a source.
    ground : dict of (M, I) arrays
        What a ground at `GROUND` adds to one at 0 K.
    light : dict of (M, I) arrays
        Per unit of the source's irradiance.
    source : dict of (M,) int arrays
        Number of the source.
    """

    wavenumber: np.ndarray
    first: np.ndarray
    surface_temperature: float
    still: dict[str, np.ndarray]
    ground: dict[str, np.ndarray]
    light: dict[str, np.ndarray]
    source: dict[str, np.ndarray]

    def mean(self, surface_temperature, irradiance, brightness):
        """As `Targets.mean`.

        Parameters
        ----------
        surface_temperature : float
            K, of the ground.
        irradiance : (B, P) array
            Of the sources at the points, W m^-2 (cm^-1)^-1.
        brightness : (B,) array
            Direct light counts relative to it.

        Raises
        ------
        ValueError
            An irradiance is not the same at all points of an interval.
        """
        sources = irradiance[:, self.first]
        if not np.allclose(
            np.repeat(sources, np.diff(self.first, append=irradiance.shape[1]), axis=1), irradiance, rtol=1e-9, atol=0.0
        ):
            raise ValueError("irradiance must be the same at all points of an interval")
        own, still, unit = (
            planck_wavenumber(self.wavenumber, t) for t in (surface_temperature, self.surface_temperature, GROUND)
        )
        found = {}
        for kind in KINDS:
            sent = sources / brightness[:, None] if kind == DIRECT else sources
            lit = np.sum(self.light[kind] * sent[self.source[kind]], axis=1)
            found[kind] = self.still[kind] + self.ground[kind] @ ((own - still) / unit) + lit
        return _without_dark(found)


@dataclass(frozen=True, eq=False)
class _Rows:
    """Some targets (m, P) of a quantity; without ground or light where these are 0."""

    kind: str
    still: np.ndarray
    ground: np.ndarray | None = None
    light: np.ndarray | None = None
    source: np.ndarray | None = None

    def through(self, transmittance, place):
        """Some of the rows, counted round, each through a path of its own."""
        rows = place % len(self.still)
        seen = (None if part is None else part[rows] * transmittance for part in (self.still, self.ground, self.light))
        return _Rows(self.kind, *seen, self.source[rows])


def fitted_and_tested(air, weight, irradiance, brightness, fit, candidates, test):
    """Targets of one sample and responses of another.

    Parameters
    ----------
    air : SpectralAir
        At all P points.
    weight : (P,) array
        `BandPoints.weight`.
    irradiance : (B, P) array
        Of the sources, W m^-2 (cm^-1)^-1.
    brightness : (B,) array
        Direct light counts relative to it.
    fit, test : Sample
    candidates : (C,) int array, increasing
        Points whose targets of `fit` are kept.

    Returns
    -------
    Targets, Responses
    """
    share = weight / weight.sum()

    def part(start, end):
        some = air.part(slice(start, end))
        columns = candidates[(candidates >= start) & (candidates < end)] - start
        return (
            _fitted(some, share[start:end], irradiance[:, start:end], brightness, fit, columns),
            responses(some, share[start:end], test, len(irradiance)),
        )

    edges = _edges(air.optics.wavenumber)
    fitted, tested = zip(*parallel_map(part, edges[:-1], edges[1:]), strict=True)
    mean = _without_dark({kind: sum(np.concatenate(means[kind]) for means, _ in fitted) for kind in KINDS})
    kept = [np.concatenate([rows for kind in mean for rows in found[kind]]) for _, found in fitted]
    return Targets(mean, np.concatenate(kept, axis=1)), _joined(tested, edges)


def responses(air, share, sample, sources):
    """Responses of a sample.

    Parameters
    ----------
    air : SpectralAir
        At P points.
    share : (P,) array
        Weights of which those of the whole band add up to 1.
    sample : Sample
    sources : int

    Returns
    -------
    Responses
    """
    first = _first_of_intervals(air.optics.wavenumber)
    still, ground, light, source = ({kind: [] for kind in KINDS} for _ in range(4))
    for rows in _rows(air, sample, sources, with_ground=True):
        count = len(rows.still)
        still[rows.kind].append(rows.still @ share)
        for part, values in ((ground, rows.ground), (light, rows.light)):
            by_interval = (
                np.zeros((count, first.size)) if values is None else np.add.reduceat(values * share, first, axis=1)
            )
            part[rows.kind].append(by_interval)
        source[rows.kind].append(np.zeros(count, int) if rows.source is None else rows.source)
    parts = ({kind: np.concatenate(found[kind]) for kind in KINDS} for found in (still, ground, light, source))
    return Responses(air.optics.wavenumber[first], first, air.state.surface_temperature, *parts)


def _first_of_intervals(wavenumber):
    """First point (I,) of each interval, from the middle of each point's interval."""
    return np.flatnonzero(np.diff(wavenumber, prepend=np.nan) != 0)


def _edges(wavenumber):
    """Edges of the pieces whose targets are computed together: whole intervals."""
    count, first = wavenumber.size, _first_of_intervals(wavenumber)
    pieces = 2 * -(-count // (2 * _CHUNK)) if count > _CHUNK // 2 else 1  # even in number, for threads in pairs
    even = np.linspace(0, count, pieces, endpoint=False)
    return np.append(np.unique(first[np.searchsorted(first, even, side="right") - 1]), count)


def _joined(parts, edges):
    """Responses at all points from those of pieces between edges."""
    still = {kind: sum(part.still[kind] for part in parts) for kind in KINDS}
    ground, light = (
        {kind: np.concatenate([getattr(part, name)[kind] for part in parts], axis=1) for kind in KINDS}
        for name in ("ground", "light")
    )
    first = np.concatenate([part.first + start for part, start in zip(parts, edges[:-1], strict=True)])
    wavenumber = np.concatenate([part.wavenumber for part in parts])
    return replace(parts[0], wavenumber=wavenumber, first=first, still=still, ground=ground, light=light)


def _without_dark(means):
    return {kind: values for kind, values in means.items() if np.any(values > 0)}


def _fitted(air, share, irradiance, brightness, sample, columns):
    """In-band means and values at some of the points of `air`, each a dict of lists by quantity."""
    means = {kind: [] for kind in KINDS}
    kept = {kind: [] for kind in KINDS}
    for rows in _rows(air, sample, len(irradiance)):
        values = rows.still
        if rows.light is not None:
            sent = irradiance / brightness[:, None] if rows.kind == DIRECT else irradiance
            values = values + rows.light * sent[rows.source]
        means[rows.kind].append(values @ share)
        kept[rows.kind].append(values[:, columns])
    return means, kept


def _rows(air, sample, sources, with_ground=False):
    """Targets of a sample at the points of `air`, in several `_Rows`; without `with_ground` the ground's part is not
    told apart.
    """
    optics = air.optics
    per_micron = optics.wavenumber**2 * 1e-4
    dark = _over_bright_ground(air) if with_ground and np.any(optics.aerosol_scattering) else None
    sky, beam = _from_above(air, dark, sample, sources, per_micron)
    yield sky
    yield beam
    for number, sight in enumerate(sample.sights):
        segments, node = sight.segments, sight.node
        depths = transfer.Depths(segments.column(optics.extinction).astype(np.float32))
        through = np.exp(-depths.before[node].astype(float))
        within = (np.arange(segments.index.size) < node[:, None]).astype(np.float32)
        thermal, ground = (
            None if one is None else (within @ one.thermal_radiance(segments, depths)) * per_micron
            for one in (air, dark)
        )
        light = air.scattered_radiance(segments, depths, sight.to_source, sight.deflection) * per_micron
        yield _Rows("transmittance", through)
        yield _Rows("path_thermal", thermal, ground)
        # Of the whole path, once for each source.
        longest = (None if rows is None else np.tile(rows[-1], (sources, 1)) for rows in (thermal, ground, light))
        yield _Rows("path_radiance", *longest, np.arange(sources))
        # The products of (20) and (36): sky and direct light on the ground through the path.
        place = number + np.arange(node.size)
        yield sky.through(through, place)
        yield beam.through(through, place)


def _from_above(air, dark, sample, sources, per_micron):
    """Rows of sky and direct irradiance at the sample's places, all of them for the first source, then for the next."""
    sky = sky_irradiance(air, sample.surface_altitude, sample.sky_elevation, zeniths=_ZENITHS, azimuths=_AZIMUTHS)
    below = (
        None if dark is None else sky_irradiance(dark, sample.surface_altitude, np.zeros(0), zeniths=_ZENITHS).thermal
    )
    thermal, ground = (
        None if rows is None else np.repeat(rows * per_micron, sample.sky_elevation.size, axis=0)
        for rows in (sky.thermal, below)
    )
    scattered, direct = (
        (rows * per_micron).reshape(-1, per_micron.size)
        for rows in (
            sky.scattered,
            direct_transmittance(air.source_paths, sample.direct_altitude, sample.direct_elevation),
        )
    )

    def of_all(kind, *parts):
        numbers = np.repeat(np.arange(sources), len(parts[-1]))
        return _Rows(kind, *(None if rows is None else np.tile(rows, (sources, 1)) for rows in parts), numbers)

    return of_all("sky_irradiance", thermal, ground, scattered), of_all(DIRECT, np.zeros_like(direct), None, direct)


def _over_bright_ground(air):
    """The same air without emission, over a ground at `GROUND`."""
    optics = replace(air.optics, emission=np.zeros_like(air.optics.emission))
    return replace(air, state=replace(air.state, surface_temperature=GROUND), optics=optics)
