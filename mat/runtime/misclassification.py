"""What a texel of the wrong material costs: error of the surface's band radiance and of its equivalent temperature.

Source 8 of error. A surface of material m at clock time t sends, at range 0, L_m(t) = L_bb(T_m(t)) (1 - rho_m),
equation (6) of DSTO-TN-0193, and, where the light of the sky is known, + L_ambient(t) rho_m, equation (19). A texel
taken for material j in place of i is wrong by L_j(t) - L_i(t); its equivalent temperature is that of a black body of
the same band radiance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np
import numpy.typing as npt
import yaml

from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import BandTable
from skyshine.mat.tables.htt import TemperatureTable
from skyshine.schemas.arrays import Floats, Integers
from skyshine.schemas.errors import InputError

P95 = 0.95


@dataclass(frozen=True)
class SurfaceRadiance:
    """What surfaces of each material send through a day.

    Attributes
    ----------
    names : tuple of str
        K materials.
    times : (T,) float64
        Local clock, h.
    temperature : (K, T) float64
        K.
    radiance : (K, T) float64
        At range 0, W m^-2 sr^-1.
    equivalent : (K, T) float64
        Temperature of a black body of the same radiance, K.
    """

    names: tuple[str, ...]
    times: Floats
    temperature: Floats
    radiance: Floats
    equivalent: Floats


@dataclass(frozen=True)
class ErrorByTime:
    """Error over texels: at each time (T,), and over the whole day."""

    mean: Floats
    rms: Floats
    p95: Floats
    maximum: Floats
    day_rms: float
    day_p95: float
    day_maximum: float


@dataclass(frozen=True)
class Pair:
    """Texels of one material taken for another.

    Attributes
    ----------
    true, found : str
    texels : int
    radiance_rms, kelvin_rms : float
        Over the day, of one such texel.
    kelvin_maximum, hour : float
        The largest error, with its sign, and when it occurs.
    contribution : float
        Share of all texels' squared error in radiance, 0 to 1.
    """

    true: str
    found: str
    texels: int
    radiance_rms: float
    kelvin_rms: float
    kelvin_maximum: float
    hour: float
    contribution: float


@dataclass(frozen=True)
class MisclassificationCost:
    """Cost of a classification.

    Attributes
    ----------
    times : (T,) float64
        Local clock, h.
    texels, unknown : int
        Scored texels with a material found, and those found unknown, which have no radiance and do not count.
    radiance, kelvin : ErrorByTime
        W m^-2 sr^-1 and K, found minus true; right texels count with 0.
    pairs : list of Pair
        Wrong pairs, the largest contribution first.
    """

    times: Floats
    texels: int
    unknown: int
    radiance: ErrorByTime
    kelvin: ErrorByTime
    pairs: list[Pair]


def surface_radiance(
    surface: TemperatureTable,
    band: BandTable,
    names: Sequence[str],
    *,
    altitude: float | None = None,
    azimuth: float = 0.0,
    slope: float = 0.0,
    air: AtmosphereTable | None = None,
) -> SurfaceRadiance:
    """Radiance of materials at each node of the time axis of a temperature table.

    Parameters
    ----------
    surface, band : tables of the same job
    names : sequence of str
        Materials.
    altitude : float, optional
        Of the surface, km; by default the lowest of the table.
    azimuth, slope : float
        Of the surface, degree.
    air : AtmosphereTable, optional
        With the Sun as source; gives the light of the sky that the surface reflects. Direct light is left out.

    Raises
    ------
    InputError
        A table lacks a material, the surface is outside the table, or `air` is of the Moon or of another band.
    """
    names = tuple(names)
    times = np.mod(surface.root.axes["time"].values.astype(float), 24.0)
    altitude = float(surface.root.axes["altitude"].values[0]) if altitude is None else altitude
    temperature = surface.temperature(
        material=np.array(names)[:, np.newaxis], altitude=altitude, azimuth=azimuth, slope=slope, time=times
    )
    reflectance = band.value("reflectance", material=np.array(names))[:, np.newaxis]
    radiance = band.blackbody_radiance(temperature) * (1 - reflectance)  # (6)
    if air is not None:
        radiance = radiance + _ambient(surface, air, band, times) * reflectance  # (19)
    return SurfaceRadiance(names, times, temperature, radiance, equivalent_temperature(band, radiance))


def _ambient(surface: TemperatureTable, air: AtmosphereTable, band: BandTable, times: Floats) -> Floats:
    """L_ambient* (T,) at the ground by the Sun's elevation at each clock time, W m^-2 sr^-1."""
    if air.attributes.get("source") != "sun":
        raise InputError(f"has the source '{air.attributes.get('source')}'; allowed: sun; name an .atmq", file=air.path)
    limits = np.asarray(air.attributes["wavelength_um"], float)
    response = band.root.axes["wavelength"].values
    if not np.allclose(limits, [response[0], response[-1]], rtol=1e-3):
        raise InputError(
            f"is of {limits[0]:g}-{limits[-1]:g} um; allowed: the band of {band.path.name},"
            f" {response[0]:g}-{response[-1]:g} um",
            file=air.path,
        )
    place = {"range": air.nodes_of("range")[0], "altitude": air.nodes_of("altitude")[0]}
    place["elevation"] = air.nodes_of("elevation")[-1]
    elevation = sun_elevation(surface, times)
    ambient: Floats = air.clamped().value("ambient_radiance", **place, source_elevation=elevation)
    return ambient


