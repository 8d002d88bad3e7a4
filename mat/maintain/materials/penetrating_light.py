"""Depths at which clear ice absorbs sunlight, as exponential laws: `light` of `materials/ht/ice_clear.yaml`.

Run ``python -m mat.maintain.materials.penetrating_light FILE``; FILE is ``rii_nk/H2O__Warren-2008.yml`` of
refractiveindex.info (Warren and Brandt 2008, J. Geophys. Res. 113, D14220).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from mat.maintain.materials.readers import read_constants
from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.schemas.arrays import Floats

THICKNESS = 0.3  # m, of the material
SKIN = 0.003  # m: what is absorbed above counts as absorbed at the surface
_START = (6.0, 70.0)  # m^-1


def absorbed_above(file: Path, depth: Floats) -> Floats:
    """Share of the sunlight that ice absorbs, absorbed above depths (n,) [m]: (n,)."""
    nodes, index = read_constants(file)
    wavelength, irradiance = ground_sunlight()
    extinct = np.exp(np.interp(np.log(wavelength), np.log(nodes), np.log(index.imag)))
    absorption = 4 * np.pi * extinct / (wavelength * 1e-6)

    def passed(at: float) -> float:
        return float(np.trapezoid(irradiance * np.exp(-absorption * at), wavelength))

    total = passed(0.0) - passed(THICKNESS)
    return np.array([(passed(0.0) - passed(float(at))) / total for at in depth])


def laws(file: Path) -> tuple[Floats, Floats, float]:
    """Shares and extinctions [1/m] of two exponential laws below the skin, and their largest error."""
    depth = np.geomspace(SKIN, THICKNESS, 200)
    target = absorbed_above(file, depth)

    def error(parameters: Floats) -> Floats:
        share, extinction = parameters[:2], np.exp(parameters[2:])
        part = (1 - np.exp(-np.outer(depth, extinction))) / (1 - np.exp(-THICKNESS * extinction))
        residual: Floats = 1 - share.sum() + part @ share - target
        return residual

    fit = least_squares(error, np.concatenate([[0.4, 0.3], np.log(_START)]))
    return fit.x[:2], np.exp(fit.x[2:]), float(np.abs(fit.fun).max())


if __name__ == "__main__":
    shares, extinctions, largest = laws(Path(sys.argv[1]))
    for share, extinction in zip(shares, extinctions, strict=True):
        print(f"share {share:.3f}, extinction {extinction:.3g} /m")
    print(f"absorbed above any depth below {1e3 * SKIN:g} mm: {largest:.3f} at most away")
