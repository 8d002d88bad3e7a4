"""The four quantities of the atmospheric tables, equations (8), (10), (20) and (36), for a state, a band and a source.

Angles: source elevation is geometric (without refraction), line-of-sight elevation apparent. For the path radiance both
source angles are those at the observer, azimuth counted from that of the line of sight; for ambient and direct the
source elevation is that at the surface point, the end of the line of sight.

In-band transmittance weights wavelengths: integral of phi tau dlambda over integral of phi dlambda.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer import segments as transfer
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
from skyshine.mat.atmosphere.transfer.thermal_source import lean
from skyshine.mat.quantities.formulas import band_transmittance, beta_star
from skyshine.mat.quantities.results import QUANTITIES, AtmosphericQuantities, SpectralLines
from skyshine.mat.radiometry.scattering_angle import azimuth_at
from skyshine.mat.threads import parallel_map
from skyshine.schemas.errors import InputError

# Of a line's length before the ground: over it the air's source function is taken that goes on behind the ground.
_LAST_STRETCH = 0.03
# Points whose field of scattered light is in memory at once where a spectrum is asked for.
_SPECTRAL_CHUNK = 256
# Heights whose sky is computed together.
_SKY_PART = 3
# Heights above the ground [m] at which sky irradiance is computed; between them it is exponential. Aerosol ends steeply
# above 2 km.
SKY_HEIGHTS = (
    0,
    250,
    500,
    1e3,
    1.5e3,
    2e3,
    2.25e3,
    2.5e3,
    3e3,
    4e3,
    5e3,
    6.5e3,
    8e3,
    10e3,
    12e3,
    14e3,
    17e3,
    22e3,
    30e3,
    40e3,
    60e3,
)


@dataclass(frozen=True, eq=False)
class BandAtmosphere:
    """A state prepared for a band: everything that does not depend on grid or source.

    Attributes
    ----------
    band : BandPoints
        All points of the band (`compile.band_points`) or the compiled ones (`compile.compile_band`); the response is in
        their weights.
    air : air.SpectralAir
    """

    band: BandPoints
    air: SpectralAir

    @classmethod
    def of(cls, state: AtmosphericState, band: BandPoints, *, streams: bool = True) -> BandAtmosphere:
        """Prepare a state for a band; `streams` as `air.SpectralAir.of`."""
        return cls(band, SpectralAir.of(state, band.points, band.gases, band.weight, streams=streams))

    def table(self, grid, source_irradiance, *, wanted=QUANTITIES, progress=None):
        """The quantities on a grid.

        Parameters
        ----------
        grid : PathGrid
        source_irradiance : (P,) array
            Of the source outside the atmosphere, normal to the beam, at `band.points`, W m^-2 (cm^-1)^-1.
        wanted : names out of `QUANTITIES`
            Only these are computed; the others are None.
        progress : callable, optional
            Called with the number of lines of sight done since the last call; there are A * E.

        Returns
        -------
        AtmosphericQuantities

        Raises
        ------
        InputError
            For an observer below the ground, a negative range, or an irradiance that is negative or of another length.
        """
        irradiance = self._irradiance(source_irradiance)
        ranges, elevation = grid.range_km * 1e3, np.radians(grid.elevation_deg)
        source = np.radians(grid.source_elevation_deg)
        azimuth = np.radians(grid.source_azimuth_deg)
        self.air.prepare()
        heights = np.add(self.air.state.surface_altitude, SKY_HEIGHTS)
        sky = self._sky(heights, source, irradiance) if "ambient" in wanted else None
        result = _empty(grid.shape, wanted)
        altitudes = grid.altitude_km * 1e3
        reach = np.broadcast_to(ranges, (elevation.size, ranges.size))

        def line_of_sight(rays, place, row):
            path = LineOfSight.of(self.air, rays, row, altitudes[place], elevation[row], ranges)
            sources = _sources(elevation[row], source, azimuth, grid.by_scattering_angle)
            self._fill(result, (slice(None), place, row), path, source, sources, irradiance, sky)

        for place, altitude in enumerate(altitudes):
            rays = trace(self.air.shells, np.full(elevation.size, altitude), elevation, reach)
            rows = range(elevation.size)
            parallel_map(line_of_sight, [rays] * len(rows), [place] * len(rows), rows)
            if progress is not None:
                progress(len(rows))
        return AtmosphericQuantities(**result)

    def at_points(
        self, range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg, source_irradiance
    ):
        """The quantities at single points, computed directly.

        Parameters
        ----------
        range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg : (n,) arrays
        source_irradiance : (P,) array

        Returns
        -------
        AtmosphericQuantities
            Of (n,) arrays.
        """
        irradiance = self._irradiance(source_irradiance)
        columns = np.broadcast_arrays(
            *(
                np.atleast_1d(a)
                for a in (range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg)
            )
        )
        ranges, altitude = (columns[i].astype(float) * 1e3 for i in (0, 1))
        elevation, source, azimuth = (np.radians(columns[i]) for i in (2, 3, 4))
        rays = trace(self.air.shells, altitude, elevation, ranges[:, None])
        results = []
        for row in range(ranges.size):
            path = LineOfSight.of(self.air, rays, row, altitude[row], elevation[row], ranges[row : row + 1])
            one = slice(row, row + 1)
            sky = self._sky(path.surface_altitude, source[one], irradiance)
            result = _empty((1, 1, 1, 1, 1), QUANTITIES)
            self._fill(
                result, (slice(None), 0, 0), path, source[one], (source[one], azimuth[one], 0.0), irradiance, sky
            )
            results.append(result)
        return AtmosphericQuantities(**{name: np.array([r[name].item() for r in results]) for name in results[0]})

    def along_lines(
        self,
        range_km,
        altitude_km,
        elevation_deg,
        source_elevation_deg,
        source_azimuth_deg,
        ambient_at,
        source_irradiance,
        *,
        wanted=QUANTITIES,
    ):
        """The quantities on n lines of sight at R ranges and for S sources each, computed directly; ambient at one
        range of some.

        Parameters
        ----------
        range_km : (n, R) array
            Increasing along each line.
        altitude_km, elevation_deg : (n,) arrays
        source_elevation_deg, source_azimuth_deg : (n, S) arrays
            Sky light is computed for the first source; lines that share its elevation cost less.
        ambient_at : (m,) int array
            Number of the range at which it is computed, for each of the first m lines.
        source_irradiance : (P,) array
        wanted : names out of `QUANTITIES`
            Only these are computed; the others are None, but ambient, which is computed wherever it is asked for by
            `ambient_at`.

        Returns
        -------
        AtmosphericQuantities
            beta_star, valid, transmittance (n, R); path_radiance_ratio, direct (n, R, S); ambient (m,).
        """
        irradiance = self._irradiance(source_irradiance)
        ranges, altitude = (np.asarray(a, float) * 1e3 for a in (range_km, altitude_km))
        elevation, source, azimuth = (np.radians(a) for a in (elevation_deg, source_elevation_deg, source_azimuth_deg))
        rays = trace(self.air.shells, altitude, elevation, ranges)
        found = {name: [] for name in ("valid", "transmittance", *wanted) if name != "ambient"}
        end, seen = np.empty(len(ambient_at)), np.empty((len(ambient_at), irradiance.size))
        for row in range(altitude.size):
            path = LineOfSight.of(self.air, rays, row, altitude[row], elevation[row], ranges[row])
            weight = self._radiance_weight(path)
            ln_tau, absorbed = band_transmittance(path.depth, self.band.weight)
            found["valid"].append(path.valid)
            found["transmittance"].append(np.exp(ln_tau))
            if "beta_star" in wanted:
                found["beta_star"].append(self._beta(path))
            if "path_radiance_ratio" in wanted:
                ratio = self._path_radiance_ratio(path, absorbed, source[row], azimuth[row], irradiance)
                found["path_radiance_ratio"].append(ratio)
            if "direct" in wanted:
                direct = direct_transmittance(self.air.source_paths, path.surface_altitude, source[row])
                found["direct"].append(np.einsum("rp,rsp->rs", weight * irradiance, direct))
            if row < end.size:
                end[row], seen[row] = path.surface_altitude[ambient_at[row]], weight[ambient_at[row]]
        ambient, first = np.empty(end.size), source[: end.size, 0]
        for one in np.unique(first):
            rows = first == one
            sky = self._sky_at(end[rows], self._sky(end[rows], np.array([one]), irradiance))[:, 0]
            ambient[rows] = np.sum(seen[rows] * sky, axis=1)
        rest = dict.fromkeys(QUANTITIES) | {"ambient": ambient}
        return AtmosphericQuantities(**rest | {name: np.array(values) for name, values in found.items()})

    def spectral_at_points(
        self, range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg, source_irradiance
    ):
        """What the quantities are integrals of, at n single points; arguments as `at_points`, each an (n,) array.

        Returns
        -------
        SpectralLines
        """
        irradiance = self._irradiance(source_irradiance)
        places = range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg
        parts = []
        for start in range(0, irradiance.size, _SPECTRAL_CHUNK):
            index = np.arange(start, min(start + _SPECTRAL_CHUNK, irradiance.size))
            air = self.air.part(slice(start, start + _SPECTRAL_CHUNK))
            band = BandPoints(self.band.points.subset(index), self.band.weight[index], self.band.gases)
            parts.append(BandAtmosphere(band, air)._spectral_part(*places, irradiance[index]))
        through, sky, direct = (np.concatenate(values, axis=1) for values in list(zip(*parts, strict=True))[:3])
        return SpectralLines(through, sky, direct, sum(part[3] for part in parts), parts[0][4])

    def _spectral_part(
        self, range_km, altitude_km, elevation_deg, source_elevation_deg, source_azimuth_deg, irradiance
    ):
        """The fields of `SpectralLines` at the points of this band."""
        ranges, altitude = (np.asarray(a, float) * 1e3 for a in (range_km, altitude_km))
        elevation, source, azimuth = (np.radians(a) for a in (elevation_deg, source_elevation_deg, source_azimuth_deg))
        rays = trace(self.air.shells, altitude, elevation, ranges[:, None])
        shape = ranges.size, irradiance.size
        through, sky, direct = (np.empty(shape) for _ in range(3))
        radiance, valid = np.empty(ranges.size), np.empty(ranges.size, dtype=bool)
        for row in range(ranges.size):
            path = LineOfSight.of(self.air, rays, row, altitude[row], elevation[row], ranges[row : row + 1])
            one = slice(row, row + 1)
            through[row] = np.exp(-path.depth[0])
            sky[row] = self._sky_at(path.surface_altitude, self._sky(path.surface_altitude, source[one], irradiance))[
                0, 0
            ]
            direct[row] = (
                irradiance * direct_transmittance(self.air.source_paths, path.surface_altitude, source[one])[0, 0]
            )
            radiance[row] = self._radiance_along(path, source[one], azimuth[one], irradiance)[path.node[0], 0]
            valid[row] = path.valid[0]
        return through, sky, direct, radiance, valid

    def _irradiance(self, source_irradiance):
        irradiance = np.asarray(source_irradiance, dtype=float)
        if irradiance.shape != self.band.weight.shape:
            raise InputError(
                f"source irradiance has shape {irradiance.shape}; give one for each of {self.band.weight.size} points"
            )
        if not np.all(np.isfinite(irradiance) & (irradiance >= 0)):
            raise InputError("source irradiance must be finite and not negative")
        return irradiance

    def _sky(self, altitude, source_elevation, irradiance):
        """Altitudes (Z,) [m], increasing, and the logarithm of sky irradiance (Z, SE, P) [W m^-2 (cm^-1)^-1] at
        them.
        """
        altitude = np.unique(np.minimum(altitude, self.air.shells.top))

        def total(height):
            sky = sky_irradiance(self.air, height, source_elevation)
            return sky.thermal[:, None] + sky.scattered * irradiance

        parts = np.array_split(altitude, -(-altitude.size // _SKY_PART))
        return altitude, np.log(np.maximum(np.concatenate(parallel_map(total, parts)), np.finfo(float).tiny))

    def _sky_at(self, altitude, sky):
        """Sky irradiance (R, SE, P) at altitudes (R,): exponential between those of `_sky`, falling with the pressure
        above.
        """
        nodes, log_irradiance = sky
        lower = np.clip(np.searchsorted(nodes, altitude, side="right") - 1, 0, nodes.size - 1)
        upper = np.minimum(lower + 1, nodes.size - 1)
        share = np.where(
            upper > lower, (altitude - nodes[lower]) / np.where(upper > lower, nodes[upper] - nodes[lower], 1.0), 0.0
        )
        share = share[:, None, None]
        irradiance = np.exp(log_irradiance[lower] * (1 - share) + log_irradiance[upper] * share)
        state = self.air.state
        pressure = np.where(altitude > self.air.shells.top, 0.0, state.pressure_at(altitude))
        return irradiance * np.minimum(pressure / state.pressure_at(nodes[-1]), 1.0)[:, None, None]

    def _fill(self, result, cell, path, source_elevation, sources, irradiance, sky):
        """Put the quantities of one line of sight into the arrays of the result that are there; `sources` as `_sources`
        gives them.
        """
        band = self.band
        ln_tau, absorbed = band_transmittance(path.depth, band.weight)
        result["valid"][cell] = path.valid
        result["transmittance"][cell] = np.exp(ln_tau)
        if result["beta_star"] is not None:
            result["beta_star"][cell] = self._beta(path)
        if result["path_radiance_ratio"] is not None:
            elevations, azimuths, rest = sources
            ratio = self._path_radiance_ratio(path, absorbed, elevations, azimuths, irradiance, rest)
            result["path_radiance_ratio"][cell] = ratio.reshape(
                -1, source_elevation.size, elevations.size // source_elevation.size
            )
        if result["ambient"] is None and result["direct"] is None:
            return
        weight = self._radiance_weight(path)
        if result["ambient"] is not None:
            result["ambient"][cell] = np.einsum("rp,rsp->rs", weight, self._sky_at(path.surface_altitude, sky))
        if result["direct"] is not None:
            direct = direct_transmittance(self.air.source_paths, path.surface_altitude, source_elevation)
            result["direct"][cell] = np.einsum("rp,rsp->rs", weight * irradiance, direct)

    def _path_radiance_ratio(self, path, absorbed, elevations, azimuths, irradiance, rest=0.0):
        """Path radiance over what each range absorbs, (R, S), with its limit where that is nothing; `rest` as
        `scattering.azimuth_at`.
        """
        along = self._radiance_along(path, elevations, azimuths, irradiance, rest)
        radiance, behind = along[path.node], path.beyond > 0
        if np.any(behind) and path.segments.index.size:
            absorbed = absorbed.copy()
            radiance[behind], absorbed[behind] = self._behind_ground(path, behind, along)
        radiance /= np.where(absorbed > 0, absorbed, 1.0)[:, None]
        empty = absorbed <= 0
        if np.any(empty):
            radiance[empty] = self._local_source(path, elevations, azimuths, irradiance, rest)
        return radiance

    def _behind_ground(self, path, behind, along):
        """Path radiance (B, S) and what is absorbed (B,) at the ranges behind the ground.

        The line goes on as for beta*, through air as bright as that before the ground, so that the ratio of the two
        passes smoothly through the ground.
        """
        end, weight = path.node[behind][0], self.band.weight
        distance = path.segments.distance
        start = int(np.clip(np.searchsorted(distance, distance[end] * (1 - _LAST_STRETCH)) - 1, 0, max(end - 1, 0)))
        stretch = band_transmittance(path.segment_depths.before[[start, end]], weight)[1]
        absorbed = band_transmittance(path.depth[behind] + path.depth_behind(self.air)[behind], weight)[1]
        grown = stretch[1] - stretch[0]
        if grown > 1e-6 * stretch[1]:
            slope = (along[end] - along[start]) / grown
        else:
            slope = along[end] / stretch[1] if stretch[1] > 0 else np.zeros_like(along[end])
        return along[end] + np.maximum(absorbed - stretch[1], 0.0)[:, None] * slope, absorbed

    def _radiance_weight(self, path):
        """Weights (R, P) that turn irradiance at the end of each range into (20) and (36)."""
        band = self.band
        through = np.exp(path.depth.min(axis=1, keepdims=True) - path.depth)  # transmittance over its largest
        return through * band.radiance_weight / (np.pi * (through @ band.weight / band.weight.sum()))[:, None]

    def _beta(self, path):
        """beta* [km] of each range."""
        band = self.band
        ln_tau = band_transmittance(path.depth + path.depth_behind(self.air), band.weight)[0]
        return beta_star(path.length + path.beyond, ln_tau, path.local_extinction @ band.weight / band.weight.sum())

    def _radiance_along(self, path, elevations, azimuths, irradiance, rest=0.0):
        """In-band path radiance (K+1, S) up to each segment end."""
        segments, band = path.segments, self.band
        total = np.zeros((segments.distance.size, elevations.size))
        if segments.index.size:
            thermal = self.air.thermal_radiance(segments, path.segment_depths) @ band.radiance_weight
            total[1:] += np.cumsum(thermal)[:, None]
            if self.air.scatters and np.any(irradiance > 0):
                ends = path.ends
                to_source = source_cosine(ends, elevations, azimuths)[0]
                deflection = _turned(scattering_cosine(ends, elevations, azimuths)[0], rest)
                weight = band.radiance_weight * irradiance
                total += self.air.scattered_in_band(segments, path.segment_depths, to_source, deflection, weight)
        return total

    def _local_source(self, path, elevations, azimuths, irradiance, rest=0.0):
        """Limit of path radiance over (1 - transmittance) for short ranges, (S,); in space that of the highest air."""
        layer, share = path.local_layer, path.local_share

        def here(values):
            return values[layer] * (1 - share) + values[layer + 1] * share

        optics, band = self.air.optics, self.band
        direction = np.pi / 2 - path.elevation
        cosine = np.sin(elevations) * np.cos(direction) + np.cos(elevations) * np.cos(azimuths) * np.sin(direction)
        cosine = _turned(cosine, rest)
        # The air of one metre at the density of the ground: any amount will do, this one stays inside single precision.
        air = 1e25 * np.array([[1 - share], [share]])
        point = transfer.Segments(np.zeros(1, int), np.array([layer]), *air, *(np.zeros(2),) * 4)
        extinction = point.column(optics.extinction)[0]
        rise = -np.sin(path.elevation)
        thermal = here(self.air.thermal.mean) + lean(rise) * here(self.air.thermal.tilt)
        source = np.broadcast_to(extinction * thermal, (cosine.size, extinction.size))
        if self.air.scatters:
            light = direct_transmittance(self.air.scaled_source_paths, np.array([path.local_altitude]), elevations)
            unit = transfer.scattered_spectral(point, optics, light.astype(np.float32), np.stack([cosine, cosine]))
            again = self.air.diffuse_light.at(layer, share, rise, np.sin(elevations), cosine)
            source = source + (unit + extinction * again) * irradiance
        return source @ band.radiance_weight / (extinction @ band.weight / band.weight.sum())


def _sources(elevation, source_elevation, source, by_scattering_angle):
    """Elevations, azimuths and rests (S,) of all sources of a line of sight; `source` holds azimuths or scattering
    angles.
    """
    elevations, last = np.repeat(source_elevation, source.size), np.tile(source, source_elevation.size)
    return (elevations, *azimuth_at(elevation, elevations, last)) if by_scattering_angle else (elevations, last, 0.0)


def _turned(cosine, rest):
    """Cosines of angles that a rest of `scattering.azimuth_at` is added to."""
    if not np.any(rest):
        return cosine
    return np.cos(np.clip(np.arccos(np.clip(cosine, -1.0, 1.0)) + rest, 0.0, np.pi))


def _empty(shape, wanted):
    path, source = shape[:3], shape[:4]
    sizes = {"beta_star": path, "path_radiance_ratio": shape, "ambient": source, "direct": source}
    found = {name: np.empty(size) if name in wanted else None for name, size in sizes.items()}
    return found | {"valid": np.empty(path, dtype=bool), "transmittance": np.empty(path)}
