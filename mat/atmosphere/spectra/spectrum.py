"""Spectra of lines of sight: transmittance by gas, path radiance, light on the surface at their ends."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.directions import angles_along
from skyshine.mat.atmosphere.transfer.geometry import Rays, scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.night_light import night_irradiance, night_radiance
from skyshine.mat.atmosphere.transfer.segments import Depths, Segments
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance, zenith_angles
from skyshine.mat.atmosphere.transfer.source_nodes import elevations_along
from skyshine.schemas.arrays import Booleans, Floats, Integers, Reals
from skyshine.schemas.errors import InputError

# Points computed together: bounds memory to about 100 MB.
_CHUNK = 600


@dataclass(frozen=True, eq=False)
class LineSpectrum:
    """Means over B spectral bins, of lines of sight in an array of any shape (...); that of a single one is ().

    Attributes
    ----------
    wavenumber : (B,) array
        Middle of each bin, cm^-1.
    transmittance : (..., B) array
    transmittance_by_gas : dict of (..., B) arrays
        Transmittances of each gas alone; the water vapour continuum separately.
    transmittance_rayleigh, transmittance_aerosol : (..., B) arrays
        Transmittances of scattering by molecules alone, and of particles.
    path_thermal, path_scattered : (..., B) arrays
        W m^-2 sr^-1 (cm^-1)^-1.
    sky_irradiance, direct_irradiance : (..., B) arrays
        Diffuse, and direct normal to the beam, at the end of the line of sight; at the observer where that leads into
        space. W m^-2 (cm^-1)^-1.
    night_sky : (..., B) array
        Radiance of airglow and starlight at the end of a line of sight that leads into space above the horizon, through
        the air; 0 elsewhere, and where the state has no night sky. W m^-2 sr^-1 (cm^-1)^-1.
    range : float or (...) array
        m, to the end of the range or to the ground; infinite into space.
    ground : bool or (...) array
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
    range: float | Floats
    ground: bool | Booleans


def line_spectrum(
    state: AtmosphericState,
    points: SpectralPoints,
    irradiance: Floats,
    *,
    altitude: npt.ArrayLike,
    elevation: npt.ArrayLike,
    distance: npt.ArrayLike,
    source_elevation: float,
    source_azimuth: float,
    resolution: float | None = None,
) -> LineSpectrum:
    """Spectra along lines of sight through one air, whose scattered light is solved once for all of them.

    Parameters
    ----------
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, W m^-2 (cm^-1)^-1; 0 for none.
    altitude, elevation, distance : float or arrays
        Altitude of the observer above sea level, m; elevation of the line of sight, rad; its range, m, infinite for
        space. Arrays are broadcast to one shape.
    source_elevation, source_azimuth : float
        rad; at the observer for path radiance, azimuth from that of the line of sight; for the light on the surface the
        elevation is that at the surface.
    resolution : float, optional
        Width of the bins, cm^-1, a multiple of the interval width; by default each interval is a bin.

    Raises
    ------
    InputError
        For a resolution below the width of an interval, or what `geometry.trace` refuses.
    """
    bins, centre = _bins(points, resolution)
    sights = np.broadcast_arrays(*(np.asarray(value, dtype=float) for value in (altitude, elevation, distance)))
    shape, rows = sights[0].shape, np.stack([sight.ravel() for sight in sights], axis=1)
    sums: dict[str, Floats] = {}
    ends: list[LineEnd] = []
    for part, number, values, end in _parts(state, points, irradiance, rows, source_elevation, source_azimuth):
        for name, at_points in values.items():
            if name not in sums:
                sums[name] = np.zeros((len(rows), centre.size))
            sums[name][number] += np.bincount(bins[part], points.weight[part] * at_points, centre.size)
        if part.start == 0:
            ends.append(end)
    width = np.bincount(bins, points.weight, centre.size)
    means = {name: (total / width).reshape(*shape, centre.size) for name, total in sums.items()}
    length, ground = np.array([end.length for end in ends]), np.array([end.ground for end in ends])
    return LineSpectrum(
        wavenumber=centre,
        transmittance_by_gas={gas: means[gas] for gas in ends[0].gases},
        range=length.reshape(shape) if shape else float(length[0]),
        ground=ground.reshape(shape) if shape else bool(ground[0]),
        **{name: means[name] for name in _MEANS},
    )


