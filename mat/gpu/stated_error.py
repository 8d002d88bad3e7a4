"""Random pixels: how far an exported atmosphere is from the library in double precision."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.gpu.air import relative
from skyshine.mat.gpu.container import GpuFile
from skyshine.mat.gpu.evaluation import GpuAir
from skyshine.mat.quantities.lines_of_sight import LinesOfSight, direction
from skyshine.mat.runtime.pixel import Faces, View, pixel_radiance
from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Floats

PIXELS = 4000  # random pixels, so that 40 lie beyond the 99th percentile
_FRAMES = 16  # random hours and altitudes
_SEED = 17  # seed of random numbers, so that an export is the same bytes
_FARTHEST_KM, _NEAREST_KM = 50.0, 0.05  # ranges of a ground scene [km]
_SPREAD_K = 25.0  # spread of surface temperatures about 295 K


@dataclass(frozen=True, eq=False)
class Pixels:
    """Random pixels of one source elevation."""

    faces: Faces
    view: View


def random_pixels(
    content: GpuFile, count: int, random: np.random.Generator, source_elevation: float, hour: float = 0.0
) -> Pixels:
    """Pixels (count,) of all materials, most of them on the ground, some in the air; some are seen from below."""
    numbers = content.numbers
    low, high = numbers["altitude_km"]
    altitude = random.uniform(low, high, count)
    ground = numbers["ground_altitude_km"]
    elevation = -np.degrees(np.arcsin(random.uniform(0.02, 1.0, count)))
    elevation[: count // 8] = random.uniform(-2.0, 10.0, count // 8)
    drop = np.maximum(altitude - ground, 1e-3)
    to_ground = drop / np.maximum(np.sin(np.radians(-elevation)), 1e-3)
    nearest, farthest = max(numbers["range_km"][0], _NEAREST_KM), min(numbers["range_km"][1], _FARTHEST_KM)
    unobstructed = np.exp(random.uniform(np.log(nearest), np.log(farthest), count))
    airborne = random.random(count) < 0.25
    reach = np.clip(
        np.where(airborne | (elevation > -1), np.minimum(unobstructed, to_ground), to_ground), nearest, farthest
    )
    codes = random.choice(np.array(numbers["material"]), (count, 1))
    slope = np.where(random.random(count) < 0.5, 0.0, random.uniform(0.0, 120.0, count))
    if not numbers["harmonic"]:
        slope[:] = 0.0
    azimuth, heading, line = (random.uniform(0.0, 360.0, count) for _ in range(3))
    temperature = random.uniform(295.0 - _SPREAD_K, 295.0 + _SPREAD_K, (count, 1))
    lines = LinesOfSight(reach, altitude, elevation, np.full(count, source_elevation), heading - line)
    view = View.of(lines, line, direction(90.0 - slope, azimuth))
    zeros = np.zeros(count)
    kelvin, _ = GpuAir.of(content).ground_at(hour)
    ground = None if np.isnan(kelvin) else np.full(count, kelvin)
    shares = np.ones((count, 1))
    faces = Faces(codes, shares, zeros, azimuth, slope, zeros, temperature, ground_temperature=ground)
    return Pixels(faces, view)


def with_stated_error(content: GpuFile, air: AtmosphereTable, band: BandTable, surface: TemperatureTable) -> GpuFile:
    """An export with its largest and 99 % difference from the library over random pixels.

    In kelvin of apparent temperature; in percent of the radiance where the band has no thermal radiance.
    """
    random = np.random.default_rng(_SEED)
    gpu = GpuAir.of(content)
    heights = content.numbers["source_elevation"]["path"]
    if len(heights) == 1:
        elevations = np.full(_FRAMES, heights[0])
    else:
        elevations = random.uniform(
            content.numbers["lowest_source_elevation"], content.numbers["highest_source_elevation"], _FRAMES
        )
    errors = []
    for elevation in elevations:
        hour = float(random.uniform(0.0, 24.0))
        pixels = random_pixels(content, PIXELS // _FRAMES, random, float(elevation), hour)
        exact = pixel_radiance(surface, band, air, pixels.faces, pixels.view).radiance
        read = gpu.frame(float(elevation), hour).radiance(band, pixels.faces, pixels.view)
        errors.append(np.abs(_measure(exact, read, air, band)))
    error = np.concatenate(errors)
    units = "%" if relative(air) else "K"
    stated = {
        "pixels": int(error.size),
        "units": units,
        "largest": float(error.max()),
        "p99": float(np.quantile(error, 0.99)),
    }
    return replace(content, stated_error=stated)


def _measure(exact: Floats, read: Floats, air: AtmosphereTable, band: BandTable) -> Floats:
    if relative(air):
        return np.asarray(100 * (read / exact - 1))
    return apparent_temperature(band, read) - apparent_temperature(band, exact)


def apparent_temperature(band: BandTable, radiance: Floats) -> Floats:
    """Temperature [K] of a black body of a radiance, within the table of (7)."""
    nodes = np.asarray(band.root.axes["temperature"].values, float)
    values = np.asarray(band.root.variables["blackbody_radiance"].data, float)
    return np.asarray(np.interp(radiance, values, nodes))
