"""The query limits of a job from what the frames of a scene read, each with its reason."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.mat.atmosphere.sources.ephemeris import position
from skyshine.mat.job.fields import Span
from skyshine.mat.job.load import LoadedJob
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import local_times_utc
from skyshine.mat.job.trim import STEP_H
from skyshine.mat.render.reads import SceneReads
from skyshine.mat.render.scene_file import LoadedScene
from skyshine.materials.library import MaterialLibrary
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import nearest

LEAST_SHARE = 1e-3  # fraction of the pixels, of a material that is built
# Beyond what is read, for a camera that moves a little: share of a range, metres, degree.
RANGE_MARGIN, HEIGHT_MARGIN_M, ANGLE_MARGIN = 0.02, 1.0, 0.5
FARTHEST_KM = 100_000.0
MOST_FACES = 128  # slopes times azimuths that are tabulated by themselves; of more, the span of slopes is
_UNSEEN_WALL = (90.0, 0.0)
_CLUSTER_DEG = 0.1  # between slopes or azimuths that count as one
_COMPARED_UM = np.geomspace(0.3, 14.0, 200)
_SHOWN = 5  # faces and materials in a reason


@dataclass(frozen=True)
class Limit:
    """A key of `needs`.

    Attributes
    ----------
    value : list
        Value as YAML has it.
    """

    key: str
    value: list[Any]
    reason: str


@dataclass(frozen=True)
class SceneNeeds:
    """The needs of a scene.

    Attributes
    ----------
    replaced : dict of str to str
        Materials that are omitted, with those that replace them.
    replaced_share : float
        Share of the pixels that all these materials cover together.
    notes : tuple of str
        What no key says.
    """

    limits: tuple[Limit, ...]
    replaced: dict[str, str]
    replaced_share: float
    notes: tuple[str, ...]


def scene_needs(
    scene: LoadedScene,
    reads: SceneReads,
    library: MaterialLibrary,
    loaded: LoadedJob | None = None,
    least_share: float = LEAST_SHARE,
) -> SceneNeeds:
    """Query limits within which all reads of a scene lie.

    Parameters
    ----------
    loaded : LoadedJob, optional
        Job whose site and date place the source; without it the source's position has no limit.
    least_share : float
        Least share of the pixels that meet the surface; rarer materials are omitted.

    Raises
    ------
    InputError
        The job's tables do not reach what the scene reads, or lack its bands, state, source or materials.
    """
    materials, replaced = _materials(reads, library, least_share)
    limits = [*_of_lines(reads), *_of_surfaces(reads, materials, least_share)]
    limits.append(Limit("sources", [scene.model.source], "source of the scene"))
    if scene.model.bands is not None:
        limits.append(Limit("bands", list(scene.model.bands), "bands of the scene"))
    start, stop = reads.clock
    limits.append(Limit("hours", [_clock(start, -1), _clock(stop, 1)], f"{reads.hours.size} frames"))
    if loaded is not None:
        limits += _of_source(scene, reads, _of_state(scene, loaded))
        limits = [_within(scene, loaded, limit) for limit in limits]
        _check_names(scene, loaded, materials)
    notes = []
    if reads.range_km is None:
        notes.append("no pixel meets the surface: materials, faces and altitudes of surfaces are not limited")
    share = sum(reads.materials.get(name, 0.0) for name in replaced)
    return SceneNeeds(tuple(limits), replaced, share, tuple(notes))


def _of_lines(reads: SceneReads) -> Iterator[Limit]:
    near, far, reason = FARTHEST_KM, FARTHEST_KM, "from the observer to the surface"
    if reads.range_km is not None:
        near, far = reads.range_km[0] * (1 - RANGE_MARGIN), reads.range_km[1] * (1 + RANGE_MARGIN)
    if reads.air > 0:
        far = FARTHEST_KM
        reason = f"{reads.air:.3g} of the pixels meet nothing, and read the longest range"
    yield Limit("range_km", _outward(near, min(far, FARTHEST_KM)), reason)
    yield Limit("observer_altitude_km", _heights(reads.observer_altitude_km), "of the cameras, above sea level")
    low, high = reads.elevation_deg
    low, high = max(low - ANGLE_MARGIN, -90.0), min(high + ANGLE_MARGIN, 90.0)
    yield Limit("elevation_deg", _outward(low, high), "of the lines of sight of all pixels")


def _of_surfaces(reads: SceneReads, materials: tuple[str, ...], least_share: float) -> Iterator[Limit]:
    if reads.surface_altitude_km is None:
        return
    yield Limit("surface_altitude_km", _heights(reads.surface_altitude_km), "of what is seen, above sea level")
    slopes = [slope for slope, _ in reads.faces]
    faces = face_nodes(list(reads.faces))
    if not reads.level and not any(0 < slope < 180 for slope in slopes):
        # Walls and trees that no pixel shows send light to what it shows, which tables of level faces alone lack.
        faces.append(_UNSEEN_WALL)
    if len({slope for slope, _ in faces}) * len({azimuth for _, azimuth in faces}) <= MOST_FACES:
        largest = ", ".join(f"{slope:.4g}/{azimuth:.4g} {share:.2%}" for (slope, azimuth), share in _first(reads.faces))
        reason = f"slope and azimuth of all faces seen, {len(reads.faces)}; {largest} of the pixels"
        yield Limit("faces_deg", [list(face) for face in faces], reason)
    else:
        yield Limit("slope_deg", _outward(min(slopes), max(slopes)), f"of all faces seen, {len(reads.faces)}")
    shares = ", ".join(f"{name} {share:.2%}" for name, share in _first(reads.materials))
    yield Limit("materials", list(materials), f"{shares} of the pixels; those below {least_share:g} are omitted")


def _first(shares: dict[Any, float]) -> list[tuple[Any, float]]:
    return list(shares.items())[:_SHOWN]


def face_nodes(faces: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Slopes and azimuths between which those of all faces lie, faces of nearly the same direction together."""
    slopes = _cluster_ends(np.array([slope for slope, _ in faces]))
    azimuths = _cluster_ends(np.array([azimuth for slope, azimuth in faces if 0 < slope < 180]))
    nodes: set[tuple[float, float]] = set()
    for slope, azimuth in faces:
        turns = azimuths[azimuth] if 0 < slope < 180 else (0.0,)
        nodes |= {(node, turn) for node in slopes[slope] for turn in turns}
    return sorted(nodes)


