"""Optical turbulence of the surface layer over a state's ground or sea, in its ``.htt`` database."""

from __future__ import annotations

import numpy as np

from skyshine.mat.job.atmosphere import State
from skyshine.mat.radiometry.constants import ZERO_CELSIUS
from skyshine.mat.surface.convection import Wind
from skyshine.mat.surface.forcing import Scene
from skyshine.mat.surface.ground_turbulence import ground_turbulence
from skyshine.mat.surface.sea_surface import sea_surface, specific_humidity
from skyshine.mat.surface.similarity import index_structure
from skyshine.mat.surface.sun_path import sun_hours
from skyshine.mat.tables.axes import CLOCK_UNIT, PERIODIC, table_axis
from skyshine.schemas.arrays import Floats
from skyshine.schemas.hdf5 import Axis, Variable

HOURS = np.arange(24.0)  # local clock [h]
HEIGHTS = np.geomspace(0.5, 50.0, 14)  # m: between them linear reading errs by 5 % at most


def turbulence_fields(
    scene: Scene, state: State, ground: Floats | None, roughness_length: float
) -> tuple[dict[str, Axis], dict[str, Variable]]:
    """Axes and array of Cn2.

    Parameters
    ----------
    scene : Scene
        Its A altitudes are those of the file.
    ground : (A, 24) array or None
        Temperature of the level ground at the hours [K]; not needed over a sea.
    roughness_length : float
        Roughness length of the ground [m].

    Returns
    -------
    tuple of dict
        Empty with neither ground nor sea.
    """
    if ground is None and state.sea_temperature_c is None:
        return {}, {}
    altitude = np.asarray(scene.altitude, float)
    temperature, vapour, pressure = (
        np.array([np.interp(HOURS, sun_hours(), row, period=24.0) for row in np.broadcast_to(field, shape)])
        for shape in [(altitude.size, sun_hours().size)]
        for field in scene.weather.at(altitude, scene.sky.pressure_at(np.append(altitude, scene.weather.altitude)))
    )
    speed = np.interp(HOURS, sun_hours(), scene.weather.wind_speed, period=24.0)
    wind_height, air_height = scene.weather.wind_height, scene.weather.air_height
    cn2 = np.empty((altitude.size, HEIGHTS.size, HOURS.size))
    for level, (kelvin, pascal, humid) in enumerate(zip(temperature, pressure, vapour, strict=True)):
        if state.sea_temperature_c is None:
            assert ground is not None
            wind = Wind(speed, wind_height, air_height)
            cn2[level] = ground_turbulence(ground[level], kelvin, wind, pascal, roughness_length, HEIGHTS)
            continue
        for hour in range(HOURS.size):
            sea = sea_surface(
                state.sea_temperature_c + ZERO_CELSIUS,
                float(kelvin[hour]),
                specific_humidity(float(humid[hour]), float(pascal[hour])),
                float(speed[hour]),
                float(pascal[hour]),
                wind_height=wind_height,
                air_height=air_height,
            )
            scales = sea.friction_velocity, sea.temperature_scale, sea.humidity_scale
            cn2[level, :, hour] = index_structure(HEIGHTS, *scales, kelvin[hour], pascal[hour])
    axes = {
        "cn2_height": table_axis(HEIGHTS, "m", "height above the ground or sea at which the turbulence is given"),
        "cn2_hour": table_axis(
            HOURS, CLOCK_UNIT, "local clock time of the turbulence", interpolation=PERIODIC, period=24.0
        ),
    }
    name = "structure constant of the refractive index in the surface layer, over the ground material or the sea"
    values = Variable(("altitude", *axes), cn2.astype(np.float32), "m^(-2/3)", name)
    return axes, {"cn2": values}
