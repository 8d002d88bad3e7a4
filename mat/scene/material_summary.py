"""Broadband numbers of a material: solar absorptance at the ground and emissivities of 300 K."""

from __future__ import annotations

from skyshine.mat.atmosphere.sources.solar import ground_sunlight
from skyshine.mat.radiometry.blackbody import SpectralResponse
from skyshine.mat.radiometry.reflectance import band_emissivity, solar_absorptance, thermal_emissivity
from skyshine.materials.library import Material

EMISSIVITY_BANDS = ((3.0, 5.0), (8.0, 12.0))  # um
TEMPERATURE = 300.0  # K


def material_summary(material: Material) -> dict[str, float]:
    """Solar absorptance and the emissivities of a material, by name."""
    summary = {"solar_absorptance": solar_absorptance(material, *ground_sunlight())}
    for lower, upper in EMISSIVITY_BANDS:
        response = SpectralResponse.rectangular(lower, upper)
        summary[f"emissivity_{lower:g}_{upper:g}_um"] = band_emissivity(material, response, TEMPERATURE)
    summary["thermal_emissivity"] = thermal_emissivity(material, TEMPERATURE)
    return summary
