"""Ambient radiance of a face of any direction from few spherical harmonics of the radiance around it.

Irradiance is radiance convolved with the clamped cosine, whose harmonics fall so steeply that those of radiance up to
l = 2 or l = 4 suffice. Radiance is symmetric about the plane of the vertical and the source, so that only terms in
cos(m phi) remain. In the frame of a face z points up and x is horizontal, towards the source.

References
----------
Ramamoorthi and Hanrahan 2001, J. Opt. Soc. Am. A 18, 2448 (irradiance by spherical harmonics).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.schemas.arrays import Floats, Integers

# Codes 10 l + m of the harmonics, in the order of the tables; odd l above 1 have no irradiance.
HARMONICS = (0, 10, 11, 20, 21, 22, 40, 41, 42, 43, 44)
COUNTS = (6, 11)  # up to l = 2, up to l = 4
# A_l / pi of the clamped cosine (Ramamoorthi and Hanrahan 2001, equation 9).
_COSINE_FACTORS = {0: 1.0, 1: 2 / 3, 2: 1 / 4, 4: -1 / 24}
# Norms of the real harmonics with the polynomials of `harmonics_at`.
_NORMS = np.sqrt(
    np.array([1, 3, 3, 5, 60, 15, 9, 90, 45, 630, 315]) / (np.pi * np.array([4, 4, 4, 4, 16, 16, 4, 16, 16, 16, 256]))
)


def zonal(count: int) -> tuple[int, ...]:
    """Codes of those of the first `count` harmonics that do not depend on azimuth."""
    return tuple(code for code in HARMONICS[:count] if code % 10 == 0)


def face_normal(slope: npt.ArrayLike, azimuth: npt.ArrayLike) -> Floats:
    """Unit vectors (..., 3) of faces in the frame of the harmonics.

    Parameters
    ----------
    slope : array
        0 faces up, 180 down, degree.
    azimuth : array
        Azimuth of the face relative to the source's, degree.
    """
    tilt, turn = np.radians(slope), np.radians(azimuth)
    return np.stack(
        np.broadcast_arrays(np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)), axis=-1
    )


def harmonics_at(direction: Floats, codes: npt.ArrayLike = HARMONICS) -> Floats:
    """Real orthonormal harmonics Y_lm (..., H) of codes (H,) at unit vectors (..., 3)."""
    x, y, z = np.moveaxis(np.asarray(direction, float), -1, 0)
    even = x * x - y * y
    values = np.stack(
        [
            np.ones_like(z),
            z,
            x,
            (3 * z**2 - 1) / 2,
            x * z,
            even,
            legendre(4, z),
            x * z * (7 * z**2 - 3) / 2,
            even * (7 * z**2 - 1) / 2,
            x * z * (x * x - 3 * y * y) / 2,
            even**2 - 4 * x * x * y * y,
        ],
        axis=-1,
    )
    columns: Integers = np.searchsorted(HARMONICS, codes)
    harmonics: Floats = (values * _NORMS)[..., columns]
    return harmonics


def irradiance_factors(codes: npt.ArrayLike) -> Floats:
    """A_l / pi of harmonics of codes (H,): irradiance over pi of a unit of each, over Y_lm of the normal."""
    return np.array([_COSINE_FACTORS[int(code) // 10] for code in np.asarray(codes)])


def legendre(order: int, cosine: npt.ArrayLike) -> Floats:
    """Legendre polynomial P4 or P6."""
    square = np.square(np.asarray(cosine, float))
    if order == 4:
        return np.asarray(((35 * square - 30) * square + 3) / 8)
    return np.asarray((((231 * square - 315) * square + 105) * square - 5) / 16)


def level_share(cosine: Floats, count: int) -> Floats:
    """Change of `ambient_of_faces` over that of the level value, at cosines of slope, for so many harmonics."""
    return legendre(4 if count == COUNTS[0] else 6, cosine)


def ambient_of_faces(
    level: Floats, radiance: Floats, ground: Floats, ground_radiance: Floats, normal: Floats
) -> Floats:
    """Ambient radiance of faces: irradiance by everything around over pi, weighted as that of a level face is.

    The sum of harmonics S is S(normal) + (level - S(up)) P(cosine of slope): a level face has exactly the level value,
    and its difference from the sum is an estimate of the first harmonic that the sum lacks, which P4 (6 harmonics) or
    P6 (11) carries to other slopes.

    Parameters
    ----------
    level : (...) array
        Ambient light of a level face, equation (20).
    radiance : (..., H) array
        Coefficients of the radiance around the face, without the light that the ground emits; H is one of `COUNTS`.
    ground : (..., Z) array
        Coefficients of the harmonics `zonal` of the ground's emission, per unit of `ground_radiance`.
    ground_radiance : (...) array
        Radiance that the ground emits.
    normal : (..., 3) array
        Normals from `face_normal`.

    Returns
    -------
    (...) array
        In the units of `level`; not below 0.
    """
    codes = np.array(HARMONICS[: radiance.shape[-1]])
    index = np.searchsorted(codes, zonal(codes.size))
    total = np.array(np.broadcast_arrays(radiance, np.zeros((*np.shape(ground_radiance), 1)))[0])
    total[..., index] += ground * np.asarray(ground_radiance)[..., None]
    factors = irradiance_factors(codes)
    upright = total @ (factors * harmonics_at(np.array([0.0, 0.0, 1.0]), codes))
    facing = np.sum(total * (factors * harmonics_at(normal, codes)), axis=-1)
    correction = level_share(normal[..., 2], codes.size)
    light: Floats = np.maximum(facing + (level - upright) * correction, 0.0)
    return light
