"""Emission and reflection inside the integral over the band: light by wavelength meets the materials' own spectra."""

from __future__ import annotations

import numpy as np

from skyshine.mat.tables.band import BandSpectra
from skyshine.schemas.arrays import Floats


def emitted_share(spectra: BandSpectra, transmittance: Floats) -> Floats:
    """What surfaces emit and paths let through, over the radiance of a black body (7): the integral (5).

    Parameters
    ----------
    spectra : BandSpectra
        Spectra of (..., M) materials at their temperatures.
    transmittance : (..., B) array
        Transmittance of the path by wavelength.
    """
    share: Floats = np.sum((1.0 - spectra.reflectance) * spectra.emission * transmittance[..., None, :], axis=-1)
    return share


def reflected(spectra: BandSpectra, light: Floats) -> Floats:
    """Light by wavelength (..., B) that (..., M) materials reflect: the integrals (18) and (26) without geometry."""
    radiance: Floats = np.maximum(np.sum(spectra.reflectance * light[..., None, :], axis=-1), 0.0)
    return radiance
