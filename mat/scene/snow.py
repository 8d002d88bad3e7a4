"""Materials of a job under the snow that it lays on them."""

from __future__ import annotations

from dataclasses import replace

from skyshine.materials.records import Material


def under_snow(material: Material, snow: Material, depth: float) -> Material:
    """A material below a layer of snow of a depth [m], which gives it its looks and melts.

    The skin and the layers of the material lie below the snow, over its own back; wind reaches it as it did.
    """
    top = snow.thermal.layers[0]
    below = material.thermal
    solids = (below.skin, *below.layers) if below.skin.thickness else below.layers
    return replace(
        material,
        thermal=replace(below, skin=snow.thermal.skin, layers=(replace(top, thickness=depth), *solids), light=()),
        surface=replace(snow.surface, exposure=material.surface.exposure),
        wavelength=snow.wavelength,
        reflectance=snow.reflectance,
        absorptance=snow.absorptance,
        transmits=snow.transmits,
        ranges=snow.ranges,
        specular_fraction=snow.specular_fraction,
        lobe_fwhm=snow.lobe_fwhm,
        soil=None,
    )
