"""Absorption cross sections of gases at the spectral points, interpolated in pressure and temperature."""
