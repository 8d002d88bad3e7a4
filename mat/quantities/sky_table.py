"""Sky irradiance of horizontal surfaces, tabulated over their altitude."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.night_light import night_irradiance
from skyshine.mat.atmosphere.transfer.path_axes import ALL_PATHS, PathScope
from skyshine.mat.atmosphere.transfer.sky import sky_irradiance
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats

# Heights above the ground [m] at which sky irradiance is computed; between them it is exponential. Aerosol falls
# steeply above 2 km.
SKY_HEIGHTS = (
    0,
    250,
    500,
    1e3,
    1.5e3,
    2e3,
    2.25e3,
    2.5e3,
    3e3,
    4e3,
    5e3,
    6.5e3,
    8e3,
    10e3,
    12e3,
    14e3,
    17e3,
    22e3,
    30e3,
    40e3,
    60e3,
)
# Altitudes whose sky is computed together.
_GROUP = 3


@dataclass(frozen=True, eq=False)
class SkyTable:
    """Sky irradiance at Z altitudes, under a source at each of SE elevations, at P points.

    Attributes
    ----------
    altitude : (Z,) array
        m, increasing, inside the atmosphere.
    log_irradiance : (Z, SE, P) array
        Logarithm of W m^-2 (cm^-1)^-1.
    """

    air: SpectralAir
    altitude: Floats
    log_irradiance: Floats

    @classmethod
    def of(cls, air: SpectralAir, altitude: Floats, source_elevation: Floats, irradiance: Floats) -> SkyTable:
        """Compute a table.

        Parameters
        ----------
        altitude : (any,) array
            m, in any order; altitudes in space count as the top of the atmosphere.
        source_elevation : (SE,) array
            Geometric, at the surfaces, rad.
        irradiance : (P,) array
            Irradiance of the source outside the atmosphere, normal to the beam, W m^-2 (cm^-1)^-1.
        """
        altitude = np.unique(np.minimum(altitude, air.shells.top))

        def total(group: Floats) -> Floats:
            sky = sky_irradiance(air, group, source_elevation)
            emitted = sky.thermal + night_irradiance(air, group) if air.state.night_sky else sky.thermal
            return emitted[:, None] + sky.scattered * irradiance

        groups = np.array_split(altitude, -(-altitude.size // _GROUP))
        irradiances = np.concatenate(parallel_map(total, groups))
        return cls(air, altitude, np.log(np.maximum(irradiances, np.finfo(float).tiny)))

    @classmethod
    def over_ground(
        cls, air: SpectralAir, source_elevation: Floats, irradiance: Floats, scope: PathScope = ALL_PATHS
    ) -> SkyTable:
        """The table at those of `SKY_HEIGHTS` above the ground that are read; arguments as `of`."""
        heights = scope.heights(SKY_HEIGHTS)
        return cls.of(air, air.state.surface_altitude + heights, source_elevation, irradiance)

    def at(self, altitude: Floats) -> Floats:
        """Sky irradiance (R, SE, P) [W m^-2 (cm^-1)^-1] at altitudes (R,) [m]: exponential between those of the table,
        in proportion to pressure above the highest.
        """
        nodes, state = self.altitude, self.air.state
        lower = np.clip(np.searchsorted(nodes, altitude, side="right") - 1, 0, nodes.size - 1)
        upper = np.minimum(lower + 1, nodes.size - 1)
        fraction = np.where(
            upper > lower, (altitude - nodes[lower]) / np.where(upper > lower, nodes[upper] - nodes[lower], 1.0), 0.0
        )
        share = fraction[:, None, None]
        irradiance = np.exp(self.log_irradiance[lower] * (1 - share) + self.log_irradiance[upper] * share)
        pressure = np.where(altitude > self.air.shells.top, 0.0, state.pressure_at(altitude))
        thinning: Floats = np.minimum(pressure / state.pressure_at(nodes[-1]), 1.0)
        at: Floats = irradiance * thinning[:, None, None]
        return at
