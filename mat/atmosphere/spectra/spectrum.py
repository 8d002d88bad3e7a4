"""Spectra of one line of sight: transmittance by gas, path radiance, light on the surface at its end."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.directions import angles_along
from skyshine.mat.atmosphere.transfer.geometry import Rays, scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.night_light import night_irradiance, night_radiance
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance, zenith_angles
from skyshine.mat.atmosphere.transfer.source_nodes import elevations_along
from skyshine.schemas.arrays import Floats, Integers, Reals
from skyshine.schemas.errors import InputError

# Points computed together: bounds memory to about 100 MB.
_CHUNK = 600


@dataclass(frozen=True, eq=False)
class LineSpectrum:
    """Means over B spectral bins.

    Attributes
    ----------
    wavenumber : (B,) array
        Middle of each bin, cm^-1.
    transmittance : (B,) array
    transmittance_by_gas : dict of (B,) arrays
        Transmittances of each gas alone; the water vapour continuum separately.
    transmittance_rayleigh, transmittance_aerosol : (B,) arrays
        Transmittances of scattering by molecules alone, and of particles.
    path_thermal, path_scattered : (B,) arrays
        W m^-2 sr^-1 (cm^-1)^-1.
    sky_irradiance, direct_irradiance : (B,) arrays
        Diffuse, and direct normal to the beam, at the end of the line of sight; at the observer where that leads into
        space. W m^-2 (cm^-1)^-1.
    night_sky : (B,) array
        Radiance of airglow and starlight at the end of a line of sight that leads into space above the horizon, through
        the air; 0 elsewhere, and where the state has no night sky. W m^-2 sr^-1 (cm^-1)^-1.
    range : float
        m, to the end of the range or to the ground; infinite into space.
    ground : bool
        The line of sight ends at the ground.
    """

    wavenumber: Floats
    transmittance: Floats
    transmittance_by_gas: dict[str, Floats]
    transmittance_rayleigh: Floats
    transmittance_aerosol: Floats
    path_thermal: Floats
    path_scattered: Floats
    sky_irradiance: Floats
    direct_irradiance: Floats
    night_sky: Floats
    range: float
    ground: bool


def line_spectrum(
    state: AtmosphericState,
    points: SpectralPoints,
    irradiance: Floats,
    *,
    altitude: float,
    elevation: float,
    distance: float,
    source_elevation: float,
    source_azimuth: float,
    resolution: float | None = None,
) -> LineSpectrum:
    """Spectra along one line of sight.

    Parameters
    ----------
    state : AtmosphericState
    points : SpectralPoints
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, W m^-2 (cm^-1)^-1; 0 for none.
    altitude, elevation, distance : float
        Altitude of the observer above sea level, m; elevation of the line of sight, rad; its range, m, infinite for
        space.
    source_elevation, source_azimuth : float
        rad; at the observer for path radiance, azimuth from that of the line of sight; for the light on the surface the
        elevation is that at the surface.
    resolution : float, optional
        Width of the bins, cm^-1, a multiple of the interval width; by default each interval is a bin.

    Returns
    -------
    LineSpectrum

    Raises
    ------
    InputError
        For a resolution below the width of an interval, or what `geometry.trace` refuses.
    """
    bins, centre = _bins(points, resolution)
    values, line = line_points(
        state,
        points,
        irradiance,
        altitude=altitude,
        elevation=elevation,
        distance=distance,
        source_elevation=source_elevation,
        source_azimuth=source_azimuth,
    )
    width = np.bincount(bins, points.weight, centre.size)

    def mean(name: str) -> Floats:
        binned: Floats = np.bincount(bins, points.weight * values[name], centre.size) / width
        return binned

    return LineSpectrum(
        wavenumber=centre,
        transmittance=mean("transmittance"),
        transmittance_by_gas={gas: mean(gas) for gas in line.gases},
        transmittance_rayleigh=mean("transmittance_rayleigh"),
        transmittance_aerosol=mean("transmittance_aerosol"),
        path_thermal=mean("path_thermal"),
        path_scattered=mean("path_scattered"),
        sky_irradiance=mean("sky_irradiance"),
        direct_irradiance=mean("direct_irradiance"),
        night_sky=mean("night_sky"),
        range=line.length,
        ground=line.ground,
    )


def line_points(
    state: AtmosphericState,
    points: SpectralPoints,
    irradiance: Floats,
    *,
    altitude: float,
    elevation: float,
    distance: float,
    source_elevation: float,
    source_azimuth: float,
) -> tuple[dict[str, Reals], LineEnd]:
    """What `line_spectrum` averages, at each spectral point.

    Parameters
    ----------
    state, points, irradiance, altitude, elevation, distance, source_elevation, source_azimuth
        As for `line_spectrum`.

    Returns
    -------
    dict of (P,) arrays
        By the names of `LineSpectrum`, the transmittance of each gas by its own; ``sky_thermal`` and
        ``sky_scattered``, the parts of the sky's irradiance, beside it.
    LineEnd
    """
    source = np.array([source_elevation]), np.array([source_azimuth])
    parts = []
    for start in range(0, points.wavenumber.size, _CHUNK):
        part = slice(start, start + _CHUNK)
        air = SpectralAir.of(state, points.subset(np.arange(points.wavenumber.size)[part]))
        line = _Line.of(air, altitude, elevation, distance)
        air = _of_line(air, line, *source)
        parts.append(_along(air, line) | _from_source(air, line, irradiance[part], *source))
    values = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return values, LineEnd(line.length, line.ground, tuple(air.optics.absorption))


@dataclass(frozen=True)
class LineEnd:
    """Where a line of sight ends, and which gases absorb along it.

    Attributes
    ----------
    length : float
        m; infinite into space.
    ground : bool
    gases : tuple of str
    """

    length: float
    ground: bool
    gases: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Line:
    """A traced line of sight to its range.

    Attributes
    ----------
    rays : Rays
        Rays with M = 1.
    segments : Segments
        Up to the range.
    depths : Depths
    length : float
        m; to the ground if the line ends there.
    ground : bool
        The line ends at the ground.
    surface : (1,) array
        Altitude of the end, m; of the observer where the line leads into space.
    elevation : float
        Elevation of the line at the observer, rad.
    """

    rays: Rays
    segments: Segments
    depths: Depths
    length: float
    ground: bool
    surface: Floats
    elevation: float

    @classmethod
    def of(cls, air: SpectralAir, altitude: float, elevation: float, distance: float) -> _Line:
        """The line from an altitude [m] at an elevation [rad] over a distance [m]."""
        reach = np.array([[min(distance, np.finfo(float).max)]])
        rays = trace(air.shells, np.array([altitude]), np.array([elevation]), reach)
        ground = bool(rays.ground[0] and distance >= rays.end[0])
        length = float(rays.end[0]) if ground else distance
        segments = Segments.of(rays, 0).within(length)
        end = altitude if np.isinf(distance) and not ground else segments.altitude[-1]
        depths = Depths(segments.column(air.optics.extinction))
        return cls(rays, segments, depths, length, ground, np.array([end]), elevation)


def _of_line(air: SpectralAir, line: _Line, source_elevation: Floats, source_azimuth: Floats) -> SpectralAir:
    """The air with its scattered light solved where the line needs it: for the source's elevations along it, in its own
    directions and those from which the sky lights its end.
    """
    segments = line.segments
    sources, angles = np.sin(source_elevation), set(zenith_angles())
    if segments.index.size:
        along = source_cosine(line.rays, source_elevation, source_azimuth)[0, segments.ends]
        sources = np.append(sources, 0.5 * (along[1:] + along[:-1]))
        angles |= set(angles_along(segments.upward_cosine))
    return replace(air, elevations=elevations_along(sources), angles=tuple(sorted(angles)))


def _along(air: SpectralAir, line: _Line) -> dict[str, Reals]:
    """Transmittances and thermal path radiance (P,) by name."""
    optics, segments = air.optics, line.segments
    sections = {
        **optics.absorption,
        "transmittance_rayleigh": optics.rayleigh,
        "transmittance_aerosol": optics.aerosol_extinction,
    }
    return {
        "transmittance": np.exp(-line.depths.cumulative[-1]),
        "path_thermal": air.thermal_radiance(segments, line.depths).sum(axis=0),
        "night_sky": _behind(air, line),
        **{name: np.exp(-segments.column(section).sum(axis=0)) for name, section in sections.items()},
    }


def _behind(air: SpectralAir, line: _Line) -> Floats:
    """Radiance (P,) of the night sky at the end of a line that leads into space, as the air lets it through."""
    if np.isfinite(line.length) or line.elevation <= 0:
        return np.zeros(air.optics.wavenumber.size)
    whole = night_radiance(air, float(np.sin(line.elevation)), float(line.surface[0]))
    seen: Floats = whole * np.exp(-line.depths.cumulative[-1])
    return seen


def _from_source(
    air: SpectralAir, line: _Line, irradiance: Floats, source_elevation: Floats, source_azimuth: Floats
) -> dict[str, Floats]:
    """Scattered path radiance and irradiances of the surface at the end of the line, (P,) by name."""
    scattered, segments = np.zeros(irradiance.size), line.segments
    dark = not np.any(irradiance > 0)
    if segments.index.size and not dark:
        to_source = source_cosine(line.rays, source_elevation, source_azimuth)[0, segments.ends]
        deflection = scattering_cosine(line.rays, source_elevation, source_azimuth)[0, segments.ends]
        scattered = air.scattered_light.along(segments, line.depths, to_source, deflection)[0][0] * irradiance
    sky = sky_irradiance(air, line.surface, np.zeros(0) if dark else source_elevation)
    direct = direct_transmittance(air.source_paths, line.surface, source_elevation)[0, 0]
    night = night_irradiance(air, line.surface)[0]
    lit = sky.scattered.sum(axis=(0, 1)) * irradiance
    return {
        "path_scattered": scattered,
        "sky_thermal": sky.thermal[0],
        "sky_scattered": lit,
        "sky_irradiance": sky.thermal[0] + lit + night,
        "direct_irradiance": direct * irradiance,
    }


def _bins(points: SpectralPoints, resolution: float | None) -> tuple[Integers, Floats]:
    """The bin of each point (P,), and the middle of each bin (B,) [cm^-1]."""
    low, high = points.interval_edges.T
    if resolution is None:
        return points.interval, 0.5 * (low + high)
    width = float(np.max(high - low))
    ratio = resolution / width
    if not (np.isfinite(ratio) and ratio > 0.999 and abs(ratio - round(ratio)) < 1e-6):
        raise InputError(
            f"resolution {resolution:g} cm^-1 is not a multiple of the {width:g} cm^-1 of the absorption table;"
            " give one, or line_by_line with a folder of HITRAN records for finer bins"
        )
    place = np.floor((low - low[0]) / resolution + 1e-9).astype(int)
    _, number = np.unique(place, return_inverse=True)
    count = number.max() + 1
    centre = 0.5 * (
        np.array([low[number == b].min() for b in range(count)])
        + np.array([high[number == b].max() for b in range(count)])
    )
    return number[points.interval], centre
