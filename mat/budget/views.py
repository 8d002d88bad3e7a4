"""Random views of random surfaces inside the axes of a job: what an error budget is measured on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.mat.atmosphere.transfer.geometry import EARTH_RADIUS, Shells, trace
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import local_times_utc
from skyshine.mat.measure.random_streams import Stream, random_stream
from skyshine.mat.measure.sampling import random_coordinates
from skyshine.mat.quantities.grid import PathGrid
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction, slope_and_azimuth
from skyshine.schemas.arrays import Booleans, Floats

RANGES_KM = (0.1, 40.0)  # drawn evenly in their logarithm, as far as the tables reach
NEAR_KM = (0.001, 0.1)  # likewise, of the views from nearby
NEAR_SHARE = 0.25  # fraction of the views
# Heights above the surface of observers [km], even in their logarithm, as far as the tables reach: of drones, aircraft
# and satellites. Half of the views that are not near are theirs, in equal parts; the others start anywhere on the axis.
OBSERVERS_KM = {"drones": (0.02, 0.5), "aircraft": (1.0, 12.0), "satellites": (200.0, 2000.0)}
OBSERVER_SHARE = 0.5
_FLATTEST = 0.02  # sine of the elevation of their lines from the horizon: a degree
# Faces at one place at one time, under one sky: the light around them is computed once.
FACES_OF_A_PLACE = 4
FACES_M = (1.0, 100.0)  # lengths of faces, likewise
BEND_DEG = 15.0  # between the normals at the two ends of a face, at most
GLINT_DEG = 10.0  # spread of the normals of surfaces that mirror the source
LEAST_COSINE = 0.05  # smallest cosine of the angle between normal and view: flatter faces fill no pixel
_PLACES, _CANDIDATES, _TRIES = 16, 16, 60  # places of a batch and candidates of each; batches


@dataclass(frozen=True, eq=False)
class Views:
    """n lines of sight, each to one point of a face.

    Attributes
    ----------
    altitude, surface_altitude, range : (n,) arrays
        km; of the observer, of the surface, between them.
    elevation, heading : (n,) arrays
        Direction of the line of sight at the observer, degree; heading clockwise from north.
    time : (n,) array
        Local clock, h.
    source_elevation, source_azimuth : (n,) arrays
        degree; azimuth from north eastward.
    normal : (n, 3) array
        Unit normal of the surface: east, north, up.
    along : (n, 3) array
        Unit vector in the face, from one of its vertices to the other.
    face, share, bend : (n,) arrays
        Length [m]; place of the pixel between the vertices, 0 to 1; angle between their normals [rad].
    """

    altitude: Floats
    surface_altitude: Floats
    range: Floats
    elevation: Floats
    heading: Floats
    time: Floats
    source_elevation: Floats
    source_azimuth: Floats
    normal: Floats
    along: Floats
    face: Floats
    share: Floats
    bend: Floats

    def __len__(self) -> int:
        return len(self.range)

    def take(self, chosen: slice | Booleans) -> Views:
        """Some of the views."""
        return Views(*(getattr(self, field.name)[chosen] for field in fields(self)))

    @property
    def near(self) -> Booleans:
        """Views within `NEAR_KM`."""
        return self.range <= NEAR_KM[1]

    @property
    def height(self) -> Floats:
        """Height of the observers above the surfaces, km."""
        return self.altitude - self.surface_altitude

    @property
    def lines(self) -> LinesOfSight:
        """The lines of sight, with the source 0 to 180 degree beside them."""
        azimuth = fold(self.source_azimuth - self.heading)
        return LinesOfSight(self.range, self.altitude, self.elevation, self.source_elevation, azimuth)

    @property
    def to_source(self) -> Floats:
        """Unit vectors (n, 3)."""
        return direction(self.source_elevation, self.source_azimuth)

    @property
    def to_observer(self) -> Floats:
        """Unit vectors (n, 3), as if the Earth were flat between."""
        return -direction(self.elevation, self.heading)


def fold(azimuth: npt.ArrayLike) -> Floats:
    """An azimuth difference as 0 to 180 degree."""
    return np.abs(np.mod(np.asarray(azimuth) + 180.0, 360.0) - 180.0)


def random_views(
    job: Job, source: str, grid: PathGrid, surface_axes: Mapping[str, Floats], shells: Shells, count: int, seed: int
) -> Views:
    """Draw views whose every coordinate lies on the axes of the tables: the Sun at all hours, the Moon where it is up.

    Below the first node of its elevation the Sun has no light, which tables read there too.

    Parameters
    ----------
    source : {'sun', 'moon'}
    surface_axes : dict of str to array
        altitude [km], azimuth, slope [degree] and time [h] of the temperature table.
    shells : Shells
        Layers of the atmosphere, to find where a refracted line meets the ground.

    Returns
    -------
    Views
        `count` of them, `FACES_OF_A_PLACE` at each place and time; fewer, or none, where the axes leave no room: the
        Moon is never up at the times of the table, say.
    """
    generator = random_stream(seed, Stream.VIEWS, int(source == "moon"))
    batches: list[Views] = []
    for _ in range(_TRIES):
        batches.append(_candidates(job, source, grid, surface_axes, shells, generator))
        if sum(map(len, batches)) >= count:
            break
    joined = Views(*(np.concatenate([getattr(batch, field.name) for batch in batches]) for field in fields(Views)))
    return joined.take(slice(count))


def _candidates(
    job: Job,
    source: str,
    grid: PathGrid,
    axes: Mapping[str, Floats],
    shells: Shells,
    generator: np.random.Generator,
) -> Views:
    """Draw a batch of views and keep those that lie on the axes, a few of each place."""
    low, high = axes["altitude"][0], axes["altitude"][-1]
    count = _PLACES * _CANDIDATES
    location = np.repeat(np.arange(_PLACES), _CANDIDATES)
    surface = generator.uniform(low, high, _PLACES)[location]
    altitude, distance = _observers(grid, surface, generator)
    sine = _sine_of_elevation(altitude, surface, distance)
    elevation = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))
    heading = generator.uniform(0.0, 360.0, count)
    # With query limits the table has only the hours asked for; those after midnight count beyond 24.
    limited = job.query_limits is not None and job.query_limits.hours is not None
    start, stop = (axes["time"][0], axes["time"][-1]) if limited else (0.0, 24.0)
    one_time = axes["time"].size == 1
    hours = np.full(_PLACES, axes["time"][0]) if one_time else generator.uniform(start, stop, _PLACES)
    time = np.mod(hours, 24.0)[location]
    where = position(source, local_times_utc(job.site, time), job.site.latitude_deg, job.site.longitude_deg)
    normal = _normals(axes, direction(where.elevation, where.azimuth), -direction(elevation, heading), generator)
    faces, most_bent = None if job.query_limits is None else job.query_limits.faces_deg, BEND_DEG
    if faces is not None:  # others are not known, nor are those of bent ones
        slope, azimuth = np.array(faces)[generator.integers(len(faces), size=count)].T
        normal, most_bent = direction(90.0 - slope, azimuth), 0.0
    along = np.cross(normal, generator.normal(size=(count, 3)))
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    log_shortest, log_longest = np.log(FACES_M)
    views = Views(
        altitude,
        surface,
        distance,
        elevation,
        heading,
        time,
        where.elevation,
        where.azimuth,
        normal,
        along,
        np.exp(generator.uniform(log_shortest, log_longest, count)),
        generator.random(count),
        np.radians(generator.uniform(0.0, most_bent, count)),
    )
    facing = np.sum(normal * views.to_observer, axis=1) > LEAST_COSINE
    keep = (np.abs(sine) <= 1) & facing & (views.near | (altitude >= surface))
    source_elevation = np.maximum(where.elevation, grid.source_elevation_deg[0]) if source == "sun" else where.elevation
    keep &= (where.elevation > 0) | (source == "sun")
    for values, nodes in (
        (altitude, grid.altitude_km),
        (elevation, grid.elevation_deg),
        (source_elevation, grid.source_elevation_deg),
        (fold(views.source_azimuth - views.heading), grid.source_azimuth_deg),
    ):
        keep &= (values >= nodes[0]) & (values <= nodes[-1])
    ended = _ending_on_the_ground(views.take(keep), shells, grid)
    return ended.take(_first_of_each(ended.time, FACES_OF_A_PLACE))


def _first_of_each(values: Floats, count: int) -> Booleans:
    """Which of values (n,) are among the first so many that are equal."""
    earlier = np.tril(values[:, None] == values, -1).sum(axis=1)
    early: Booleans = earlier < count
    return early


def _observers(grid: PathGrid, surface: Floats, generator: np.random.Generator) -> tuple[Floats, Floats]:
    """Altitudes of observers and their distances [km] from faces at altitudes (n,) [km].

    Some look from `NEAR_KM` in any direction, some as drones, aircraft and satellites do, even in solid angle, some
    from any altitude of the table.
    """
    count = surface.size
    shortest, longest = grid.range_km[[0, -1]]
    near, far = (
        np.exp(generator.uniform(np.log(max(low, shortest, 1e-3)), np.log(max(min(high, longest), low, 1e-3)), count))
        for low, high in (NEAR_KM, RANGES_KM)
    )
    kind = generator.random(count)
    anywhere = random_coordinates(grid.altitude_km, count, generator)
    beside = surface - near * np.sin(np.radians(generator.uniform(-90.0, 90.0, count)))
    flying = _heights_of_observers(grid, surface, generator)
    slant = flying / generator.uniform(_FLATTEST, 1.0, count)
    is_near, flies = kind < NEAR_SHARE, kind > 1 - OBSERVER_SHARE * (1 - NEAR_SHARE)
    flies &= np.isfinite(flying) & (slant >= shortest) & (slant <= longest)
    return (
        np.select([is_near, flies], [beside, surface + flying], anywhere),
        np.select([is_near, flies], [near, slant], far),
    )


def _heights_of_observers(grid: PathGrid, surface: Floats, generator: np.random.Generator) -> Floats:
    """Heights (n,) above surfaces at altitudes (n,) [km] of drones, aircraft and satellites, as far as the table has
    them; not a number where it has none.
    """
    lowest, highest = grid.altitude_km[[0, -1]]
    heights = []
    for low, high in OBSERVERS_KM.values():
        lower, upper = np.maximum(low, lowest - surface), np.minimum(high, highest - surface)
        share = generator.random(surface.size)
        with np.errstate(invalid="ignore"):
            heights.append(np.where(lower <= upper, lower * (np.maximum(upper, lower) / lower) ** share, np.nan))
    chosen = generator.permuted(np.array(heights), axis=0)
    # The first of them that the table has, in random order.
    first_known: Floats = np.take_along_axis(chosen, np.argmax(np.isfinite(chosen), axis=0)[None], axis=0)[0]
    return first_known


def _sine_of_elevation(altitude: Floats, surface: Floats, distance: Floats) -> Floats:
    """Sine of the elevation of the straight line between two altitudes [km] over a round Earth."""
    start, end = EARTH_RADIUS * 1e-3 + altitude, EARTH_RADIUS * 1e-3 + surface
    return (end**2 - start**2 - distance**2) / (2 * distance * start)


def _normals(
    axes: Mapping[str, Floats], to_source: Floats, to_observer: Floats, generator: np.random.Generator
) -> Floats:
    """Half of the surfaces have a random direction; half nearly mirror the source, where it is up."""
    count = len(to_source)
    sunlit = to_source[:, 2:] > 0
    slope = random_coordinates(axes["slope"], count, generator)
    unrelated = direction(90.0 - slope, generator.uniform(0.0, 360.0, count))
    mirror = to_source + to_observer + 2 * np.sin(np.radians(GLINT_DEG) / 2) * generator.normal(size=(count, 3))
    mirror /= np.maximum(np.linalg.norm(mirror, axis=1, keepdims=True), 1e-12)
    return on_axes(np.where((generator.random((count, 1)) < 0.5) & sunlit, mirror, unrelated), axes)


def on_axes(normal: Floats, axes: Mapping[str, Floats]) -> Floats:
    """Turn normals (..., 3) into the slopes and azimuths of the temperature table's axes."""
    slope, azimuth = slope_and_azimuth(normal)
    slope = np.clip(slope, axes["slope"][0], axes["slope"][-1])
    if axes["azimuth"].size == 1:
        azimuth = np.full_like(azimuth, axes["azimuth"][0])
    return direction(90.0 - slope, azimuth)


def _ending_on_the_ground(views: Views, shells: Shells, grid: PathGrid) -> Views:
    """Shorten lines that refraction bends into the ground before the surface, and drop those too short."""
    if not len(views):
        return views
    rays = trace(shells, views.altitude * 1e3, np.radians(views.elevation))
    ends = np.where(rays.ground, rays.end * 1e-3, np.inf)
    distance = np.minimum(views.range, ends)
    shortened = Views(*(distance if field.name == "range" else getattr(views, field.name) for field in fields(Views)))
    return shortened.take((distance >= grid.range_km[0]) & (distance > 0))
