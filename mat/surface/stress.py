"""Random columns that no kind scene has, to see that the solver holds on them.

Foil to water, dry to wet, emissivity 0.02 to 1, any back; calm to 50 m/s, polar night to desert noon, step shadows,
vacuum. The ranges are chosen wider than any scene; nothing here feeds a table.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skyshine.mat.surface.balance import Forcing, saturation_pressure
from skyshine.mat.surface.material import SurfaceMaterial
from skyshine.materials.records import Back, Layer, SurfaceProperties, ThermalStack

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
    first, second = (_KINDS[generator.integers(len(_KINDS))] for _ in range(2))
    back = [
        Back("adiabatic"),
        Back("fixed", float(generator.uniform(250, 310))),
        Back("fixed"),
        Back("convective", float(generator.uniform(250, 310)), _log(generator, 1, 30)),
    ][generator.integers(4)]
    last = np.inf if generator.random() < 0.2 else _log(generator, 1e-4, 2.0)
    stack = ThermalStack(
        Layer(_log(generator, 1e-6, 5e-3), *first),
        (Layer(_log(generator, 1e-5, 0.5), *first), Layer(last, *second)),
        back,
    )
    wet = generator.random() < 0.5
    surface = SurfaceProperties(
        roughness_length=_log(generator, 1e-6, 1.0),
        wetness=float(generator.uniform(0, 1)) if wet else 0.0,
        surface_resistance=_log(generator, 1, 500) if generator.random() < 0.5 else 0.0,
        canopy=bool(generator.random() < 0.2),
        snow=bool(generator.random() < 0.15),
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

    def forcing(steps: int) -> Forcing:
        hours = np.arange(steps) * (24.0 / steps)
        sun = np.maximum(np.cos(np.pi * (hours - 12) / length), 0) * (np.abs(hours - 12) < length / 2)
        sun = np.where((hours >= shadow[0]) & (hours < shadow[0] + shadow[1]), 0.0, sun)
        air = mean + swing * np.cos(2 * np.pi * (hours - 15) / 24)
        windy = wind * np.where(gusts & (np.floor(hours) % 2 == 0), 0.1, 1.0)
        vapour = np.minimum(humidity * saturation_pressure(mean), saturation_pressure(air))
        rows = [noon * sun, 0.1 * noon * sun, 0 * sun, (0 if vacuum else sky) * 5.67e-8 * air**4, 0 * sun, air, vapour]
        rows += [np.full(steps, 0.0 if vacuum else 9e4), windy]
        return Forcing(*(row[None, :] for row in rows), cos_slope=np.array([[tilt]]))

    return forcing
