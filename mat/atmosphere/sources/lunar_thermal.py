"""Thermal emission of the whole disk of the Moon: facets of a rough sphere in equilibrium with sunlight.

Every point of the sphere is rough on a scale that is resolved by no observer and whose facets keep their own
temperatures. Their slopes are Gaussian (Shkuratov et al. 2000, ASP Conf. Ser. 196, 221, from the maps of Saari and
Shorthill; Bandfield et al. 2015, doi:10.1016/j.icarus.2014.11.009, from Diviner). Facets hide one another from the Sun
and from the observer as Smith 1967 (doi:10.1109/TAP.1967.1138991) has it, and both hide the same facets where Sun and
observer are in one direction (van Ginneken, Stavridi and Koenderink 1998, doi:10.1364/AO.37.000130): the full Moon
shows few shadows and is brighter than a smooth sphere, the half Moon is darker. A facet receives what it sees of its
surroundings as they would emit when level.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy

from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.schemas.arrays import Floats

SOLAR_CONSTANT = 1361.0  # W m^-2 at 1 au (Kopp and Lean 2011)
SOLAR_ALBEDO = 0.12  # solar albedo of the mean lunar surface (Vasavada et al. 2012, doi:10.1029/2011JE003987)
BROADBAND_EMISSIVITY = 0.95  # (Vasavada et al. 2012)
NIGHT_TEMPERATURE = 100.0  # K (Vasavada et al. 2012: 95 to 110 K at low latitudes)
# Degree; about 30 (Shkuratov et al. 2000), 20 to 35 over emission angles (Bandfield et al. 2015).
RMS_SLOPE = 30.0
# Gauss points of the disk integral across latitude, the sunlit and the dark part of longitude.
LATITUDES, DAY_LONGITUDES, NIGHT_LONGITUDES = 16, 16, 6
SLOPES, ASPECTS = 8, 24
CLASSES = 200  # classes of absorbed power


def subsolar_temperature(sun_distance: float) -> float:
    """Temperature of the surface under the Sun in equilibrium with it, K; the Sun's distance in au."""
    absorbed = (1 - SOLAR_ALBEDO) * SOLAR_CONSTANT / sun_distance**2
    return float((absorbed / (BROADBAND_EMISSIVITY * STEFAN_BOLTZMANN)) ** 0.25)


def disk_emission(wavenumber: Floats, phase_angle: float, sun_distance: float, rms_slope: float = RMS_SLOPE) -> Floats:
    """Blackbody radiance of the facets times their projected area, summed over the disk of a unit sphere.

    Parameters
    ----------
    wavenumber : (P,) array
        [cm^-1].
    phase_angle : float
        [degree], 0 (full) to 180 (new).
    sun_distance : float
        [au].
    rms_slope : float
        Slope of the facets [degree], above 0.

    Returns
    -------
    (P,) array
        [W m^-2 (cm^-1)^-1].
    """
    power, area = _facets(float(phase_angle), float(rms_slope))
    fourth_power = subsolar_temperature(sun_distance) ** 4 * power + NIGHT_TEMPERATURE**4
    integral: Floats = area @ planck_wavenumber(wavenumber, fourth_power[:, None] ** 0.25)
    return integral


