"""Sun and Moon of a job: irradiance outside the atmosphere, and the hours in which they are up."""

from __future__ import annotations

import numpy as np
import scipy

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.gases.lagrange import lagrange_weights
from skyshine.mat.atmosphere.sources.ephemeris import SourcePosition, position
from skyshine.mat.atmosphere.sources.lunar import lunar_irradiance
from skyshine.mat.atmosphere.sources.solar import ASTRONOMICAL_UNIT, solar_irradiance
from skyshine.mat.job.fields import clock_text
from skyshine.mat.job.model import Job
from skyshine.mat.job.site import Site, local_times_utc
from skyshine.schemas.arrays import Floats

SUNLIGHT_UM, SUNLIGHT_NODES = (0.25, 25.0), 3000
# Hours between computed positions of a source, of which so many lie beyond either end, and degree of the splines.
TRACK_NODE_H, _TRACK_ENDS, _TRACK_DEGREE = 1.0, 3, 7
_HOURS = np.arange(25.0)  # hours of a day: cubics between them give elevations near the horizon within 0.005 degree
USUAL_PHASE = 60.0  # degree; the shape of moonlight changes little from full Moon to beyond the quarters
MEAN_MOON_DISTANCE = 384_400e3  # m, semi-major axis
LONGEST_WAVE = 1000.0  # um, the end of the solar table and of the band model


def source_irradiance(job: Job, source: str, wavenumber: Floats, width: Floats | None = None) -> Floats:
    """Irradiance (P,) of a source outside the atmosphere on the day of the job, W m^-2 (cm^-1)^-1; mean over widths in
    cm^-1.

    The Sun at its distance at noon; the Moon at its phase and distance at local midnight, the middle of the night
    that its tables are for.
    """
    site = job.site
    hour = 12.0 if source == "sun" else 24.0
    where = position(source, local_times_utc(site, np.array([hour])), site.latitude_deg, site.longitude_deg)
    if source == "sun":
        sunlight: Floats = solar_irradiance(wavenumber, width) / where.sun_distance[0] ** 2
        return sunlight
    moon = lunar_irradiance(
        wavenumber, where.phase_angle[0], where.distance[0], where.sun_distance[0], bool(where.waxing[0]), width
    )
    return moon.total


def usual_irradiance(source: str, wavenumber: Floats, width: Floats | None = None) -> Floats:
    """Irradiance (P,) outside the atmosphere that is the same on all days, W m^-2 (cm^-1)^-1: of the Sun at 1 au, or of
    the Moon at its mean distance and `USUAL_PHASE`. Points of a band are chosen under it.
    """
    if source == "sun":
        return solar_irradiance(wavenumber, width)
    return lunar_irradiance(wavenumber, USUAL_PHASE, MEAN_MOON_DISTANCE, 1.0, width=width).total


def solar_spectrum(longest: float = SUNLIGHT_UM[1]) -> tuple[Floats, Floats]:
    """Sunlight outside the atmosphere at 1 au.

    Parameters
    ----------
    longest : float
        [um], 25 to 1000. To 25 um lies all but 4e-5 of the energy, which is enough for the absorptance of a material;
        the weights of a band need the waves of the band.

    Returns
    -------
    wavelength : (n,) array
        [um], increasing from 0.25.
    irradiance : (n,) array
        [W m^-2 um^-1].
    """
    wavelength = np.geomspace(*SUNLIGHT_UM, SUNLIGHT_NODES)
    if longest > SUNLIGHT_UM[1]:
        per_decade = (SUNLIGHT_NODES - 1) / np.log10(SUNLIGHT_UM[1] / SUNLIGHT_UM[0])
        count = 1 + int(np.ceil(per_decade * np.log10(longest / SUNLIGHT_UM[1])))
        wavelength = np.concatenate([wavelength, np.geomspace(SUNLIGHT_UM[1], longest, count)[1:]])
    wavenumber = 1e4 / wavelength
    return wavelength, solar_irradiance(wavenumber) * wavenumber**2 * 1e-4


def source_hours(job: Job, step: float = 1 / 12) -> dict[str, list[tuple[str, str]]]:
    """Local clock times between which each source of the job is above the horizon, to the step in hours."""
    site, hours = job.site, np.arange(0.0, 24.0, step)
    between = lagrange_weights(_HOURS, hours)
    spans: dict[str, list[tuple[str, str]]] = {}
    for source in job.sources:
        where = position(
            source, local_times_utc(site, _HOURS), site.latitude_deg, site.longitude_deg, 1e3 * site.altitude_km
        )
        up = between @ np.sin(np.radians(where.elevation)) > 0
        edges = np.flatnonzero(np.diff(np.concatenate([[False], up, [False]]).astype(int)))
        spans[source] = [
            (clock_text(hours[a]), clock_text(hours[b - 1] + step))
            for a, b in zip(edges[::2], edges[1::2], strict=True)
        ]
    return spans


def irradiance_of_sources(job: Job, band: BandPoints) -> Floats:
    """Irradiance (B, P) W m^-2 (cm^-1)^-1 of each source of a job outside the atmosphere, at the points of a band."""
    return np.stack([source_irradiance(job, source, band.wavenumber, band.width) for source in job.sources])


def source_tracks(site: Site, hours: Floats) -> dict[str, Floats]:
    """Positions of Sun and Moon at local clock hours on the day of a site, by `source_track`.

    Parameters
    ----------
    hours : (T,) array
        Increasing; beyond 24 on the next day.

    Returns
    -------
    dict of str to (T,) array
        sun_elevation, sun_azimuth [degree], sun_distance [au]; moon_elevation, moon_azimuth, moon_phase_angle
        [degree], moon_distance [km]. Azimuths have no jumps.
    """
    tracks: dict[str, Floats] = {}
    for source, unit in (("sun", ASTRONOMICAL_UNIT), ("moon", 1e3)):
        track = source_track(site, source, hours)
        tracks[f"{source}_elevation"] = track.elevation
        tracks[f"{source}_azimuth"] = np.degrees(np.unwrap(np.radians(track.azimuth)))
        tracks[f"{source}_distance"] = track.distance / unit
        if source == "moon":
            tracks["moon_phase_angle"] = track.phase_angle
    return tracks


def source_track(site: Site, source: str, hours: Floats) -> SourcePosition:
    """Positions of a source at local clock hours (T,), increasing, on the day of a site.

    They are computed each hour; splines through them give the direction between them within 0.001 degree.
    """
    beyond = _TRACK_ENDS * TRACK_NODE_H
    nodes = np.arange(hours[0] - beyond, hours[-1] + TRACK_NODE_H + beyond, TRACK_NODE_H)
    where = position(
        source, local_times_utc(site, nodes), site.latitude_deg, site.longitude_deg, 1e3 * site.altitude_km
    )
    up, turn = np.radians(where.elevation), np.radians(where.azimuth)
    level = np.cos(up)
    vector = np.stack([level * np.sin(turn), level * np.cos(turn), np.sin(up)], axis=-1) * where.distance[:, None]

    def between(values: Floats) -> Floats:
        spline: Floats = scipy.interpolate.make_interp_spline(nodes, values, k=_TRACK_DEGREE)(hours)
        return spline

    east, north, above = between(vector).T
    return SourcePosition(
        np.degrees(np.arctan2(above, np.hypot(east, north))),
        np.degrees(np.arctan2(east, north)) % 360.0,
        np.sqrt(east**2 + north**2 + above**2),
        np.clip(between(where.phase_angle), 0.0, 180.0),
        where.waxing[np.searchsorted(nodes, hours, side="right") - 1],
        between(where.sun_distance),
    )
