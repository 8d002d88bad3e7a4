"""Optical constants of liquid water: `materials/water.csv`."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import numpy.typing as npt

from skyshine import materials
from skyshine.schemas.csv_table import parse_table, read_text


@lru_cache(maxsize=1)
def water_index() -> tuple[npt.NDArray[np.float64], npt.NDArray[np.complex128]]:
    """Wavelength (n,) [um] and refractive index n + ik (n,) of water at 25 C.

    References
    ----------
    Hale and Querry (1973), Appl. Opt. 12, 555-563.
    """
    file = materials.path("water.csv")
    table = parse_table(read_text(file), file).values
    return table[:, 0], table[:, 1] + 1j * table[:, 2]
