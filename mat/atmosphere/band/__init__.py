"""Compiled bands: the spectral points of a sensor band, chosen and weighted so that few of them stand for all."""
