"""Emission and reflection inside the integral over the band: light by wavelength meets the materials' own spectra."""

from __future__ import annotations

import numpy as np

from skyshine.mat.tables.atmosphere_table import AtmosphereTable
from skyshine.mat.tables.band import BandSpectra, BandTable
from skyshine.mat.tables.channel_reader import SHORTEST_KM
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError


def check_same_band(air: AtmosphereTable, band: BandTable) -> None:
    """Refuse an atmosphere and a band database of different bands.

    Raises
    ------
    InputError
        They are not of one band.
    """
    ours, theirs = (np.asarray(table.root.axes["band_wavelength"].values, float) for table in (air, band))
    if ours.shape != theirs.shape or not np.allclose(ours, theirs, rtol=1e-6, atol=0.0):
        raise InputError(
            f"spans {theirs[0]:g} to {theirs[-1]:g} um, the atmosphere {ours[0]:g} to {ours[-1]:g} um; allowed: the"
            " same band; build both from one job",
            file=band.path,
        )


def emitted_share(spectra: BandSpectra, transmittance: Floats) -> Floats:
    """What surfaces emit and paths let through, over the radiance of a black body (7): the integral (5).

    Parameters
    ----------
    spectra : BandSpectra
        Of (..., M) materials at their temperatures.
    transmittance : (..., B) array
        By wavelength.
    """
    share: Floats = np.sum((1.0 - spectra.reflectance) * spectra.emission * transmittance[..., None, :], axis=-1)
    return share


def reflected(spectra: BandSpectra, light: Floats) -> Floats:
    """Light by wavelength (..., B) that (..., M) materials reflect: the integrals (18) and (26) without geometry."""
    radiance: Floats = np.maximum(np.sum(spectra.reflectance * light[..., None, :], axis=-1), 0.0)
    return radiance


def transmittance(depth: Floats, centre_range: Floats, pixel_range: Floats) -> Floats:
    """Transmittance by wavelength (n, B) over the range of pixels (n,) [km], from the optical depth (n, B) over that of
    their centres (n,): as (8) and (9) do with one beta*.
    """
    stretch = pixel_range / np.maximum(centre_range, SHORTEST_KM)
    through: Floats = np.exp(-depth * np.where(pixel_range == centre_range, 1.0, stretch)[..., None])
    return through
