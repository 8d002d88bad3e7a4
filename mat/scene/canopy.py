"""Stands of leaves through whose gaps soil is seen, as a job asks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from skyshine.mat.job.by_material import value_for
from skyshine.mat.surface.canopy import gap_towards
from skyshine.materials.library import MaterialLibrary
from skyshine.materials.records import Material, OpenStand

NO_LEAVES = 1e-6  # m2/m2: below, a stand is its soil; it hides less than a millionth of it


def opened(material: Material, library: MaterialLibrary, given: Any) -> Material:
    """A material whose leaves have gaps, as a job's `leaf_area_index` says; the material itself where it says nothing.

    Its spectra are those of leaves and soil in the shares in which they are seen from above.
    """
    value = value_for(given, material.name)
    if value is None or material.stand is None:
        return material
    stand, soil = material.stand, library[material.stand.soil]
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
