"""Stands of leaves through whose gaps soil is seen, as a job asks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skyshine.mat.surface.canopy import gap_towards
from skyshine.materials.records import Material, OpenStand

NO_LEAVES = 1e-6  # m2/m2: below, a stand is its soil; it hides less than a millionth of it


def opened(material: Material, soil: Material, value: float | str) -> Material:
    """A material with a stand whose leaves have gaps, by a leaf area index or that of the library, over a soil.

    Its spectra are those of leaves and soil in the shares in which they are seen from above.
    """
    stand = material.stand
    assert stand is not None
    index = stand.leaf_area_index if value == "library" else float(value)
    area = stand.clumping * index
    gap = 1.0 if area < NO_LEAVES else float(gap_towards(area, 1.0))
    wavelength = np.union1d(material.wavelength, soil.wavelength)
    reflectance, absorptance = (
        (1 - gap) * np.interp(wavelength, material.wavelength, getattr(material, name))
        + gap * np.interp(wavelength, soil.wavelength, getattr(soil, name))
        for name in ("reflectance", "absorptance")
    )
    lobe = soil if gap == 1.0 else material
    return replace(
        material,
        wavelength=wavelength,
        reflectance=reflectance,
        absorptance=absorptance,
        specular_fraction=lobe.specular_fraction,
        lobe_fwhm=lobe.lobe_fwhm,
        opened=OpenStand(area, material, soil),
    )