_MEANS = (
    *("transmittance", "transmittance_rayleigh", "transmittance_aerosol", "path_thermal", "path_scattered"),
    *("sky_irradiance", "direct_irradiance", "night_sky"),
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
    """What `line_spectrum` averages of a single line of sight, at each spectral point.

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
    rows = np.array([[altitude, elevation, distance]])
    parts = list(_parts(state, points, irradiance, rows, source_elevation, source_azimuth))
    return {name: np.concatenate([part[2][name] for part in parts]) for name in parts[0][2]}, parts[0][3]


def _parts(
    state: AtmosphericState,
    points: SpectralPoints,
    irradiance: Floats,
    rows: Floats,
    source_elevation: float,
    source_azimuth: float,
) -> Iterator[tuple[slice, int, dict[str, Reals], LineEnd]]:
    """Values at parts of the points: the part, the number of the line, its values (p,) by name, and its end. Lines of
    sight are rows (M, 3) of altitude, elevation, distance.
    """
    source = np.array([source_elevation]), np.array([source_azimuth])
    dark = not np.any(irradiance > 0)
    for start in range(0, points.wavenumber.size, _CHUNK):
        part = slice(start, start + _CHUNK)
        air = SpectralAir.of(state, points.subset(np.arange(points.wavenumber.size)[part]))
        lines = [_Line.of(air, *row) for row in rows.tolist()]
        air = _of_lines(air, lines, *source)
        surfaces, surface_number = np.unique([line.surface for line in lines], return_inverse=True)
        light = _light_on(air, surfaces, irradiance[part], source[0], dark)
        for number, line in enumerate(lines):
            depths = Depths(line.segments.column(air.optics.extinction))
            values = _along(air, line, depths) | {name: rows[surface_number[number]] for name, rows in light.items()}
            values["path_scattered"] = np.zeros(air.optics.wavenumber.size)
            if line.segments.index.size and not dark:
                values["path_scattered"] = _scattered(air, line, depths, *source) * irradiance[part]
            yield part, number, values, LineEnd(line.length, line.ground, tuple(air.optics.absorption))


@dataclass(frozen=True)
class LineEnd:
    """Where a line of sight ends, and which gases absorb along it.

    Attributes
    ----------
    length : float
        m; infinite into space.
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
    length : float
        m; to the ground if the line ends there.
    ground : bool
        The line ends at the ground.
    surface : float
        Altitude of the end, m; of the observer where the line leads into space.
    elevation : float
        Elevation of the line at the observer, rad.
    """

    rays: Rays
    segments: Segments
    length: float
    ground: bool
    surface: float
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
        return cls(rays, segments, length, ground, float(end), elevation)


def _of_lines(
    air: SpectralAir, lines: Sequence[_Line], source_elevation: Floats, source_azimuth: Floats
) -> SpectralAir:
    """The air with its scattered light solved where the lines need it: for the source's elevations along them, in their
    own directions and those from which the sky lights their ends.
    """
    sines, cosines = [np.sin(source_elevation)], [np.zeros(0)]
    for line in (line for line in lines if line.segments.index.size):
        along = source_cosine(line.rays, source_elevation, source_azimuth)[0, line.segments.ends]
        sines.append(0.5 * (along[1:] + along[:-1]).ravel())
        cosines.append(line.segments.upward_cosine.ravel())
    upward, angles = np.concatenate(cosines), set(zenith_angles())
    if upward.size:
        angles |= set(angles_along(upward))
    return replace(air, elevations=elevations_along(np.concatenate(sines)), angles=tuple(sorted(angles)))


def _along(air: SpectralAir, line: _Line, depths: Depths) -> dict[str, Reals]:
    """Transmittances, thermal path radiance and the night sky (P,) by name."""
    optics, segments = air.optics, line.segments
    sections = {
        **optics.absorption,
        "transmittance_rayleigh": optics.rayleigh,
        "transmittance_aerosol": optics.aerosol_extinction,
    }
    transmittance = np.exp(-depths.cumulative[-1])
    return {
        "transmittance": transmittance,
        "path_thermal": air.thermal_radiance(segments, depths).sum(axis=0),
        "night_sky": _behind(air, line, transmittance),
        **{name: np.exp(-segments.column(section).sum(axis=0)) for name, section in sections.items()},
    }


def _behind(air: SpectralAir, line: _Line, transmittance: Reals) -> Floats:
    """Radiance (P,) of the night sky at the end of a line that leads into space, as the air lets it through."""
    if np.isfinite(line.length) or line.elevation <= 0:
        return np.zeros(air.optics.wavenumber.size)
    radiance: Floats = night_radiance(air, float(np.sin(line.elevation)), line.surface) * transmittance
    return radiance


def _scattered(
    air: SpectralAir, line: _Line, depths: Depths, source_elevation: Floats, source_azimuth: Floats
) -> Floats:
    """Light of the source scattered into a line (P,), per unit of its irradiance."""
    ends = line.segments.ends
    to_source = source_cosine(line.rays, source_elevation, source_azimuth)[0, ends]
    deflection = scattering_cosine(line.rays, source_elevation, source_azimuth)[0, ends]
    scattered: Floats = air.scattered_light.along(line.segments, depths, to_source, deflection)[0][0]
    return scattered


def _light_on(
    air: SpectralAir, surface: Floats, irradiance: Floats, source_elevation: Floats, dark: bool
) -> dict[str, Floats]:
    """Irradiances (Z, P) by name of level surfaces at altitudes (Z,) [m]."""
    sky = sky_irradiance(air, surface, np.zeros(0) if dark else source_elevation)
    scattered = sky.scattered.sum(axis=1) * irradiance
    return {
        "sky_thermal": sky.thermal,
        "sky_scattered": scattered,
        "sky_irradiance": sky.thermal + scattered + night_irradiance(air, surface),
        "direct_irradiance": direct_transmittance(air.source_paths, surface, source_elevation)[:, 0] * irradiance,
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
    bin_number = np.floor((low - low[0]) / resolution + 1e-9).astype(int)
    _, number = np.unique(bin_number, return_inverse=True)
    count = number.max() + 1
    centre = 0.5 * (
        np.array([low[number == b].min() for b in range(count)])
        + np.array([high[number == b].max() for b in range(count)])
    )
    return number[points.interval], centre
