"""Light of the night sky without the Moon: airglow, zodiacal light and starlight, outside the lower atmosphere.

Airglow is what the ESO sky model (Noll et al. 2012) has beyond zodiacal light, as means over broad bands: the lines of
O at 0.5577 and 0.630 um and of Na at 0.589 um and the bands of OH, which make most of it from 0.7 um on, are inside
these means and not resolved. It comes from a thin layer and brightens towards the horizon (van Rhijn 1921). Zodiacal
light and starlight are even over the sky, of the Sun's colour.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.solar import solar_irradiance
from skyshine.mat.atmosphere.sources.tables import night_sky_table
from skyshine.schemas.arrays import Floats

LONGEST = 2.5  # um; beyond, the air's own emission is thousands of times brighter
LAYER_HEIGHT = 90e3  # m above sea level (Noll et al. 2012)
EARTH_RADIUS = 6371e3  # m
SQUARE_ARCSECOND = np.radians(1 / 3600) ** 2  # sr
# One star of magnitude 10 (V) a square degree, over the Sun's irradiance, sr^-1: the Sun has V = -26.75 (Willmer 2018,
# doi:10.3847/1538-4365/aabfdf).
TENTH_MAGNITUDE = 10 ** (-0.4 * (10 + 26.75)) / np.radians(1) ** 2
# Stars of magnitude 10 a square degree: zodiacal light at the ecliptic pole (Leinert et al. 1998,
# doi:10.1051/aas:1998105) and away from the zodiac; faint stars and diffuse galactic light, mean of the sky (Allen
# 1973, Astrophysical Quantities, 3rd edition).
ZODIACAL_AT_THE_POLE = 60.0
ZODIACAL, STARS, GALACTIC = 100.0, 95.0, 20.0


def airglow_radiance(wavenumber: npt.ArrayLike) -> Floats:
    """Radiance of airglow in the zenith, 0 beyond 2.5 um.

    Parameters
    ----------
    wavenumber : (P,) array
        [cm^-1].

    Returns
    -------
    (P,) array
        [W m^-2 sr^-1 (cm^-1)^-1].
    """
    table = night_sky_table()
    nodes = table["wavelength[um]"]
    total = table["zero_point[W m-2 um-1]"] * 10 ** (-0.4 * table["brightness[mag arcsec-2]"]) / SQUARE_ARCSECOND
    # The Sun's spectrum within a broad band, about a seventh of the wavelength wide.
    middle = 1e4 / nodes
    zodiacal = ZODIACAL_AT_THE_POLE * TENTH_MAGNITUDE * solar_irradiance(middle, middle / 7) * middle**2 * 1e-4
    wavelength = 1e4 / np.asarray(wavenumber, dtype=float)
    per_um = np.exp(np.interp(wavelength, nodes, np.log(total - zodiacal)))
    radiance: Floats = np.where(wavelength <= LONGEST, per_um * wavelength**2 * 1e-4, 0.0)
    return radiance


def starlight_radiance(wavenumber: npt.ArrayLike, width: npt.ArrayLike | None = None) -> Floats:
    """Radiance of zodiacal light and of stars too faint to be seen, the same everywhere, 0 beyond 2.5 um.

    Parameters
    ----------
    wavenumber : (P,) array
        [cm^-1].
    width : (P,) array or float, optional
        [cm^-1], over which sunlight is averaged, see `solar_irradiance`.

    Returns
    -------
    (P,) array
        [W m^-2 sr^-1 (cm^-1)^-1].
    """
    wavenumber = np.asarray(wavenumber, dtype=float)
    brightness = (ZODIACAL + STARS + GALACTIC) * TENTH_MAGNITUDE * solar_irradiance(wavenumber, width)
    radiance: Floats = np.where(1e4 / wavenumber <= LONGEST, brightness, 0.0)
    return radiance


def van_rhijn(sine: npt.ArrayLike, altitude: npt.ArrayLike = 0.0) -> Floats:
    """Brightness of the airglow layer over that in the zenith.

    Parameters
    ----------
    sine : array_like
        Sine of the elevation of the line of sight, above the horizon.
    altitude : array_like
        Altitude of the observer above sea level [m], below the layer.

    References
    ----------
    van Rhijn 1921; Roach and Gordon 1973, The Light of the Night Sky.
    """
    ratio = (EARTH_RADIUS + np.asarray(altitude)) / (EARTH_RADIUS + LAYER_HEIGHT)
    factor: Floats = 1 / np.sqrt(1 - ratio**2 * (1 - np.asarray(sine) ** 2))
    return factor
