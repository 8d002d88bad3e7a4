"""Random columns that are harder than those of any scene, as trials of the solver.

Foil to water, dry to wet, emissivity 0.02 to 1, any back; calm to 50 m/s, polar night to desert noon, step shadows,
vacuum; showers; long records of melting snow. The ranges are chosen wider than any scene; nothing here feeds a table.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.surface.column_forcing import Forcing
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.mat.surface.vapour import saturation_pressure
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack
from skyshine.schemas.arrays import Floats

# Conductivity [W m^-1 K^-1], density [kg m^-3], heat capacity [J kg^-1 K^-1]: water, aluminium, steel, concrete, dry
# soil, insulation.
_KINDS = [
    (0.6, 1000.0, 4180.0),
    (200.0, 2700.0, 900.0),
    (45.0, 7800.0, 480.0),
    (1.5, 2300.0, 900.0),
    (0.3, 1500.0, 850.0),
    (0.03, 30.0, 1400.0),
]


def _log(generator: np.random.Generator, low: float, high: float) -> float:
    """Log-uniform."""
    return float(np.exp(generator.uniform(np.log(low), np.log(high))))


def random_material(generator: np.random.Generator) -> SurfaceMaterial:
    """A surface of foil to water, dry or wet, on any back."""
    upper, lower = (_KINDS[generator.integers(len(_KINDS))] for _ in range(2))
    back_boundary = [
        Back("adiabatic"),
        Back("fixed", float(generator.uniform(250, 310))),
        Back("fixed"),
        Back("convective", float(generator.uniform(250, 310)), _log(generator, 1, 30)),
        Back("open", coefficient=_log(generator, 1, 30)),
        Back("cavity", None, _log(generator, 1, 30), None, _log(generator, 0.01, 100), _log(generator, 1, 1e6)),
    ][generator.integers(6)]
    thickness = np.inf if generator.random() < 0.2 else _log(generator, 1e-4, 2.0)
    stack = ThermalStack(
        Layer(_log(generator, 1e-6, 5e-3), *upper),
        (Layer(_log(generator, 1e-5, 0.5), *upper), Layer(thickness, *lower)),
        back_boundary,
    )
    wet = generator.random() < 0.5
    surface = SurfaceProperties(
        roughness_length=_log(generator, 1e-6, 1.0),
        wetness=float(generator.uniform(0, 1)) if wet else 0.0,
        surface_resistance=_log(generator, 1, 500) if generator.random() < 0.5 else 0.0,
        canopy=bool(generator.random() < 0.2),
        snow=bool(generator.random() < 0.15),
        exposure=str(generator.choice(["field", "plate", "roof", "wall"], p=[0.55, 0.15, 0.15, 0.15])),
    )
    return SurfaceMaterial(
        "random", stack, surface, float(generator.uniform(0.02, 1)), float(generator.uniform(0.02, 1))
    )


def random_forcing(generator: np.random.Generator) -> Callable[[int], Forcing]:
    """The forcing of one column as a function of the number of steps."""
    vacuum = generator.random() < 0.1
    mean, swing = generator.uniform(210, 315), generator.uniform(0, 20)
    noon = 0.0 if generator.random() < 0.15 else generator.uniform(50, 1100)
    length = generator.uniform(2, 22)
    shadow = generator.uniform(6, 18), generator.uniform(0, 4)
    humidity = generator.uniform(0, 1)
    wind = 0.0 if generator.random() < 0.2 else generator.uniform(0, 50)
    gusts = generator.random() < 0.3
    tilt = generator.uniform(-1, 1)
    sky = generator.uniform(0.5, 1.0)
    heights = generator.uniform(1, 30), generator.uniform(0.5, 12)

    def forcing(steps: int) -> Forcing:
        hours = np.arange(steps) * (24.0 / steps)
        sun = np.maximum(np.cos(np.pi * (hours - 12) / length), 0) * (np.abs(hours - 12) < length / 2)
        sun = np.where((hours >= shadow[0]) & (hours < shadow[0] + shadow[1]), 0.0, sun)
        air = mean + swing * np.cos(2 * np.pi * (hours - 15) / 24)
        windy = wind * np.where(gusts & (np.floor(hours) % 2 == 0), 0.1, 1.0)
        vapour = np.minimum(humidity * saturation_pressure(mean), saturation_pressure(air))
        return Forcing(
            shortwave_direct=(noon * sun)[None],
            shortwave_diffuse=(0.1 * noon * sun)[None],
            shortwave_reflected=np.zeros((1, steps)),
            longwave_sky=((0 if vacuum else sky) * STEFAN_BOLTZMANN * air**4)[None],
            longwave_ground=np.zeros((1, steps)),
            air_temperature=air[None],
            vapour_pressure=vapour[None],
            pressure=np.full((1, steps), 0.0 if vacuum else 9e4),
            wind_speed=windy[None],
            cos_slope=np.array([[tilt]]),
            wind_height=np.array([[heights[0]]]),
            air_height=np.array([[heights[1]]]),
        )

    return forcing


def random_snow(generator: np.random.Generator) -> tuple[SurfaceMaterial, Forcing, float]:
    """Snow of any density and albedo under a long record about freezing, with its period [s].

    The record has 1,600 to 4,000 steps of 5 to 15 minutes: too many for a dense matrix.
    """
    step = float(generator.choice([300.0, 450.0, 600.0, 900.0]))
    steps = int(generator.integers(1600, 4000))
    hours = np.arange(float(steps)) * (step / 3600.0)
    air = generator.uniform(266, 279) + generator.uniform(0, 8) * np.cos(2 * np.pi * (hours - 15) / 24)
    air = air + generator.uniform(0, 5) * _red_noise(generator, steps, step / 3600.0 / 40.0)
    cloud = 1 / (1 + np.exp(-2.0 * _red_noise(generator, steps, step / 3600.0 / 10.0)))
    sun = generator.uniform(200, 1000) * np.maximum(np.sin(2 * np.pi * (hours - 6) / 24), 0.0) * (1 - 0.7 * cloud)
    wind = np.abs(4.0 * _red_noise(generator, steps, step / 3600.0 / 8.0))
    zero = np.zeros((1, steps))
    forcing = Forcing(
        shortwave_direct=zero,
        shortwave_diffuse=sun[None],
        shortwave_reflected=zero,
        longwave_sky=((0.7 + 0.28 * cloud) * STEFAN_BOLTZMANN * air**4)[None],
        longwave_ground=zero,
        air_temperature=air[None],
        vapour_pressure=generator.uniform(0.4, 1.0) * saturation_pressure(air)[None],
        pressure=zero + 9e4,
        wind_speed=wind[None],
        cos_slope=np.ones((1, 1)),
    )
    return _random_snow_material(generator), forcing, step * steps


def _random_snow_material(generator: np.random.Generator) -> SurfaceMaterial:
    """Fresh to old snow, dry or sublimating, on soil at air temperature, at the melting point, or on nothing."""
    density = generator.uniform(80, 500)
    # Yen (1981), Review of thermal properties of snow, ice and sea ice, CRREL Report 81-10.
    conductivity = 2.22 * (density / 917.0) ** 1.88

    def layer(thickness: float) -> Layer:
        return Layer(thickness, conductivity, density, 2090.0)

    back_boundary = [Back("fixed"), Back("fixed", 272.0), Back("adiabatic")][generator.integers(3)]
    layers = layer(_log(generator, 0.03, 0.3)), layer(_log(generator, 0.05, 1.0))
    surface = SurfaceProperties(_log(generator, 1e-4, 1e-2), float(generator.integers(2)), 0.0, False, True)
    albedo, emissivity = generator.uniform(0.2, 0.95), generator.uniform(0.9, 1.0)
    return SurfaceMaterial("snow", ThermalStack(layer(5e-3), layers, back_boundary), surface, 1 - albedo, emissivity)


def _red_noise(generator: np.random.Generator, steps: int, rate: float) -> Floats:
    """First-order autoregressive series (N,) of unit variance; `rate` is a step over the time of decay."""
    from scipy.signal import lfilter

    persistence = np.exp(-rate)
    shocks = generator.normal(size=steps) * np.sqrt(1 - persistence**2)
    shocks[0] = generator.normal()
    series: Floats = lfilter([1.0], [1.0, -persistence], shocks)
    return series
