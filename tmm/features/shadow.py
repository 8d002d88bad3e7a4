"""Shadows: texels far darker than the material they show is elsewhere in the texture.

Under a clear sky a surface in cast shadow is lit by the sky alone, by a fifth to a third of what falls on it in
sunlight; materials themselves seldom vary that much. The comparison is with the same material, because a threshold on
brightness alone takes dark materials for shadows, and finds shadows where there are none.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

SHADOW_RATIO = (
    0.4  # of the material's median luminance: above the skylight's share of clear-sky irradiance, 0.2 to 0.35
)


def luminance(colours: npt.NDArray[Any], encoding: str) -> npt.NDArray[Any]:
    """Relative luminance (N,) of colours (N, 3 or more) as a file holds them."""
    from skyshine.tmm.features.colour import to_xyz

    return to_xyz(colours[..., :3], encoding)[..., 1]


def shadow_limits(lightness: npt.NDArray[Any], material: npt.NDArray[Any], count: int) -> npt.NDArray[Any]:
    """Luminance below which a texel of each material is in shadow.

    Parameters
    ----------
    lightness : (N,) float
        Luminance of texels of the texture, a fair sample of them at least.
    material : (N,) int
        Index of their material, 0 to `count` - 1; others are left out.

    Returns
    -------
    (count,) float64
        0 for a material without texels.
    """
    by_material = [lightness[material == k] for k in range(count)]
    return np.array([SHADOW_RATIO * np.median(values) if values.size else 0.0 for values in by_material])