def sun_elevation(surface: TemperatureTable, times: npt.ArrayLike) -> Floats:
    """Elevation (T,) [degree] of the Sun at local clock times [h], for day and site of a temperature table."""
    from skyshine.mat.atmosphere.sources.ephemeris import position

    site = yaml.safe_load(surface.attributes["job"])["site"]
    midnight = datetime.fromisoformat(str(site["date"])) - timedelta(hours=site["utc_offset_h"])
    moments = np.datetime64(midnight) + (np.asarray(times) * 3600e6).astype("timedelta64[us]")
    return position("sun", moments, site["latitude_deg"], site["longitude_deg"], 1e3 * site["altitude_km"]).elevation


def equivalent_temperature(band: BandTable, radiance: npt.ArrayLike) -> Floats:
    """Temperature of a black body of a band radiance, K; 0 where there is none.

    ln L against 1/T is almost straight (Wien), so that it is interpolated, and continued below the table, in these.
    """
    inverse = 1 / band.root.axes["temperature"].values.astype(float)
    table = np.log(band.root.variables["blackbody_radiance"].data.astype(float))
    with np.errstate(divide="ignore"):
        logarithm = np.log(np.asarray(radiance, float))
    below = inverse[0] + (logarithm - table[0]) * (inverse[1] - inverse[0]) / (table[1] - table[0])
    temperature: Floats = 1 / np.where(logarithm < table[0], below, np.interp(logarithm, table, inverse))
    return temperature


def misclassification_cost(confusion: Integers, surface: SurfaceRadiance) -> MisclassificationCost:
    """Turn a confusion into errors of radiance and temperature.

    Parameters
    ----------
    confusion : (K, K + 1) integer
        Texels by true material and material found, in the order of ``surface.names``; the first column is unknown.
    surface : SurfaceRadiance

    Raises
    ------
    InputError
        No texel has a material found.
    """
    unknown, counts = int(confusion[:, 0].sum()), confusion[:, 1:]
    true, taken_for = np.nonzero(counts)
    weights = counts[true, taken_for]
    if not weights.size:
        raise InputError("no labelled texel has a material found; there is no radiance to compare")
    radiance = surface.radiance[taken_for] - surface.radiance[true]
    kelvin = surface.equivalent[taken_for] - surface.equivalent[true]
    return MisclassificationCost(
        surface.times,
        int(weights.sum()),
        unknown,
        _by_time(radiance, weights),
        _by_time(kelvin, weights),
        _pairs(surface, true, taken_for, weights, radiance, kelvin),
    )


def _by_time(error: Floats, weights: Integers) -> ErrorByTime:
    """Summary of errors (N, T) of pairs with numbers of texels (N,)."""
    total = weights.sum()
    rms = np.sqrt(weights @ error**2 / total)
    size = np.abs(error)
    p95 = np.array([_quantile(column, weights) for column in size.T])
    every = np.repeat(weights, error.shape[1])
    return ErrorByTime(
        weights @ error / total,
        rms,
        p95,
        size.max(axis=0),
        float(np.sqrt(np.mean(rms**2))),
        _quantile(size.ravel(), every),
        float(size.max()),
    )


def _quantile(values: Floats, weights: Integers) -> float:
    """The least value that at least 95 % of the weight does not exceed."""
    order = np.argsort(values)
    reached = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(reached, P95 * reached[-1])])


def _pairs(
    surface: SurfaceRadiance,
    true: Integers,
    taken_for: Integers,
    weights: Integers,
    radiance: Floats,
    kelvin: Floats,
) -> list[Pair]:
    squared = weights * np.mean(radiance**2, axis=1)
    total = max(squared.sum(), np.finfo(float).tiny)
    pairs = []
    for n in np.argsort(-squared, kind="stable"):
        if true[n] == taken_for[n]:
            continue
        worst = int(np.argmax(np.abs(kelvin[n])))
        pairs.append(
            Pair(
                surface.names[true[n]],
                surface.names[taken_for[n]],
                int(weights[n]),
                float(np.sqrt(np.mean(radiance[n] ** 2))),
                float(np.sqrt(np.mean(kelvin[n] ** 2))),
                float(kelvin[n, worst]),
                float(surface.times[worst]),
                float(squared[n] / total),
            )
        )
    return pairs
