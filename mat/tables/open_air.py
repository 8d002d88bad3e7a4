"""Light, longwave and air over open surfaces, of a ``.htt`` database; heat from walls of known state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.radiometry.constants import STEFAN_BOLTZMANN
from skyshine.mat.surface.forcing import plane_irradiance
from skyshine.mat.surface.surroundings import Exposure
from skyshine.mat.tables.axes import PERIODIC, AxisRule
from skyshine.mat.tables.interpolation import interpolate
from skyshine.mat.tables.response import DAY_H, forcing_hours, need_parts
from skyshine.mat.tables.shade import AIR, AUREOLE, DIFFUSE, DIRECT, FORCING_TIME, SUN_AZIMUTH, SUN_ELEVATION
from skyshine.schemas.arrays import Floats
from skyshine.schemas.hdf5 import Group


@dataclass(frozen=True, eq=False)
class OpenAir:
    """Light and air over surfaces without surroundings, by altitude and time of day.

    Attributes
    ----------
    altitude : AxisRule
        Axis [km].
    direct, diffuse : (A, 288) array
        Direct normal and diffuse horizontal irradiance [W m^-2].
    air : (A, 288) array
        Air temperature [K].
    elevation, azimuth : (288,) array
        Elevation and azimuth of the Sun [degree].
    aureole : (288,) array
        Share of the diffuse light that comes from around the Sun.
    """

    altitude: AxisRule
    direct: Floats
    diffuse: Floats
    air: Floats
    elevation: Floats
    azimuth: Floats
    aureole: Floats

    @classmethod
    def of(cls, root: Group) -> OpenAir:
        """Light and air of a database.

        Raises
        ------
        InputError
            The database has no response to shade.
        """
        names = (DIRECT, DIFFUSE, AIR, SUN_ELEVATION, SUN_AZIMUTH, AUREOLE)
        need_parts(root, names)
        return cls(
            AxisRule.of("altitude", root.axes["altitude"]),
            *(np.asarray(root.variables[name].data, float) for name in names),
        )

    def sunlight(
        self, exposure: Exposure, altitude: Floats, azimuth: Floats, slope: Floats, ground_albedo: float
    ) -> Floats:
        """Sunlight (P, 288) on P surfaces in their surroundings [W m^-2].

        Parameters
        ----------
        exposure : Exposure
            Shade and open sky of the surfaces at the 288 steps of the day.
        altitude, azimuth, slope : (P,) array
            Altitude [km], azimuth and slope [degree].
        ground_albedo : float
            Albedo of the ground, which reflects evenly.
        """
        normal, level = self._at(altitude, self.direct, self.diffuse)
        direct, diffuse, reflected = plane_irradiance(
            slope[:, None], azimuth[:, None], self.elevation, self.azimuth, normal, level, ground_albedo, self.aureole
        )
        view = _sky_view(slope)
        beam, spread = exposure.sunlight(view, direct, diffuse, view * (1 - self.aureole) * level)
        return beam + spread + reflected

    def air_temperature(self, altitude: Floats) -> Floats:
        """Air temperature (P, 288) [K] at altitudes (P,) [km]."""
        (air,) = self._at(altitude, self.air)
        return air

    def heat_of_walls(
        self, exposure: Exposure, altitude: Floats, slope: Floats, absorptance: Floats, emissivity: Floats
    ) -> Floats:
        """Absorbed heat (P, 288) [W m^-2] that walls send beyond what dark walls of the air's temperature do.

        Parameters
        ----------
        exposure : Exposure
            Surroundings with `facing` [K] and `wall_light` [W m^-2] of each surface and step.
        altitude, slope : (P,) array
            Altitude [km] and slope [degree].
        absorptance, emissivity : (P,) array
            Absorptance of sunlight and emissivity in the longwave.
        """
        air = self.air_temperature(altitude)
        kelvin = air if exposure.facing is None else exposure.facing
        longwave = exposure.facing_emissivity * STEFAN_BOLTZMANN * (kelvin**4 - air**4)
        hidden = (1 - exposure.sky_view) * _sky_view(slope)
        heat: Floats = hidden * (emissivity[:, None] * longwave + absorptance[:, None] * exposure.wall_light)
        return heat

    def _at(self, altitude: Floats, *fields: Floats) -> list[Floats]:
        """Fields (A, 288) at altitudes (P,) [km], within those of the database: (P, 288) each."""
        steps = AxisRule(FORCING_TIME, forcing_hours(), PERIODIC, DAY_H)
        position = {
            "altitude": np.clip(altitude, *self.altitude.nodes[[0, -1]])[:, None],
            FORCING_TIME: forcing_hours()[None, :],
        }
        return [interpolate(values, [self.altitude, steps], position) for values in fields]


def _sky_view(slope: Floats) -> Floats:
    """Share (P, 1) of the sky before tilted surfaces (P,) without obstructions."""
    view: Floats = 0.5 * (1 + np.cos(np.radians(slope)))[:, None]
    return view
