"""Results of a band on a grid or at points."""

from __future__ import annotations

from dataclasses import dataclass

from skyshine.schemas.arrays import Booleans, Floats

QUANTITIES = ("beta_star", "path_radiance_ratio", "ambient", "direct")


@dataclass(frozen=True, eq=False)
class AtmosphericQuantities:
    """The four quantities on a grid, or at points; None in place of a quantity that was not requested.

    Attributes
    ----------
    beta_star : (R, A, E) array
        km; at most `BETA_CAP_KM`.
    path_radiance_ratio : (R, A, E, SE, SA) array
        Path radiance over (1 - transmittance), W m^-2 sr^-1.
    ambient, direct : (R, A, E, SE) arrays
        W m^-2 sr^-1; direct is the irradiance normal to the beam over pi.
    valid : (R, A, E) bool array
        False where the range would pass through the ground: beta_star and the path radiance go on there as through the
        air above the ground, the other quantities are held at their values on the ground.
    transmittance : (R, A, E) array
    """

    beta_star: Floats
    path_radiance_ratio: Floats
    ambient: Floats
    direct: Floats
    valid: Booleans
    transmittance: Floats


@dataclass(frozen=True, eq=False)
class SpectralLines:
    """Lines of sight to n surfaces at the P points of a band.

    Attributes
    ----------
    transmittance : (n, P) array
    sky_irradiance : (n, P) array
        Diffuse, on a level surface at the end of the line, or on the face there, W m^-2 (cm^-1)^-1.
    direct_irradiance : (n, P) array
        Irradiance of the source at the end of the line, normal to its beam, W m^-2 (cm^-1)^-1.
    path_radiance : (n,) array
        Path radiance in band, W m^-2 sr^-1.
    valid : (n,) bool array
        False where the range would pass through the ground.
    """

    transmittance: Floats
    sky_irradiance: Floats
    direct_irradiance: Floats
    path_radiance: Floats
    valid: Booleans
