"""Spectra of one line of sight: transmittance by gas, path radiance, light on the surface at its end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer import segments as transfer
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.geometry import scattering_cosine, source_cosine, trace
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, sky_irradiance
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
        Of each gas alone; the water vapour continuum apart.
    transmittance_rayleigh, transmittance_aerosol : (B,) arrays
        Of scattering by molecules alone, and of particles.
    path_thermal, path_scattered : (B,) arrays
        W m^-2 sr^-1 (cm^-1)^-1.
    sky_irradiance, direct_irradiance : (B,) arrays
        Diffuse, and direct normal to the beam, at the end of the line of sight; at the observer where that leads into
        space. W m^-2 (cm^-1)^-1.
    range : float
        m, to the end of the range or to the ground; infinite into space.
    ground : bool
        The line of sight ends at the ground.
    """

    wavenumber: np.ndarray
    transmittance: np.ndarray
    transmittance_by_gas: dict[str, np.ndarray]
    transmittance_rayleigh: np.ndarray
    transmittance_aerosol: np.ndarray
    path_thermal: np.ndarray
    path_scattered: np.ndarray
    sky_irradiance: np.ndarray
    direct_irradiance: np.ndarray
    range: float
    ground: bool


def line_spectrum(
    state, points, irradiance, *, altitude, elevation, distance, source_elevation, source_azimuth, resolution=None
):
    """Spectra along one line of sight.

    Parameters
    ----------
    state : AtmosphericState
    points : SpectralPoints
    irradiance : (P,) array
        Of the source outside the atmosphere, W m^-2 (cm^-1)^-1; 0 for none.
    altitude, elevation, distance : float
        Of the observer above sea level, m; of the line of sight, rad; its range, m, infinite for space.
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
    parts = []
    for start in range(0, points.wavenumber.size, _CHUNK):
        part = slice(start, start + _CHUNK)
        index = np.arange(points.wavenumber.size)[part]
        air = SpectralAir.of(state, points.subset(index))
        values, length, ground = _monochromatic(
            air,
            irradiance[part],
            altitude,
            elevation,
            distance,
            np.array([source_elevation]),
            np.array([source_azimuth]),
        )
        parts.append(values)
    width = np.bincount(bins, points.weight, centre.size)

    def mean(name):
        return np.bincount(bins, points.weight * np.concatenate([part[name] for part in parts]), centre.size) / width

    gases = parts[0]["gases"]
    fields = (name for name in LineSpectrum.__dataclass_fields__ if name in parts[0])
    return LineSpectrum(
        wavenumber=centre,
        transmittance_by_gas={gas: mean(gas) for gas in gases},
        range=length,
        ground=ground,
        **{name: mean(name) for name in fields},
    )


def _monochromatic(air, irradiance, altitude, elevation, distance, source_elevation, source_azimuth):
    """All spectra at the points of `air`, with the length of the path [m] and whether it ends at the ground."""
    optics = air.optics
    rays = trace(
        air.shells, np.array([altitude]), np.array([elevation]), np.array([[min(distance, np.finfo(float).max)]])
    )
    ground = bool(rays.ground[0] and distance >= rays.end[0])
    length = float(rays.end[0]) if ground else distance
    segments = transfer.Segments.of(rays, 0)
    segments = segments.first(min(int(np.searchsorted(segments.distance, length)), segments.index.size))
    depths = transfer.Depths(segments.column(optics.extinction))
    values = {
        "transmittance": np.exp(-depths.before[-1]),
        "path_thermal": air.thermal_radiance(segments, depths).sum(axis=0),
    }
    values["gases"] = tuple(optics.absorption)
    apart = {"transmittance_rayleigh": optics.rayleigh, "transmittance_aerosol": optics.aerosol_extinction}
    for name, section in {**optics.absorption, **apart}.items():
        values[name] = np.exp(-segments.column(section).sum(axis=0))
    values["path_scattered"] = np.zeros(irradiance.size)
    if segments.index.size and np.any(irradiance > 0):
        ends = np.append(segments.index, segments.index[-1] + 1)
        to_source = source_cosine(rays, source_elevation, source_azimuth)[0, ends]
        deflection = scattering_cosine(rays, source_elevation, source_azimuth)[0, ends]
        values["path_scattered"] = air.scattered_radiance(segments, depths, to_source, deflection)[0] * irradiance
    surface = np.array([altitude if np.isinf(distance) and not ground else segments.altitude[-1]])
    sky = sky_irradiance(air, surface, source_elevation if np.any(irradiance > 0) else np.zeros(0))
    values["sky_irradiance"] = sky.thermal[0] + sky.scattered.sum(axis=(0, 1)) * irradiance
    values["direct_irradiance"] = direct_transmittance(air.source_paths, surface, source_elevation)[0, 0] * irradiance
    return values, length, ground


def _bins(points, resolution):
    """The bin of each point, and the middle of each bin [cm^-1]."""
    low, high = points.interval_edges.T
    if resolution is None:
        return points.interval, 0.5 * (low + high)
    width = float(np.max(high - low))
    ratio = resolution / width
    if not (np.isfinite(ratio) and ratio > 0.999 and abs(ratio - round(ratio)) < 1e-6):
        raise InputError(
            f"resolution {resolution:g} cm^-1 is not a multiple of the {width:g} cm^-1 of the absorption table;"
            " give one"
        )
    place = np.floor((low - low[0]) / resolution + 1e-9).astype(int)
    _, number = np.unique(place, return_inverse=True)
    count = number.max() + 1
    centre = 0.5 * (
        np.array([low[number == b].min() for b in range(count)])
        + np.array([high[number == b].max() for b in range(count)])
    )
    return number[points.interval], centre