@lru_cache(maxsize=64)
def _facets(phase_angle: float, rms_slope: float) -> tuple[Floats, Floats]:
    """Absorbed power, relative to that under the Sun, and projected area of the visible facets by class of power, both
    (C,). The areas sum to pi.
    """
    cos_sun, cos_observer, level_area = _visible_hemisphere(phase_angle)
    axis_slope = np.tan(np.radians(rms_slope)) / np.sqrt(2)  # rms along one axis
    nodes, slope_weight = np.polynomial.laguerre.laggauss(
        SLOPES
    )  # weights of tan^2 over twice the variance, an exponential law
    slope = axis_slope * np.sqrt(2 * nodes)[:, None]
    aspect = (np.arange(ASPECTS) + 0.5) * 2 * np.pi / ASPECTS  # from that of the observer
    sin_sun, sin_observer = np.sqrt(1 - cos_sun**2), np.sqrt(1 - cos_observer**2)
    between = np.cos(np.radians(phase_angle)) - cos_observer * cos_sun
    azimuth = np.arccos(np.clip(between / np.maximum(sin_sun * sin_observer, 1e-12), -1, 1))
    facing = cos_observer[:, None, None] + sin_observer[:, None, None] * slope * np.cos(aspect)
    to_sun = sin_sun[:, None, None] * slope * np.cos(aspect - azimuth[:, None, None])
    cos_slope = 1 / np.sqrt(1 + slope**2)
    incidence = (cos_sun[:, None, None] + to_sun) * cos_slope
    visible, sunlit = _unshadowed(cos_observer, axis_slope), _unshadowed(cos_sun, axis_slope)
    # Share that the Sun reaches of what the observer sees: independent of one another at large azimuths.
    apart = 4.41 * azimuth / (4.41 * azimuth + 1)
    sunlit = apart * sunlit + (1 - apart) * np.minimum(sunlit / visible, 1.0)
    area = (level_area * visible)[:, None, None] * np.maximum(facing, 0) * slope_weight[:, None] / ASPECTS
    lit_area = area * np.where(incidence > 0, sunlit[:, None, None], 0.0)
    from_ground = np.broadcast_to((1 - cos_slope) / 2 * np.maximum(cos_sun, 0)[:, None, None], area.shape)
    power = np.concatenate([(from_ground + np.maximum(incidence, 0)).ravel(), from_ground.ravel()])
    areas = np.concatenate([lit_area.ravel(), (area - lit_area).ravel()])
    class_number = np.minimum((power * CLASSES / max(power.max(), 1e-9)).astype(int), CLASSES - 1)
    in_class = np.bincount(class_number, areas, CLASSES).astype(float)
    mean = np.bincount(class_number, areas * power, CLASSES) / np.where(in_class > 0, in_class, 1.0)
    return mean, in_class


def _unshadowed(cosine: Floats, axis_slope: float) -> Floats:
    """Share (N,) of the facets turned to a direction that nothing hides from it (Smith 1967); 0 below the horizon."""
    above = np.clip(cosine, 1e-9, 1 - 1e-12)
    steepness = above / np.sqrt(1 - above**2) / (np.sqrt(2) * axis_slope)
    hidden = 0.5 * (np.exp(-(steepness**2)) / (steepness * np.sqrt(np.pi)) - scipy.special.erfc(steepness))
    return np.where(cosine > 0, 1 / (1 + hidden), 0.0)


def _visible_hemisphere(phase_angle: float) -> tuple[Floats, Floats, Floats]:
    """Cosines of the Sun's and the observer's zenith angle, and area, all (N,), of points on the half sphere that the
    observer sees.

    Photometric coordinates: the observer over longitude 0 of the equator, the Sun over longitude `phase_angle` of it.
    """
    latitude, latitude_weight = _gauss(-np.pi / 2, np.pi / 2, LATITUDES)
    phase = np.radians(phase_angle)
    terminator = phase - np.pi / 2
    longitude, longitude_weight = (
        np.concatenate(parts)
        for parts in zip(
            _gauss(-np.pi / 2, terminator, NIGHT_LONGITUDES), _gauss(terminator, np.pi / 2, DAY_LONGITUDES), strict=True
        )
    )
    level = np.cos(latitude)[:, None]
    area = (level * latitude_weight[:, None]) * longitude_weight
    return (level * np.cos(longitude - phase)).ravel(), (level * np.cos(longitude)).ravel(), area.ravel()


def _gauss(low: float, high: float, count: int) -> tuple[Floats, Floats]:
    nodes, weights = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (high - low)
    return low + half * (nodes + 1), half * weights
