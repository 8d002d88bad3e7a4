"""Blackbody radiation, spectral responses, reflectance, specular lobes, equivalent temperature."""