def _cluster_ends(values: Floats) -> dict[float, tuple[float, ...]]:
    """The ends of the cluster in which each value lies."""
    ends: dict[float, tuple[float, ...]] = {}
    distinct = np.unique(values)
    for cluster in np.split(distinct, np.flatnonzero(np.diff(distinct) > _CLUSTER_DEG) + 1):
        for value in cluster:
            ends[float(value)] = tuple(sorted({float(cluster[0]), float(cluster[-1])}))
    return ends


def _materials(
    reads: SceneReads, library: MaterialLibrary, least_share: float
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Materials that are built, and the most similar of them for each of the others that the surface names."""
    retained = tuple(name for name, share in reads.materials.items() if share >= least_share)
    retained = retained or tuple(reads.materials)[:1]
    if not retained:
        return (), {}
    left_out = [name for name in reads.named if name not in retained and name in library.names]
    spectra = {
        name: np.interp(_COMPARED_UM, library[name].wavelength, library[name].reflectance)
        for name in (*retained, *left_out)
        if name in library.names
    }
    nearest_of = {
        name: min(
            (candidate for candidate in retained if candidate in spectra),
            key=lambda candidate: float(np.mean((spectra[name] - spectra[candidate]) ** 2)),
        )
        for name in left_out
    }
    return retained, nearest_of


def _of_state(scene: LoadedScene, loaded: LoadedJob) -> Job:
    job = loaded.requested
    if scene.model.state > len(job.states):
        raise scene.error(
            ("state",), f"found {scene.model.state}; {loaded.file.name} has states 1 to {len(job.states)}"
        )
    return job.on_date_of_state(scene.model.state)


def _of_source(scene: LoadedScene, reads: SceneReads, job: Job) -> Iterator[Limit]:
    """Positions of the source at the hours of the frames, and between them."""
    source, site = scene.model.source, job.site
    earliest, stop = reads.clock
    length = (stop - earliest) % 24.0
    hours = earliest + np.append(np.arange(0.0, length, STEP_H), length)
    where = position(source, local_times_utc(site, hours), site.latitude_deg, site.longitude_deg)
    low, high = float(np.min(where.elevation)) - ANGLE_MARGIN, float(np.max(where.elevation)) + ANGLE_MARGIN
    reason = f"of the {source} on {site.date} in these hours"
    yield Limit("source_elevation_deg", _outward(max(low, -90.0), min(high, 90.0)), reason)
    # Each hour of the source beside the nearest hour of a frame.
    apart = np.abs((hours[:, None] - reads.hours + 12.0) % 24.0 - 12.0)
    start, arc = reads.azimuth_deg[np.argmin(apart, axis=1)].T
    lines = start[:, None] + arc[:, None] * np.linspace(0.0, 1.0, 65)
    separation = np.abs((np.asarray(where.azimuth)[:, None] - lines + 180.0) % 360.0 - 180.0)
    margin = ANGLE_MARGIN + float(arc.max()) / 64
    value = _outward(max(float(separation.min()) - margin, 0.0), min(float(separation.max()) + margin, 180.0))
    yield Limit("source_azimuth_deg", value, f"of the {source} from the lines of sight")


def _within(scene: LoadedScene, loaded: LoadedJob, limit: Limit) -> Limit:
    """The limit without its margin beyond the tables of a job.

    Raises
    ------
    InputError
        The tables do not reach what is read.
    """
    job = loaded.requested
    nodes, key, margins = {
        "range_km": (job.atmosphere_grid.range_km, "atmosphere_grid.range_km", RANGE_MARGIN),
        "observer_altitude_km": (job.observer_altitudes_km, "atmosphere_grid.altitude_km", HEIGHT_MARGIN_M / 1e3),
        "elevation_deg": (job.atmosphere_grid.elevation_deg, "atmosphere_grid.elevation_deg", ANGLE_MARGIN),
        "surface_altitude_km": (job.surface_altitudes_km, "surface_grid.altitude_km", HEIGHT_MARGIN_M / 1e3),
        "slope_deg": (job.surface_grid.slope_deg, "surface_grid.slope_deg", 0.0),
    }.get(limit.key, ([], "", 0.0))
    if not nodes:
        return limit
    low, high = limit.value
    if limit.key == "range_km":  # what is nearer is read at the nearest
        low, high = (nodes[-1] if km == FARTHEST_KM else max(km, nodes[0]) for km in (low, high))
        read: Span = (low, high / (1 + margins) if high > nodes[-1] else high)
    else:
        read = (low + margins, high - margins)
    if limit.key == "slope_deg" and any(state.ground_material is not None for state in job.states):
        low = 0.0  # slope of the ground around the faces, which is level
    if read[0] < nodes[0] - 1e-6 or read[1] > nodes[-1] + 1e-6:
        raise loaded.document.error(
            tuple(key.split(".")),
            f"{key}: has {nodes[0]:g} to {nodes[-1]:g}; the scene {scene.document.file.name} reads {read[0]:.6g} to"
            f" {read[1]:.6g}; widen it",
        )
    return Limit(limit.key, [max(low, nodes[0]), min(high, nodes[-1])], limit.reason)


def _check_names(scene: LoadedScene, loaded: LoadedJob, materials: tuple[str, ...]) -> None:
    """Refuse a job without a band, a source or a material of the scene."""
    job = loaded.requested
    for number, name in enumerate(scene.model.bands or []):
        if name not in job.band_names:
            raise scene.error(("bands", number), f"found the band '{name}'; {nearest(name, job.band_names)}")
    if scene.model.source not in job.sources:
        raise scene.error(
            ("source",), f"found {scene.model.source}; {loaded.file.name} builds {', '.join(job.sources)}"
        )
    for name in materials:
        if isinstance(job.materials, list) and name not in job.materials:
            raise loaded.document.error(
                ("materials",), f"materials: lacks '{name}', which {scene.document.file.name} shows; add it"
            )


def _heights(kilometres: Span) -> list[float]:
    low, high = kilometres
    return _outward(low - HEIGHT_MARGIN_M / 1e3, high + HEIGHT_MARGIN_M / 1e3)


def _outward(low: float, high: float) -> list[float]:
    """Both ends with six digits behind the point, rounded outwards."""
    return [float(np.floor(low * 1e6) / 1e6), float(np.ceil(high * 1e6) / 1e6)]


def _clock(hour: float, direction: int) -> str:
    """The whole minute at or beyond an hour of the day: before it (-1) or after it (1)."""
    minutes = hour * 60.0
    minute = int(np.floor(minutes + 1e-6) if direction < 0 else np.ceil(minutes - 1e-6))
    return f"{minute // 60 % 24:02d}:{minute % 60:02d}"
