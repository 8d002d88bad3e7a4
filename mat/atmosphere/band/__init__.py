"""Compiled bands: a few weighted spectral points that replace all points of a sensor band."""
