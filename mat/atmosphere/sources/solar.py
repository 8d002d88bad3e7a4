"""Solar spectral irradiance: outside the atmosphere (TSIS-1 HSRS to 2.73 um, ASTM E490 beyond) and at the ground."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import numpy.typing as npt

from skyshine.mat.atmosphere.sources.tables import solar_bins
from skyshine.schemas.arrays import Floats
from skyshine.schemas.errors import InputError

RAYLEIGH_JEANS = 400.0  # cm^-1; below it h c nu is less than a seventh of k T for the 4,400 K and more of the Sun there
ASTRONOMICAL_UNIT = 149_597_870_700.0  # m, exact (IAU 2012 resolution B2)


def solar_irradiance(wavenumber: npt.ArrayLike, width: npt.ArrayLike | None = None) -> Floats:
    """Solar spectral irradiance outside the atmosphere at 1 au.

    Constant inside the bins of the packaged table, which are 5 cm^-1 wide from 10 to 33,500 cm^-1; beyond 25 um, where
    such a bin spans much of the spectrum, it follows Rayleigh and Jeans's law inside a bin, as the square of
    wavenumber. Either way the sum over any set of bins is the irradiance of the source spectrum.

    Parameters
    ----------
    wavenumber : (P,) array
        cm^-1, 10 to 83,500.
    width : (P,) array or float, optional
        cm^-1; the mean over this width around each wavenumber instead of the bin that contains it. Fraunhofer lines are
        narrower than the wider intervals of the band model.

    Returns
    -------
    (P,) array
        W m^-2 (cm^-1)^-1; divide by the square of the distance in astronomical units.

    Raises
    ------
    InputError
        Outside the table.

    References
    ----------
    Coddington et al. 2021, doi:10.1029/2020GL091709; ASTM E490-00a.
    """
    edges, irradiance = solar_bins()
    wavenumber = np.asarray(wavenumber, dtype=float)
    if not np.all((wavenumber >= edges[0]) & (wavenumber <= edges[-1])):
        raise InputError(f"solar irradiance is tabulated from {edges[0]:.0f} to {edges[-1]:.0f} cm-1 only")
    bins = np.minimum(np.searchsorted(edges, wavenumber, side="right") - 1, len(irradiance) - 1)
    if width is not None:
        low, high = (np.clip(wavenumber + sign * np.asarray(width) / 2, edges[0], edges[-1]) for sign in (-1, 1))
        mean: Floats = (_running(high, edges, irradiance) - _running(low, edges, irradiance)) / (high - low)
        return mean
    in_bin: Floats = irradiance[bins]
    square = 3 * wavenumber**2 * (edges[bins + 1] - edges[bins]) / (edges[bins + 1] ** 3 - edges[bins] ** 3)
    return np.where(edges[bins] < RAYLEIGH_JEANS, in_bin * square, in_bin)


def ground_sunlight() -> tuple[Floats, Floats]:
    """Sunlight on a plane tilted by 37 degrees through 1.5 air masses: the weight of solar absorptances.

    Returns
    -------
    wavelength : (n,) array
        [um], increasing from 0.28 to 4.
    irradiance : (n,) array
        Direct and diffuse [W m^-2 um^-1]; 1000 W m^-2 in all.

    References
    ----------
    ASTM G173-03, global tilted; the table is that of pvlib.
    """
    # The table alone: the package imports pandas, which takes longer than most jobs are checked in.
    package = find_spec("pvlib")
    assert package is not None and package.submodule_search_locations is not None
    path = Path(package.submodule_search_locations[0]) / "data" / "ASTMG173.csv"
    wavelength, irradiance = np.loadtxt(path, delimiter=",", skiprows=2, usecols=(0, 2), unpack=True)
    return wavelength / 1000.0, irradiance * 1000.0


def _running(wavenumber: Floats, edges: Floats, irradiance: Floats) -> Floats:
    """Irradiance [W m^-2] between the first edge and wavenumbers of any shape."""
    total = np.concatenate([[0.0], np.cumsum(irradiance * np.diff(edges))])
    linear: Floats = np.interp(wavenumber, edges, total)
    bins = np.clip(np.searchsorted(edges, wavenumber, side="right") - 1, 0, len(irradiance) - 1)
    low, high = edges[bins], edges[bins + 1]
    cubic = total[bins] + (total[bins + 1] - total[bins]) * (wavenumber**3 - low**3) / (high**3 - low**3)
    return np.where(low < RAYLEIGH_JEANS, cubic, linear)
