"""Absorption cross sections of gases at the spectral points of the band model."""
