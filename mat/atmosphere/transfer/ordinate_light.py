"""Light of Sun or Moon scattered more than once, by discrete ordinates.

Under a low source the field of plane layers is made spherical by `spherical_orders`.

`scattered_light` follows lines of sight through it, and adds light scattered once. Diffuse light scattered straight
forward into the line of sight belongs to it; light scattered once has no such part, which matters only to paths that
end inside a cloud.

References
----------
Dahlback and Stamnes 1991, Planet. Space Sci. 39, 671 (beam through spherical layers over a plane diffuse field).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.diffuse_field import NODES, ScaledLayers, layer_parts, solved_moments
from skyshine.mat.atmosphere.transfer.directions import DIRECTIONS
from skyshine.mat.atmosphere.transfer.geometry import Shells
from skyshine.mat.atmosphere.transfer.kernel_arrays import empty_rows
from skyshine.mat.atmosphere.transfer.layer_parts import LayerParts
from skyshine.mat.atmosphere.transfer.optics import SpectralOptics
from skyshine.mat.atmosphere.transfer.ordinates import AZIMUTHAL, Ordinates, ordinates
from skyshine.mat.atmosphere.transfer.source_nodes import ELEVATIONS, source_nodes
from skyshine.mat.atmosphere.transfer.source_paths import SourcePaths
from skyshine.mat.atmosphere.transfer.spherical_orders import LowSun
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats, Integers, Singles

# Points solved together: bounds memory to about 200 MB a thread. Of a field of few directions and elevations more are
# solved together, up to `_MOST_POINTS`: their arrays are then of the same size.
_CHUNK, _MOST_POINTS = 32, 256


@dataclass(frozen=True, eq=False)
class OrdinateLight:
    """Source function of light scattered more than once, per unit of the source's irradiance outside the atmosphere
    [sr^-1].

    Attributes
    ----------
    levels : (N,) array
        Altitude, m.
    sine : (U,) array
        Sine of the source's geometric elevation at the point of scattering, increasing.
    extinction, scaled : (N, P) arrays
        All, and delta-scaled, m^2 per molecule.
    source : (Q, U, B, P) array
        Source function of the scaled layers, by `Ordinates.functions` of the direction in which light leaves; those of
        azimuthal moment m times the cosine of m times the azimuth between that direction and the beam; single
        precision.
    straight : (N, U, X, M, P) array or None
        Radiance at the levels by direction, which particles scatter straight forward; coefficients of those cosines.
        None where no light is scattered so; single precision.
    angles : (X,) array
        Angles of its directions from the vertical, rad, increasing.
    falling : (N, U, P) array
        Diffuse flux on the levels, without the light scattered straight forward out of the beam.
    """

    levels: Floats
    sine: Floats
    extinction: Floats
    scaled: Floats
    ordinates: Ordinates
    parts: LayerParts
    source: Singles
    straight: Singles | None
    angles: Floats
    falling: Floats

    @classmethod
    def of(
        cls,
        state: AtmosphericState,
        shells: Shells,
        optics: SpectralOptics,
        fraction: Floats,
        source_paths: SourcePaths,
        elevations: Sequence[float] = ELEVATIONS,
        azimuthal: int = AZIMUTHAL,
        nodes: int = NODES,
        angles: Sequence[float] = DIRECTIONS,
        *,
        spherical: bool = True,
    ) -> OrdinateLight:
        """Solve the field of a state.

        Parameters
        ----------
        fraction : (N, P) array
            `diffuse_field.delta_fraction` of the optics.
        source_paths : source_paths.SourcePaths
            Paths of the source's light through the extinction without that fraction.
        elevations : sequence of float
            Elevations of the source at which the field is solved, degree, increasing.
        azimuthal : int
            Azimuthal moments of the field.
        nodes : int
            Number of ordinates in each hemisphere, which sets the fraction.
        spherical : bool
            The field under a low source is that of `LowSun`.
        angles : sequence of float
            Angles from the vertical of the directions in which light is scattered straight forward, rad, increasing;
            none is the horizon's.
        """
        sine = np.sin(np.radians(elevations))
        levels, points = state.altitude.size, optics.wavenumber.size
        directions, cosine = ordinates(nodes, azimuthal), np.cos(angles)
        parts = layer_parts(shells, optics, fraction, molecules=True)
        forward = optics.aerosol_scattering * fraction
        source: Singles = empty_rows((parts.places, sine.size, directions.pairs[0].size, points), np.float32)
        straight: Singles | None = None
        if np.any(forward):
            straight = empty_rows((levels, sine.size, cosine.size, azimuthal, points), np.float32)
        falling = np.empty((levels, sine.size, points))
        albedo = state.albedo_at(optics.wavenumber)

        numbers = AZIMUTHAL * NODES * len(ELEVATIONS) // (azimuthal * nodes * sine.size)
        together = min(max(_CHUNK * numbers, _CHUNK), _MOST_POINTS)

        def solve(start: int) -> None:
            part = slice(start, start + together)
            layers, rising, down = _field(
                state,
                shells,
                optics,
                moments,
                fraction,
                source_paths,
                sine,
                part,
                azimuthal,
                albedo,
                low_sun,
                parts,
            )
            falling[..., part] = directions.flux(down[parts.levels])
            source[..., part] = layers.source(rising, down)
            if straight is not None:
                straight[..., part] = np.swapaxes(layers.radiance(cosine, rising, down), 1, 2)

        moments = solved_moments(optics, nodes)
        low_sun = LowSun.of(shells, nodes, sine) if spherical else None
        parallel_map(solve, range(0, points, together))
        scaled = optics.extinction - forward
        angle = np.array(angles)
        return cls(state.altitude, sine, optics.extinction, scaled, directions, parts, source, straight, angle, falling)

    def part(self, points: slice | Integers) -> OrdinateLight:
        """The same at some of the points."""
        parts: dict[str, Any] = {}
        for name in ("extinction", "scaled", "source", "straight", "falling"):
            values = getattr(self, name)
            if values is not None:
                selected = values[..., points]
                values = empty_rows(selected.shape, values.dtype)
                values[:] = selected
            parts[name] = values
        return replace(self, **parts)

    def between(
        self, shells: Shells, optics: SpectralOptics, fraction: Floats, solved: Integers, lower: Integers, share: Floats
    ) -> OrdinateLight:
        """The field at points of which it is solved at some: diffuse radiance is linear between two of these, and each
        point scatters it by its own share.

        Parameters
        ----------
        shells, optics, fraction
            As of `of`, at all P points.
        solved : (K,) int array
            Places of the solved points among all.
        lower : (P,) int array
            Number of the solved point before each point; the next follows it.
        share : (P,) array
            Weight of the next, 0 to 1.
        """
        nodes, (_, degree) = self.ordinates.moments // 2, self.ordinates.pairs
        layers = ScaledLayers.of(
            shells, optics, solved_moments(optics, nodes), fraction, molecules=True, azimuthal=1, parts=self.parts
        )
        weighted = np.concatenate([layers.at_levels, layers.weighted[self.parts.inside[0]]])[:, degree]
        light, further = self.part(lower), self.part(lower + 1)
        for field, number, weight in ((light, lower, 1 - share), (further, lower + 1, share)):
            of_solved = weighted[..., solved[number]]
            ratio = np.divide(weighted, of_solved, out=np.ones_like(weighted), where=of_solved != 0)
            field.source[:] *= weight * ratio[:, None]
            field.falling[:] *= weight
            if field.straight is not None:
                field.straight[:] *= weight
        light.source[:] += further.source
        light.falling[:] += further.falling
        if light.straight is not None and further.straight is not None:
            light.straight[:] += further.straight
        scaled = optics.extinction - optics.aerosol_scattering * fraction
        return replace(light, extinction=optics.extinction, scaled=scaled)

    def sky(self, altitude: Floats, source_elevation: Floats) -> Floats:
        """`falling` at altitudes (Z,) [m] and source elevations (S,) [rad]: (Z, S, P)."""
        lower = np.clip(np.searchsorted(self.levels, altitude, side="right") - 1, 0, self.levels.size - 2)
        share = np.clip((altitude - self.levels[lower]) / np.diff(self.levels)[lower], 0.0, 1.0)[:, None, None]
        flux = self.falling[lower] * (1 - share) + self.falling[lower + 1] * share
        nodes, weight = source_nodes(self.sine, np.broadcast_to(np.sin(source_elevation), (2, source_elevation.size)))
        sky: Floats = np.maximum(weight[0].astype(float) @ flux[:, nodes], 0.0)
        return sky


def level_light(
    state: AtmosphericState,
    shells: Shells,
    optics: SpectralOptics,
    fraction: Floats,
    source_paths: SourcePaths,
    sine: Floats,
    albedo: npt.ArrayLike,
    nodes: int = NODES,
    *,
    spherical: bool = True,
) -> tuple[Floats, Floats]:
    """Rising and falling diffuse flux (N, U, P) on the levels, under a source of unit irradiance at elevations of sines
    (U,).

    Other arguments as of `OrdinateLight.of`; `albedo` of the ground, one number or (P,). Light scattered straight
    forward counts as beam.
    """
    rising, falling = np.empty((2, state.altitude.size, sine.size, optics.wavenumber.size))
    moments = solved_moments(optics, nodes)
    low_sun = LowSun.of(shells, nodes, sine) if spherical else None
    parts = layer_parts(shells, optics, fraction, molecules=True)

    def solve(start: int) -> None:
        part = slice(start, start + _CHUNK)
        layers, up, down = _field(
            state, shells, optics, moments, fraction, source_paths, sine, part, 1, albedo, low_sun, parts
        )
        rising[..., part] = layers.ordinates.flux(up[parts.levels])
        falling[..., part] = layers.ordinates.flux(down[parts.levels])

    parallel_map(solve, range(0, optics.wavenumber.size, _CHUNK))
    return rising, falling


def _field(
    state: AtmosphericState,
    shells: Shells,
    optics: SpectralOptics,
    moments: Floats,
    fraction: Floats,
    source_paths: SourcePaths,
    sine: Floats,
    part: slice,
    azimuthal: int,
    albedo: npt.ArrayLike,
    low_sun: LowSun | None,
    parts: LayerParts,
) -> tuple[ScaledLayers, Floats, Floats]:
    """The layers of a state at a part of the points, and radiances rising and falling at the ends of their parts."""
    layers = ScaledLayers.of(
        shells, optics.at(part), moments, fraction[:, part], molecules=True, azimuthal=azimuthal, parts=parts
    )
    paths = replace(source_paths, log_depth=source_paths.log_depth[..., part])
    shape = state.altitude.size, sine.size
    beam = paths.optical_depth(state.altitude, np.broadcast_to(sine, shape)).astype(float)
    ground = np.broadcast_to(np.asarray(albedo, dtype=float), (optics.wavenumber.size,))[part]
    plane = layers.sunlight(beam, sine, ground)
    if low_sun is None:
        return layers, *plane
    scaled = optics.extinction[:, part] - optics.aerosol_scattering[:, part] * fraction[:, part]
    at_levels = plane[0][parts.levels], plane[1][parts.levels]
    rising, falling = low_sun.corrected(at_levels, layers, scaled, paths, sine, ground)
    if not parts.is_cut:
        return layers, rising, falling
    up, down = (parts.between(new - old) for new, old in zip((rising, falling), at_levels, strict=True))
    return layers, plane[0] + up, plane[1] + down
