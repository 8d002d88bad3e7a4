"""Solar spectral irradiance: TSIS-1 HSRS to 2.73 um, ASTM E490 beyond."""

from functools import lru_cache

import numpy as np

from skyshine import atmospheres
from skyshine.schemas.csv_table import read_csv
from skyshine.schemas.errors import InputError

ASTRONOMICAL_UNIT = 149_597_870_700.0  # m, exact (IAU 2012 resolution B2)


def solar_irradiance(wavenumber, width=None):
    """Solar spectral irradiance outside the atmosphere at 1 au.

    Constant inside the bins of the packaged table, which are 5 cm^-1 wide from 10 to 33,500 cm^-1, so that the sum over
    any set of bins is the irradiance of the source spectrum.

    Parameters
    ----------
    wavenumber : (P,) array
        cm^-1, 10 to 83,500.
    width : (P,) array or float, optional
        cm^-1; the mean over this width around each wavenumber instead of the bin that holds it. Fraunhofer lines are
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
    edges, irradiance = _table()
    wavenumber = np.asarray(wavenumber, dtype=float)
    if not np.all((wavenumber >= edges[0]) & (wavenumber <= edges[-1])):
        raise InputError(f"solar irradiance is tabulated from {edges[0]:.0f} to {edges[-1]:.0f} cm-1 only")
    if width is not None:
        total = np.concatenate([[0.0], np.cumsum(irradiance * np.diff(edges))])
        low, high = (np.clip(wavenumber + sign * np.asarray(width) / 2, edges[0], edges[-1]) for sign in (-1, 1))
        return (np.interp(high, edges, total) - np.interp(low, edges, total)) / (high - low)
    bins = np.searchsorted(edges, wavenumber, side="right") - 1
    return irradiance[np.minimum(bins, len(irradiance) - 1)]


@lru_cache(maxsize=1)
def _table():
    """Edges (N + 1,) and mean irradiance (N,) of the bins."""
    table = read_csv(atmospheres.path("sources/solar.csv"))
    return table["wavenumber[cm-1]"], table["irradiance[W m-2 (cm-1)-1]"][:-1]
