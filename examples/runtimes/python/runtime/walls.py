"""Light of the sky on a face from which something hides a part of it: ../../../../schemas/formats/atmq-2.md."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .axis import Floats, SceneError
from .database import Database
from .shade import WALL_EMISSIVITY, air_temperature


def hide_sky(
    surface: Database,
    band: Database,
    air: Database,
    centre: Mapping[str, float],
    given: dict[str, Any],
    hidden: float,
    sky: Floats,
) -> Floats:
    """The light of the sky on a pixel's face, as `Database.light`, with what hides a share of that sky in its place: it
    is as warm as the air.
    """
    level = air.light("ambient_radiance", centre)
    wall = glow(band, air, centre, air_temperature(surface, given["surface_altitude"], given["time"]))
    ground = glow(band, air, centre, ground_temperature(surface, band, air, given))
    share = hidden * 0.5 * (1 + math.cos(math.radians(given["surface_slope"])))
    light = WALL_EMISSIVITY * wall + (1 - WALL_EMISSIVITY) * 0.5 * (level + ground)
    return np.maximum(sky + share * (light - level), 0.0)


def glow(band: Database, air: Database, centre: Mapping[str, float], temperature: float) -> Floats:
    """What black bodies beside the pixel emit, as `Database.light`."""
    radiance = band.value("blackbody_radiance", {"temperature": temperature})
    if not air.parted:
        return np.array([radiance])
    tau = math.exp(-5.5 * centre["range"] / air.value("beta_star", centre))
    share = band.spectrum("emission_share", {"planck_temperature": temperature})
    return radiance * share * (air.transmittance(centre, centre["range"]) / tau if tau > 0 else np.zeros(share.size))


def ground_temperature(surface: Database, band: Database, air: Database, given: dict[str, Any]) -> float:
    """Of the ground that what hides the sky reflects: of the pixel's material, of the file's, or as that states it."""
    level = {"azimuth": 0.0, "slope": 0.0, "time": given["time"]}
    if "ground_material" in given:
        place = {"material": band.material(given["ground_material"]), "altitude": given["surface_altitude"]}
        return surface.value("temperature", level | place)
    if air.ground_material:
        lowest = float(surface.arrays["temperature"][0][1].nodes[0])
        return surface.value(
            "temperature", level | {"material": band.material(air.ground_material), "altitude": lowest}
        )
    if not (math.isfinite(air.ground_temperature) and air.ground_temperature >= 0):
        raise SceneError(f"{air.path}: does not state the temperature of the ground")
    return air.ground_temperature
