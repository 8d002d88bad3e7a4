"""Refracted lines of sight through spherical layers.

Between two levels the refractive index n falls as a power of the radius r, n = n_j (r / r_j)^-q. Bouguer's invariant
n r sin(zenith) then makes the ray a straight line in the plane of the radius rho = (r / r_j)^(1 - q): its position x
along that line, counted from its nearest point to the Earth's centre, gives length, altitude and angles in closed form,
at the horizon and through the tangent point too. Air between two levels is exponential in altitude.

References
----------
Born and Wolf 1999, Principles of Optics, section 3.2 (Bouguer's formula).
Gallery, Kneizys and Clough 1983, AFGL-TR-83-0065 (x = r cos(zenith) as the regular variable of a limb path).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Booleans, Floats, Integers
from skyshine.schemas.errors import InputError

EARTH_RADIUS = 6371008.8  # m, mean radius (IUGG 1980: Moritz 2000, J. Geod. 74, 128)
# Molecules per m^3 of the air to which the refractivity below belongs: 15 C, 1013.25 hPa (Bodhaine et al. 1999).
STANDARD_DENSITY = 2.546899e25
# At q = 1 a horizontal ray follows the ground and no longer leaves a layer (ducting), which is not modelled; standard
# air has 0.2.
LARGEST_BENDING = 0.95
# A ray that runs level stays long in one layer; it is cut at these distances (m) from its lowest point too, which keeps
# the source function inside a segment nearly linear.
_LEVEL_CUTS = np.array([-96e3, -64e3, -48e3, -32e3, -20e3, -10e3, 10e3, 20e3, 32e3, 48e3, 64e3, 96e3])
# Gauss nodes per segment for the air in it: exact to 1e-7 for a layer of three scale heights.
_POINT, _WEIGHT = np.polynomial.legendre.leggauss(4)


def refractivity(wavenumber: npt.ArrayLike) -> Floats:
    """n - 1 of dry air at 15 C and 1013.25 hPa, at wavenumbers [cm^-1], in their shape.

    References
    ----------
    Peck and Reeder 1972, J. Opt. Soc. Am. 62, 958, equation (2), 0.23 to 1.69 um; continued into the infrared, where it
    tends to its limit of 2.726e-4.
    """
    s2 = (np.asarray(wavenumber, dtype=float) * 1e-4) ** 2  # um^-2
    excess: Floats = (8060.51 + 2480990.0 / (132.274 - s2) + 17455.7 / (39.32957 - s2)) * 1e-8
    return excess


Number = TypeVar("Number", bound=np.generic)


@dataclass(frozen=True, eq=False)
class Shells:
    """Spherical layers between N levels.

    Attributes
    ----------
    altitude, number_density : (N,) arrays
        m, m^-3.
    radius : (N,) array
        m.
    index : (N,) array
        Refractive index.
    bending : (N-1,) array
        q of each layer.
    """

    altitude: Floats
    number_density: Floats
    radius: Floats
    index: Floats
    bending: Floats

    @classmethod
    def of(cls, altitude: Floats, number_density: Floats, wavenumber: float) -> Shells:
        """The layers between levels (N,) of altitude [m] and number density [m^-3], refracting as at one wavenumber
        [cm^-1].
        """
        radius = EARTH_RADIUS + altitude
        log_index = np.log1p(refractivity(wavenumber) * number_density / STANDARD_DENSITY)
        log_radius = np.diff(np.log(radius))
        bending = np.minimum(-np.diff(log_index) / log_radius, LARGEST_BENDING)
        # Counted from the top, so that limiting a layer moves no level above it.
        drop = bending * log_radius
        index = np.exp(log_index[-1] + np.append(np.cumsum(drop[::-1])[::-1], 0.0))
        return cls(altitude, number_density, radius, index, bending)

    @property
    def top(self) -> float:
        """Altitude of the highest level, m."""
        return float(self.altitude[-1])


@dataclass(frozen=True, eq=False)
class Rays:
    """M lines of sight, each cut into K segments that lie in one layer each; some have length 0.

    Attributes
    ----------
    distance : (M, K+1) array
        Distance of the segment ends from the observer, m.
    altitude : (M, K+1) array
        m.
    central_angle : (M, K+1) array
        Angle at the Earth's centre, from the observer, rad.
    direction : (M, K+1) array
        Angle of the ray from the observer's zenith, in its plane, rad; constant but for refraction.
    layer : (M, K) int array
    lower, upper : (M, K) arrays
        Air of the segment, molecules m^-2, shared between the layer's lower and upper level so that for any property
        linear in altitude per molecule the integral along the segment is lower * value[layer] + upper * value[layer +
        1].
    end : (M,) array
        Distance at which the ray leaves the atmosphere or meets the ground, m.
    ground : (M,) bool array
        It meets the ground.
    """

    distance: Floats
    altitude: Floats
    central_angle: Floats
    direction: Floats
    layer: Integers
    lower: Floats
    upper: Floats
    end: Floats
    ground: Booleans

    def at(self, row: int) -> Rays:
        """One of the rays, with M = 1."""
        return Rays(*(getattr(self, name)[row : row + 1] for name in self.__dataclass_fields__))


def trace(shells: Shells, altitude: Floats, elevation: Floats, ranges: Floats | None = None) -> Rays:
    """Follow lines of sight until they leave the atmosphere or meet the ground.

    Parameters
    ----------
    altitude, elevation : (M,) arrays
        Altitudes of the observers, m, at least the ground's, the highest may be in space; elevations of the (apparent)
        lines of sight at the observer, rad, -pi/2 to pi/2.
    ranges : (M, R) array, optional
        Distances [m] that are to be segment ends; beyond the end of the ray they are taken as its end. Without them the
        segments are the layers in order, all down, then all up.

    Raises
    ------
    InputError
        For an observer below the ground or an elevation or range outside its limits.
    """
    altitude, elevation = np.asarray(altitude, dtype=float), np.asarray(elevation, dtype=float)
    _check(shells, altitude, elevation, ranges)
    portions = _portions(shells, altitude, elevation)
    if ranges is None:
        distance = portions.distance
        portion = np.broadcast_to(np.arange(distance.shape[1] - 1), portions.layer.shape)
    else:
        lowest = -(EARTH_RADIUS + altitude) * np.sin(elevation)
        cuts = np.concatenate(
            [np.broadcast_to(ranges, (altitude.size, np.shape(ranges)[-1])), lowest[:, None] + _LEVEL_CUTS], axis=1
        )
        distance, portion = _insert(portions.distance, np.minimum(cuts, portions.distance[:, -1:]))
    return _measure(shells, portions, distance, portion, altitude, elevation)


def departure_angle(rays: Rays) -> Floats:
    """Angle (M,) [rad] from each observer's zenith at which its ray leaves the atmosphere: the geometric zenith angle
    of a distant object that is seen along the ray.
    """
    return rays.direction[:, -1]


@dataclass(frozen=True, eq=False)
class _Portions:
    """The part of each ray in each layer it may meet: all layers on the way down, then all on the way up.

    start, end are positions x of the straight line (M, Q); offset (M, Q) its distance from the centre; metre (M, Q) the
    length per unit of x; distance (M, Q+1) cumulative.
    """

    layer: Integers
    start: Floats
    end: Floats
    offset: Floats
    metre: Floats
    distance: Floats
    ground: Booleans
    entry_angle: Floats


def _check(shells: Shells, altitude: Floats, elevation: Floats, ranges: Floats | None) -> None:
    if not np.all(altitude >= shells.altitude[0] - 1e-6):
        raise InputError(
            f"observer altitude {np.min(altitude) / 1e3:g} km is below the ground at {shells.altitude[0] / 1e3:g} km;"
            " raise it"
        )
    if not np.all(np.abs(elevation) <= np.pi / 2 * (1 + 1e-12)):
        raise InputError("line-of-sight elevations must lie between -90 and 90 degree")
    if ranges is not None and not np.all(np.asarray(ranges) >= 0):
        raise InputError("ranges must be at least 0 and a number")


def _portions(shells: Shells, altitude: Floats, elevation: Floats) -> _Portions:
    """The portions of rays from observers (M,) [m] at elevations (M,) [rad]."""
    q, radius = shells.bending, shells.radius
    count = q.size
    observer = np.maximum(EARTH_RADIUS + altitude, radius[0])[:, None]  # (M, 1)
    outside = observer > radius[-1]
    down = elevation[:, None] < 0
    # An observer exactly on a level looks down into the layer below it and up into the one above.
    layer_number = (
        np.where(down, np.searchsorted(radius, observer, "left"), np.searchsorted(radius, observer, "right")) - 1
    )
    home = np.clip(layer_number, 0, count - 1)
    stretch = (observer / radius[home]) ** (1 - q[home])  # rho of the observer in its layer
    invariant = np.where(outside, observer, shells.index[home] * radius[home] * stretch) * np.cos(elevation)[:, None]

    layer = np.arange(count)
    offset = invariant / (shells.index * radius)[:-1]  # rho sin(zenith) in each layer, (M, N-1)
    outer = (radius[1:] / radius[:-1]) ** (1 - q)
    low = np.sqrt(np.maximum((1 - offset) * (1 + offset), 0.0))
    high = np.sqrt(np.maximum((outer - offset) * (outer + offset), 0.0))
    here = np.where(outside, 0.0, stretch * np.sin(elevation)[:, None])  # x of the observer in its layer

    crossed = outer > offset
    below = (layer < home) | outside
    falls = down & crossed & (below | (layer == home))
    start_down = np.where(falls, np.where(below, -high, here), 0.0)
    end_down = np.where(falls, np.maximum(-low, start_down), 0.0)
    ground = (down[:, 0] & (offset[:, 0] < 1.0)) | (down[:, 0] & (observer[:, 0] <= radius[0]))
    rises = np.where(down, crossed & ~ground[:, None], (layer >= home) & ~outside)
    start_up = np.where(rises, np.where(~down & (layer == home), here, low), 0.0)
    end_up = np.where(rises, np.maximum(high, start_up), 0.0)

    flip = slice(None, None, -1)
    start = np.concatenate([start_down[:, flip], start_up], axis=1)
    end = np.concatenate([end_down[:, flip], end_up], axis=1)
    layers = np.concatenate([layer[flip], layer])
    middle = np.sqrt(radius[1:] * radius[:-1])
    metre = (radius[:-1] / (1 - q) * (middle / radius[:-1]) ** q)[layers]
    entry, entry_angle = _entry(observer[:, 0], radius[-1], invariant[:, 0], elevation, outside[:, 0] & down[:, 0])
    distance = np.concatenate([entry[:, None], (end - start) * metre], axis=1).cumsum(axis=1)
    shape = start.shape
    return _Portions(
        np.broadcast_to(layers, shape),
        start,
        end,
        offset[:, layers],
        np.broadcast_to(metre, shape),
        distance,
        ground,
        entry_angle,
    )


def _entry(
    observer: Floats, top: float, invariant: Floats, elevation: Floats, comes_down: Booleans
) -> tuple[Floats, Floats]:
    """Distance [m] and central angle [rad], (M,) each, from an observer in space to the top of the atmosphere; 0 for
    all others.
    """
    enters = comes_down & (invariant < top)
    depth = np.sqrt(np.where(enters, (top - invariant) * (top + invariant), 0.0))
    height = observer * np.sin(-elevation)
    distance = np.where(enters, height - depth, 0.0)
    angle = np.where(enters, np.arctan2(height, invariant) - np.arctan2(depth, invariant), 0.0)
    return distance, angle


def _insert(boundaries: Floats, ranges: Floats) -> tuple[Floats, Integers]:
    """Merge ranges among the portion boundaries: segment ends (M, K+1), and the portion of each segment (M, K)."""
    merged = np.concatenate([boundaries, np.maximum(ranges, boundaries[:, :1])], axis=1)
    # A stable sort puts a boundary before a range at the same distance: the segment after both is in the later portion.
    order = np.argsort(merged, axis=1, kind="stable")
    distance = np.take_along_axis(merged, order, axis=1)
    passed = np.cumsum(order < boundaries.shape[1], axis=1)
    return distance, np.clip(passed[:, :-1] - 1, 0, boundaries.shape[1] - 2)


def _measure(
    shells: Shells, portions: _Portions, distance: Floats, portion: Integers, altitude: Floats, elevation: Floats
) -> Rays:
    """Altitudes, angles and air of the segments between distances (M, K+1) [m] in portions (M, K)."""

    def take(values: npt.NDArray[Number]) -> npt.NDArray[Number]:
        return np.take_along_axis(values, portion, axis=1)

    layer, start, end = take(portions.layer), take(portions.start), take(portions.end)
    offset, metre, origin = take(portions.offset), take(portions.metre), take(portions.distance[:, :-1])
    stretch = 1 - shells.bending[layer]
    start_height = np.clip(start + (distance[:, :-1] - origin) / metre, start, end)
    stop_height = np.clip(start + (distance[:, 1:] - origin) / metre, start, end)

    lower, upper = _air(shells, layer, start_height, stop_height, offset, metre)
    nonempty = np.diff(distance, axis=1) > 0
    zenith = np.arctan2(offset, start_height), np.arctan2(offset, stop_height)
    turn = np.where(nonempty, (zenith[0] - zenith[1]) / stretch, 0.0)
    central = np.concatenate([portions.entry_angle[:, None], turn], axis=1).cumsum(axis=1)
    bent = np.where(nonempty, turn + zenith[1] - zenith[0], 0.0)
    start_direction = (np.pi / 2 - elevation)[:, None]
    direction = np.concatenate([start_direction, bent], axis=1).cumsum(axis=1)
    heights = _altitude(shells, layer, stop_height, offset)
    entered = np.where(portions.distance[:, 0] > 0, shells.top, np.maximum(altitude, shells.altitude[0]))
    heights = _hold(np.concatenate([entered[:, None], np.where(nonempty, heights, np.nan)], axis=1))
    return Rays(
        distance,
        heights,
        central,
        direction,
        layer,
        np.where(nonempty, lower, 0.0),
        np.where(nonempty, upper, 0.0),
        portions.distance[:, -1],
        portions.ground,
    )


def _altitude(shells: Shells, layer: Integers, x: Floats, offset: Floats) -> Floats:
    """Altitude [m] of a position on the straight line of a layer; all of one shape."""
    rho = np.hypot(x, offset)
    altitude: Floats = shells.altitude[layer] + shells.radius[layer] * np.expm1(
        np.log(rho) / (1 - shells.bending[layer])
    )
    return altitude


def _air(
    shells: Shells, layer: Integers, start: Floats, stop: Floats, offset: Floats, metre: Floats
) -> tuple[Floats, Floats]:
    """Air of segments [molecules m^-2], shared between the lower and the upper level of their layer."""
    depth = np.diff(shells.altitude)[layer]
    log_ratio = np.diff(np.log(shells.number_density))[layer]
    lower, upper = np.zeros(start.shape), np.zeros(start.shape)
    half = 0.5 * (stop - start)
    for point, weight in zip(_POINT, _WEIGHT, strict=True):
        height = _altitude(shells, layer, 0.5 * (start + stop) + point * half, offset) - shells.altitude[layer]
        share = np.clip(height / depth, 0.0, 1.0)
        air = weight * half * metre * shells.number_density[layer] * np.exp(log_ratio * share)
        lower += air * (1.0 - share)
        upper += air * share
    return lower, upper


def _hold(values: Floats) -> Floats:
    """Replace each NaN of a row by the last number before it."""
    index = np.where(np.isnan(values), 0, np.arange(values.shape[1]))
    return np.take_along_axis(values, np.maximum.accumulate(index, axis=1), axis=1)


def source_cosine(rays: Rays, elevation: Floats, azimuth: Floats) -> Floats:
    """Cosine of a source's zenith angle at the segment ends.

    Parameters
    ----------
    elevation, azimuth : (S,) arrays
        Geometric, at the observer, rad; azimuth from that of the line of sight.

    Returns
    -------
    (M, K+1, S) array
    """
    angle = rays.central_angle[..., None]
    cosine: Floats = np.sin(elevation) * np.cos(angle) + np.cos(elevation) * np.cos(azimuth) * np.sin(angle)
    return cosine


def scattering_cosine(rays: Rays, elevation: Floats, azimuth: Floats) -> Floats:
    """Cosine of the scattering angle of a source's light at the segment ends, (M, K+1, S); arguments as
    `source_cosine`.
    """
    direction = rays.direction[..., None]
    cosine: Floats = np.sin(elevation) * np.cos(direction) + np.cos(elevation) * np.cos(azimuth) * np.sin(direction)
    return cosine
