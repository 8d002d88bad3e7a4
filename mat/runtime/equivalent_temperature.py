"""Temperature of a black body that sends a band radiance."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from skyshine.mat.tables.band import BandTable
from skyshine.schemas.arrays import Floats


def equivalent_temperature(band: BandTable, radiance: npt.ArrayLike) -> Floats:
    """Temperature of a black body of a band radiance, K; 0 where there is none.

    ln L against 1/T is almost straight (Wien), so that it is interpolated, and continued below the table, in these.
    """
    inverse = 1 / band.root.axes["temperature"].values.astype(float)
    table = np.log(band.root.variables["blackbody_radiance"].data.astype(float))
    with np.errstate(divide="ignore"):
        logarithm = np.log(np.asarray(radiance, float))
    below = inverse[0] + (logarithm - table[0]) * (inverse[1] - inverse[0]) / (table[1] - table[0])
    temperature: Floats = 1 / np.where(logarithm < table[0], below, np.interp(logarithm, table, inverse))
    return temperature
