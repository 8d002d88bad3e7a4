"""Random showers over the random columns of `surface.stress`."""

from dataclasses import replace

import numpy as np

from skyshine.mat.surface.wet_skin import FilmSkin, film_capacity


def random_rain(generator, material, forcing):
    """A material and forcing with a shower, from drizzle to a cloudburst, over a film of any size; None for snow and
    open water.
    """
    capacity = film_capacity(material.surface, None) * float(generator.choice([0.1, 1.0, 1.0]))
    if not capacity:
        return None
    absorptance, emissivity = (
        float(generator.uniform(dry, 1)) for dry in (material.solar_absorptance, material.thermal_emissivity)
    )
    begin, length, rate = (
        generator.uniform(0, 24),
        generator.uniform(0, 6),
        10 ** generator.uniform(-6, -2),
    )

    def with_rain(steps):
        hours = np.arange(steps) * (24.0 / steps)
        rain = np.where((hours >= begin) & (hours < begin + length), rate, 0.0)
        return replace(forcing(steps), rain=rain[None])

    return replace(material, film=FilmSkin(absorptance, emissivity, capacity)), with_rain
