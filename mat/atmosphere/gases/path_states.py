"""Paths through standard atmospheres on which sets of spectral points are fitted to line-by-line spectra and judged by
them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skyshine.mat.radiometry.constants import C2
from skyshine.schemas.arrays import Booleans, Floats, Singles


@dataclass(frozen=True)
class PathState:
    """One atmosphere with its paths.

    Attributes
    ----------
    pressure, temperature, h2o_fraction : (L,) arrays, Pa, K, 1
    fraction : dict of (L,) arrays
        Mole fractions of the gases.
    columns : (R, L) array
        Molecules of air m^-2 that each path collects at each level.
    apart : (R,) bool array
        Paths whose transmittance by single gases is a target too.
    emission : list of (S, L) arrays
        Lines of sight through successive slabs, nearest first, up to the highest level: air columns of slab s, for
        thermal path radiance.
    """

    pressure: Floats
    temperature: Floats
    h2o_fraction: Floats
    fraction: dict[str, Floats]
    columns: Floats
    apart: Booleans
    emission: list[Floats]

    def values(self, absorption: Floats | Singles, wavenumber: float | Floats) -> Singles:
        """Transmittance of the paths and thermal radiance of the lines of sight, over that of the warmest level.

        Parameters
        ----------
        absorption : (L, K) array
            Absorption of all gases at the levels, m2 per molecule of air.
        wavenumber : float or (K,) array
            Wavenumber of the black body, cm^-1.

        Returns
        -------
        (R + E, K) float32 array
        """
        total = absorption.astype(np.float32)
        through = np.exp(-(self.columns.astype(np.float32) @ total))
        source = planck_ratio(wavenumber, self.temperature)
        rows = [slab_emission(slabs.astype(np.float32) @ total, source)[None] for slabs in self.emission]
        return np.concatenate([through, *rows])


def slab_emission(depth: Singles, source: Floats) -> Singles:
    """Radiance of successive slabs of optical depth (S, K), nearest first, that end at the top of the levels.

    Parameters
    ----------
    depth : (S, K) array
    source : (L,) or (L, K) array
        Radiance of a black body at the levels.

    Returns
    -------
    (K,) float32 array, in the unit of `source`
    """
    through = np.exp(-np.vstack([np.zeros((1, depth.shape[1]), np.float32), np.cumsum(depth, axis=0)]))
    start = len(source) - 1 - len(depth)
    mean = 0.5 * (source[start:-1] + source[start + 1 :])
    emitted = -np.diff(through, axis=0)
    if mean.ndim == 1:
        return np.asarray(mean.astype(np.float32) @ emitted, dtype=np.float32)
    return np.asarray(np.einsum("sk,sk->k", mean, emitted), dtype=np.float32)


def planck_ratio(wavenumber: float | Floats, temperature: Floats) -> Floats:
    """Planck radiance at a wavenumber [cm^-1] over that of the warmest of temperatures (L,) [K]: (L,); (L, K) at
    several (K,).
    """
    kelvin = temperature if np.ndim(wavenumber) == 0 else temperature[:, None]
    return np.asarray(np.expm1(C2 * wavenumber / temperature.max()) / np.expm1(C2 * wavenumber / kelvin))
