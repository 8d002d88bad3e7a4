"""An atmosphere as textures: its fields as sums of few principal components, half floats on chosen nodes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from skyshine.mat.gpu.container import GpuFile, texture
from skyshine.mat.gpu.coordinates import AirCoordinates
from skyshine.mat.gpu.fields import WARM_K, AirFields
from skyshine.mat.gpu.nodes import best_counts, insertion_order
from skyshine.mat.quantities.lines_of_sight import LinesOfSight
from skyshine.mat.radiometry.spherical_harmonics import zonal
from skyshine.mat.tables.ambient import stated_ground
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.atmq import AMBIENT_HARMONICS
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

TOLERANCE_K = 0.004  # tolerance of nodes, and of the omitted components
FRAME_BYTES = 64_000  # largest size for one altitude and source elevation
_HEADER_BYTES = 6000  # bytes of a frame's JSON header; the rest of `FRAME_BYTES` is for textures
DAY_TEXELS = 4000  # texels of the textures of a whole day
_MOST_NODES, _MOST_LAYERS = 128, 24  # nodes of range and direction; layers of altitude
_LEAST_TEXELS, _COMPONENTS = 400, (4, 8, 12, 16)
_ELEVATIONS_TRIED = (3.0, 20.0, 60.0)  # degree, of the source
_SPECTRA_TRIED, _PLACES, _LEAST_LINES = 5, 1500, 5
RELATIVE_BELOW_UM = 2.5  # bands in which surfaces at WARM_K do not shine: errors in percent
_TEMPERATURES_TRIED = (275.0, 300.0, 325.0)  # K
_HARMONIC_WEIGHT = 0.25  # typical, beside the level value


@dataclass(frozen=True, eq=False)
class Weights:
    """What turns fields into kelvin: band radiance of a black body and its derivative, at one temperature."""

    radiance: float
    per_kelvin: float


@dataclass(frozen=True, eq=False)
class GroundDay:
    """The ground around faces through a day.

    Attributes
    ----------
    time, temperature, radiance : (T,) array
        Local clock [h], ascending over a whole day; [K]; emitted in the band [W m^-2 sr^-1].
    """

    time: Floats
    temperature: Floats
    radiance: Floats

    @classmethod
    def of(cls, air: AtmosphereTable, band: BandTable, surface: TemperatureTable) -> GroundDay | None:
        """That of an atmosphere that names its ground and has light of tilted faces; None for others."""
        if "ground_material" not in air.attributes or AMBIENT_HARMONICS not in air.quantities:
            return None
        time = np.asarray(surface.root.axes["time"].values, float)
        if AxisRule.of("time", surface.root.axes["time"]).interpolation == PERIODIC:
            time = np.append(time, time[0] + 24.0)
        kelvin = air.ground_temperature(surface, time=time)
        emissivity = stated_ground(air.attributes).emissivity
        return cls(time, kelvin, emissivity * band.blackbody_radiance(kelvin))


def weights_of(fields: AirFields, lines: LinesOfSight) -> Weights:
    """Those of a band; in a band of reflected light 1 % of the radiance counts as 1 K."""
    low, radiance, high = fields.band.blackbody_radiance(np.array([WARM_K - 0.5, WARM_K, WARM_K + 0.5]))
    if not relative(fields.air):
        return Weights(float(radiance), float(high - low))
    sunlit = fields.sky(lines, 45.0)[..., 0].mean() + fields.direct(lines, 45.0).mean()
    return Weights(float(radiance), 0.01 * float(sunlit))


def relative(air: AtmosphereTable) -> bool:
    """Whether errors are given in percent of the radiance."""
    return float(np.max(np.asarray(air.attributes["wavelength_um"], float))) < RELATIVE_BELOW_UM


def export_air(
    air: AtmosphereTable,
    band: BandTable,
    *,
    altitude: float | None = None,
    source_elevation: float | None = None,
    ground_temperature: float | None = None,
    ground_day: GroundDay | None = None,
    range_km: float | None = None,
    texels: int = DAY_TEXELS,
    most_components: int = 16,
) -> GpuFile:
    """Textures and coefficients of an atmospheric table for the materials of a band.

    Parameters
    ----------
    air, band : AtmosphereTable, BandTable
        Tables of one band.
    altitude : float, optional
        Altitude of the observer [km]; if given, the textures have one layer.
    source_elevation : float, optional
        Elevation of the source [degree]; if given, the coefficients are those of one frame.
    ground_temperature : float, optional
        Temperature of the ground around faces [K]; by default that of the file.
    ground_day : GroundDay, optional
        Ground temperature by the hour, in a texture of its own, instead of one temperature.
    range_km : float, optional
        Farthest range asked for.
    texels : int
        Most texels of a layer; those of a frame follow from `FRAME_BYTES`.
    most_components : int
        A multiple of four.

    Raises
    ------
    InputError
        The two are not of one band, or a value is outside the table.
    """
    kelvin = ground_temperature if ground_day is None else np.nan
    fields, coordinates = AirFields(air, band, kelvin), AirCoordinates.of(air, range_km)
    if altitude is not None and not coordinates.altitude_km[0] <= altitude <= coordinates.altitude_km[1]:
        low, high = coordinates.altitude_km
        raise InputError(f"altitude: found {altitude:g}; allowed: {low:g} to {high:g} km", file=air.path)
    elevations: list[float] = [e for e in _ELEVATIONS_TRIED if fields.source.nodes[0] <= e <= fields.source.nodes[-1]]
    elevations = elevations or [float(fields.source.nodes[-1])]
    elevations = elevations if source_elevation is None else [source_elevation]
    candidates = coordinates.candidates(altitude)
    middle = coordinates.lines(*(axis[[axis.size // 2]] for axis in candidates))
    weights = weights_of(fields, middle)

    def sampled(lines: LinesOfSight) -> Floats:
        return _columns(fields, lines, elevations, weights)

    rows = _rows(fields)
    frame = altitude is not None and source_elevation is not None
    budget = FRAME_BYTES - _HEADER_BYTES
    components = _needed(sampled(coordinates.lines(*(_thinned(axis, 24) for axis in candidates))))
    components = min(components, most_components)
    if frame:
        texels = max((budget - rows * components * 4) // (2 * components), _LEAST_TEXELS)
    nodes = _nodes(coordinates, candidates, lambda lines: _pixels(fields, lines, elevations, weights), texels)
    lines = coordinates.lines(*nodes)
    flat = LinesOfSight(*(values.reshape(-1) for values in (lines.range, lines.altitude, lines.elevation)))
    columns = sampled(flat)
    basis = _principal(columns, components)
    stored = basis.astype(np.float16)
    count = basis.shape[1]
    positions = np.random.default_rng(1).permutation(len(basis))[:_PLACES]
    basis_here = stored[positions].astype(float)
    subset, inverse = flat.take(positions), np.linalg.pinv(basis_here)

    def fitted(values: Floats) -> Floats:
        """Coefficients (..., K) of fields (P, ...)."""
        return np.moveaxis(np.tensordot(inverse, values, axes=(1, 0)), 0, -1)

    terms: dict[str, Any] = {
        "emission": fitted(fields.emission(subset)),
        "thermal_path": fitted(fields.thermal_path(subset)),
    }
    if ground_day is not None:
        terms["ground"] = np.stack([fitted(fields.ground(subset, kelvin)) for kelvin in fields.ground_nodes])
    heights: dict[str, Floats] = {}
    dark = fields.thermal_path(subset)[:, None]

    def fitted_path(elevation: float) -> Floats:
        """Coefficients (A, K) of the source's path radiance, from the lines that can be at each angle from it."""
        values = fields.path(subset, elevation, fields.angles) - dark
        reached = fields.reachable(subset, elevation)
        rows = []
        for angle in range(fields.angles.size):
            lines = reached[:, angle] if reached[:, angle].sum() >= _LEAST_LINES * count else slice(None)
            reaching = basis_here[lines]  # its normal equations: few components, many lines
            moments = reaching.T @ values[lines, angle]
            rows.append(np.linalg.lstsq(reaching.T @ reaching, moments, rcond=None)[0])
        return np.array(rows)

    readers: dict[str, Callable[[float], Floats]] = {
        "path": fitted_path,
        "sky": lambda s: fitted(fields.sky(subset, s)),
        "direct": lambda s: fitted(fields.direct(subset, s)),
    }
    for term, read in readers.items():
        heights[term] = fields.source_nodes(term) if source_elevation is None else np.array([source_elevation])
        terms[term] = np.stack([read(float(s)) for s in heights[term]])
    shape = lines.range.shape
    groups = stored.reshape(*shape, count // 4, 4)
    textures = {
        f"air{group}": texture(
            "RGBA16F", groups[..., group, :], "principal components of the air, in units of their largest"
        )
        for group in range(count // 4)
    }
    for term, values in terms.items():
        by_row = values.reshape(-1, count // 4, 4)
        textures[term] = texture("RGBA32F", by_row, _WHAT[term])
    numbers: dict[str, Any] = {
        "components": count,
        "axes": [_short(axis) for axis in nodes],
        "range_km": coordinates.range_km.tolist(),
        "altitude_km": coordinates.altitude_km.tolist() if altitude is None else [altitude, altitude],
        "material": [int(code) for code in fields.codes],
        "emission_temperature": fields.temperatures.tolist(),
        "harmonic": [int(code) for code in fields.harmonics],
        "angle": fields.angles.tolist(),
        "source_elevation": {term: _short(values) for term, values in heights.items()},
        "lowest_source_elevation": float(fields.source.nodes[0]),
        "highest_source_elevation": float(fields.source.nodes[-1]),
        "dark_below": fields.dark,
        "fades": fields.fades,
        "source": str(air.attributes.get("source", "sun")),
        "wavelength_um": np.asarray(air.attributes["wavelength_um"], float).tolist(),
        "ground_altitude_km": coordinates.rays.ground_km,
        "scale_height_km": coordinates.rays.scale_height_km,
        "height_root": _short(coordinates.rays.height_root),
        "effective_radius": _short(coordinates.rays.effective_radius),
    }
    if ground_day is not None:
        numbers |= {
            "zonal_harmonic": list(zonal(fields.harmonics.size)),
            "ground_node": fields.ground_nodes.tolist(),
            "ground_time": ground_day.time.tolist(),
            "ground_temperature": ground_day.temperature.tolist(),
            "ground_radiance": ground_day.radiance.tolist(),
        }
    elif fields.harmonics.size:
        numbers["ground_temperature"] = fields.ground_kelvin
    return GpuFile("atmosphere", source_of(air.path.name, air.attributes), textures, numbers)


_WHAT = {
    "ground": "reflected light of the ground over its emission in the band, by ground_node, material, zonal_harmonic",
    "emission": "share of black-body radiance emitted and let through, by material and emission_temperature",
    "thermal_path": "path radiance without the source, W m^-2 sr^-1",
    "path": "path radiance of the source, W m^-2 sr^-1, by source elevation and angle",
    "sky": "reflected ambient radiance, W m^-2 sr^-1, by source elevation, material, and level value or harmonic",
    "direct": "reflected direct radiance of faces normal to it, W m^-2 sr^-1, by source elevation and material",
}


def source_of(name: str, attributes: dict[str, Any]) -> dict[str, Any]:
    """The database of an export."""
    return {"file": name} | {
        key: str(attributes[key])
        for key in ("filetype", "format_version", "content_sha256", "state", "band", "date")
        if key in attributes
    }


def _short(values: Floats) -> list[float]:
    """Numbers with the digits that single precision needs."""
    return [float(str(value)) for value in values.astype(np.float32)]


def _rows(fields: AirFields) -> int:
    """Rows of coefficients of one frame."""
    return int(fields.codes.size * (fields.temperatures.size + 2 + fields.harmonics.size) + 1 + fields.angles.size)


def _columns(fields: AirFields, lines: LinesOfSight, elevations: list[float], weights: Weights) -> Floats:
    """Fields (..., F) at lines of sight, in kelvin of a surface at `WARM_K`."""
    codes = np.unique(np.linspace(0, fields.codes.size - 1, _SPECTRA_TRIED).astype(int))
    angles = fields.angles[np.unique(np.linspace(0, fields.angles.size - 1, 9).astype(int))]
    near = fields.temperatures[np.abs(fields.temperatures - WARM_K) <= 60]
    temperatures = np.isin(fields.temperatures, near) if near.size else slice(None)
    emission = fields.emission(lines)[..., codes, :][..., temperatures] * weights.radiance
    parts = [emission.reshape(*lines.range.shape, -1), fields.thermal_path(lines)[..., None]]
    for elevation in elevations:
        parts.append(fields.path(lines, elevation, fields.met(lines, elevation, angles)))
        sky = fields.sky(lines, elevation)[..., codes, :]
        scale = np.concatenate([[1.0], np.full(sky.shape[-1] - 1, _HARMONIC_WEIGHT)])
        parts.append((sky * scale).reshape(*lines.range.shape, -1))
        parts.append(fields.direct(lines, elevation)[..., codes])
    return np.concatenate(parts, axis=-1) / weights.per_kelvin


def _pixels(fields: AirFields, lines: LinesOfSight, elevations: list[float], weights: Weights) -> Floats:
    """Radiance (..., F) of pixels at lines of sight, in kelvin of a surface at `WARM_K`.

    Emission and path radiance err together: nodes are placed by their sums, not by each.
    """
    codes = np.unique(np.linspace(0, fields.codes.size - 1, _SPECTRA_TRIED).astype(int))
    emission = fields.emission(lines)[..., codes, :]
    emitted = []
    for kelvin in _TEMPERATURES_TRIED:
        index = int(np.abs(fields.temperatures - kelvin).argmin())
        emitted.append(emission[..., index] * float(fields.band.blackbody_radiance(kelvin)))
    angles = fields.angles[np.unique(np.linspace(0, fields.angles.size - 1, 5).astype(int))]
    columns = []
    for elevation in elevations:
        path = fields.path(lines, elevation, fields.met(lines, elevation, angles))
        illumination = fields.sky(lines, elevation)[..., codes, 0] + 0.5 * fields.direct(lines, elevation)[..., codes]
        columns += [glow[..., None] + illumination[..., None] + path[..., None, :] for glow in emitted]
    parts = [column.reshape(*lines.range.shape, -1) for column in columns]
    return np.concatenate(parts, axis=-1) / weights.per_kelvin


def _nodes(
    coordinates: AirCoordinates,
    candidates: tuple[Floats, Floats, Floats],
    sampled: Callable[[LinesOfSight], Floats],
    texels: int,
) -> tuple[Floats, Floats, Floats]:
    """Nodes of the three axes, whose first two make at most `texels`."""
    first_nodes = coordinates.first_nodes(candidates)
    orders, errors = [], []
    for axis in range(3):
        thin = [c if k == axis else _thinned(c, 9) for k, c in enumerate(candidates)]
        lines = coordinates.lines(*thin)
        values = np.moveaxis(sampled(lines), 2 - axis, 0).reshape(candidates[axis].size, -1)
        max_nodes = _MOST_LAYERS if axis == 2 else _MOST_NODES
        start = np.searchsorted(candidates[axis], first_nodes[axis])
        order, error = insertion_order(candidates[axis], values, start, max_nodes)
        orders.append(order)
        errors.append(error)
    counts = (*best_counts((errors[0], errors[1]), texels, TOLERANCE_K), orders[2].size)
    first_axis, second_axis, third_axis = (candidates[axis][np.sort(orders[axis][: counts[axis]])] for axis in range(3))
    return first_axis, second_axis, third_axis


def _thinned(axis: Floats, count: int) -> Floats:
    return np.asarray(axis[np.unique(np.linspace(0, axis.size - 1, count).astype(int))])


def _needed(columns: Floats) -> int:
    """Principal components that fields (..., F) need, a multiple of four."""
    flat = columns.reshape(-1, columns.shape[-1])
    projected, right, _ = _projected(flat, _COMPONENTS[-1])
    for count in _COMPONENTS:
        residual = np.abs(flat - projected[:, :count] @ right[:, :count].T)
        if np.quantile(residual, 0.999) <= TOLERANCE_K:
            return count
    return _COMPONENTS[-1]


def _principal(columns: Floats, count: int) -> Floats:
    """The first principal components (P, count) of columns (P, F) in units of their largest values."""
    projected, _, rank = _projected(columns, count)
    basis = np.zeros((len(columns), count))
    basis[:, :rank] = projected[:, :rank] / np.abs(projected[:, :rank]).max(axis=0)
    return basis


def _projected(columns: Floats, count: int) -> tuple[Floats, Floats, int]:
    """Columns (P, F) along their first directions (P, count); the directions (F, count); how many are not zero.

    From the eigenvectors of the products of columns, which are fewer than the lines.
    """
    values, vectors = np.linalg.eigh(columns.T @ columns)
    directions = vectors[:, ::-1][:, :count]
    rank = int(np.sum(values[::-1][:count] > values[-1] * columns.shape[1] * np.finfo(float).eps))
    return columns @ directions, directions, rank
