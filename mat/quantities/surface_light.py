"""Light on the surface at the end of a line of sight, as the observer sees it: equations (20) and (36)."""

from __future__ import annotations

import numpy as np

from skyshine.mat.atmosphere.band.points import BandPoints
from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.atmosphere.transfer.line_of_sight import LineOfSight
from skyshine.mat.atmosphere.transfer.sky import direct_transmittance
from skyshine.mat.quantities.sky_table import SkyTable
from skyshine.schemas.arrays import Floats


def radiance_weight(band: BandPoints, path: LineOfSight) -> Floats:
    """Weights (R, P) [cm^-1 sr^-1] that turn irradiance at the end of each range into (20) and (36): the band's
    radiance weights over pi, times transmittance over its in-band mean.
    """
    relative = np.exp(path.depth.min(axis=1, keepdims=True) - path.depth)  # transmittance over its largest
    weight: Floats = relative * band.radiance_weight / (np.pi * (relative @ band.weight / band.weight.sum()))[:, None]
    return weight


def ambient(path: LineOfSight, weight: Floats, sky: SkyTable) -> Floats:
    """Radiance (R, SE) [W m^-2 sr^-1] of a white surface under the sky, equation (20).

    Parameters
    ----------
    weight : (R, P) array
        Weights from `radiance_weight`.
    """
    radiance: Floats = np.einsum("rp,rsp->rs", weight, sky.at(path.surface_altitude))
    return radiance


def direct(air: SpectralAir, path: LineOfSight, weight: Floats, source_elevation: Floats, irradiance: Floats) -> Floats:
    """Radiance (R, SE) [W m^-2 sr^-1] of a white surface normal to a source's beam, equation (36).

    Parameters
    ----------
    weight : (R, P) array
        Weights from `radiance_weight`.
    source_elevation : (SE,) array
        Elevation of the source at the surface, rad.
    irradiance : (P,) array
        Irradiance of the source outside the atmosphere, W m^-2 (cm^-1)^-1.
    """
    transmittance = direct_transmittance(air.source_paths, path.surface_altitude, source_elevation)
    radiance: Floats = np.einsum("rp,rsp->rs", weight * irradiance, transmittance)
    return radiance
