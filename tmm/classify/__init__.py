"""Classifiers of texels: colour, texture, the average over a box, calibrated confidence."""
