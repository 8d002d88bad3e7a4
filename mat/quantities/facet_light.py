"""Ambient radiance of a face of any direction, integrated directly over the hemisphere that it sees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.atmosphere.transfer.air import SpectralAir
from skyshine.mat.quantities.radiance_field import Directions, GroundReflection, RadianceField, cell_phases
from skyshine.mat.radiometry.blackbody import planck_wavenumber
from skyshine.mat.threads import parallel_map
from skyshine.schemas.arrays import Floats

# Zenith angles of a hemisphere and azimuths of half a turn; against 32 x 24: 0.006 K rms and 0.02 K at most, at
# reflectance 0.3, in 3-5 and 8-12 um.
ZENITHS, AZIMUTHS = 12, 6


@dataclass(frozen=True, eq=False)
class Faces:
    """n faces and the ground around them.

    Attributes
    ----------
    normal : (n, 3) array
        Of `spherical_harmonics.face_normal`.
    ground_temperature : (n,) array
        K.
    """

    normal: Floats
    ground_temperature: Floats


def facet_irradiance(
    air: SpectralAir,
    altitude: Floats,
    source_elevation: Floats,
    normal: Floats,
    irradiance: Floats,
    ground_temperature: Floats,
) -> Floats:
    """Irradiance of faces by sky, air and ground, but for the source itself.

    Parameters
    ----------
    air : SpectralAir
    altitude : (n,) array
        m.
    source_elevation : (n,) array
        Geometric, rad.
    normal : (n, F, 3) array
        F faces at each place, of `spherical_harmonics.face_normal`.
    irradiance : (P,) array
        Of the source outside the atmosphere, normal to the beam, W m^-2 (cm^-1)^-1.
    ground_temperature : (n,) array
        K.

    Returns
    -------
    (n, F, P) array
        W m^-2 (cm^-1)^-1.
    """
    directions = Directions.of(ZENITHS, AZIMUTHS)
    air.prepare()

    def one(place: int) -> Floats:
        source = source_elevation[place : place + 1]
        reflection = GroundReflection.of(air, source)
        phases = cell_phases(air, directions, source)
        field = RadianceField.at(air, float(altitude[place]), source, reflection, directions, phases)
        emitted = (1 - air.state.surface_albedo) * planck_wavenumber(air.optics.wavenumber, ground_temperature[place])
        radiance = field.radiance(irradiance)[:, 0] + (field.to_ground * emitted)[:, None]
        weights = np.stack([directions.irradiance_weights(face) for face in normal[place]])
        light: Floats = np.einsum("fda,dap->fp", weights, radiance, optimize=True)
        return light

    _ = directions.samples  # before threads share it
    shape = (*normal.shape[:2], irradiance.size)
    return np.array(parallel_map(one, range(altitude.size))).reshape(shape)
