"""Choice of a band's points: their number against what they err in a pixel and the time that choosing them takes."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.band.compile import FittedBand, choose_points, fit_band, over_air, points_in_air
from skyshine.mat.atmosphere.band.points import band_points
from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.state.ground_air import GroundAir
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.bench.ladders import GRID
from skyshine.mat.measure.scale import Scale
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.scene.bands import absorption_table
from skyshine.mat.scene.compiled import MAX_POINTS
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.schemas.arrays import Floats

DEFAULT_TOLERANCE = 1e-3  # of accuracy.spectral_tolerance
_OWN, _SIMILAR = (290.0, 0.7), ((280.0, 0.5), (280.0, 1.0), (300.0, 0.5), (300.0, 1.0))  # K, relative humidity
_SEED = 0


@dataclass(frozen=True, eq=False)
class CompiledRung:
    """A choice of points.

    Attributes
    ----------
    name : str
    points : int
    seconds : float
        Processor seconds of a state and band.
    error : (M,) array
        K of a pixel.
    default : bool
    """

    name: str
    points: int
    seconds: float
    error: Floats
    default: bool

    @property
    def rms(self) -> float:
        """Root mean square of the errors."""
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def percentile(self) -> float:
        """Below it lie 99 % of the errors."""
        return float(np.percentile(self.error, 99))


def compile_rungs(band_um: tuple[float, float], tolerances: Sequence[float]) -> list[CompiledRung]:
    """Points chosen for a summer's day at several tolerances, and last those shared with similar days.

    Parameters
    ----------
    band_um : (float, float)
        Edges [um]; the band ends beyond 2.5 um, where a pixel has a temperature.
    tolerances : sequence of float

    Returns
    -------
    list of CompiledRung
        With the errors of a black body at 300 K, seen along paths to which the points were not fitted.
    """
    response = SpectralResponse.rectangular(*band_um)
    everything = band_points(absorption_table().points(*response.wavenumber_range), response)
    sun, scale = solar_irradiance(everything.wavenumber, everything.width), Scale.kelvin(response)
    state, similar = _day(*_OWN), [_day(*weather) for weather in _SIMILAR]

    def rung(name: str, begin: float, fit: FittedBand, default: bool) -> CompiledRung:
        seconds = time.process_time() - begin
        error = pixel_errors(fit, state.surface_temperature, sun, scale)
        return CompiledRung(name, fit.chosen.index.size, seconds, error, default)

    rungs = []
    for tolerance in tolerances:
        begin = time.process_time()
        fit = fit_band(state, everything, GRID, sun, tolerance=tolerance, max_points=MAX_POINTS, seed=_SEED)
        rungs.append(rung(f"tolerance {tolerance:g}", begin, fit, tolerance == DEFAULT_TOLERANCE))
    chosen = choose_points(
        similar, everything, GRID, sun, tolerance=DEFAULT_TOLERANCE, max_points=MAX_POINTS, seed=_SEED
    )
    begin = time.process_time()
    fit = points_in_air(chosen, state, everything, GRID, 1, _SEED)
    return [*rungs, rung("shared with similar days", begin, fit, False)]


def pixel_errors(fit: FittedBand, surface_temperature: float, source_irradiance: Floats, scale: Scale) -> Floats:
    """Error (M,) of a black body at 300 K seen along the paths of a fit's test, in units of the scale, without sign.

    Parameters
    ----------
    fit : FittedBand
    surface_temperature : float
        K, of the ground.
    source_irradiance : (P,) array
        At all points, W m^-2 (cm^-1)^-1.
    scale : Scale
    """
    light = source_irradiance[None]
    brightness = light.mean(axis=1)
    exact = fit.exact.mean(surface_temperature, light, brightness)
    few = fit.approximate.mean(surface_temperature, light[:, fit.chosen.index], brightness)
    seen, emitted = (few[kind] - exact[kind] for kind in ("transmittance", "path_thermal"))
    width = fit.chosen.band.weight.sum()  # um
    error: Floats = np.abs(seen * scale.background + emitted * width) * scale.factor
    return error


def _day(kelvin: float, humidity: float) -> AtmosphericState:
    """A summer's day of a temperature [K] and relative humidity at the ground."""
    vapour = humidity * float(saturation_pressure(kelvin))
    air = GroundAir(0.0, kelvin, kelvin, vapour, vapour)
    return over_air(AtmosphericState.from_profile("midlatitude_summer", ground_air=air))
