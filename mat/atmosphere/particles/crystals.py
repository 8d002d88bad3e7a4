"""Ice crystals: rough aggregates, whose phase functions have no halo.

The parametrisation of Raisanen et al. 2015 represents a mixture of severely rough droxtals, aggregates of severely
rough plates and strongly distorted Koch fractals that reproduces the phase function measured in blowing snow. Its size
is three quarters of the ratio of volume to projected area, the effective radius of clouds. It was fitted from 0.199 to
2.7 um to radii from 10 um on.

References
----------
Raisanen et al. 2015, The Cryosphere 9, 1277, doi:10.5194/tc-9-1277-2015.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.particles.moments import MOMENTS
from skyshine.mat.atmosphere.particles.particles import SpectralModel, between_wavelengths, henyey_greenstein
from skyshine.schemas.arrays import Floats

JOIN = (2.4, 2.7)  # um: between them tables pass from the fit to spheres of the same ratio of volume to area
# Equation 27: coefficients of 1, co-albedo, asymmetry and the product of the two, by order of the Legendre polynomial;
# that of order 6 replaces all higher orders.
_RESIDUAL = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
        [-0.01400, -0.10367, 0.02144, 0.08903],
        [-0.13184, -0.01741, 0.16890, -0.06365],
        [-0.20878, -0.03438, 0.27353, -0.10418],
        [-0.29763, -0.06931, 0.38501, -0.11329],
        [-0.32153, -0.10691, 0.41282, -0.07934],
    ]
)
# Co-albedos and asymmetries between which the residual fades out: above 0.3 the fit is not valid (section 6.4), and
# crystals as small as the wavelength, which have lower asymmetries, are not in it.
_FADING_COALBEDO, _FADING_ASYMMETRY = (0.2, 0.3), (0.75, 0.65)
# Bounds of the asymmetry of refracted light, and of its share that is not isotropic, where the fit ends.
_RAY_ASYMMETRY, _LEAST_SHARE = (0.0, 0.95), 0.3


def crystal_coalbedo(size_parameter: npt.ArrayLike, refractive_index: npt.ArrayLike) -> Floats:
    """Share of the extinction that is absorbed; of circumference over wavelength and n + ik (equations 11 and 12)."""
    index = np.asarray(refractive_index)
    absorbing = np.asarray(size_parameter) * index.imag * index.real**2
    result: Floats = 0.470 * (1 - np.exp(-2.69 * absorbing * (1 - 0.31 * np.minimum(absorbing, 2.0) ** 0.67)))
    return result


def crystal_asymmetry(size_parameter: npt.ArrayLike, refractive_index: npt.ArrayLike) -> Floats:
    """Mean cosine of the scattering angle; arguments as `crystal_coalbedo` (equation 13)."""
    size, index = np.asarray(size_parameter, float), np.asarray(refractive_index)
    absorbed = crystal_coalbedo(size, index)
    result: Floats = 1 - 1.146 * (index.real - 1) ** 0.8 * (0.52 - absorbed) ** 1.05 * (1 + 8 * size**-1.5)
    return result


@dataclass(frozen=True, eq=False)
class CrystalModel(SpectralModel):
    """Crystals of an effective radius [um].

    The phase function is that of diffraction and of light that has passed through the crystals, each after Henyey and
    Greenstein, an even part and a residual of low orders (equation 30), with albedo and asymmetry of the tables. Beyond
    the range of the fit its shape is kept, with the asymmetry of the tables and no residual.
    """

    effective_radius: float

    def _phase(self, cosine: Floats, wavelength: Floats) -> Floats:
        diffracted, narrow, refracted, wide, even, residual = self._parts(wavelength)
        column = cosine[:, None]
        smooth = np.polynomial.legendre.legval(
            cosine, (2 * np.arange(residual.shape[0]) + 1)[:, None] * residual, tensor=True
        ).T
        phase: Floats = (
            diffracted * henyey_greenstein(narrow, column) + refracted * henyey_greenstein(wide, column) + even + smooth
        )
        return phase

    def _moments(self, wavelength: Floats) -> Floats:
        diffracted, narrow, refracted, wide, even, residual = self._parts(wavelength)
        order = np.arange(MOMENTS)[:, None]
        moments: Floats = diffracted * narrow**order + refracted * wide**order
        moments[0] += even
        moments[: residual.shape[0]] += residual
        return moments

    def _parts(self, wavelength: Floats) -> tuple[Floats, ...]:
        """Weight and asymmetry of diffraction, of refracted light, (P,) each; weight of the even part (P,); moments
        (6, P) of the residual.
        """
        albedo = between_wavelengths(self.wavelength, self.extinction, self.absorption, wavelength)[1]
        asymmetry = np.interp(wavelength, self.wavelength, self.asymmetry)
        absorbed = 1 - albedo
        size = 2 * np.pi * self.effective_radius / wavelength
        # Equations 15 to 24, of which the asymmetry of the whole decides where the fit ends.
        narrow = np.maximum(1 - 0.60 / size, asymmetry + 0.1 * (1 - asymmetry))
        shadow = np.minimum(0.5 / albedo, 0.98)
        ray = np.clip((asymmetry - shadow * narrow) / (1 - shadow), *_RAY_ASYMMETRY)
        ray = np.minimum(ray, asymmetry)
        shadow = (asymmetry - ray) / (narrow - ray)
        share = np.maximum(1 - 1.53 * np.maximum(0.77 - ray, 0.0) ** 1.2, _LEAST_SHARE)
        fading = np.minimum(_faded(absorbed, *_FADING_COALBEDO), _faded(asymmetry, *_FADING_ASYMMETRY))
        terms = np.array([np.ones_like(absorbed), absorbed, asymmetry, absorbed * asymmetry])
        coefficients = fading * (_RESIDUAL @ terms)
        # The part of all orders alike goes straight forward: it counts as diffraction.
        forward = coefficients[-1]
        residual = coefficients[:-1] - forward
        residual[1] = -forward * narrow  # the mean cosine stays that of the tables
        return (
            shadow + forward,
            narrow,
            (1 - shadow) * share,
            ray / share,
            (1 - shadow) * (1 - share),
            residual,
        )


def _faded(values: Floats, full: float, zero: float) -> Floats:
    return np.clip((zero - values) / (zero - full), 0.0, 1.0)
