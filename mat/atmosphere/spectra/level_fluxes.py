"""Spectral fluxes on the levels of a state: thermal and solar, upward and downward.

Radiation between plane layers by discrete ordinates, with beams that are refracted through spherical shells, as all
diffuse light here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.gases.spectral_points import SpectralPoints
from skyshine.mat.atmosphere.state.state import AtmosphericState
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.ordinate_light import level_light
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance, forward_scattered
from skyshine.mat.atmosphere.transfer.thermal_source import level_emission
from skyshine.schemas.arrays import Floats


@dataclass(frozen=True, eq=False)
class LevelFluxes:
    """Fluxes through horizontal surfaces at N levels, of P points, under a source at S elevations.

    Attributes
    ----------
    altitude : (N,) array
        Altitudes from the ground up, m.
    thermal_up, thermal_down : (N, P) arrays
        Emitted by ground and air, W m^-2 (cm^-1)^-1.
    direct, diffuse_down, diffuse_up : (N, S, P) arrays
        Light of the source, per unit of its irradiance normal to the beam outside the atmosphere: not scattered,
        scattered downward, and scattered or reflected upward.
    """

    altitude: Floats
    thermal_up: Floats
    thermal_down: Floats
    direct: Floats
    diffuse_down: Floats
    diffuse_up: Floats

    @classmethod
    def of(cls, state: AtmosphericState, points: SpectralPoints, source_elevation: npt.ArrayLike) -> LevelFluxes:
        """The fluxes of a state over its ground.

        Parameters
        ----------
        state : AtmosphericState
            State with ground temperature and albedo.
        source_elevation : (S,) array
            Geometric, at each level, degree; may be empty.

        References
        ----------
        Stamnes, Tsay, Wiscombe and Jayaweera 1988, Appl. Opt. 27, 2502 (discrete ordinates).

        Examples
        --------
        >>> import numpy as np
        >>> from skyshine.mat.atmosphere.gases.absorption import AbsorptionTable
        >>> from skyshine.mat.atmosphere.state.state import AtmosphericState
        >>> points = AbsorptionTable.open().points(1000, 1010)
        >>> fluxes = LevelFluxes.of(AtmosphericState.from_profile("us_standard"), points, [])
        >>> bool(np.all(fluxes.thermal_up > fluxes.thermal_down))
        True
        """
        air = SpectralAir.of(state, points)
        elevation = np.radians(np.asarray(source_elevation, dtype=float))
        thermal_up, thermal_down = level_emission(state, air.shells, air.optics, air.nodes)
        shape = (state.altitude.size, elevation.size, points.wavenumber.size)
        if not elevation.size:
            return cls(state.altitude, thermal_up, thermal_down, *np.zeros((3, *shape)))
        sine = np.maximum(np.sin(elevation), 0.0)[:, None]
        through = direct_transmittance(air.source_paths, state.altitude, elevation)
        forward = sine * forward_scattered(air, state.altitude, elevation, through)
        order = np.argsort(elevation)
        rising, falling = np.empty((2, *shape))
        rising[:, order], falling[:, order] = level_light(
            state,
            air.shells,
            air.optics,
            air.delta_fraction,
            air.scaled_source_paths,
            np.sin(elevation[order]),
            state.albedo_at(points.wavenumber),
            air.nodes,
        )
        return cls(state.altitude, thermal_up, thermal_down, sine * through, falling + forward, rising)

    def in_band(self, weight: Floats, irradiance: Floats) -> LevelFluxes:
        """Sums over the points as a single one, W m^-2: thermal by weights (P,) [cm^-1], light by the source's
        irradiance (P,) at the points [W m^-2].
        """
        thermal = ((values @ weight)[..., None] for values in (self.thermal_up, self.thermal_down))
        light = ((values @ irradiance)[..., None] for values in (self.direct, self.diffuse_down, self.diffuse_up))
        return replace(self, **dict(zip(_FLUXES, (*thermal, *light), strict=True)))


_FLUXES = ("thermal_up", "thermal_down", "direct", "diffuse_down", "diffuse_up")
