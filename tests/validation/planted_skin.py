"""Records made for fits: days of changing weather, and the skin that the solver finds under them."""

import numpy as np

from skyshine.mat.scene.surface import surface_materials
from skyshine.mat.surface.column import from_record
from skyshine.mat.surface.free_parameters import with_numbers
from skyshine.mat.surface.measured_skin import MeasuredRecord
from skyshine.mat.surface.record import Record
from skyshine.materials.library import load_library


def weather(days, step=3600.0, seed=0):
    """Cloud, air and wind that change every six hours at random."""
    count, random = round(days * 86400 / step), np.random.default_rng(seed)
    hours = np.arange(count) * step / 3600

    def slow(size):
        knots = np.arange(0, 24 * days + 6.1, 6)
        return np.interp(hours, knots, size * random.normal(size=len(knots)))

    cloud = np.clip(0.5 + slow(0.4), 0, 1)
    turn = np.sin(2 * np.pi * (hours - 9) / 24)
    air = 288 + 6 * turn + slow(2.0)
    values = {
        "sw_down": np.maximum(np.sin(2 * np.pi * (hours - 6) / 24), 0) * 900 * (1 - 0.7 * cloud),
        "lw_down": 5.67e-8 * air**4 * (0.75 + 0.2 * cloud),
        "air_temperature": air,
        "relative_humidity": np.clip(60 + slow(15.0) - 10 * turn, 10, 100),
        "wind_speed": np.maximum(2.5 + slow(1.2), 0.2),
        "pressure": np.full(count, 98e3),
        "wind_height": np.full(count, 10.0),
        "air_height": np.full(count, 2.0),
    }
    return Record(np.datetime64("2026-06-01T00:00:00", "ms"), float(step), values)


def library(name):
    (material,) = surface_materials([load_library()[name]])
    return material


def planted(name, values, record, noise=0.0):
    """A material of the library, and a record whose skin is that of the material with other values, by the solver."""
    material = library(name)
    skin = from_record(with_numbers(material, values), record, 0.0, 0.0, None, 0.2).temperature
    return material, MeasuredRecord(record, skin + noise, False)


def autoregression(count, decay, seed):
    """Noise of variance 1 whose correlation falls by one factor from step to step, (count,)."""
    random = np.random.default_rng(seed)
    noise = random.normal(size=count)
    for index in range(1, count):
        noise[index] = decay * noise[index - 1] + np.sqrt(1 - decay**2) * noise[index]
    return noise
