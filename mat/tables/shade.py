"""Changes of absorbed heat from the light and longwave in a ``.htt`` database: shade, obstructions, walls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.constants import Stefan_Boltzmann

from skyshine.mat.surface.forcing import plane_irradiance
from skyshine.mat.surface.surroundings import Exposure, Surroundings
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.response import DAY_H, FORCING_STEPS, StoredResponse, forcing_hours, need_parts
from skyshine.schemas.arrays import Floats
from skyshine.schemas.hdf5 import Group

FORCING_TIME = "forcing_time"
DIRECT, DIFFUSE, LONGWAVE, AIR = "direct_normal_irradiance", "diffuse_irradiance", "sky_irradiance", "air_temperature"
SUN_ELEVATION, SUN_AZIMUTH = "solar_elevation", "solar_azimuth"
ABSORPTANCE, EMISSIVITY = "solar_absorptance", "thermal_emissivity"
AUREOLE = "aureole_share"


@dataclass(frozen=True, eq=False)
class OpenAir:
    """Light, longwave and air over surfaces without surroundings, by altitude and time of day.

    Attributes
    ----------
    altitude : AxisRule
        [km]
    direct, diffuse, longwave : (A, FORCING_STEPS) ndarray
        Direct normal, diffuse horizontal, of the whole sky on a level surface [W m^-2].
    air : (A, FORCING_STEPS) ndarray
        [K]
    elevation, azimuth : (FORCING_STEPS,) ndarray
        Elevation and azimuth of the Sun [degree].
    aureole : (FORCING_STEPS,) ndarray
        Share of the diffuse light that comes from around the Sun.
    """

    altitude: AxisRule
    direct: Floats
    diffuse: Floats
    longwave: Floats
    air: Floats
    elevation: Floats
    azimuth: Floats
    aureole: Floats

    @classmethod
    def of(cls, root: Group) -> OpenAir:
        """The light that a database holds; `StoredResponse.of` refuses one without it."""
        names = (DIRECT, DIFFUSE, LONGWAVE, AIR, SUN_ELEVATION, SUN_AZIMUTH, AUREOLE)
        need_parts(root, names)
        return cls(
            AxisRule.of("altitude", root.axes["altitude"]),
            *(np.asarray(root.variables[name].data, float) for name in names),
        )

    def absorbed_change(
        self,
        exposure: Exposure,
        altitude: Floats,
        azimuth: Floats,
        slope: Floats,
        absorptance: Floats,
        emissivity: Floats,
    ) -> Floats:
        """Change of the absorbed heat of P surfaces by their surroundings.

        Parameters
        ----------
        exposure : Exposure
            Exposure of the P surfaces, at the steps of the day.
        altitude, azimuth, slope : (P,) ndarray
            [km], [degree]
        absorptance, emissivity : (P,) ndarray
            Absorptance of sunlight, and emissivity for longwave.

        Returns
        -------
        (P, FORCING_STEPS) ndarray
            [W m^-2]
        """
        steps = AxisRule(FORCING_TIME, forcing_hours(), PERIODIC, DAY_H)
        place = {
            "altitude": np.clip(altitude, *self.altitude.nodes[[0, -1]])[:, None],
            FORCING_TIME: forcing_hours()[None, :],
        }
        direct_normal, diffuse_level, longwave, air = (
            interpolate(values, [self.altitude, steps], place)
            for values in (self.direct, self.diffuse, self.longwave, self.air)
        )
        direct, diffuse, _ = plane_irradiance(
            slope[:, None],
            azimuth[:, None],
            self.elevation,
            self.azimuth,
            direct_normal,
            diffuse_level,
            0.0,
            self.aureole,
        )
        view = 0.5 * (1 + np.cos(np.radians(slope)))[:, None]
        beam, spread = exposure.sunlight(direct, diffuse, view * (1 - self.aureole) * diffuse_level)
        sky, others = exposure.longwave(view, longwave, air)
        open_sky, ground = Surroundings().longwave(view, longwave, air)
        change: Floats = absorptance[:, None] * (beam + spread - direct - diffuse)
        change += emissivity[:, None] * (sky + others - open_sky - ground)
        return change


def absorbed_change(
    root: Group,
    around: Surroundings | Exposure,
    material: npt.NDArray[Any],
    altitude: Floats,
    azimuth: Floats,
    slope: Floats,
    *,
    ground: Ground | None = None,
) -> Floats:
    """Change of absorbed heat at places of a ``.htt`` database.

    Parameters
    ----------
    root : Group
        Root group of the database.
    around : Surroundings or Exposure
        Surroundings of all points, or of each point in the order of the broadcast shape.
    material, altitude, azimuth, slope : ndarray
        Codes, [km], [degree], to be broadcast.
    ground : Ground, optional
        Ground in the same shade; by default its temperature is that of the open ground.

    Returns
    -------
    (..., FORCING_STEPS) ndarray
        [W m^-2]

    Raises
    ------
    InputError
        The database holds no response, or no such material.
    """
    StoredResponse.of(root)
    need_parts(root, (ABSORPTANCE, EMISSIVITY))
    rule = AxisRule.of("material", root.axes["material"])
    at, up, over, tilt = np.broadcast_arrays(rule.locate(material)[0], altitude, azimuth, slope)
    absorptance, emissivity = (root.variables[name].data[at.ravel()] for name in (ABSORPTANCE, EMISSIVITY))
    if isinstance(around, Surroundings):
        around = Exposure.of(around, forcing_hours(), DAY_H / FORCING_STEPS)
    change = OpenAir.of(root).absorbed_change(
        around, up.ravel(), over.ravel(), tilt.ravel(), absorptance.astype(float), emissivity.astype(float)
    )
    if ground is not None and np.any(tilt > 0):
        change += _from_ground(root, around, ground, up.ravel(), tilt.ravel(), absorptance, emissivity)
    return change.reshape(*at.shape, FORCING_STEPS)


@dataclass(frozen=True)
class Ground:
    """Ground of a ``.htt`` database that has the shade of the tilted surfaces before which it lies.

    Attributes
    ----------
    number : int
        Number of its material in the database.
    emissivity, albedo : float
    temperature : callable
        Temperatures (Z, FORCING_STEPS) [K] of level ground at altitudes (Z,) [km], under an absorbed heat (Z,
        FORCING_STEPS) [W m^-2] or none.
    """

    number: int
    emissivity: float
    albedo: float
    temperature: Callable[[Floats, Floats | None], Floats]


def _from_ground(
    root: Group,
    around: Exposure,
    ground: Ground,
    altitude: Floats,
    slope: Floats,
    absorptance: Floats,
    emissivity: Floats,
) -> Floats:
    """Change of absorbed heat (P, FORCING_STEPS) by ground that is colder and reflects less light in the shade."""
    count = max(len(around.shaded), len(around.sky_view))
    heights, which = (altitude, np.arange(altitude.size)) if count > 1 else np.unique(altitude, return_inverse=True)
    level, one = np.zeros(heights.size), np.ones(heights.size)
    air = OpenAir.of(root)
    light = air.absorbed_change(around, heights, level, level, one, level)
    own = (np.full(heights.size, root.variables[name].data[ground.number], float) for name in (ABSORPTANCE, EMISSIVITY))
    heat = air.absorbed_change(around, heights, level, level, *own)
    colder = ground.temperature(heights, heat) ** 4 - ground.temperature(heights, None) ** 4
    view = 0.5 * (1 - np.cos(np.radians(slope)))[:, None]
    longwave, reflected = ground.emissivity * Stefan_Boltzmann * colder, ground.albedo * light
    change: Floats = view * (emissivity[:, None] * longwave[which] + absorptance[:, None] * reflected[which])
    return change
